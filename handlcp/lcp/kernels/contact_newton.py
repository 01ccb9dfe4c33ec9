"""Newton's method on the rows of a contact problem."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact_rows import Contacts, Subgradient, rows, work
from handlcp.lcp.kernels.dense import multiply_add, solve_ranked
from handlcp.lcp.kernels.newton import size
from handlcp.tolerances import RANK

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
