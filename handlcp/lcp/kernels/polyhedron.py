"""The point of a ball or polyhedron about the origin that is nearest to a given one, and how it moves.

    min ‖p - s‖  with  nᵀp ≤ a for every normal n

Planes are added where p is farthest outside and dropped where they pull: a dual active-set method (Goldfarb & Idnani,
Math. Program. 27, 1983), with three planes at most, as many as there are dimensions.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["nearest_in_ball", "nearest_in_polyhedron"]

_TIE = 1e-12  # how far outside, in sizes of the answer, still counts as on a plane
_MOST = 60  # changes of the active planes, of which a polyhedron of a hundred faces takes five


@kernel
def nearest_in_ball(s: Array, a: float, p: Array, D: Array) -> None:
    """P (3,) ← the nearest point of the ball of radius a; D (3, 4) as in `nearest_in_polyhedron`."""
    length = np.sqrt(s[0] ** 2 + s[1] ** 2 + s[2] ** 2)
    D[:, :] = 0.0
    if length <= a:
        p[:] = s
        for i in range(3):
            D[i, i] = 1.0
        return
    # p = a e with e = s / |s|, and dp = (a/|s|)(1 - e eᵀ) ds + e da
    for i in range(3):
        e = s[i] / length
        p[i], D[i, 3] = a * e, e
        for j in range(3):
            D[i, j] = a / length * ((1.0 if i == j else 0.0) - e * s[j] / length)


@kernel
def nearest_in_polyhedron(s: Array, a: float, normals: Array, p: Array, D: Array) -> None:
    """P (3,) ← the nearest point; D (3, 4) ← its derivative by s and by a, of one of the pieces where several meet.

    normals (f, 3), unit. A plane problem has normals without a third component.
    """
    planes, count = np.empty(3, np.int64), 0
    weights, G = np.zeros(3), np.empty((3, 3))
    tie = _TIE * max(a, np.max(np.abs(s)))
    p[:], D[:, :] = s, 0.0
    if a <= 0.0:
        p[:] = 0.0
        return
    for _ in range(_MOST):
        worst, out = -1, tie
        for j in range(len(normals)):
            over = normals[j, 0] * p[0] + normals[j, 1] * p[1] + normals[j, 2] * p[2] - a
            if over > out:
                worst, out = j, over
        if worst < 0:
            break
        count = _enter(worst, a, normals, planes, count, weights, G, p)
    for i in range(3):
        D[i, i] = 1.0
    if count == 0:
        return
    _gram(normals, planes, count, G)
    for c in range(3):
        unit = np.zeros(3)
        unit[c] = 1.0
        r = _solve(G, count, normals, planes, unit)
        for i in range(count):
            for k in range(3):
                D[k, c] -= r[i] * normals[planes[i], k]
    r = _eliminated(G, count, np.ones(3))
    for i in range(count):
        for k in range(3):
            D[k, 3] += r[i] * normals[planes[i], k]


@kernel
def _enter(worst: int, a: float, normals: Array, planes: Ints, count: int, weights: Array, G: Array, p: Array) -> int:
    """Move p onto the plane `worst`, as far as the active ones allow: where one would pull, it goes first."""
    entering, n = 0.0, normals[worst]
    while True:
        _gram(normals, planes, count, G)
        r = _solve(G, count, normals, planes, n)
        across = n.copy()
        for i in range(count):
            across -= r[i] * normals[planes[i]]
        drop, length = -1, np.inf
        for i in range(count):
            if r[i] > 0.0 and weights[i] / r[i] < length:
                drop, length = i, weights[i] / r[i]
        size = across @ across
        full = (n @ p - a) / size if size > 1e-14 else np.inf
        step = min(full, length)
        if step == np.inf:
            return count
        for i in range(count):
            weights[i] -= step * r[i]
        entering += step
        if size > 1e-14:
            p -= step * across
        if full <= length:
            planes[count], weights[count] = worst, entering
            return count + 1
        for i in range(drop, count - 1):
            planes[i], weights[i] = planes[i + 1], weights[i + 1]
        count -= 1


@kernel
def _gram(normals: Array, planes: Ints, count: int, G: Array) -> None:
    """G ← the products of the active normals."""
    for i in range(count):
        for j in range(count):
            G[i, j] = normals[planes[i]] @ normals[planes[j]]


@kernel
def _solve(G: Array, count: int, normals: Array, planes: Ints, v: Array) -> Array:
    """The weights of the active normals that come nearest to v."""
    b = np.zeros(3)
    for i in range(count):
        b[i] = normals[planes[i]] @ v
    return _eliminated(G, count, b)


@kernel
def _eliminated(G: Array, count: int, b: Array) -> Array:
    """G⁻¹ b of the leading count × count block, positive definite: elimination without pivoting."""
    A, x = G.copy(), b.copy()
    for s in range(count):
        for i in range(s + 1, count):
            f = A[i, s] / A[s, s]
            for j in range(s, count):
                A[i, j] -= f * A[s, j]
            x[i] -= f * x[s]
    for s in range(count - 1, -1, -1):
        for j in range(s + 1, count):
            x[s] -= A[s, j] * x[j]
        x[s] /= A[s, s]
    return x
