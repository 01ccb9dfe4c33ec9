"""The certifier's arithmetic: w = M z + q afresh, and the natural residual in natural units."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import project

__all__ = ["product", "recompute", "recompute_contact"]


@kernel
def product(a: Array, b: Array) -> Array:
    """A b, entry by entry; what overflows is infinite, and the certifier refuses it."""
    return a * b


@kernel
def recompute(
    M: Array, q: Array, free: Bools, z_unit: Array, w_unit: Array, z: Array, growth: float
) -> tuple[Array, float]:
    """(w, residual): w = M z + q, and the worst of |min(z_i, w_i)|, |w_i| where free, in units of z and w.

    Divided by the size of z, clipped to [1, growth]. Infinite where anything is not finite.
    """
    n = len(q)
    w, size, worst = np.empty(n), 1.0, 0.0
    some, k = np.empty(n, np.int64), 0  # most multipliers are zero
    for j in range(n):
        if z[j] != 0.0:
            some[k] = j
            k += 1
    for i in range(n):
        total = q[i]
        for t in range(k):
            total += M[i, some[t]] * z[some[t]]
        w[i] = total
        zs, ws = z[i] / z_unit[i], total / w_unit[i]
        if not (abs(zs) < np.inf and abs(ws) < np.inf):
            worst = np.inf
        else:
            size = max(size, abs(zs))
            worst = max(worst, abs(ws) if free[i] else abs(min(zs, ws)))
    return w, worst / min(size, growth)


@kernel
def recompute_contact(
    M: Array, q: Array, role: Ints, blocks: Ints, limits: Array, faces: int, x: Array, growth: float
) -> tuple[Array, float]:
    """(y, residual) of a contact problem: the worst of |y_i| (free), |min(x_i, y_i)| (pairs), and for each block the
    excess of x_T over its limit and the distance of x_T from the projection of x_T - y_T; over the size of x, clipped.
    """
    n = len(q)
    y, size, worst = np.empty(n), 1.0, 0.0
    for i in range(n):
        total = q[i]
        for j in range(n):
            total += M[i, j] * x[j]
        y[i] = total
        if not (abs(x[i]) < np.inf and abs(total) < np.inf):
            return y, np.inf
        size = max(size, abs(x[i]))
        if role[i] == 0:
            worst = max(worst, abs(total))
        elif role[i] == 1:
            worst = max(worst, abs(min(x[i], total)))
    P, unused = np.empty(2), np.empty((2, 3))
    for k in range(len(blocks)):
        t, o = blocks[k, 1], blocks[k, 2]
        a = limits[k] * max(x[blocks[k, 0]], 0.0)
        side, slip = (0.0, 0.0) if o < 0 else (x[o], y[o])
        project(x[t], side, a, 0.0, faces, P, unused)
        worst = max(worst, np.hypot(x[t] - P[0], side - P[1]))
        project(x[t] - y[t], side - slip, a, 0.0, faces, P, unused)
        worst = max(worst, np.hypot(x[t] - P[0], side - P[1]))
    return y, worst / min(size, growth)
