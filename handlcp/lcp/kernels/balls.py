"""Newton's method on contacts whose friction is a ball or a polyhedron in three dimensions, with a dense Jacobian.

    free            F_i = y_i
    pair            F_i = x_i where x_i ≤ ρ_i y_i, else ρ_i y_i
    ball            F_T = x_T - P(x_T - ρ y_T),  P onto the ball of radius (or polyhedron of apothem) μ max(x_N, 0)

The equations of `kernels.contact` with as many tangents as there are (Alart & Curnier, Comput. Methods Appl. Mech.
Eng. 92, 1991).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.lcp.kernels.polyhedron import nearest_in_ball, nearest_in_polyhedron

__all__ = ["ball_held", "ball_newton"]

_MEMORY = 8  # steps over which ‖F‖ may rise
_GAIN = 1e-4  # share of ‖F‖² that a step below the tolerance must get under, to be worth another
_SHORTEST = 1e-2  # step length at which the line search takes what it has


@kernel
def ball_held(
    M: Array, q: Array, free: Bools, balls: Ints, apart: Bools, slippery: Bools, x: Array, rank_tolerance: float
) -> None:
    """X ← the solution of the linear problem in which pairs stay at 0 where `apart` (n,), balls carry nothing
    tangential where `slippery` (k,), and every other contact sticks.
    """
    n = len(x)
    A, b, col = M.copy(), -q, np.empty(n, np.int64)
    for i in range(n):
        if not free[i] and apart[i]:
            A[i], A[i, i], b[i] = 0.0, 1.0, 0.0
    for k in range(len(balls)):
        if apart[balls[k, 0]] or slippery[k]:
            for i in balls[k, 1:]:
                if i >= 0:
                    A[i], A[i, i], b[i] = 0.0, 1.0, 0.0
    solve_ranked(A, b, x, col, rank_tolerance)


@kernel
def _rows(
    M: Array, q: Array, role: Ints, balls: Ints, limits: Array, flat: Array, full: Array, rho: Array, x: Array,
    F: Array, J: Array,
) -> float:  # fmt: skip
    """F (n,) and its subgradients in the rows of J (n, n). Returns ‖F‖²."""
    n, y = len(x), np.dot(M, x) + q
    for i in range(n):
        if role[i] == 0:
            F[i], J[i] = y[i], M[i]
        elif role[i] == 1:
            if x[i] > rho[i] * y[i]:
                F[i], J[i] = rho[i] * y[i], rho[i] * M[i]
            else:
                F[i], J[i] = x[i], 0.0
                J[i, i] = 1.0
    s, p, D = np.empty(3), np.empty(3), np.empty((3, 4))
    for k in range(len(balls)):
        normal, t = balls[k, 0], balls[k, 1:]
        d = 3 if t[2] >= 0 else 2
        a, slope = (limits[k] * x[normal], limits[k]) if x[normal] > 0.0 else (0.0, 0.0)
        s[2] = 0.0
        for m in range(d):
            s[m] = x[t[m]] - rho[t[m]] * y[t[m]]
        if len(full) == 0:
            nearest_in_ball(s, a, p, D)
        else:
            nearest_in_polyhedron(s, a, full if d == 3 else flat, p, D)
        for m in range(d):
            i = t[m]
            F[i], J[i] = x[i] - p[m], 0.0
            J[i, i] += 1.0
            J[i, normal] -= slope * D[m, 3]
            for o in range(d):
                if D[m, o] != 0.0:
                    j = t[o]
                    J[i, j] -= D[m, o]
                    J[i] += D[m, o] * rho[j] * M[j]
    total = 0.0
    for i in range(n):
        total += F[i] * F[i]
    return total


@kernel
def ball_newton(
    M: Array, q: Array, role: Ints, balls: Ints, limits: Array, flat: Array, full: Array, rho: Array, x: Array,
    steps: int, tolerance: float, rank_tolerance: float,
) -> tuple[int, float]:  # fmt: skip
    """Semismooth Newton in place, with a line search that lets ‖F‖ rise for a while (Grippo, Lampariello & Lucidi
    1986). Below the tolerance it goes on for as long as steps still gain something. Returns (steps, ‖F‖ over the larger
    of 1 and the largest |x|).
    """
    n = len(x)
    F, J, dx, col, recent = np.empty(n), np.empty((n, n)), np.empty(n), np.empty(n, np.int64), np.zeros(_MEMORY)
    total, relative, before = _rows(M, q, role, balls, limits, flat, full, rho, x, F, J), np.inf, np.inf
    for step in range(steps + 1):
        relative = np.sqrt(total) / max(1.0, np.max(np.abs(x)))
        if not total < np.inf:
            return step, np.inf
        if step == steps or (relative <= tolerance and (total == 0.0 or total > _GAIN * before)):
            return step, relative
        before = total
        solve_ranked(J, F, dx, col, rank_tolerance)
        recent[step % _MEMORY] = total
        ceiling, t, old = np.max(recent), 1.0, x.copy()
        while True:
            x[:] = old - t * dx
            total = _rows(M, q, role, balls, limits, flat, full, rho, x, F, J)
            if total <= (1.0 - 1e-4 * t) * ceiling:
                break
            t *= 0.5
            if t < _SHORTEST:
                break
    return steps, relative
