"""Newton's method on the rows of a contact problem."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.arrow import multiply_arrow, room, solve_arrow
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import Contacts, rows, work

__all__ = ["contact_newton", "stick"]

_MEMORY = 8  # steps over which ‖F‖ may rise
_SHORTEST = 1e-2  # step length at which the line search takes what it has


@kernel
def stick(p: Contacts, x: Array, rank_tolerance: float) -> None:
    """X ← the solution of the linear problem in which every contact sticks that starts without a gap."""
    n = len(x)
    g, rhs = work(n), np.empty(n)
    for i in range(n):
        g.unit[i, :], g.row[i, :], g.c[i, :] = i, i, 0.0
        g.b[i, 0], g.b[i, 1], rhs[i] = 1.0, 0.0, -p.q[i]
        if p.role[i] == 1 and p.q[i] > 0.0:
            _nothing(i, g.c, g.b, rhs)
    for k in range(len(p.blocks)):
        if p.q[p.blocks[k, 0]] > 0.0:
            for a in range(1, 3):
                if p.blocks[k, a] >= 0:
                    _nothing(p.blocks[k, a], g.c, g.b, rhs)
    solve_arrow(p.M, g, rhs, x, room(p.M), rank_tolerance)


@kernel
def _nothing(i: int, c: Array, b: Array, rhs: Array) -> None:
    """Row i becomes x_i = 0."""
    c[i, 0], b[i, 0], rhs[i] = 1.0, 0.0, 0.0


@kernel
def contact_newton(p: Contacts, x: Array, steps: int, tolerance: float, rank_tolerance: float) -> tuple[int, float]:
    """Semismooth Newton on F in place, with a line search that lets ‖F‖ rise for a while (Grippo, Lampariello &
    Lucidi 1986). Stops at ‖F‖ ≤ tolerance × max(1, largest |x|). Returns (steps, ‖F‖ over that size).
    """
    n = len(x)
    y, F, dx, x1, recent = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.zeros(_MEMORY)
    g, R = work(n), room(p.M)
    multiply_arrow(p.M, x, p.q, y)
    total, relative = rows(p, x, y, F, g), np.inf
    for step in range(steps + 1):
        size = 1.0
        for i in range(n):
            size = max(size, abs(x[i]))
        relative = np.sqrt(total) / size
        if not total < np.inf:
            return step, np.inf
        if relative <= tolerance or step == steps:
            return step, relative
        solve_arrow(p.M, g, F, dx, R, rank_tolerance)
        recent[step % _MEMORY] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            for i in range(n):
                x1[i] = x[i] - t * dx[i]
            multiply_arrow(p.M, x1, p.q, y)
            total = rows(p, x1, y, F, g)
            if total <= (1.0 - 1e-4 * t) * ceiling:
                break
            t *= 0.5
            if t < _SHORTEST:
                break
        x[:] = x1
    return steps, relative
