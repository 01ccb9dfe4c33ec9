"""Products of small vectors and matrices of small blocks, where numpy's own cost ten times as much."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array


def cross_rows(a: Array, b: Array) -> Array:
    """A × b for (3,) arguments, or (n, 3) ones row by row."""
    if a.ndim == b.ndim == 1:
        (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
        return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    ax, ay, az = a.T
    bx, by, bz = b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def block_diagonal(blocks: Array, n: int) -> Array:
    """(nk, nk) with blocks (m, k, k), m ≤ n, first on its diagonal, or one (k, k) n times."""
    k, each = blocks.shape[-1], np.arange(len(blocks) if blocks.ndim == 3 else n)
    out = np.zeros((n, k, n, k))
    out[each, :, each] = blocks
    return out.reshape(n * k, n * k)


def shifted(twist: Array, arm: Array) -> Array:
    """(6,) the same small motion seen at a point `arm` (3,) away: u' = u + ω × arm."""
    u, v, w, p, q, r = twist.tolist()
    x, y, z = arm.tolist()
    return np.array([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r])
