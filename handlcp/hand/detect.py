"""Contacts by coal: nearest points, normal and signed gap between a fingertip and an object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.hand.meshes import winding
from handlcp.hand.objects import Object
from handlcp.hand.tips import TipShape

__all__ = ["Proximity", "nearest"]

# GJK and EPA: tolerance on the distance [m]. Tighter ones gain nothing in the points and lose digits in the distance
# (measured on ellipsoids: 1e-10 → distance 1e-10, points 1e-6; 1e-14 → distance 3e-7).
GJK_TOLERANCE = 1e-10
GJK_ITERATIONS = 1000


@dataclass(frozen=True, slots=True)
class Proximity:
    """How a fingertip stands to an object: world axes, metres.

    gap : signed distance, negative when they overlap. position : (3,) on the object's surface. tip_point : (3,) on the
        fingertip's
    surface. normal : (3,) unit, from the tip into the object.
    """

    gap: float
    position: Array
    tip_point: Array
    normal: Array


def nearest(shapes: tuple[TipShape, ...], position: Array, rotation: Array, obj: Object) -> Proximity:
    """The nearest of a tip's shapes, the tip frame standing at `position` (3,) and `rotation` (3, 3).

    Raises InputError for an object that is not convex and overlaps (or faces) a tip that is no sphere.
    """
    best = None
    for shape in shapes:
        found = _nearest(shape, position + rotation @ shape.translation, rotation @ shape.rotation, obj)
        if best is None or found.gap < best.gap:
            best = found
    assert best is not None
    return best


def _nearest(shape: TipShape, p: Array, R: Array, obj: Object) -> Proximity:
    if shape.radius is not None:
        known = obj.closest(p) if obj.triangles is None else _to_triangles(p, obj, obj.triangles)
        if known is not None:
            distance, x, outward = known
            return Proximity(distance - shape.radius, x, p - shape.radius * outward, -outward)
    elif obj.triangles is not None:
        raise InputError(
            "tip_radius", "spherical fingertips for an object that is not convex", f"a {type(shape.geometry).__name__}"
        )
    gap, on_tip, on_object, normal = _ask(shape.geometry, coal.Transform3s(R, p), obj)
    return Proximity(gap, on_object, on_tip, normal)


def _to_triangles(p: Array, obj: Object, triangles: Array) -> tuple[float, Array, Array]:
    """Signed distance of a point to a closed surface: coal's distance with a ball too small to overlap, signed by the
    winding.
    """
    tiny = 1e-9 * float(np.ptp(triangles, axis=(0, 1)).max())
    distance, _, x, normal = _ask(coal.Sphere(tiny), coal.Transform3s(np.eye(3), p), obj)
    local = obj.placement.actInv(p)
    inside = abs(winding(local, triangles)) > 0.5
    apart = p - x
    length = float(np.sqrt(apart @ apart))
    outward = -normal if length <= 2 * tiny else apart / length * (-1.0 if inside else 1.0)
    return (-1.0 if inside else 1.0) * max(distance + tiny, length), x, outward


def _ask(geometry: Any, transform: Any, obj: Object) -> tuple[float, Array, Array, Array]:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = GJK_TOLERANCE
    request.gjk_max_iterations = request.epa_max_iterations = GJK_ITERATIONS
    gap = float(coal.distance(geometry, transform, obj.geometry, obj.transform, request, result))
    return gap, np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2()), np.array(result.normal)
