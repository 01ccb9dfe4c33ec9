"""Convex shapes of coal as numbers: the furthest point in a direction, what lies inside, boxes and balls around them.

    h(n) = max over x in the shape of n · x

They follow from the shapes' dimensions alone, so that they can judge the distances that coal computes.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import coal
import numpy as np

from handlcp.check import Array, read_only
from handlcp.hand.robot.link_surface import planes
from handlcp.lcp.kernels.dense import kernel

_BOX, _SPHERE, _CAPSULE, _CYLINDER, _ELLIPSOID, _HULL = range(6)


class Solid(NamedTuple):
    """kind : of shape. sizes (3,) [m] : half the sides of a box, the radius and half the length of what is round about
    z, the radii of an ellipsoid. Of a hull points (m, 3), and the planes n · x = offset of its faces.
    """

    kind: int
    sizes: Array
    points: Array
    normals: Array
    offsets: Array


_SHAPES = (coal.Box, coal.Sphere, coal.Capsule, coal.Cylinder, coal.Ellipsoid, coal.Convex)


def known(geometry: Any) -> bool:
    """Whether this shape of coal has a support function here."""
    return isinstance(geometry, _SHAPES) and geometry.getSweptSphereRadius() == 0.0


@lru_cache(maxsize=1024)  # shapes of a hand and of what it holds: they are asked for at every distance
def solid(geometry: Any) -> Solid:
    """Of a shape of coal that is `known`."""
    match geometry:
        case coal.Box():
            return _round(_BOX, *geometry.halfSide)
        case coal.Sphere():
            return _round(_SPHERE, geometry.radius)
        case coal.Capsule():
            return _round(_CAPSULE, geometry.radius, geometry.halfLength)
        case coal.Cylinder():
            return _round(_CYLINDER, geometry.radius, geometry.halfLength)
        case coal.Ellipsoid():
            return _round(_ELLIPSOID, *geometry.radii)
        case _:
            _, normals, offsets = planes(geometry)
            return Solid(_HULL, np.zeros(3), *map(np.ascontiguousarray, (geometry.points(), normals, offsets)))


def _round(kind: int, *sizes: float) -> Solid:
    three = np.zeros(3)
    three[: len(sizes)] = sizes
    return Solid(kind, three, np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1))


@kernel
def furthest(s: Solid, n: Array, x: Array) -> None:
    """Write the furthest point (3,) along n (3,), a unit vector, in the shape's own axes."""
    if s.kind == _HULL:
        k = np.argmax(s.points[:, 0] * n[0] + s.points[:, 1] * n[1] + s.points[:, 2] * n[2])
        x[:] = s.points[k]
        return
    across = np.sqrt(n[0] * n[0] + n[1] * n[1])
    stretched = np.sqrt((s.sizes[0] * n[0]) ** 2 + (s.sizes[1] * n[1]) ** 2 + (s.sizes[2] * n[2]) ** 2)
    for a in range(3):
        if s.kind == _BOX:
            x[a] = np.copysign(s.sizes[a], n[a])
        elif s.kind == _ELLIPSOID:
            x[a] = s.sizes[a] * s.sizes[a] * n[a] / stretched
        elif s.kind == _CYLINDER:
            x[a] = s.sizes[0] * n[a] / max(across, 1e-300) if a < 2 else np.copysign(s.sizes[1], n[2])
        else:
            x[a] = s.sizes[0] * n[a]
            if s.kind == _CAPSULE and a == 2:
                x[a] += np.copysign(s.sizes[1], n[2])


@kernel
def out_of(s: Solid, x: Array) -> float:
    """By how much the point x (3,), in the shape's axes, lies outside the shape [m]; 0 or less inside."""
    if s.kind == _HULL:
        return float(np.max(s.normals[:, 0] * x[0] + s.normals[:, 1] * x[1] + s.normals[:, 2] * x[2] - s.offsets))
    if s.kind == _BOX:
        return float(max(abs(x[0]) - s.sizes[0], abs(x[1]) - s.sizes[1], abs(x[2]) - s.sizes[2]))
    if s.kind == _CYLINDER:
        return float(max(np.sqrt(x[0] * x[0] + x[1] * x[1]) - s.sizes[0], abs(x[2]) - s.sizes[1]))
    if s.kind == _ELLIPSOID:
        a, b, c = s.sizes
        return float((np.sqrt((x[0] / a) ** 2 + (x[1] / b) ** 2 + (x[2] / c) ** 2) - 1.0) * min(a, b, c))
    off = max(abs(x[2]) - s.sizes[1], 0.0) if s.kind == _CAPSULE else x[2]
    return float(np.sqrt(x[0] * x[0] + x[1] * x[1] + off * off) - s.sizes[0])


@kernel
def furthest_along(s: Solid, at: Array, ways: Array, sign: float, out: Array) -> None:
    """Write the furthest points (k, 3) of a shape along ways (k, 3), or against them by the sign; at (4, 3) : the
    shape's rotation, and in the last row its place.
    """
    n, x = np.empty(3), np.empty(3)
    for k in range(len(ways)):
        for a in range(3):
            n[a] = sign * (ways[k, 0] * at[0, a] + ways[k, 1] * at[1, a] + ways[k, 2] * at[2, a])
        furthest(s, n, x)
        for a in range(3):
            out[k, a] = at[a, 0] * x[0] + at[a, 1] * x[1] + at[a, 2] * x[2] + at[3, a]


_WHERE = np.vstack([np.eye(3), np.zeros(3)])


def support(geometry: Any, n: Array) -> Array:
    """(k, 3) furthest points of the shape along n (k, 3), unit vectors; the shape's own axes."""
    out = np.empty((len(n), 3))
    furthest_along(solid(geometry), _WHERE, np.ascontiguousarray(n), 1.0, out)
    return out


def beyond(geometry: Any, x: Array) -> float:
    """As `out_of`, of a shape of coal."""
    return out_of(solid(geometry), x)


@lru_cache(maxsize=1024)
def size_of(geometry: Any) -> float:
    """A length of the shape [m]: the largest distance of its surface from the origin of its axes, along an axis."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    return float(abs(support(geometry, axes)).max())


# ----------------------------------------------------------------
# Boxes and balls that hold coal's shapes, whether they are convex or not.


@lru_cache(maxsize=1024)
def box_of(geometry: Any) -> tuple[Array, Array]:
    """(3,) and (3,) the lowest and the highest corner of the box that holds the shape, along its own axes [m]."""
    geometry.computeLocalAABB()  # coal keeps it with the shape
    box = geometry.aabb_local
    return read_only(np.array(box.min_)), read_only(np.array(box.max_))


def balls_of(placed: Sequence[tuple[Any, Array, Array]]) -> tuple[Array, Array]:
    """Middles (m, 3) and radii (m,) of balls that hold m shapes [m]; placed : each shape, and its rotation (3, 3) and
    position (3,) [m] in the axes in which the middles are said.
    """
    boxes = [box_of(shape) for shape, _, _ in placed]
    middles = [R @ (0.5 * (low + high)) + p for (low, high), (_, R, p) in zip(boxes, placed, strict=True)]
    return np.array(middles), np.array([0.5 * float(np.linalg.norm(high - low)) for low, high in boxes])
