"""Greedy randomized Kaczmarz steps on the rows of a contact problem."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import Contacts, rows, work
from handlcp.lcp.kernels.kaczmarz import Seeds, multiply_add, uniform

__all__ = ["contact_kaczmarz"]


@kernel
def contact_kaczmarz(
    p: Contacts, M: Array, MT: Array, MMT: Array, x: Array, y: Array, state: Seeds, steps: int, tolerance: float
) -> tuple[int, float]:
    """Greedy randomized Kaczmarz on the rows of F, as in `kaczmarz` ((20)–(22) of the paper); O(n) a step, in place.

    M (n, n), its transpose and M Mᵀ are in the order of p. x and y (n,) belong together on entry and on return.
    Returns (steps taken, ‖F‖₂).
    """
    n = len(x)
    F, g2, g = np.empty(n), np.empty(n), work(n)
    unit, c, row, b = g.unit, g.c, g.row, g.b
    norm = np.inf
    for step in range(steps + 1):
        if step % (4 * n) == 0 and step > 0:
            multiply_add(M, x, p.q, y)
        total = rows(p, x, y, F, g)
        norm = np.sqrt(total)
        frobenius, best = 0.0, 0.0
        for i in range(n):
            d, e = row[i, 0], row[i, 1]
            s = b[i, 0] * b[i, 0] * MMT[d, d] + b[i, 1] * b[i, 1] * MMT[e, e] + 2.0 * b[i, 0] * b[i, 1] * MMT[d, e]
            for a in range(3):
                k = unit[i, a]
                s += 2.0 * c[i, a] * (b[i, 0] * M[d, k] + b[i, 1] * M[e, k])
                for h in range(3):
                    if unit[i, h] == k:
                        s += c[i, a] * c[i, h]
            g2[i] = s
            frobenius += s
            if F[i] * F[i] > best * s:
                best = F[i] * F[i] / s if s > 0.0 else 0.0
        if not norm > tolerance or step == steps or not 0.0 < best < np.inf:
            return step, norm
        bar = 0.5 * (best + total / frobenius) * (1.0 - 1e-12)
        mass = 0.0
        for i in range(n):
            if F[i] * F[i] >= bar * g2[i] > 0.0:
                mass += F[i] * F[i]
        pick, chosen = uniform(state) * mass, -1
        for i in range(n):
            if F[i] * F[i] >= bar * g2[i] > 0.0:
                pick -= F[i] * F[i]
                chosen = i
                if pick < 0.0:
                    break
        t = F[chosen] / g2[chosen]
        for e in range(2):
            f, d = t * b[chosen, e], row[chosen, e]
            if f != 0.0:
                for j in range(n):
                    x[j] -= f * M[d, j]
                    y[j] -= f * MMT[d, j]
        for a in range(3):
            f, k = t * c[chosen, a], unit[chosen, a]
            if f != 0.0:
                x[k] -= f
                for j in range(n):
                    y[j] -= f * MT[k, j]
    return steps, norm
