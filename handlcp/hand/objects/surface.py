"""The nearest point of a triangulated surface to a point, in closed form, compiled.

coal 3.0.3 measures a wrong distance between a triangle mesh and a ball that overlaps it: -3.9 mm instead of -5 mm.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.hand.robot.link_surface import planes
from handlcp.lcp.kernels.dense import kernel

_ON = 1e-9  # of the size: a point this near to the surface takes its normal from the triangle
_AT_ONCE = 1024  # points that are measured together: what they take stays in the processor's cache
_SAME = 1e-12  # of the size: a foot that is beyond no other face by more lies on the hull


class Faces(NamedTuple):
    """The triangles (m, 3, 3) of a hull, balls (m, 4) that hold them, their outward normals (m, 3) and offsets (m,)."""

    triangles: Array
    balls: Array
    normals: Array
    offsets: Array


class Hull:
    """The surface of a convex hull of coal's: its planes n · x = offset with outward normals, and its triangles."""

    __slots__ = ("_faces", "_size")

    def __init__(self, hull: Any) -> None:
        triangles, normals, offsets = planes(hull)
        self._faces = Faces(triangles, _around(triangles), normals, offsets)
        self._size = _size(triangles)

    def beyond(self, points: Array) -> Array:
        """(m,) how far points (m, 3) are beyond the face that they are furthest beyond [m]: inside, minus the depth."""
        return beyond(points, self._faces.normals, self._faces.offsets)

    def closest(self, points: Array) -> tuple[Array, Array, Array]:
        """Signed distances (m,) [m] of points (m, 3), nearest surface points and outward normals (m, 3), own axes."""
        away, on, out = np.empty(len(points)), np.empty_like(points), np.empty_like(points)
        _on_hull(points, self._faces, _SAME * self._size, away, on, out)
        return away, on, out


class Closed:
    """A closed surface of triangles (m, 3, 3) that need not be convex."""

    __slots__ = ("_balls", "_numbers", "_size", "_triangles")

    def __init__(self, triangles: Array) -> None:
        self._triangles, self._balls, self._size = triangles, _around(triangles), _size(triangles)
        self._numbers = np.arange(len(triangles))

    def closest(self, points: Array) -> tuple[Array, Array, Array]:
        """As of a hull."""
        away, on, out = np.empty(len(points)), np.empty_like(points), np.empty_like(points)
        for i, point in enumerate(points):
            away[i], on[i], out[i] = self._closest(point)
        return away, on, out

    def _closest(self, point: Array) -> tuple[float, Array, Array]:
        """Of one point (3,)."""
        x = np.empty(3)
        k = _nearest(point, self._triangles, self._balls, self._numbers, x)
        apart = point - x
        distance = float(np.sqrt(apart @ apart))
        inside = abs(winding(point, self._triangles)) > 0.5
        if distance > _ON * self._size:
            return (-distance, x, -apart / distance) if inside else (distance, x, apart / distance)
        a, b, c = self._triangles[k]
        out = np.cross(b - a, c - a)
        out /= np.linalg.norm(out)
        if abs(winding(x + 1e-6 * self._size * out, self._triangles)) > 0.5:
            out = -out
        return -distance if inside else distance, x, out


def beyond(points: Array, normals: Array, offsets: Array) -> Array:
    """(m,) how far points (m, 3) are beyond that of the planes n · x = offset, normals (k, 3), which they are furthest
    beyond.
    """
    out = np.empty(len(points))
    for k in range(0, len(points), _AT_ONCE):
        out[k : k + _AT_ONCE] = (points[k : k + _AT_ONCE] @ normals.T - offsets).max(axis=1)
    return out


def _around(triangles: Array) -> Array:
    """(m, 4) middles and radii of balls that hold triangles (m, 3, 3)."""
    middles = triangles.mean(axis=1)
    radii = np.linalg.norm(triangles - middles[:, None], axis=2).max(axis=1)
    return np.column_stack([middles, radii])


def _size(triangles: Array) -> float:
    """The longest edge of a box around triangles (m, 3, 3) [m]."""
    return float(np.ptp(triangles, axis=(0, 1)).max())


def winding(point: Array, triangles: Array) -> float:
    """How often a closed surface winds around a point: ±1 inside, 0 outside. The sum of the solid angles over 4π."""
    return float(solid_angles(triangles - point).sum() / (4 * np.pi))


def solid_angles(triangles: Array) -> Array:
    """(k,) of triangles (k, 3, 3) seen from the origin, < 0 from their front: Van Oosterom and Strackee (1983)."""
    a, b, c = triangles.transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1), np.linalg.norm(c, axis=1)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.asarray(2 * np.arctan2(volume, below))


# ----------------------------------------------------------------


@kernel
def _on_hull(points: Array, faces: Faces, same: float, away: Array, on: Array, out: Array) -> None:
    """Write distances (m,) of points (m, 3) from a hull, signed; nearest points of its surface; the normals there."""
    triangles, balls, normals, offsets = faces
    visible = np.empty(len(offsets), np.int64)
    for m in range(len(points)):
        point, x = points[m], on[m]
        furthest, k, count = -np.inf, 0, 0
        for i in range(len(offsets)):
            over = normals[i, 0] * point[0] + normals[i, 1] * point[1] + normals[i, 2] * point[2] - offsets[i]
            if over > 0.0:
                visible[count] = i
                count += 1
            if over > furthest:
                furthest, k = over, i
        for a in range(3):
            x[a], out[m, a] = point[a] - furthest * normals[k, a], normals[k, a]
        away[m], on_face = furthest, True
        for i in range(len(offsets) if count > 0 else 0):
            if normals[i, 0] * x[0] + normals[i, 1] * x[1] + normals[i, 2] * x[2] - offsets[i] > same:
                on_face = False
                break
        if not on_face:
            _nearest(point, triangles, balls, visible[:count], x)  # the nearest point lies on a face that is visible
            away[m] = np.sqrt((point[0] - x[0]) ** 2 + (point[1] - x[1]) ** 2 + (point[2] - x[2]) ** 2)
            if away[m] > 0.0:
                for a in range(3):
                    out[m, a] = (point[a] - x[a]) / away[m]


@kernel
def _nearest(point: Array, triangles: Array, balls: Array, among: Ints, x: Array) -> int:
    """Write the nearest point (3,) of those of the triangles (m, 3, 3) whose numbers are given; returns the number.
    balls (m, 4) : a triangle is looked at where its ball could be nearer than what was found, the nearest one first.
    """
    far, first = np.empty(len(among)), 0
    for i in range(len(among)):
        b = balls[among[i]]
        far[i] = np.sqrt((point[0] - b[0]) ** 2 + (point[1] - b[1]) ** 2 + (point[2] - b[2]) ** 2) - b[3]
        if far[i] < far[first]:
            first = i
    best, found = np.inf, among[first]
    foot, n, along, to = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for number in range(-1, len(among)):
        k = first if number < 0 else number
        if number == first or (far[k] > 0.0 and far[k] * far[k] >= best):
            continue
        i = among[k]
        for j in range(3):
            length2, share = 0.0, 0.0
            for a in range(3):
                along[j, a] = triangles[i, (j + 1) % 3, a] - triangles[i, j, a]
                to[j, a] = point[a] - triangles[i, j, a]
                length2 += along[j, a] * along[j, a]
                share += to[j, a] * along[j, a]
            share = min(max(share / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
            off = 0.0
            for a in range(3):
                foot[a] = triangles[i, j, a] + share * along[j, a]
                off += (point[a] - foot[a]) ** 2
            if off < best:
                best, found = off, i
                x[:] = foot
        size2, above = 0.0, 0.0
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            n[a] = along[0, b] * along[1, c] - along[0, c] * along[1, b]
            size2 += n[a] * n[a]
            above += to[0, a] * n[a]
        over = size2 > 0.0 and above * above < best * size2
        for j in range(3):  # over the face: on the inner side of each edge
            beside = 0.0
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                beside += (along[j, b] * to[j, c] - along[j, c] * to[j, b]) * n[a]
            over = over and beside >= 0.0
        if over:
            best, found = above * above / size2, i
            for a in range(3):
                x[a] = point[a] - above / size2 * n[a]
    return int(found)
