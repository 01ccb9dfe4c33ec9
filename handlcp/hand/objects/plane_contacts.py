"""Where an object meets a plane: the points that can touch it, and no more of them than are needed.

A rigid object stays above a plane as long as its extreme points do: corners of a box, points on the rims of a
cylinder, one point of a ball or an ellipsoid, vertices of a mesh. A point above the convex hull of points that are no
higher cannot touch before they do, and is left out. Of a flat patch the corners of its convex hull remain.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.grasp.model.contact import frame
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Box, Cylinder, Ellipsoid, Mesh, Sphere

RIM = 8  # points on each rim of a cylinder
_LIES = 0.2  # sine of the angle between a cylinder's axis and the plane's normal: less, and it stands on its rim
_FLAT = 1e-9  # times the object's size: smaller differences of height and distances from a line are zero


def plane_contacts(obj: Object, point: Array, normal: Array, max_gap: float) -> tuple[Array, Array, float]:
    """(m, 3) points of the object within `max_gap` [m] of the plane through `point` with this unit normal, on the side
    of the object; their gaps (m,) [m], < 0 below the plane; and the smallest gap of the object, also where m is 0.
    World axes. Raises InputError for an object of an unknown kind.
    """
    points = _extremes(obj, normal)
    heights = (points - point) @ normal
    near = heights <= max_gap
    points, gaps = points[near], heights[near]
    if len(points) > 1:
        kept = _needed(points, gaps, normal)
        points, gaps = points[kept], gaps[kept]
    return points, gaps, float(heights.min())


def rolling_point(obj: Object, normal: Array, near: Array) -> Array | None:
    """(3,) where a round object touches a plane with this unit normal, world axes; None for an object that stands on
    corners. near (3,) : where it touched before; of a cylinder it tells which rim.
    """
    R, p = obj.placement.rotation, obj.placement.translation
    down = -(R.T @ normal)
    match obj:
        case Sphere() | Ellipsoid():
            return np.asarray(_extremes(obj, normal)[0])
        case Cylinder() if float(np.hypot(down[0], down[1])) > _LIES:
            rims = _rims(obj, down)[::RIM]
            upper = float(R[:, 2] @ (near - p)) > 0.0
            return np.asarray(R @ rims[int(upper)] + p)
    return None


def _extremes(obj: Object, normal: Array) -> Array:
    """(k, 3) extreme points towards the plane, world axes."""
    R, p = obj.placement.rotation, obj.placement.translation
    down = -(R.T @ normal)
    match obj:
        case Box():
            signs = np.array([[x, y, z] for z in (-0.5, 0.5) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
            local = signs * obj.size
        case Sphere():
            local = obj.radius * down[None]
        case Ellipsoid():
            stretched = obj.radii * down
            local = (obj.radii * stretched / np.sqrt(stretched @ stretched))[None]
        case Cylinder():
            local = _rims(obj, down)
        case Mesh():
            corners = obj.geometry.points() if obj.triangles is None else obj.triangles
            local = np.unique(np.array(corners, dtype=float).reshape(-1, 3), axis=0)
        case _:
            expected = "a Box, Sphere, Cylinder, Ellipsoid or Mesh to find contacts of"
            raise InputError("object", expected, repr(obj)[:80])
    return np.asarray(local @ R.T + p)


def _rims(obj: Cylinder, down: Array) -> Array:
    """(2 RIM, 3) points on both rims, the first of each the one furthest along `down`; cylinder axes."""
    leaning = float(np.hypot(down[0], down[1]))
    start = np.arctan2(down[1], down[0]) if leaning > _FLAT else 0.0
    a = start + 2 * np.pi * np.arange(RIM) / RIM
    ring = np.column_stack([obj.radius * np.cos(a), obj.radius * np.sin(a), np.full(RIM, 0.5 * obj.length)])
    return np.concatenate([ring * (1, 1, -1), ring])


def _needed(points: Array, heights: Array, normal: Array) -> list[int]:
    """Numbers of the points that are corners of the hull of all at their height or below, the lowest first."""
    flat = (points - points[0]) @ frame(normal)[:, :2]
    size = float(np.ptp(points, axis=0).max())
    order = np.argsort(heights, kind="stable")
    levels = np.split(order, np.flatnonzero(np.diff(heights[order]) > _FLAT * size) + 1)
    hull: list[int] = []
    kept: list[int] = []
    for level in levels:
        hull = _hull(flat, [*hull, *level.tolist()], _FLAT * size)
        kept += [i for i in hull if i not in kept]
    return kept


def _hull(flat: Array, members: list[int], least: float) -> list[int]:
    """Corners of the convex hull of the points of flat (k, 2) numbered `members`, by Andrew's monotone chain. A point
    within `least` of a line between two others, or of another point, is no corner.
    """
    members = sorted(members, key=lambda i: (flat[i, 0], flat[i, 1]))

    def half(run: list[int]) -> list[int]:
        out: list[int] = []
        for i in run:
            while len(out) > 1 and _turn(flat[out[-2]], flat[out[-1]], flat[i]) <= least:
                out.pop()
            if not out or np.hypot(*(flat[i] - flat[out[-1]])) > least:
                out.append(i)
        return out

    lower, upper = half(members), half(members[::-1])
    corners = [*lower[:-1], *upper[:-1]] or lower
    return list(dict.fromkeys(corners))


def _turn(a: Array, b: Array, c: Array) -> float:
    """Distance of b to the right of the line from a to c [m]; > 0 where the chain turns left at b."""
    along = c - a
    length = float(np.hypot(*along))
    cross = float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    return cross / length if length > 0.0 else 0.0
