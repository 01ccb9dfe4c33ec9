"""NSNGRK on contact problems: Newton's method first, and Kaczmarz steps between its runs where it fails."""

from __future__ import annotations

from typing import cast

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.contact_rows import Contacts, Subgradient, contact_kaczmarz, rows, work
from handlcp.lcp.kernels.dense import kernel, multiply_add, solve_ranked
from handlcp.lcp.kernels.newton import size
from handlcp.tolerances import RANK

# ---------------------------------------------------------------- Newton's method on the rows of a contact problem.

_MEMORY = 8  # steps over which ‖F‖ may rise
_SHORTEST = 2e-2  # step length below which the line search takes what it has


@kernel
def hold(p: Contacts, apart: Bools, slippery: Bools, x: Array) -> None:
    """Write into x (n,) the solution of the linear problem in which pairs stay at 0 where `apart` (n,), contacts carry
    nothing along their tangents where `slippery` (k,), and every other contact sticks.
    """
    n = len(x)
    A, rhs, col = p.M.copy(), np.empty(n), np.empty(n, np.int64)
    for i in range(n):
        rhs[i] = -p.q[i]
        if p.role[i] == 1 and apart[i]:
            _at_zero(A, rhs, i)
    for k in range(len(p.blocks)):
        if apart[p.blocks[k, 0]] or slippery[k]:
            for i in p.blocks[k, 1:]:
                if i >= 0:
                    _at_zero(A, rhs, i)
    solve_ranked(A, rhs, x, col, RANK)


@kernel
def _at_zero(A: Array, rhs: Array, i: int) -> None:
    """Put x_i = 0 in the place of row i."""
    for j in range(len(rhs)):
        A[i, j] = 0.0
    A[i, i], rhs[i] = 1.0, 0.0


@kernel
def contact_newton(p: Contacts, x: Array, steps: int, tolerance: float) -> tuple[int, float]:
    """Semismooth Newton on F in place, with a line search that lets ‖F‖ rise for a while (Grippo, Lampariello &
    Lucidi 1986). Stops at ‖F‖ ≤ tolerance × max(1, largest |x|). Returns (steps, ‖F‖ over that size).
    """
    n, M, q = len(x), p.M, p.q
    y, F, g = np.empty(n), np.empty(n), work(p)
    multiply_add(M, x, q, y)
    total = rows(p, x, y, F, g)
    relative = np.sqrt(total) / size(x)
    if relative <= tolerance:  # most often: where every contact sticks
        return 0, relative
    dx, x1, recent = np.empty(n), np.empty(n), np.zeros(_MEMORY)
    J, col = np.empty((n, n)), np.empty(n, np.int64)
    for step in range(steps + 1):
        relative = np.sqrt(total) / size(x)
        if not total < np.inf:
            return step, np.inf
        if relative <= tolerance or step == steps:
            return step, relative
        jacobian(p, g, J)
        solve_ranked(J, F, dx, col, RANK)
        recent[step % _MEMORY] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            for i in range(n):
                x1[i] = x[i] - t * dx[i]
            multiply_add(M, x1, q, y)
            total = rows(p, x1, y, F, g)
            if total <= (1.0 - 1e-4 * t) * ceiling or t < _SHORTEST:
                break
            t *= 0.5
        x[:] = x1
    return steps, relative


@kernel
def jacobian(p: Contacts, g: Subgradient, J: Array) -> None:
    """Write the subgradients as the rows of J (n, n)."""
    M, role, rho, blocks, scale, D = p.M, p.role, p.rho, p.blocks, g.scale, g.D
    n = len(M)
    for i in range(n):
        if role[i] < 2:
            for j in range(n):
                J[i, j] = scale[i] * M[i, j]
            if scale[i] == 0.0:
                J[i, i] = 1.0
    for k in range(len(blocks)):
        for a in range(3):
            i = blocks[k, 1 + a]
            if i < 0:
                break
            for j in range(n):
                J[i, j] = 0.0
            for e in range(3):
                column, d = blocks[k, 1 + e], D[k, a, e]
                if column < 0:
                    break
                if d != 0.0:
                    for j in range(n):
                        J[i, j] += rho[column] * d * M[column, j]
                J[i, column] += 1.0 - d if e == a else -d  # one difference: where contacts stick, it is exactly zero
            J[i, blocks[k, 0]] -= D[k, a, 3]


# ----------------------------------------------------------------

_ON_BALL = 1e-2  # how well the ball's answer has to be known to name a polygon's faces
# int64, no literals: kernels are compiled for each literal anew
_BALL_STEPS, _STEPS = cast(int, np.int64(8)), cast(int, np.int64(12))  # runs that end well take half as many
# Which contacts Newton's next step takes for sticking depends on ρ: where it fails with the stiffness of each contact,
# other scales lead elsewhere, from there and from where Kaczmarz steps have come
_SCALES = (0.03, 0.3, 1.0)


@kernel
def contact_run(
    p: Contacts, x: Array, cold: bool, seed: int, most: int, polish: bool, tolerance: float
) -> tuple[int, int, float]:
    """Solve in place from x (n,); cold: from the linear solution in which contacts with a gap are open and
    all others stick. Returns (Kaczmarz steps, Newton steps, residual).

    most : Kaczmarz steps at most, 0: Newton's method alone. polish : Newton's method before and between them.
    """
    if cold:
        hold(p, p.q > 0.0, np.zeros(len(p.blocks), np.bool_), x)
    taken, newton, r, best = 0, 0, np.inf, x
    if polish:
        best, newton, r = newton_first(p, x, cold, tolerance)
    if not polish or (r > tolerance and most > 0):
        taken, more, r = in_turns(p, x, best, r, seed, most, polish, tolerance)
        newton += more
    else:
        x[:] = best
    closed(p, x)
    return taken, newton, r


@kernel
def closed(p: Contacts, x: Array) -> None:
    """Take out, in place, what rounding left of pairs that are apart."""
    for i in range(len(x)):
        if p.role[i] == 1 and x[i] < 0.0:
            x[i] = 0.0


@kernel
def _newton(p: Contacts, scale: float, x: Array, tolerance: float) -> tuple[int, float]:
    """Newton's method in place, with ρ times `scale`. A polygon or polyhedron is approached from the answer on the ball
    in its place, which names the faces: from there it takes two or three steps, whatever their number.
    """
    before, rho = 0, p.rho if scale == 1.0 else p.rho * scale
    if p.faces > 2:
        ball = Contacts(p.M, p.q, p.role, rho, p.blocks, p.limits, 0, p.normals)
        before, _ = contact_newton(ball, x, _BALL_STEPS, _ON_BALL)
    own = Contacts(p.M, p.q, p.role, rho, p.blocks, p.limits, p.faces, p.normals)
    steps, r = contact_newton(own, x, _STEPS, tolerance)
    return before + steps, r


@kernel
def newton_first(p: Contacts, x: Array, cold: bool, tolerance: float) -> tuple[Array, int, float]:
    """(answer, steps, residual) of Newton's method from x, which is left alone."""
    best, before, r = x.copy(), 0, np.inf
    if not cold and p.faces > 2:  # a good start lies on the right faces already
        before, r = contact_newton(p, best, _STEPS, tolerance)
        if r <= tolerance:
            return best, before, r
    other = x.copy()
    steps, r_other = _newton(p, 1.0, other, tolerance)
    return (other, before + steps, r_other) if not r_other > r else (best, before + steps, r)


@kernel
def in_turns(
    p: Contacts, x: Array, best: Array, best_r: float, seed: int, most: int, polish: bool, tolerance: float
) -> tuple[int, int, float]:
    """Kaczmarz steps and Newton's method in turn, in place, until Newton's converges; else the best of it all."""
    n, newton, taken, k = len(x), 0, 0, 0
    MT = np.ascontiguousarray(p.M.T)
    MMT = np.dot(p.M, MT)
    state, y = np.full(1, seed, np.uint64), np.empty(n)
    multiply_add(p.M, x, p.q, y)
    batch = 2 * n if polish else most
    while taken < most:
        done, r = contact_kaczmarz(p, MT, MMT, x, y, state, min(batch, most - taken), tolerance)
        taken += done
        if not polish:
            return taken, 0, r
        trial = x.copy()
        steps, r = _newton(p, _SCALES[k % len(_SCALES)], trial, tolerance)
        newton += steps
        k += 1
        if r < best_r:
            best, best_r = trial, r
        if r <= tolerance or done < batch:  # solved, or stalled where no row moves any more
            break
        batch *= 2
    x[:] = best
    return taken, newton, best_r
