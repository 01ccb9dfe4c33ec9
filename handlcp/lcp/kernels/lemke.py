"""Lemke's complementary pivoting on a dictionary (paper, Algorithm 1), with lexicographic ties.

The dictionary writes the n basic variables as affine functions of the n + 1 others; it starts as w = q + M z + d z₀.
Lexicographic order perturbs q by (ε, ε², …). No column has to be kept for that: where w_c is nonbasic the
coefficient of ε_c in row i is minus its dictionary entry, and where it is basic it is one in its own row.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel

SOLVED, RAY, SPENT = 0, 1, 2


@kernel
def lemke(M: Array, q: Array, d: Array, most: int, pivot: float) -> tuple[int, int, Array]:
    """Pivot until z₀ leaves. d (n,) > 0 is the covering vector, `pivot` the relative tolerance of pivots and ties.

    Returns (SOLVED | RAY | SPENT, pivots, z (n,)); z is what the last basis says, whatever the outcome.
    Variables are numbered w: 0 … n-1, z: n … 2n-1, z₀: 2n.
    """
    n = len(q)
    D = np.empty((n, n + 2))  # columns: z₀, the n others, constant
    D[:, 0], D[:, 1 : n + 1], D[:, n + 1] = d, M, q
    basic, nonbasic = np.arange(n), np.arange(n - 1, 2 * n)
    nonbasic[0] = 2 * n
    column = np.full(2 * n + 1, -1, np.int64)  # where a nonbasic variable stands
    column[nonbasic] = np.arange(n + 1)
    z, row = np.zeros(n), 0
    for i in range(1, n):  # z₀ enters where q_i / d_i is least; of equals the last, which is lexicographically least
        if q[i] * d[row] <= q[row] * d[i]:
            row = i
    if n == 0 or q[row] >= 0.0:
        return SOLVED, 0, z
    entering, status, count = 0, SPENT, 0
    while count < most:
        leaving = basic[row]
        _exchange(D, row, entering)
        basic[row], nonbasic[entering] = nonbasic[entering], leaving
        column[basic[row]], column[leaving] = -1, entering
        count += 1
        if leaving == 2 * n:
            status = SOLVED
            break
        entering = column[leaving + n if leaving < n else leaving - n]
        row = _ratio(D, entering, basic, column, pivot)
        if row < 0:
            status = RAY
            break
    for i in range(n):
        if n <= basic[i] < 2 * n:
            z[basic[i] - n] = D[i, n + 1]
    return status, count, z


@kernel
def _exchange(D: Array, r: int, e: int) -> None:
    """Swap the basic variable of row r with the nonbasic variable of column e."""
    rows, columns = D.shape
    p = 1.0 / D[r, e]
    for c in range(columns):
        D[r, c] *= -p
    D[r, e] = p
    for i in range(rows):
        f = D[i, e]
        if i != r and f != 0.0:
            D[i, e] = 0.0
            for c in range(columns):
                D[i, c] += f * D[r, c]


@kernel
def _ratio(D: Array, e: int, basic: Ints, column: Ints, tolerance: float) -> int:
    """The row that blocks the growth of column e first; of equals z₀, then the lexicographically least. -1: none."""
    n, last = D.shape[0], D.shape[1] - 1
    size, constants = 0.0, 0.0
    for i in range(n):
        size, constants = max(size, abs(D[i, e])), max(constants, abs(D[i, last]))
    least = np.inf
    for i in range(n):
        if D[i, e] < -tolerance * size:
            least = min(least, max(D[i, last], 0.0) / -D[i, e])
    row = -1
    for i in range(n):
        if D[i, e] < -tolerance * size and D[i, last] + D[i, e] * least <= tolerance * constants:
            if basic[i] == 2 * n:
                return i
            if row < 0 or _before(D, i, row, e, basic, column):
                row = i
    return row


@kernel
def _before(D: Array, i: int, k: int, e: int, basic: Ints, column: Ints) -> bool:
    """Whether row i's perturbed ratio is lexicographically less than row k's."""
    for c in range(D.shape[0]):
        at = column[c]  # w_c
        a = (-D[i, at] if at >= 0 else 1.0 * (basic[i] == c)) / -D[i, e]
        b = (-D[k, at] if at >= 0 else 1.0 * (basic[k] == c)) / -D[k, e]
        if abs(a - b) > 1e-9 * max(abs(a), abs(b)):
            return bool(a < b)
    return False
