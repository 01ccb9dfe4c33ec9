"""NSNGRK on contact problems: Newton's method first, and Kaczmarz steps between its runs where it fails."""

from __future__ import annotations

from typing import cast

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact_kaczmarz import contact_kaczmarz
from handlcp.lcp.kernels.contact_newton import contact_newton, hold
from handlcp.lcp.kernels.contact_rows import Contacts
from handlcp.lcp.kernels.dense import multiply_add

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
    before = 0
    if p.faces > 2:
        ball = Contacts(p.M, p.q, p.role, p.rho * scale, p.blocks, p.limits, 0, p.normals)
        before, _ = contact_newton(ball, x, _BALL_STEPS, _ON_BALL)
    own = Contacts(p.M, p.q, p.role, p.rho * scale, p.blocks, p.limits, p.faces, p.normals)
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
