"""Convex hulls as coal's shapes.

coal 3.0.3 refuses hulls with a vertex of 255 or more neighbours: the tip of a fine cone, and one corner of a lid with
as many corners, which is cut into triangles like a fan. It crashes the process on points of one plane.
"""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from handlcp.check import Array, Ints

_MOST, _EACH = 250, 100  # neighbours that a vertex keeps, and how many those have that come in its place
_CUT = 1e-6  # of the edges' lengths: how much of such a vertex is cut off
_FLAT = 1e-9  # of its width: a hull that is thinner is flat


def hull(points: Array) -> Any | None:
    """The convex hull of points (k, 3) [m], a `coal.Convex`; None where they lie in a plane.

    A vertex with too many neighbours is cut off by a millionth of its edges, and several come in its place.
    """
    points = np.unique(points, axis=0)
    width = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1] if len(points) > 3 else np.zeros(3)
    if not width[2] > _FLAT * width[0]:
        return None
    try:
        return coal.Convex.convexHull(_vertices(points), True, "Qt")
    except RuntimeError:
        return _with_few_neighbours(points)


def planes(shape: Any) -> tuple[Array, Array, Array]:
    """The triangles (m, 3, 3) of a hull, their outward normals (m, 3) and offsets (m,): n · x = offset on each."""
    polygons = [shape.polygons(i) for i in range(shape.num_polygons)]
    triangles = np.array(shape.points(), dtype=float)[[[t[0], t[1], t[2]] for t in polygons]]
    if shape.num_normals_and_offsets == len(polygons):
        return triangles, np.array(shape.normals(), dtype=float), -np.array(shape.offsets(), dtype=float)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1)
    triangles, normals = triangles[length > 0.0], normals[length > 0.0] / length[length > 0.0, None]
    return triangles, normals, (triangles[:, 0] * normals).sum(axis=1)


def _vertices(points: Array) -> Any:
    given = coal.StdVec_Vec3s()
    for point in points:
        given.append(point)
    return given


def _with_few_neighbours(points: Array) -> Any:
    """The hull with lids in strips of triangles, and without vertices that even so have too many neighbours."""
    from scipy.spatial import ConvexHull  # a tenth of a second that few meshes should pay

    faces = _in_strips(points, ConvexHull(points))
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    corners, count = np.unique(edges, return_counts=True)
    if (many := corners[count > _MOST]).size:
        kept = [points[corners[count <= _MOST]]]
        for corner in many:
            there = edges[(edges == corner).any(axis=1)]
            to = points[there[there != corner]] - points[corner]
            axis = to.mean(axis=0)
            kept.append(points[corner] + _CUT * to[_round(to, axis)][::_EACH])
        points = np.concatenate(kept)
        faces = _in_strips(points, ConvexHull(points))
    used, faces = np.unique(faces, return_inverse=True)
    triangles = coal.StdVec_Triangle()
    for a, b, c in faces.reshape(-1, 3).tolist():
        triangles.append(coal.Triangle(a, b, c))
    return coal.Convex(_vertices(points[used]), triangles)


def _in_strips(points: Array, found: Any) -> Ints:
    """(m, 3) triangles of a hull found by qhull, counterclockwise from outside; flat faces with more than one of them
    cut into strips, so that no corner of such a face has more than four neighbours there.
    """
    _, face, size = np.unique(found.equations, axis=0, return_inverse=True, return_counts=True)
    out = []
    for own in np.split(np.argsort(face.reshape(-1), kind="stable"), np.cumsum(size)[:-1]):
        corners = np.unique(found.simplices[own])
        middle = points[corners].mean(axis=0)
        corners = corners[_round(points[corners] - middle, found.equations[own[0], :3])]
        low, high = 0, len(corners) - 1
        while high - low > 1:
            out.append(corners[[low, low + 1, high]])
            low += 1
            if high - low > 1:
                out.append(corners[[low, high - 1, high]])
                high -= 1
    return np.array(out)


def _round(to: Array, axis: Array) -> Ints:
    """The order of directions (k, 3) counterclockwise about an axis (3,)."""
    x = np.eye(3)[int(np.argmin(abs(axis)))]
    x = x - axis * (axis @ x) / (axis @ axis)
    return np.argsort(np.arctan2(to @ np.cross(axis, x), to @ x * np.linalg.norm(axis)), kind="stable")
