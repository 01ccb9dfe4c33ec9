"""Linear systems of contact problems, where each contact's unknowns meet only their own and the object's motion.

In a suitable order such a matrix is an arrow: a small block for each contact, and a border that all share.

    [ A₁           B₁ ]
    [      A₂      B₂ ]      eliminating the blocks costs O(contacts), only the border is left to dense elimination
    [           ⋱  ⋮  ]
    [ C₁   C₂   ⋯  D  ]

A block is eliminated only if Aₖ⁻¹ Bₖ stays within `_GROWTH`, so that what the others put into the border is not lost in
rounding (Demmel, Higham & Schreiber, Stability of block LU factorization, 1995). Where it doesn't, as with a rigid
finger that sticks, the block is put off to the border. Fingers coupled with one another belong there from the start.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import eliminate

__all__ = ["Arrow", "Room", "Subgradient", "arrow_order", "multiply_arrow", "pack", "room", "solve_arrow"]

_GROWTH = 1e3


@kernel
def arrow_order(M: Array, role: Ints, blocks: Ints) -> tuple[Ints, Ints]:
    """(order, starts): unknowns in the order of the arrow; block g is order[starts[g]:starts[g + 1]], then the border.

    Blocks are friction blocks and single pairs; whichever is coupled with most others goes to the border first.
    """
    n, count = len(M), 0
    group = np.full(n, -1, np.int64)
    for k in range(len(blocks)):
        for a in range(3):
            if blocks[k, a] >= 0:
                group[blocks[k, a]] = count
        count += 1
    for i in range(n):
        if role[i] == 1 and group[i] < 0:
            group[i] = count
            count += 1
    meets, others = np.zeros((count, count), np.bool_), np.zeros(count, np.int64)
    for i in range(n):
        g = group[i]
        if g >= 0:
            for j in range(n):
                h = group[j]
                if h >= 0 and h != g and M[i, j] != 0.0 and not meets[g, h]:
                    meets[g, h] = meets[h, g] = True
                    others[g] += 1
                    others[h] += 1
    while count > 0 and np.max(others) > 0:
        worst = np.argmax(others)
        others[worst] = -1
        for h in range(count):
            if meets[worst, h] and others[h] > 0:
                others[h] -= 1
    order, starts = np.empty(n, np.int64), np.zeros(count + 1, np.int64)
    at, kept = 0, 0
    for g in range(count):
        if others[g] == 0:
            for i in range(n):
                if group[i] == g:
                    order[at] = i
                    at += 1
            kept += 1
            starts[kept] = at
    for i in range(n):
        if group[i] < 0 or others[group[i]] < 0:
            order[at] = i
            at += 1
    return order, starts[: kept + 1].copy()


class Arrow(NamedTuple):
    """A matrix of n unknowns without the zeros between blocks: own (B, 3) the blocks, whose columns start at column 0,
    side (n, n - B) the border's columns, below (n - B, B) the rest of its rows, and where the blocks start.
    """

    own: Array
    side: Array
    below: Array
    starts: Ints


@kernel
def pack(M: Array, order: Ints, starts: Ints) -> tuple[Array, Array, Array]:
    """(own, side, below) of M, put in this order."""
    n, border = len(M), starts[-1]
    own, side, below = np.zeros((border, 3)), np.empty((n, n - border)), np.empty((n - border, border))
    for g in range(len(starts) - 1):
        for s in range(starts[g], starts[g + 1]):
            for t in range(starts[g], starts[g + 1]):
                own[s, t - starts[g]] = M[order[s], order[t]]
    for s in range(n):
        for t in range(border, n):
            side[s, t - border] = M[order[s], order[t]]
    for s in range(border, n):
        for t in range(border):
            below[s - border, t] = M[order[s], order[t]]
    return own, side, below


@kernel
def multiply_arrow(M: Arrow, x: Array, q: Array, y: Array) -> None:
    """Y ← M x + q."""
    border, k = len(M.own), len(M.below)
    for i in range(len(q)):
        y[i] = q[i]
        for t in range(k):
            y[i] += M.side[i, t] * x[border + t]
    for g in range(len(M.starts) - 1):
        start, width = M.starts[g], M.starts[g + 1] - M.starts[g]
        for i in range(start, start + width):
            for t in range(width):
                y[i] += M.own[i, t] * x[start + t]
    for i in range(k):
        total = 0.0
        for t in range(border):
            total += M.below[i, t] * x[t]
        y[border + i] += total


class Subgradient(NamedTuple):
    """Rows Σ c[i, a] e_unit[i, a] + Σ b[i, e] M[row[i, e]] of a generalised Jacobian; c, unit (n, 3), b, row (n, 2)."""

    unit: Ints
    c: Array
    row: Ints
    b: Array


class Room(NamedTuple):
    """Work space of `solve_arrow` for n unknowns, B of them in blocks: J (an `Arrow` whose side has the right side as a
    further column, padded to a multiple of four, which processors like), solved (B, W) blocks divided into the side,
    late (blocks,).
    """

    J: Arrow
    solved: Array
    late: Bools


@kernel
def room(M: Arrow) -> Room:
    """Room for systems of this shape."""
    border, k = len(M.own), len(M.below)
    padded = (k + 4) // 4 * 4
    J = Arrow(np.empty((border, 3)), np.zeros((border + k, padded)), np.empty((k, border)), M.starts)
    return Room(J, np.zeros((border, padded)), np.empty(len(M.starts) - 1, np.bool_))


@kernel
def solve_arrow(M: Arrow, J: Subgradient, rhs: Array, x: Array, R: Room, rank_tolerance: float) -> None:
    """Solve J x = rhs, all (n,). Directions without a pivot, relative to the largest entry, stay at zero: for a
    consistent singular system that is one solution of many. Indices of J's row i are within the block of i.
    """
    starts, border, k = M.starts, len(M.own), len(M.below)
    tiny = rank_tolerance * _fill(M, J, rhs, R.J)
    left = k
    for g in range(len(starts) - 1):
        R.late[g] = not _eliminate_block(R, starts[g], starts[g + 1] - starts[g], tiny)
        if R.late[g]:
            left += starts[g + 1] - starts[g]
    _solve_rest(R, left, tiny, x)
    for g in range(len(starts) - 1):
        if not R.late[g]:
            for i in range(starts[g], starts[g + 1]):
                x[i] = R.solved[i, k]
                for t in range(k):
                    x[i] -= R.solved[i, t] * x[border + t]


@kernel
def _fill(M: Arrow, J: Subgradient, rhs: Array, A: Arrow) -> float:
    """Matrix and right side into A; returns the largest entry."""
    n, border, k, largest = len(rhs), len(M.own), len(M.below), 0.0
    for i in range(n):
        d, e, b0, b1 = J.row[i, 0], J.row[i, 1], J.b[i, 0], J.b[i, 1]
        for t in range(k):
            A.side[i, t] = b0 * M.side[d, t] + b1 * M.side[e, t]
        A.side[i, k] = rhs[i]
        if i < border:
            for t in range(3):
                A.own[i, t] = b0 * M.own[d, t] + b1 * M.own[e, t]
    for g in range(len(M.starts) - 1):
        start = M.starts[g]
        for i in range(start, M.starts[g + 1]):
            for a in range(3):
                A.own[i, J.unit[i, a] - start] += J.c[i, a]
            for t in range(3):
                if abs(A.own[i, t]) > largest:
                    largest = abs(A.own[i, t])
    for i in range(k):
        d, e = J.row[border + i, 0] - border, J.row[border + i, 1] - border
        b0, b1 = J.b[border + i, 0], J.b[border + i, 1]
        for t in range(border):
            A.below[i, t] = b0 * M.below[d, t] + b1 * M.below[e, t]
        for a in range(3):
            A.side[border + i, J.unit[border + i, a] - border] += J.c[border + i, a]
    for i in range(n):
        for t in range(k):
            if abs(A.side[i, t]) > largest:
                largest = abs(A.side[i, t])
    return largest


@kernel
def _eliminate_block(R: Room, start: int, width: int, tiny: float) -> bool:
    """Take a block out of the border rows; False, and nothing changed, where it is no good for that."""
    side, below, solved = R.J.side, R.J.below, R.solved
    border, padded = len(R.J.own), side.shape[1]
    A = np.empty((3, 3))
    for s in range(width):
        for t in range(3):
            A[s, t] = R.J.own[start + s, t]
        for t in range(padded):
            solved[start + s, t] = side[start + s, t]
    for s in range(width):
        p = s
        for i in range(s + 1, width):
            if abs(A[i, s]) > abs(A[p, s]):
                p = i
        if not abs(A[p, s]) > tiny:
            return False
        if p != s:
            for t in range(3):
                A[s, t], A[p, t] = A[p, t], A[s, t]
            for t in range(padded):
                solved[start + s, t], solved[start + p, t] = solved[start + p, t], solved[start + s, t]
        pivot = 1.0 / A[s, s]
        for t in range(3):
            A[s, t] *= pivot
        for t in range(padded):
            solved[start + s, t] *= pivot
        for i in range(width):  # Gauss-Jordan: with three rows it costs what back substitution would
            f = A[i, s]
            if i != s and f != 0.0:
                for t in range(3):
                    A[i, t] -= f * A[s, t]
                for t in range(padded):
                    solved[start + i, t] -= f * solved[start + s, t]
    largest = 0.0
    for s in range(width):
        for t in range(len(below)):
            largest = max(largest, abs(solved[start + s, t]))
    if not largest <= _GROWTH:
        return False
    for i in range(len(below)):
        if width == 3:  # most blocks: all three at once
            f, g, h = below[i, start], below[i, start + 1], below[i, start + 2]
            for t in range(padded):
                side[border + i, t] -= f * solved[start, t] + g * solved[start + 1, t] + h * solved[start + 2, t]
        else:
            for s in range(width):
                f = below[i, start + s]
                for t in range(padded):
                    side[border + i, t] -= f * solved[start + s, t]
    return True


@kernel
def _solve_rest(R: Room, left: int, tiny: float, x: Array) -> None:
    """Solve for the border and the blocks that were put off to it, into their entries of x."""
    J, starts, border, k = R.J, R.J.starts, len(R.J.own), len(R.J.below)
    A, e, z, col = np.zeros((left, left)), np.empty(left), np.empty(left), np.empty(left, np.int64)
    for s in range(k):
        for t in range(k):
            A[s, t] = J.side[border + s, t]
        e[s] = J.side[border + s, k]
    at = k
    for g in range(len(starts) - 1):
        if R.late[g]:
            start, width = starts[g], starts[g + 1] - starts[g]
            for s in range(width):
                for t in range(width):
                    A[at + s, at + t] = J.own[start + s, t]
                for t in range(k):
                    A[at + s, t], A[t, at + s] = J.side[start + s, t], J.below[t, start + s]
                e[at + s] = J.side[start + s, k]
            at += width
    eliminate(A, e, z, col, tiny)
    for s in range(k):
        x[border + s] = z[s]
    at = k
    for g in range(len(starts) - 1):
        if R.late[g]:
            for s in range(starts[g], starts[g + 1]):
                x[s] = z[at]
                at += 1
