"""Newton's method on the rows of a contact problem."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact_rows import Contacts, Subgradient, rows, work
from handlcp.lcp.kernels.dense import multiply_add, solve_ranked
from handlcp.lcp.kernels.newton import size
from handlcp.tolerances import RANK

__all__ = ["contact_newton", "hold"]

_MEMORY = 8  # steps over which ‖F‖ may rise
_SHORTEST = 2e-2  # step length below which the line search takes what it has


@kernel
def hold(p: Contacts, apart: Bools, slippery: Bools, x: Array) -> None:
    """Write into x (n,) the solution of the linear problem in which pairs stay at 0 where `apart` (n,), contacts carry
    nothing along their tangents where `slippery` (k,), and every other contact sticks.
    """
    n = len(x)
    A, rhs, col = p.M.copy(), -p.q, np.empty(n, np.int64)
    for i in np.flatnonzero((p.role == 1) & apart):
        A[i], A[i, i], rhs[i] = 0.0, 1.0, 0.0
    for k in range(len(p.blocks)):
        if apart[p.blocks[k, 0]] or slippery[k]:
            for i in p.blocks[k, 1:]:
                if i >= 0:
                    A[i], A[i, i], rhs[i] = 0.0, 1.0, 0.0
    solve_ranked(A, rhs, x, col, RANK)


@kernel
def contact_newton(p: Contacts, x: Array, steps: int, tolerance: float) -> tuple[int, float]:
    """Semismooth Newton on F in place, with a line search that lets ‖F‖ rise for a while (Grippo, Lampariello &
    Lucidi 1986). Stops at ‖F‖ ≤ tolerance × max(1, largest |x|). Returns (steps, ‖F‖ over that size).
    """
    n = len(x)
    y, F, g = np.empty(n), np.empty(n), work(n)
    multiply_add(p.M, x, p.q, y)
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
        _jacobian(p.M, g, J)
        solve_ranked(J, F, dx, col, RANK)
        recent[step % _MEMORY] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            x1[:] = x - t * dx
            multiply_add(p.M, x1, p.q, y)
            total = rows(p, x1, y, F, g)
            if total <= (1.0 - 1e-4 * t) * ceiling or t < _SHORTEST:
                break
            t *= 0.5
        x[:] = x1
    return steps, relative


@kernel
def _jacobian(M: Array, g: Subgradient, J: Array) -> None:
    """Write the subgradients as the rows of J (n, n)."""
    J[:, :] = 0.0
    for i in range(len(M)):
        for e in range(3):
            b, d = g.b[i, e], g.row[i, e]
            if b != 0.0:
                for j in range(len(M)):
                    J[i, j] += b * M[d, j]
        for a in range(4):
            J[i, g.unit[i, a]] += g.c[i, a]
