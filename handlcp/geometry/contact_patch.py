"""`find_contact_patch`: where a link and an object meet with faces, edges and corners, and what stands there.

A corner is the same point however far the shape is tilted, unlike the nearest point of a curved surface. So the shape
is tilted twice, by a little less and a little more. A corner of the object that stands on a face which goes on around
it is a contact that moves with the object (`TipShape.corner`).
"""

from __future__ import annotations

from dataclasses import replace

import coal
import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.closest_point import TILT_ANGLE
from handlcp.geometry.contact_detection import (
    MIN_SPREAD,
    Proximity,
    choose_corners,
    find_tilted_points,
    is_wide,
    nearest_proximity,
    tangent_in_frame,
)
from handlcp.geometry.distance import shape_distance_outside, shape_size, support_points
from handlcp.geometry.object import Object
from handlcp.grasp.model.contact import contact_frame as axes_of
from handlcp.robot.fingertip import SweptBall, TipShape

SAME_CORNER_DISTANCE = 1e-4  # [m] corners nearer to each other are one
_SHAPES_WITH_CORNERS = coal.Box, coal.Cylinder, coal.ConvexBase
_TILT_ANGLES = 0.05, 0.06  # [rad]
# [m] as far as the nearest point of a corner moves between them, by rounding of distances at a rim
_CORNER_SHIFT_TOLERANCE = 2e-5
_FIRST_ANGLE = 0.7  # [rad] where counting round begins: corners of boxes are elsewhere

CORNER_BALL_RADIUS = 1e-4  # [m] radius of the ball that stands for a corner, and of edges


def project_on_plane(points: Array, near: Proximity) -> Array:
    """(m, 2) of points (m, 3), across the normal from their middle: the longer way first."""
    x, y, _ = axes_of(near.normal).T
    flat = np.stack([(points - near.tip_point) @ x, (points - near.tip_point) @ y], axis=1)
    middle = flat.mean(axis=0)
    return np.asarray((flat - middle) @ np.linalg.svd(flat - middle)[2].T)


def choose_spanning(points: Array, near: Proximity, R: Array, apart: float) -> list[int]:
    """Numbers of one to four of points (m, 3) that span them, nearer than `apart` [m] one; counted round the normal in
    the frame of the shape, R (3, 3), so that rounding changes no order.
    """
    along = project_on_plane(points, near)
    if not is_wide(along[:, 0], apart):
        return [0]
    chosen = choose_corners(along, apart)
    if not is_wide(along[:, 1], apart):
        chosen = [int(along[:, 0].argmin()), int(along[:, 0].argmax())]
    x = tangent_in_frame(R, near.normal)
    y = np.cross(near.normal, x)
    arms = points[chosen] - points[chosen].mean(axis=0)
    turns = (np.arctan2(arms @ y, arms @ x) - _FIRST_ANGLE) % (2.0 * np.pi)
    return [chosen[k] for k in np.argsort(turns, kind="stable").tolist()]


# ----------------------------------------------------------------
# The face of a shape on which a corner of the object stands.

_MIN_FACE_EXTENT = 1e-3  # [m] as far as the face goes on, at least
# [m] how far inside its surface a face is looked for; thickness of what stands for it
_FACE_DEPTH, _FACE_THICKNESS = 1e-4, 2e-3
_MAX_AXIS_TILT = 1e-3  # [rad] as far as a normal may lean from a cylinder's axis where its end is meant
_RECTANGLE_ANGLES = np.pi / 16.0 * np.arange(8)  # [rad] of rectangles that are tried on the face of a hull


def find_carrying_face(
    shape: TipShape, p: Array, R: Array, obj: Object, normal: Array, place: Array, flat: bool
) -> TipShape | None:
    """The shape as a face that the object's corner at `place` (3,) stands on, world axes; None: the face ends less than
    a millimetre from there. normal (3,) : out of the shape. flat : whether more corners show that a hull is flat there.
    """
    turn, geometry = (R @ shape.rotation).T, shape.geometry
    out = turn @ normal
    foot = turn @ (place - p - R @ shape.translation)
    if isinstance(geometry, coal.Box) or (
        isinstance(geometry, coal.Cylinder) and abs(out[2]) > 1.0 - _MAX_AXIS_TILT**2
    ):
        k = int(abs(out).argmax())
        out = np.asarray(np.sign(out[k]) * np.eye(3)[k])
        x, ways = np.roll(abs(out), 1), _RECTANGLE_ANGLES[:1]
    elif flat and isinstance(geometry, coal.ConvexBase):
        x, ways = axes_of(out)[:, 0], _RECTANGLE_ANGLES
    else:
        return None
    foot = foot + out * (support_points(geometry, out[None])[0] @ out - foot @ out)
    y = np.cross(out, x)
    tried = [np.stack([np.cos(a) * x + np.sin(a) * y, np.cos(a) * y - np.sin(a) * x]) for a in ways]
    reaches = [_face_rectangle(geometry, foot - _FACE_DEPTH * out, axes) for axes in tried]
    best = int(np.argmax([reach.min() for reach in reaches]))
    axes, reach = tried[best], reaches[best]
    x, y = axes
    if reach.min() < _MIN_FACE_EXTENT:
        return None
    middle = foot + 0.5 * ((reach[1] - reach[0]) * x + (reach[3] - reach[2]) * y) - CORNER_BALL_RADIUS * out
    spans = np.array(
        [(0.5 * (reach[0] + reach[1]) - CORNER_BALL_RADIUS) * x, (0.5 * (reach[2] + reach[3]) - CORNER_BALL_RADIUS) * y]
    )
    Q, o = obj.frame
    half = min(_MIN_FACE_EXTENT, float(reach.min()))
    return replace(
        shape,
        face=make_swept_ball(shape, middle, spans, CORNER_BALL_RADIUS),
        corner=read_only(Q.T @ (place - o)),
        geometry=coal.Box(2.0 * half, 2.0 * half, _FACE_THICKNESS),
        rotation=read_only(shape.rotation @ np.stack([x, y, out], axis=1)),
        translation=read_only(shape.translation + shape.rotation @ (foot - 0.5 * _FACE_THICKNESS * out)),
        radius=None,
        is_central=False,
    )


def make_swept_ball(shape: TipShape, centre: Array, spans: Array, radius: float) -> SweptBall:
    """From the axes of coal's shape to the frame."""
    Q = shape.rotation
    return SweptBall(read_only(shape.translation + Q @ centre), read_only(spans @ Q.T), float(radius))


def _face_rectangle(geometry: coal.ShapeBase, start: Array, axes: Array) -> Array:
    """(4,) how far a rectangle about a point below a face stays in the shape along -x, x, -y, y [m]; axes (2, 3)."""
    x, y = axes
    reach = np.array([_extent_along(geometry, start, way) for way in (-x, x, -y, y)])
    if reach.min() < _MIN_FACE_EXTENT:
        return np.zeros(4)
    while (
        max(
            shape_distance_outside(geometry, start + a * x + b * y)
            for a in (-reach[0], reach[1])
            for b in (-reach[2], reach[3])
        )
        > 0.0
    ):
        reach = 0.95 * reach
    return reach


def _extent_along(geometry: coal.ShapeBase, start: Array, way: Array) -> float:
    """How far the shape goes on from a point (3,), along a direction (3,) [m]; 0 where the point is outside."""
    low, high = 0.0, 4.0 * shape_size(geometry)
    if shape_distance_outside(geometry, start) > 0.0:
        return 0.0
    while high - low > CORNER_BALL_RADIUS * _MIN_FACE_EXTENT:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shape_distance_outside(geometry, start + middle * way) <= 0.0 else (low, middle)
    return low


# ----------------------------------------------------------------
# Where one convex shape touches an object: at a point, along a line, or on a patch; and what of it stands there.
#
# The shape is tilted by a small angle in eight directions. Where both surfaces are curved the nearest point moves by
# the angle times a radius, a tenth of a millimetre; where both are flat it moves to the other end of what touches. A
# line is held by its two ends and a patch by up to four corners. More points of a line add no wrench, and none of a
# rectangle.
#
# At each of them the shape becomes what it is there: a ball of its own radius, a line or a face (`SweptBall`), so that
# what moves later stays on the surface that is there, flat where it is flat. Hulls of meshes stay whole where they
# touch at a point.


_NORMAL_ROUNDING = 1e-4  # [rad] of detected normals
# [m], of the patch's size: how far inside its rim points lie, which its edge may leave
_RIM_INSET, _MAX_RIM_INSET_SHARE = 5e-4, 0.05


def find_contact_patch(shape: TipShape, p: Array, R: Array, obj: Object) -> tuple[tuple[TipShape, float], ...]:
    """Shapes, one to four, in the frame of `shape`, and the gap of each [m]. The frame is at p (3,) with rotation R
    (3, 3).

    Raises Unsupported and InputError as `nearest_proximity`.
    """
    near = nearest_proximity((shape,), p, R, obj)
    if shape.radius is not None:
        return ((shape, near.gap),)
    # Along an axis of the shape where it is so but for rounding: what lies on a level palm would roll down that slope
    axes = R @ shape.rotation
    along = near.normal @ axes
    k = int(abs(along).argmax())
    exact = np.copysign(1.0, along[k]) * axes[:, k]
    if np.linalg.norm(exact - near.normal) < _NORMAL_ROUNDING:
        near = replace(near, normal=read_only(exact))
    if (cornered := _patch_at_corners(shape, p, R, obj, near)) is not None:
        return cornered
    points, _ = find_tilted_points((shape,), p, R, obj, near)
    along = project_on_plane(points, near)
    if not is_wide(along[:, 0]):
        return ((_shape_at_point(shape, R.T @ (near.tip_point - p), R.T @ near.normal), near.gap),)
    chosen = choose_spanning(points, near, R, MIN_SPREAD)
    found = [_shape_on_rim(shape, p, R, near, points, k, chosen, not is_wide(along[:, 1])) for k in chosen]
    return tuple([(made, nearest_proximity((made,), p, R, obj).gap) for made in found])


def _patch_at_corners(
    shape: TipShape, p: Array, R: Array, obj: Object, near: Proximity
) -> tuple[tuple[TipShape, float], ...] | None:
    """Where faces, edges and corners alone meet: the corners of the object that stand on the shape, and those of the
    shape on which the object stands, also those that a small tilt keeps from touching. None: something is curved
    there, or a corner is on neither.
    """
    if not isinstance(shape.geometry, _SHAPES_WITH_CORNERS) or not isinstance(obj.geometry, _SHAPES_WITH_CORNERS):
        return None
    once, twice = (find_tilted_points((shape,), p, R, obj, near, angle) for angle in _TILT_ANGLES)
    of_shape, of_object = (
        np.linalg.norm(further - points, axis=1) <= _CORNER_SHIFT_TOLERANCE
        for points, further in zip(once, twice, strict=True)
    )
    if not (of_shape | of_object).all():
        return None
    points, opposite = once
    chosen = choose_spanning(np.where(of_object[:, None], opposite, points), near, R, SAME_CORNER_DISTANCE)
    flat = len(chosen) > 2
    found = list[TipShape]()
    for k in chosen:
        made = find_carrying_face(shape, p, R, obj, near.normal, opposite[k], flat) if of_object[k] else None
        if made is None and of_shape[k] and flat:
            made = _shape_on_rim(shape, p, R, near, points, k, chosen, False)
        if made is None:
            return None
        found.append(made)
    return tuple([(made, nearest_proximity((made,), p, R, obj).gap) for made in found])


def _shape_on_rim(
    shape: TipShape, p: Array, R: Array, near: Proximity, points: Array, k: int, chosen: list[int], line: bool
) -> TipShape:
    """What stands a little inside the k-th of points (m, 3), of which some are chosen; at an end of a line, or not."""
    inward, normal = points[chosen].mean(axis=0) - points[k], near.normal
    size = float(np.linalg.norm(inward))
    point = points[k] + inward * min(_RIM_INSET / size, _MAX_RIM_INSET_SHARE)
    point = point + normal * (normal @ (near.tip_point - point))
    n = R.T @ normal
    across = np.cross(n, R.T @ (inward / size)) if line else None
    return _shape_at_end(shape, R.T @ (point - p), n, across)


# ----------------------------------------------------------------
# What a shape is about one of its points.


def _shape_at_point(shape: TipShape, point: Array, normal: Array) -> TipShape:
    """What touches at a point alone (3,), where the object is along the normal (3,), both in the shape's frame."""
    geometry, Q = shape.geometry, shape.rotation
    x, n = Q.T @ (point - shape.translation), Q.T @ normal
    round_side = isinstance(geometry, coal.Capsule) or (
        isinstance(geometry, coal.Cylinder) and abs(n[2]) < TILT_ANGLE and abs(x[2]) < geometry.halfLength - MIN_SPREAD
    )
    if round_side:
        half = float(geometry.halfLength)
        return replace(
            shape, face=make_swept_ball(shape, np.zeros(3), np.array([[0, 0, half], [0, 0, 0]]), geometry.radius)
        )
    if isinstance(geometry, coal.Box):
        sides = np.array(geometry.halfSide).reshape(3)
        on = abs(x) >= sides - 1e-6
        centre, spans = np.where(on, np.copysign(sides, x), 0.0), np.diag(sides)[~on]
        radius = 0.0 if len(spans) > 1 else min(CORNER_BALL_RADIUS, float(sides.min()))  # an edge or a corner is round
        spans = np.vstack([spans, np.zeros((2 - len(spans), 3))])
        return replace(shape, face=make_swept_ball(shape, centre - radius * n, spans, radius))
    return shape


def _shape_at_end(shape: TipShape, point: Array, normal: Array, across: Array | None) -> TipShape:
    """What stands at an end of a line or a corner of a patch: a ball; at the end of a line that lies across a flat
    face, the line over the face. across (3,) : the tangent across the line that touches; None: a corner's.
    """
    radius: float = CORNER_BALL_RADIUS
    ends = np.zeros(2)
    if across is not None:
        local = shape.rotation.T
        ways = np.stack([normal + side * TILT_ANGLE * across for side in (-1.0, 1.0)]) @ local.T
        ends = (support_points(shape.geometry, ways) - local @ (point - shape.translation)) @ (local @ across)
        if np.ptp(ends) <= MIN_SPREAD:  # curved
            radius, ends = max(CORNER_BALL_RADIUS, float(np.ptp(ends)) / (2.0 * TILT_ANGLE)), np.zeros(2)
    radius = min(radius, shape_size(shape.geometry))
    centre = point - radius * normal + (0.0 if across is None else 0.5 * ends.sum() * across)
    half = 0.5 * float(np.ptp(ends))
    if half == 0.0 or across is None:
        return TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(centre), radius, False, shape.name)
    turn = axes_of(across)
    face = SweptBall(read_only(centre), read_only(np.array([half * across, np.zeros(3)])), radius)
    return TipShape(coal.Capsule(radius, 2.0 * half), turn, read_only(centre), None, False, shape.name, face)
