"""The certifier's arithmetic: w = M z + q afresh, and the natural residual in natural units."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.kernels.projection import nearest


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
    multiply_add(M, z, q, w)
    for i in range(n):
        zs, ws = z[i] / z_unit[i], w[i] / w_unit[i]
        if not (abs(zs) < np.inf and abs(ws) < np.inf):
            worst = np.inf
        else:
            size = max(size, abs(zs))
            worst = max(worst, abs(ws) if free[i] else abs(min(zs, ws)))
    return w, worst / min(size, growth)


@kernel
def recompute_contact(
    M: Array, q: Array, role: Ints, blocks: Ints, limits: Array, faces: int, normals: Array, x: Array
) -> tuple[Array, float, float]:
    """(y, worst, size) of a contact problem: the worst of |y_i| (free), |min(x_i, y_i)| (pairs), and for each block the
    excess of x_T over its limit and the distance of x_T from the projection of x_T - y_T; and the largest of 1 and |x|.
    """
    n = len(q)
    y, size, worst = np.empty(n), 1.0, 0.0
    multiply_add(M, x, q, y)
    for i in range(n):
        if not (abs(x[i]) < np.inf and abs(y[i]) < np.inf):
            return y, np.inf, 1.0
        size = max(size, abs(x[i]))
        if role[i] < 2:
            worst = max(worst, abs(y[i] if role[i] == 0 else min(x[i], y[i])))
    s, P, unused = np.zeros(3), np.empty(3), np.empty((3, 4))
    for k in range(len(blocks)):
        a, tangents = limits[k] * max(x[blocks[k, 0]], 0.0), blocks[k, 1:]
        for pull in (0.0, 1.0):
            d, off = 0, 0.0
            s[:] = 0.0
            for i in tangents:
                if i >= 0:
                    s[d] = x[i] - pull * y[i]
                    d += 1
            nearest(s, d, a, 0.0, faces, normals, P, unused)
            for m in range(d):
                off += (x[tangents[m]] - P[m]) ** 2
            worst = max(worst, np.sqrt(off))
    return y, worst, size
