"""Support functions of coal's convex shapes: the furthest point of a shape in a direction, and what lies inside it.

    h(n) = max over x in the shape of n · x

They follow from the shapes' dimensions alone, so that they can judge the distances that coal computes.
"""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.hand.robot.hull import planes

_SHAPES = (coal.Box, coal.Sphere, coal.Capsule, coal.Cylinder, coal.Ellipsoid, coal.Convex)


def known(geometry: Any) -> bool:
    """Whether this shape of coal has a support function here."""
    return isinstance(geometry, _SHAPES) and geometry.getSweptSphereRadius() == 0.0


def support(geometry: Any, n: Array) -> Array:
    """(k, 3) furthest points of the shape along n (k, 3), unit vectors; the shape's own axes."""
    match geometry:
        case coal.Box():
            return np.asarray(np.copysign(geometry.halfSide, n))
        case coal.Sphere():
            return np.asarray(geometry.radius * n)
        case coal.Capsule():
            return np.asarray(geometry.radius * n + _ends(geometry, n))
        case coal.Cylinder():
            across = n * (1.0, 1.0, 0.0)
            length = np.linalg.norm(across, axis=1, keepdims=True)
            rim = np.divide(geometry.radius * across, length, out=np.zeros_like(across), where=length > 0.0)
            return np.asarray(rim + _ends(geometry, n))
        case coal.Ellipsoid():
            stretched = geometry.radii * n
            return np.asarray(geometry.radii * stretched / np.linalg.norm(stretched, axis=1, keepdims=True))
        case _:
            points = np.asarray(geometry.points())
            return np.asarray(points[np.argmax(points @ n.T, axis=0)])


def _ends(geometry: Any, n: Array) -> Array:
    """(k, 3) the end of the axis of a capsule or a cylinder, along n."""
    out = np.zeros_like(n)
    out[:, 2] = np.copysign(geometry.halfLength, n[:, 2])
    return out


def beyond(geometry: Any, x: Array) -> float:
    """By how much the point x (3,), in the shape's axes, lies outside the shape [m]; 0 or less inside."""
    match geometry:
        case coal.Box():
            return float((abs(x) - geometry.halfSide).max())
        case coal.Sphere():
            return float(np.linalg.norm(x)) - float(geometry.radius)
        case coal.Capsule():
            off = x - _ends(geometry, x[None])[0] if abs(x[2]) > geometry.halfLength else x * (1.0, 1.0, 0.0)
            return float(np.linalg.norm(off)) - float(geometry.radius)
        case coal.Cylinder():
            return float(max(np.hypot(x[0], x[1]) - geometry.radius, abs(x[2]) - geometry.halfLength))
        case coal.Ellipsoid():
            return (float(np.linalg.norm(x / geometry.radii)) - 1.0) * float(geometry.radii.min())
        case _:
            if geometry.num_normals_and_offsets:
                return float((np.asarray(geometry.normals()) @ x + np.asarray(geometry.offsets())).max())
            _, normals, offsets = planes(geometry)
            return float((normals @ x - offsets).max())


def size_of(geometry: Any) -> float:
    """A length of the shape [m]: the largest distance of its surface from the origin of its axes, along an axis."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    return float(abs(support(geometry, axes)).max())
