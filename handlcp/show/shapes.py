"""Triangles of the shapes that hands and objects are made of; every array is (m, 3, 3), corners in metres."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array

__all__ = ["box", "capsule", "cylinder", "ellipsoid", "hull", "of_coal", "placed", "revolved"]

AROUND = 96  # facets around a round shape


def box(size: Any, cells: int = 10) -> Array:
    """A box of edges `size` (3,) about the origin; each face in cells × cells quads, so that depth sorting works."""
    g = np.linspace(-0.5, 0.5, cells + 1)
    a, b = (m.ravel() for m in np.meshgrid(g[:-1], g[:-1], indexing="ij"))
    d = 1.0 / cells
    square = np.array([[[0, 0], [d, 0], [d, d]], [[0, 0], [d, d], [0, d]]])
    flat = (np.stack([a, b], axis=1)[:, None, None, :] + square[None]).reshape(-1, 3, 2)
    faces = []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        for side in (-0.5, 0.5):
            t = np.empty((len(flat), 3, 3))
            t[..., i], t[..., j], t[..., axis] = flat[..., 0], flat[..., 1], side
            faces.append(t if side > 0 else t[:, ::-1])
    return np.asarray(np.concatenate(faces) * np.asarray(size, dtype=float))


def revolved(profile: Any, around: int = AROUND) -> Array:
    """The surface that a profile of (radius, z) points, from the lower pole to the upper, sweeps about z."""
    p = np.asarray(profile, dtype=float)
    a = 2 * np.pi * np.arange(around + 1) / around
    ring = np.stack([np.cos(a), np.sin(a)], axis=1)
    points = np.empty((len(p), around + 1, 3))
    points[..., :2] = p[:, None, :1] * ring[None]
    points[..., 2] = p[:, 1:]
    q00, q01, q10, q11 = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    both = np.concatenate([np.stack([q00, q01, q11], axis=2), np.stack([q00, q11, q10], axis=2)])
    t = both.reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
    return np.asarray(t[area > 1e-12 * max(float(area.max()), 1e-300)])


def ellipsoid(radii: Any, rings: int = 24) -> Array:
    """Semi-axes (3,) or a radius."""
    a = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    ball = revolved(np.stack([np.cos(a), np.sin(a)], axis=1))
    return np.asarray(ball * (np.ones(3) * np.asarray(radii, dtype=float)))


def cylinder(radius: float, length: float, around: int = AROUND) -> Array:
    """Along z about the origin, caps in rings."""
    h, r = length / 2, np.linspace(0, 1, 5)
    z = np.linspace(-h, h, 9)
    low, up = [(radius * x, -h) for x in r], [(radius * x, h) for x in r[::-1]]
    return revolved([*low, *((radius, x) for x in z[1:-1]), *up], around)


def capsule(start: Any, end: Any, radius: float) -> Array:
    """A rod with round ends between two points."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    axis = b - a
    length = float(np.linalg.norm(axis))
    t = np.linspace(0, np.pi / 2, 6)
    low = [(radius * np.sin(x), -radius * np.cos(x)) for x in t]
    up = [(radius * np.cos(x), length + radius * np.sin(x)) for x in t]
    middle = [(radius, z) for z in np.linspace(0, length, 7)[1:-1]] if length > 0 else []
    shape = revolved([*low, *middle, *up], 20)
    z = axis / length if length > 0 else np.array([0.0, 0.0, 1.0])
    x = np.eye(3)[int(np.argmin(abs(z)))]
    x = x - z * (z @ x)
    x /= np.linalg.norm(x)
    return np.asarray(shape @ np.column_stack([x, np.cross(z, x), z]).T + a)


def hull(points: Array, thickness: float) -> Array | None:
    """What is known of an object that nobody described: the hull of its contacts. Flat ones get a thickness."""
    from scipy.spatial import ConvexHull, QhullError

    p = np.asarray(points, dtype=float)
    centred = p - p.mean(0)
    _, s, axes = np.linalg.svd(centred)
    if len(p) < 3 or s[1] < 1e-6 * max(s[0], 1e-300):
        return None
    if len(s) < 3 or s[2] < 1e-3 * s[0]:
        p = np.concatenate([p + axes[2] * thickness / 2, p - axes[2] * thickness / 2])
    try:
        h = ConvexHull(p)
    except QhullError:
        return None
    t = np.asarray(p[h.simplices])
    outward = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    flip = (outward * (t.mean(1) - p.mean(0))).sum(1) < 0
    t[flip] = t[flip][:, ::-1]
    return t


def of_coal(geometry: Any) -> tuple[Array, bool] | None:
    """(triangles, whether they all wind outwards) of a coal geometry; None for one that has no picture."""
    import coal

    g = geometry
    if isinstance(g, coal.Sphere):
        return ellipsoid(g.radius), True
    if isinstance(g, coal.Ellipsoid):
        return ellipsoid(np.array(g.radii).ravel()), True
    if isinstance(g, coal.Box):
        return box(2 * np.array(g.halfSide).ravel()), True
    if isinstance(g, coal.Cylinder):
        return cylinder(g.radius, 2 * g.halfLength), True
    if isinstance(g, coal.Capsule):
        return capsule((0, 0, -g.halfLength), (0, 0, g.halfLength), g.radius), True
    if isinstance(g, coal.Cone):
        return revolved([(0, -g.halfLength), (g.radius, -g.halfLength), (0, g.halfLength)]), True
    if isinstance(g, coal.BVHModelBase):
        corners = np.array(g.vertices(), dtype=float)
        index = np.array([[t[0], t[1], t[2]] for t in (g.tri_indices(i) for i in range(g.num_tris))], dtype=int)
        return (corners[index], False) if len(index) else None
    if isinstance(g, coal.ConvexBase):
        return (t, True) if (t := hull(np.array(g.points()), 0.0)) is not None else None
    return None


def placed(triangles: Array, placement: Any) -> Array:
    """The same in the world, by a pin.SE3."""
    return np.asarray(triangles @ np.asarray(placement.rotation).T + np.asarray(placement.translation))
