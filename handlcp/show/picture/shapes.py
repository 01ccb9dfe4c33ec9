"""Triangles of the shapes that hands and objects are made of; every array is (m, 3, 3), corners in metres."""

from __future__ import annotations

from itertools import product
from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.contact import contact_frame
from handlcp.robot.link_surface import mesh_triangles

_MANY = 4000  # triangles: a surface of fewer is not made coarser
AROUND = 96  # facets around a round shape
_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))  # of a cube with edges of one
# Corners of each side in their order, seen from outside
_SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def box(size: Any) -> Array:
    """A box about the origin with edges `size` (3,)."""
    triangles = _SIDES[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return np.asarray((_CORNERS * np.asarray(size, dtype=float))[triangles])


def revolved(profile: Any, around: int = AROUND) -> Array:
    """The surface that a profile sweeps about z. profile : points (radius, z) from the lower pole to the upper."""
    r, z = np.asarray(profile, dtype=float).T[..., None]
    a = 2 * np.pi * np.arange(around + 1) / around
    points = np.stack(np.broadcast_arrays(r * np.cos(a), r * np.sin(a), z), axis=-1)
    q00, q01, q10, q11 = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    both = np.concatenate([np.stack([q00, q01, q11], axis=2), np.stack([q00, q11, q10], axis=2)])
    t = both.reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
    return np.asarray(t[area > 1e-12 * max(float(area.max()), 1e-300)])


def ellipsoid(radii: Any) -> Array:
    """An ellipsoid about the origin. radii : semi-axes (3,), or one radius."""
    a = np.linspace(-np.pi / 2, np.pi / 2, 25)
    ball = revolved(np.stack([np.cos(a), np.sin(a)], axis=1))
    return np.asarray(ball * (np.ones(3) * np.asarray(radii, dtype=float)))


def cylinder(radius: float, length: float) -> Array:
    """A cylinder along z about the origin."""
    h = length / 2
    return revolved([(0, -h), (radius, -h), (radius, h), (0, h)])


def capsule(start: Any, end: Any, radius: float) -> Array:
    """A rod with round ends between two points."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(b - a))
    t = np.linspace(0, np.pi / 2, 6)
    low = [(radius * np.sin(x), -radius * np.cos(x)) for x in t]
    up = [(radius * np.cos(x), length + radius * np.sin(x)) for x in t]
    shape = revolved([*low, *up], 20)
    axis = (b - a) / length if length > 0 else np.array([0.0, 0.0, 1.0])
    return np.asarray(shape @ contact_frame(axis).T + a)


def hull(points: Array, thickness: float) -> Array | None:
    """The convex hull of points (n, 3), given a thickness where they lie in a plane; None where they span nothing."""
    p = np.asarray(points, dtype=float)
    centred = p - p.mean(0)
    _, s, axes = np.linalg.svd(centred)
    if len(p) < 3 or s[1] < 1e-6 * max(s[0], 1e-300):
        return None
    if len(s) < 3 or s[2] < 1e-3 * s[0]:
        p = np.concatenate([p + axes[2] * thickness / 2, p - axes[2] * thickness / 2])
    if (t := hull_of(p)) is None:
        return None
    outward = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    flip = (outward * (t.mean(1) - p.mean(0))).sum(1) < 0
    t[flip] = t[flip][:, ::-1]
    return t


def hull_of(points: Array) -> Array | None:
    """The convex hull of points (n, 3), its triangles turned either way; None where they span no volume."""
    from scipy.spatial import ConvexHull, QhullError  # a quarter of a second that few pictures should pay

    try:
        return np.asarray(points[ConvexHull(points).simplices])
    except QhullError:
        return None


def of_coal(geometry: Any) -> Array | None:
    """Triangles of a coal geometry; None for one that has no picture."""
    g = geometry
    if isinstance(g, coal.Sphere):
        return ellipsoid(g.radius)
    if isinstance(g, coal.Ellipsoid):
        return ellipsoid(np.array(g.radii).ravel())
    if isinstance(g, coal.Box):
        return box(2 * np.array(g.halfSide).ravel())
    if isinstance(g, coal.Cylinder):
        return cylinder(g.radius, 2 * g.halfLength)
    if isinstance(g, coal.Capsule):
        return capsule((0, 0, -g.halfLength), (0, 0, g.halfLength), g.radius)
    if isinstance(g, coal.Cone):
        return revolved([(0, -g.halfLength), (g.radius, -g.halfLength), (0, g.halfLength)])
    if isinstance(g, coal.BVHModelBase):
        triangles = mesh_triangles(g)
        return triangles if len(triangles) else None
    return hull(np.array(g.points()), 0.0) if isinstance(g, coal.ConvexBase) else None


def coarse(triangles: Array, cell: float) -> Array:
    """(k, 3, 3) about the same surface, of many triangles (m, 3, 3): corners on a grid, what falls together once."""
    if len(triangles) < _MANY:
        return triangles
    corners = np.round(triangles / cell).astype(np.int64)
    a, b, c = corners.transpose(1, 0, 2)
    kept = corners[(a != b).any(1) & (b != c).any(1) & (c != a).any(1)]
    return np.asarray(np.unique(kept.reshape(-1, 9), axis=0).reshape(-1, 3, 3) * cell)


def placed(triangles: Array, placement: Any) -> Array:
    """Triangles moved by `placement`, a pin.SE3."""
    return np.asarray(triangles @ np.asarray(placement.rotation).T + np.asarray(placement.translation))
