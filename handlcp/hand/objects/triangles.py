"""The nearest point of a triangulated surface to a point, in closed form.

coal 3.0.3 measures a wrong distance between a triangle mesh and a ball that overlaps it: -3.9 mm instead of -5 mm.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.hand.robot.hull import planes

_ON = 1e-9  # of the size: a point this near to the surface takes its normal from the triangle


class Surface:
    """The surface of a convex hull of coal's: its planes n · x = offset with outward normals, and its triangles."""

    __slots__ = ("_normals", "_offsets", "_size", "_triangles")

    def __init__(self, hull: Any) -> None:
        self._triangles, self._normals, self._offsets = planes(hull)
        self._size = float(np.ptp(self._triangles, axis=(0, 1)).max())

    def beyond(self, points: Array) -> Array:
        """(m,) how far points (m, 3) are beyond the face that they are furthest beyond [m]: inside, minus the depth."""
        return np.asarray((points @ self._normals.T - self._offsets).max(axis=1))

    def closest(self, point: Array) -> tuple[float, Array, Array]:
        """Signed distance [m] of a point (3,), nearest surface point and outward normal, in the hull's axes."""
        over = self._normals @ point - self._offsets
        k = int(np.argmax(over))
        foot = point - over[k] * self._normals[k]
        if over[k] <= 0.0 or (self._normals @ foot - self._offsets).max() <= 1e-12 * self._size:
            return float(over[k]), foot, self._normals[k].copy()
        x, _ = _nearest(point, self._triangles[over > 0.0])  # the nearest point lies on a face that is visible
        apart = point - x
        distance = float(np.sqrt(apart @ apart))
        return (distance, x, apart / distance) if distance > 0.0 else (0.0, x, self._normals[k].copy())


def closest_of(point: Array, triangles: Array) -> tuple[float, Array, Array]:
    """As `Surface.closest`, of a closed surface (m, 3, 3) that need not be convex."""
    x, k = _nearest(point, triangles)
    apart, size = point - x, float(np.ptp(triangles, axis=(0, 1)).max())
    distance = float(np.sqrt(apart @ apart))
    inside = abs(winding(point, triangles)) > 0.5
    if distance > _ON * size:
        return (-distance, x, -apart / distance) if inside else (distance, x, apart / distance)
    a, b, c = triangles[k]
    out = np.cross(b - a, c - a)
    out /= np.linalg.norm(out)
    if abs(winding(x + 1e-6 * size * out, triangles)) > 0.5:
        out = -out
    return -distance if inside else distance, x, out


def _nearest(point: Array, triangles: Array) -> tuple[Array, int]:
    """The nearest point (3,) of triangles (m, 3, 3), and the number of its triangle."""
    edges = np.roll(triangles, -1, axis=1) - triangles
    to = point - triangles
    length2 = (edges * edges).sum(axis=2)
    share = np.clip((to * edges).sum(axis=2) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    on_edges = triangles + share[:, :, None] * edges
    off = ((point - on_edges) ** 2).sum(axis=2)
    i, j = np.unravel_index(int(np.argmin(off)), off.shape)
    best, found, number = float(off[i, j]), on_edges[i, j], int(i)
    normals = np.cross(edges[:, 0], edges[:, 1])
    size2 = (normals * normals).sum(axis=1)
    beside = (np.cross(edges, to) * normals[:, None]).sum(axis=2)
    above = (to[:, 0] * normals).sum(axis=1)
    over = (beside >= 0.0).all(axis=1) & (size2 > 0.0)
    height2 = np.where(over, above**2 / np.where(size2 > 0.0, size2, 1.0), np.inf)
    k = int(np.argmin(height2))
    if height2[k] < best:
        found, number = point - above[k] / size2[k] * normals[k], k
    return np.asarray(found), number


def winding(point: Array, triangles: Array) -> float:
    """How often a closed surface winds around a point: ±1 inside, 0 outside. The sum of the solid angles over 4π."""
    a, b, c = (triangles - point).transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1), np.linalg.norm(c, axis=1)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(2 * np.arctan2(volume, below).sum() / (4 * np.pi))
