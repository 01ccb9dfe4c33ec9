"""Where one convex shape touches an object: at a point, along a line, or on a patch; and what of it stands there.

The shape is tilted by a small angle in eight directions. Where both surfaces are curved the nearest point moves by the
angle times a radius, a tenth of a millimetre; where both are flat it moves to the other end of what touches. A line is
held by its two ends and a patch by up to four corners. More points of a line add no wrench, and none of a rectangle.

At each of them the shape becomes what it is there: a ball of its own radius, a line or a face (`Swept`), so that what
moves later stays on the surface that is there, flat where it is flat. Hulls of meshes stay whole where they touch at a
point.
"""

from __future__ import annotations

from dataclasses import replace

import coal
import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.model.contact import frame as axes_of
from handlcp.hand.objects.detect import Proximity, nearest
from handlcp.hand.objects.flat import SPREAD, TILT, is_wide, tilted
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.solid import size_of, support
from handlcp.hand.robot.tip_geometry import Swept, TipShape
from handlcp.hand.sites.corners import SAME, TINY, around, carrying, in_plane, spanning, swept

_ROUNDING = 1e-4  # [rad] of detected normals
_INSET, _SHARE = 5e-4, 0.05  # [m], of the patch's size: how far inside its rim points lie, which its edge may leave


def patch(shape: TipShape, p: Array, R: Array, obj: Object) -> tuple[tuple[TipShape, float], ...]:
    """Shapes, one to four, in the frame of `shape`, and the gap of each [m]. The frame is at p (3,) with rotation R
    (3, 3).

    Raises Unsupported and InputError as `nearest`.
    """
    near = nearest((shape,), p, R, obj)
    if shape.radius is not None:
        return ((shape, near.gap),)
    near = _squared(near, shape, R)
    if (cornered := _at_corners(shape, p, R, obj, near)) is not None:
        return cornered
    points, _ = tilted((shape,), p, R, obj, near)
    along = in_plane(points, near)
    if not is_wide(along[:, 0]):
        made = _at_point(shape, R.T @ (near.tip_point - p), R.T @ near.normal)
        return ((made, near.gap),)
    chosen = spanning(points, near, R, SPREAD)
    found = [_on_rim(shape, p, R, near, points, k, chosen, not is_wide(along[:, 1])) for k in chosen]
    return tuple([(made, nearest((made,), p, R, obj).gap) for made in found])


def _squared(near: Proximity, shape: TipShape, R: Array) -> Proximity:
    """With a normal along an axis of the shape where it is along it but for the rounding of detection: what lies on a
    level palm would roll away along the slope of that.
    """
    axes = R @ shape.rotation
    along = near.normal @ axes
    k = int(abs(along).argmax())
    exact = np.copysign(1.0, along[k]) * axes[:, k]
    return replace(near, normal=read_only(exact)) if np.linalg.norm(exact - near.normal) < _ROUNDING else near


def _at_corners(
    shape: TipShape, p: Array, R: Array, obj: Object, near: Proximity
) -> tuple[tuple[TipShape, float], ...] | None:
    """Where faces, edges and corners alone meet: the corners of the object that stand on the shape, and those of the
    shape on which the object stands, also those that a small tilt keeps from touching. None: something is curved
    there, or a corner is on neither.
    """
    met = around(shape, p, R, obj, near)
    if met is None:
        return None
    chosen = spanning(np.where(met.of_object[:, None], met.opposite, met.points), near, R, SAME)
    flat = len(chosen) > 2
    found = list[TipShape]()
    for k in chosen:
        made = carrying(shape, p, R, obj, near.normal, met.opposite[k], flat) if met.of_object[k] else None
        if made is None and met.of_shape[k] and flat:
            made = _on_rim(shape, p, R, near, met.points, k, chosen, False)
        if made is None:
            return None
        found.append(made)
    return tuple([(made, nearest((made,), p, R, obj).gap) for made in found])


def _on_rim(
    shape: TipShape, p: Array, R: Array, near: Proximity, points: Array, k: int, chosen: list[int], line: bool
) -> TipShape:
    """What stands a little inside the k-th of points (m, 3), of which some are chosen; at an end of a line, or not."""
    inward, normal = points[chosen].mean(axis=0) - points[k], near.normal
    size = float(np.linalg.norm(inward))
    point = points[k] + inward * min(_INSET / size, _SHARE)
    point = point + normal * (normal @ (near.tip_point - point))
    n = R.T @ normal
    across = np.cross(n, R.T @ (inward / size)) if line else None
    return _stands(shape, R.T @ (point - p), n, across)


# ----------------------------------------------------------------
# What a shape is about one of its points.


def _at_point(shape: TipShape, point: Array, normal: Array) -> TipShape:
    """What touches at a point alone (3,), where the object is along the normal (3,), both in the shape's frame."""
    geometry, Q = shape.geometry, shape.rotation
    x, n = Q.T @ (point - shape.translation), Q.T @ normal
    round_side = isinstance(geometry, coal.Capsule) or (
        isinstance(geometry, coal.Cylinder) and abs(n[2]) < TILT and abs(x[2]) < geometry.halfLength - SPREAD
    )
    if round_side:
        half = float(geometry.halfLength)
        return replace(shape, face=swept(shape, np.zeros(3), np.array([[0, 0, half], [0, 0, 0]]), geometry.radius))
    if isinstance(geometry, coal.Box):
        sides = np.array(geometry.halfSide).reshape(3)
        on = abs(x) >= sides - 1e-6
        centre, spans = np.where(on, np.copysign(sides, x), 0.0), np.diag(sides)[~on]
        radius = 0.0 if len(spans) > 1 else min(TINY, float(sides.min()))  # an edge or a corner is round
        spans = np.vstack([spans, np.zeros((2 - len(spans), 3))])
        return replace(shape, face=swept(shape, centre - radius * n, spans, radius))
    return shape


def _stands(shape: TipShape, point: Array, normal: Array, across: Array | None) -> TipShape:
    """What stands at an end of a line or a corner of a patch: a ball; at the end of a line that lies across a flat
    face, the line over the face. across (3,) : the tangent across the line that touches; None: a corner's.
    """
    radius: float = TINY
    ends = np.zeros(2)
    if across is not None:
        local = shape.rotation.T
        ways = np.stack([normal + side * TILT * across for side in (-1.0, 1.0)]) @ local.T
        ends = (support(shape.geometry, ways) - local @ (point - shape.translation)) @ (local @ across)
        if np.ptp(ends) <= SPREAD:  # curved
            radius, ends = max(TINY, float(np.ptp(ends)) / (2.0 * TILT)), np.zeros(2)
    radius = min(radius, size_of(shape.geometry))
    centre = point - radius * normal + (0.0 if across is None else 0.5 * ends.sum() * across)
    half = 0.5 * float(np.ptp(ends))
    if half == 0.0 or across is None:
        return TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(centre), radius, False, shape.name)
    turn = axes_of(across)
    face = Swept(read_only(centre), read_only(np.array([half * across, np.zeros(3)])), radius)
    return TipShape(coal.Capsule(radius, 2.0 * half), turn, read_only(centre), None, False, shape.name, face)
