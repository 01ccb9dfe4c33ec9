"""Greedy randomized Kaczmarz steps on the rows of a contact problem."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact_rows import Contacts, Subgradient, rows, work
from handlcp.lcp.kernels.dense import multiply_add
from handlcp.lcp.kernels.kaczmarz import Seeds, greedy_row


class _Sums(NamedTuple):
    """Rows Σ c[i, a] e_unit[i, a] + Σ b[i, e] M[row[i, e]]; unit, c (n, 4); row, b (n, 3)."""

    unit: Ints
    c: Array
    row: Ints
    b: Array


@kernel
def contact_kaczmarz(
    p: Contacts, MT: Array, MMT: Array, x: Array, y: Array, state: Seeds, steps: int, tolerance: float
) -> tuple[int, float]:
    """Greedy randomized Kaczmarz on the rows of F, as in `kaczmarz` ((20)–(22) of the paper); O(n) a step, in place.

    MT (n, n) is Mᵀ and MMT (n, n) is M Mᵀ. x and y (n,) belong together on entry and on return.
    Returns (steps taken, ‖F‖₂).
    """
    n = len(x)
    F, p2, g2, at = np.empty(n), np.empty(n), np.empty(n), work(p)
    g = _Sums(np.empty((n, 4), np.int64), np.empty((n, 4)), np.empty((n, 3), np.int64), np.empty((n, 3)))
    norm = np.inf
    for step in range(steps + 1):
        if step > 0 and step % (4 * n) == 0:  # y drifts by rounding
            multiply_add(p.M, x, p.q, y)
        total = rows(p, x, y, F, at)
        _sums(p, at, g)
        norm = np.sqrt(total)
        frobenius, best = 0.0, 0.0
        for i in range(n):
            p2[i], g2[i] = F[i] * F[i], _square(p.M, MMT, g, i)
            frobenius += g2[i]
            if p2[i] > best * g2[i]:
                best = p2[i] / g2[i] if g2[i] > 0.0 else np.inf
        if not norm > tolerance or step == steps or not 0.0 < best < np.inf:
            return step, norm
        i = greedy_row(p2, g2, best, total, frobenius, state)
        _move(p.M, MT, MMT, g, i, F[i] / g2[i], x, y)
    return steps, norm


@kernel
def _sums(p: Contacts, at: Subgradient, g: _Sums) -> None:
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
def _square(M: Array, MMT: Array, g: _Sums, i: int) -> float:
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
def _move(M: Array, MT: Array, MMT: Array, g: _Sums, i: int, t: float, x: Array, y: Array) -> None:
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
