"""`solve_contacts`: frictional contact as equations with subgradients, and NSNGRK on them.

Unknowns x with y = M x + q. Three kinds of rows, ρ_i > 0 a scale:

    free            F_i = y_i
    pair            F_i = x_i where x_i ≤ ρ_i y_i, else ρ_i y_i                   (natural residual, times ρ)
    friction block  F_T = x_T - P(x_T - ρ y_T; μ max(x_N, 0))

P is the projection of `kernels.projection` on the set of the block's one, two or three tangents. F = 0 says: stick, or
slide against a force on the limit (Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991). The size of the problem
does not depend on the faces.

With D = (∂P/∂s, ∂P/∂x_N), the subgradient of a tangent's row i is e_i - Σ D_ij e_j - D_iN e_N + Σ ρ D_ij M_j over the
tangents j of its block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.dense import kernel, multiply_add, solve_ranked
from handlcp.lcp.kernels.kaczmarz import Seeds, draw_greedy_row
from handlcp.lcp.kernels.newton import unknown_size
from handlcp.lcp.kernels.projection import project_on_set
from handlcp.tolerances import RANK_TOLERANCE


class ContactArrays(NamedTuple):
    """A contact problem for kernels, its unknowns in the order of its `Pattern`: M (n, n), q (n,), role (n,), blocks
    (k, 4), limits (k,), faces, normals (f, 3) as in `ContactProblem`, and rho (n,) of `row_scales`.
    """

    M: Array
    q: Array
    role: Ints
    rho: Array
    blocks: Ints
    limits: Array
    faces: int
    normals: Array


class Subgradient(NamedTuple):
    """Of free rows and pairs: scale[i] M_i where scale (n,) is positive, else e_i. D (k, 3, 4): the derivative of each
    block's projection, as in `project_on_set`. s, P (3,) : room for a point and its projection.
    """

    scale: Array
    D: Array
    s: Array
    P: Array


@kernel
def row_scales(M: Array, blocks: Ints) -> Array:
    """(n,) ρ that makes ρ y comparable with x: one over the flexibility that each contact sees, its mean in a block."""
    n, largest = len(M), 0.0
    own = np.empty(n)
    for i in range(n):
        own[i] = abs(M[i, i])
        largest = max(largest, own[i])
    for k in range(len(blocks)):
        total, count = 0.0, 0
        for i in blocks[k]:
            if i >= 0:
                total += own[i]
                count += 1
        for i in blocks[k]:
            if i >= 0:
                own[i] = total / count
    for i in range(n):
        own[i] = 1.0 / max(own[i], 1e-6 * largest) if own[i] > 0.0 else 1.0
    return own


@kernel
def reorder_problem(
    M: Array, q: Array, role: Ints, blocks: Ints, order: Ints, limits: Array, faces: int, normals: Array
) -> ContactArrays:
    """The problem with its unknowns in this order."""
    n, scales = len(q), row_scales(M, blocks)
    place, there = np.empty(n, np.int64), np.empty(blocks.shape, np.int64)
    A, b, roles, rho = np.empty((n, n)), np.empty(n), np.empty(n, np.int64), np.empty(n)
    for i in range(n):
        k = order[i]
        place[k], b[i], roles[i], rho[i] = i, q[k], role[k], scales[k]
        for j in range(n):
            A[i, j] = M[k, order[j]]
    for k in range(len(blocks)):
        for e in range(blocks.shape[1]):
            there[k, e] = place[blocks[k, e]] if blocks[k, e] >= 0 else -1
    # A copy of the limits, so that read-only ones and others are one type to compiled code
    return ContactArrays(A, b, roles, rho, there, limits.copy(), faces, normals)


@kernel
def new_subgradient(p: ContactArrays) -> Subgradient:
    """Room for the subgradients of all rows."""
    return Subgradient(np.empty(len(p.rho)), np.empty((len(p.blocks), 3, 4)), np.empty(3), np.empty(3))


@kernel
def evaluate_rows(p: ContactArrays, x: Array, y: Array, F: Array, g: Subgradient) -> float:
    """Write F (n,) and its subgradients g at x and y = M x + q. Returns ‖F‖²."""
    # Arrays of a tuple are taken out once: compiled code counts references each time
    role, rho, blocks, limits, normals, scale = p.role, p.rho, p.blocks, p.limits, p.normals, g.scale
    total = 0.0
    for i in range(len(x)):
        if role[i] == 2:
            continue
        if role[i] == 0:
            F[i], scale[i] = y[i], 1.0
        elif x[i] > rho[i] * y[i]:
            F[i], scale[i] = rho[i] * y[i], rho[i]
        else:
            F[i], scale[i] = x[i], 0.0
        total += F[i] * F[i]
    s, P, D = g.s, g.P, g.D
    for k in range(len(blocks)):
        n, tangents = blocks[k, 0], 0
        while tangents < 3 and blocks[k, tangents + 1] >= 0:
            i = blocks[k, 1 + tangents]
            s[tangents] = x[i] - rho[i] * y[i]
            tangents += 1
        for a in range(tangents, 3):
            s[a] = 0.0
        radius, slope = (limits[k] * x[n], limits[k]) if x[n] > 0.0 else (0.0, 0.0)
        project_on_set(s, tangents, radius, slope, p.faces, normals, P, D[k])
        for a in range(tangents):
            i = blocks[k, 1 + a]
            F[i] = x[i] - P[a]
            total += F[i] * F[i]
    return total


# ----------------------------------------------------------------
# Greedy randomized Kaczmarz steps on the rows of a contact problem.


class _RowSums(NamedTuple):
    """Rows Σ c[i, a] e_unit[i, a] + Σ b[i, e] M[row[i, e]]; unit, c (n, 4); row, b (n, 3)."""

    unit: Ints
    c: Array
    row: Ints
    b: Array


@kernel
def run_contact_kaczmarz(
    p: ContactArrays, MT: Array, MMT: Array, x: Array, y: Array, state: Seeds, steps: int, tolerance: float
) -> tuple[int, float]:
    """Greedy randomized Kaczmarz on the rows of F, as in `kaczmarz` ((20)–(22) of the paper); O(n) a step, in place.

    MT (n, n) is Mᵀ and MMT (n, n) is M Mᵀ. x and y (n,) belong together on entry and on return.
    Returns (steps taken, ‖F‖₂).
    """
    n = len(x)
    F, p2, g2, at = np.empty(n), np.empty(n), np.empty(n), new_subgradient(p)
    g = _RowSums(np.empty((n, 4), np.int64), np.empty((n, 4)), np.empty((n, 3), np.int64), np.empty((n, 3)))
    norm = np.inf
    for step in range(steps + 1):
        if step > 0 and step % (4 * n) == 0:  # y drifts by rounding
            multiply_add(p.M, x, p.q, y)
        total = evaluate_rows(p, x, y, F, at)
        _write_row_sums(p, at, g)
        norm = np.sqrt(total)
        frobenius, best = 0.0, 0.0
        for i in range(n):
            p2[i], g2[i] = F[i] * F[i], _row_norm_squared(p.M, MMT, g, i)
            frobenius += g2[i]
            if p2[i] > best * g2[i]:
                best = p2[i] / g2[i] if g2[i] > 0.0 else np.inf
        if not norm > tolerance or step == steps or not 0.0 < best < np.inf:
            return step, norm
        i = draw_greedy_row(p2, g2, best, total, frobenius, state)
        _take_step(p.M, MT, MMT, g, i, F[i] / g2[i], x, y)
    return steps, norm


@kernel
def _write_row_sums(p: ContactArrays, at: Subgradient, g: _RowSums) -> None:
    """Write the subgradients of all rows as sums of unit vectors and rows of M."""
    for i in range(len(p.q)):
        g.unit[i, :], g.row[i, :], g.c[i, :], g.b[i, :] = i, i, 0.0, 0.0
        if p.role[i] < 2:
            g.b[i, 0] = at.scale[i]
            g.c[i, 0] = 0.0 if at.scale[i] > 0.0 else 1.0
    for k in range(len(p.blocks)):
        for a in range(3):
            i = p.blocks[k, 1 + a]
            if i < 0:
                break
            g.unit[i, :] = p.blocks[k, 0]
            for e in range(3):
                j = p.blocks[k, 1 + e]
                if j < 0:
                    break
                d = at.D[k, a, e]
                g.unit[i, e], g.c[i, e] = j, 1.0 - d if e == a else -d
                g.row[i, e], g.b[i, e] = j, p.rho[j] * d
            g.c[i, 3] = -at.D[k, a, 3]


@kernel
def _row_norm_squared(M: Array, MMT: Array, g: _RowSums, i: int) -> float:
    """|Σ c e_a + Σ b M_j|² of row i."""
    total = 0.0
    for e in range(3):
        if g.b[i, e] == 0.0:
            continue
        for f in range(3):
            total += g.b[i, e] * g.b[i, f] * MMT[g.row[i, e], g.row[i, f]]
        for a in range(4):
            total += 2.0 * g.b[i, e] * g.c[i, a] * M[g.row[i, e], g.unit[i, a]]
    for a in range(4):
        if g.c[i, a] == 0.0:
            continue
        for h in range(4):
            if g.unit[i, h] == g.unit[i, a]:
                total += g.c[i, a] * g.c[i, h]
    return total


@kernel
def _take_step(M: Array, MT: Array, MMT: Array, g: _RowSums, i: int, t: float, x: Array, y: Array) -> None:
    """Take t times the subgradient of row i from x, and y along with it."""
    for e in range(3):
        f, d = t * g.b[i, e], g.row[i, e]
        if f != 0.0:
            for j in range(len(x)):
                x[j] -= f * M[d, j]
                y[j] -= f * MMT[d, j]
    for a in range(4):
        f, k = t * g.c[i, a], g.unit[i, a]
        if f != 0.0:
            x[k] -= f
            for j in range(len(x)):
                y[j] -= f * MT[k, j]


# ----------------------------------------------------------------
# NSNGRK on contact problems: Newton's method first, and Kaczmarz steps between its runs where it fails.


# ---------------------------------------------------------------- Newton's method on the rows of a contact problem.

LINE_SEARCH_MEMORY = 8  # steps over which ‖F‖ may rise
MIN_STEP_LENGTH = 2e-2  # step length below which the line search takes what it has


@kernel
def solve_sticking(p: ContactArrays, apart: Bools, slippery: Bools, x: Array) -> None:
    """Write into x (n,) the solution of the linear problem in which pairs stay at 0 where `apart` (n,), contacts carry
    nothing along their tangents where `slippery` (k,), and every other contact sticks.
    """
    n = len(x)
    A, rhs, col = p.M.copy(), np.empty(n), np.empty(n, np.int64)
    for i in range(n):
        rhs[i] = -p.q[i]
        if p.role[i] == 1 and apart[i]:
            _fix_at_zero(A, rhs, i)
    for k in range(len(p.blocks)):
        if apart[p.blocks[k, 0]] or slippery[k]:
            for i in p.blocks[k, 1:]:
                if i >= 0:
                    _fix_at_zero(A, rhs, i)
    solve_ranked(A, rhs, x, col, RANK_TOLERANCE)


@kernel
def _fix_at_zero(A: Array, rhs: Array, i: int) -> None:
    """Put x_i = 0 in the place of row i."""
    for j in range(len(rhs)):
        A[i, j] = 0.0
    A[i, i], rhs[i] = 1.0, 0.0


@kernel
def step_in_expected_states(p: ContactArrays, x: Array, expected: Array) -> None:
    """One step of Newton's method in place from forces x (n,) and motions y that are expected to belong to them (n,),
    both as unknowns: which contacts stick, slide and open is read from these, not from M x + q, whose error is that of
    x times a flexibility that may be very large. Free rows are those of M x + q.
    """
    n, F, J, dx = len(x), np.empty(len(x)), np.empty((len(x), len(x))), np.empty(len(x))
    y, g, col = np.empty(n), new_subgradient(p), np.empty(n, np.int64)
    multiply_add(p.M, x, p.q, y)
    evaluate_rows(p, x, expected, F, g)
    write_jacobian(p, g, J)
    for i in range(n):
        if p.role[i] == 0:
            F[i] = y[i]
        elif p.role[i] == 1:
            F[i] += g.scale[i] * (y[i] - expected[i])
    for k in range(len(p.blocks)):
        for a in range(3):
            i = p.blocks[k, 1 + a]
            if i < 0:
                break
            for e in range(3):
                j = p.blocks[k, 1 + e]
                if j < 0:
                    break
                F[i] += g.D[k, a, e] * p.rho[j] * (y[j] - expected[j])
    solve_ranked(J, F, dx, col, RANK_TOLERANCE)
    for i in range(n):
        x[i] -= dx[i]


@kernel
def run_contact_newton(p: ContactArrays, x: Array, steps: int, tolerance: float) -> tuple[int, float]:
    """Semismooth Newton on F in place, with a line search that lets ‖F‖ rise for a while (Grippo, Lampariello &
    Lucidi 1986). Stops at ‖F‖ ≤ tolerance × max(1, largest |x|). Returns (steps, ‖F‖ over that size).
    """
    n, M, q = len(x), p.M, p.q
    y, F, g = np.empty(n), np.empty(n), new_subgradient(p)
    multiply_add(M, x, q, y)
    total = evaluate_rows(p, x, y, F, g)
    relative = np.sqrt(total) / unknown_size(x)
    if relative <= tolerance:  # most often: where every contact sticks
        return 0, relative
    dx, x1, recent = np.empty(n), np.empty(n), np.zeros(LINE_SEARCH_MEMORY)
    J, col = np.empty((n, n)), np.empty(n, np.int64)
    for step in range(steps + 1):
        relative = np.sqrt(total) / unknown_size(x)
        if not total < np.inf:
            return step, np.inf
        if relative <= tolerance or step == steps:
            return step, relative
        write_jacobian(p, g, J)
        solve_ranked(J, F, dx, col, RANK_TOLERANCE)
        recent[step % LINE_SEARCH_MEMORY] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            for i in range(n):
                x1[i] = x[i] - t * dx[i]
            multiply_add(M, x1, q, y)
            total = evaluate_rows(p, x1, y, F, g)
            if total <= (1.0 - 1e-4 * t) * ceiling or t < MIN_STEP_LENGTH:
                break
            t *= 0.5
        x[:] = x1
    return steps, relative


@kernel
def write_jacobian(p: ContactArrays, g: Subgradient, J: Array) -> None:
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

BALL_TOLERANCE = 1e-2  # how well the ball's answer has to be known to name a polygon's faces
MAX_BALL_STEPS, MAX_NEWTON_STEPS = 8, 12  # runs that end well take half as many
# Which contacts Newton's next step takes for sticking depends on ρ: where it fails with the stiffness of each contact,
# other scales lead elsewhere, from there and from where Kaczmarz steps have come
_NEWTON_SCALES = (0.03, 0.3, 1.0)


@kernel
def solve_contacts(
    p: ContactArrays, x: Array, cold: bool, seed: int, most: int, polish: bool, tolerance: float
) -> tuple[int, int, float]:
    """Solve in place from x (n,); cold: from the linear solution in which contacts with a gap are open and
    all others stick. Returns (Kaczmarz steps, Newton steps, residual).

    most : Kaczmarz steps at most, 0: Newton's method alone. polish : Newton's method before and between them.
    """
    if cold:
        solve_sticking(p, p.q > 0.0, np.zeros(len(p.blocks), np.bool_), x)
    taken, newton, r, best = 0, 0, np.inf, x
    if polish:
        best, newton, r = run_newton_first(p, x, cold, tolerance)
    if not polish or (r > tolerance and most > 0):
        taken, more, r = alternate_methods(p, x, best, r, seed, most, polish, tolerance)
        newton += more
    else:
        x[:] = best
    clip_open_pairs(p, x)
    return taken, newton, r


@kernel
def clip_open_pairs(p: ContactArrays, x: Array) -> None:
    """Take out, in place, what rounding left of pairs that are apart."""
    for i in range(len(x)):
        if p.role[i] == 1 and x[i] < 0.0:
            x[i] = 0.0


@kernel
def _newton_by_ball(p: ContactArrays, scale: float, x: Array, tolerance: float) -> tuple[int, float]:
    """Newton's method in place, with ρ times `scale`. A polygon or polyhedron is approached from the answer on the ball
    in its place, which names the faces: from there it takes two or three steps, whatever their number.
    """
    before, rho = 0, p.rho if scale == 1.0 else p.rho * scale
    if p.faces > 2:
        ball = ContactArrays(p.M, p.q, p.role, rho, p.blocks, p.limits, 0, p.normals)
        before, _ = run_contact_newton(ball, x, MAX_BALL_STEPS, BALL_TOLERANCE)
    own = ContactArrays(p.M, p.q, p.role, rho, p.blocks, p.limits, p.faces, p.normals)
    steps, r = run_contact_newton(own, x, MAX_NEWTON_STEPS, tolerance)
    return before + steps, r


@kernel
def run_newton_first(p: ContactArrays, x: Array, cold: bool, tolerance: float) -> tuple[Array, int, float]:
    """(answer, steps, residual) of Newton's method from x, which is left alone."""
    best, before, r = x.copy(), 0, np.inf
    if not cold and p.faces > 2:  # a good start lies on the right faces already
        before, r = run_contact_newton(p, best, MAX_NEWTON_STEPS, tolerance)
        if r <= tolerance:
            return best, before, r
    other = x.copy()
    steps, r_other = _newton_by_ball(p, 1.0, other, tolerance)
    return (other, before + steps, r_other) if not r_other > r else (best, before + steps, r)


@kernel
def alternate_methods(
    p: ContactArrays, x: Array, best: Array, best_r: float, seed: int, most: int, polish: bool, tolerance: float
) -> tuple[int, int, float]:
    """Kaczmarz steps and Newton's method in turn, in place, until Newton's converges; else the best of it all."""
    n, newton, taken, k = len(x), 0, 0, 0
    MT = np.ascontiguousarray(p.M.T)
    MMT = np.dot(p.M, MT)
    state, y = np.full(1, seed, np.uint64), np.empty(n)
    multiply_add(p.M, x, p.q, y)
    batch = 2 * n if polish else most
    while taken < most:
        done, r = run_contact_kaczmarz(p, MT, MMT, x, y, state, min(batch, most - taken), tolerance)
        taken += done
        if not polish:
            return taken, 0, r
        trial = x.copy()
        steps, r = _newton_by_ball(p, _NEWTON_SCALES[k % len(_NEWTON_SCALES)], trial, tolerance)
        newton += steps
        k += 1
        if r < best_r:
            best, best_r = trial, r
        if r <= tolerance or done < batch:  # solved, or stalled where no row moves any more
            break
        batch *= 2
    x[:] = best
    return taken, newton, best_r
