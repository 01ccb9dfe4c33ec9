"""Where one convex shape touches an object: at a point, along a line, or on a patch; and what of it stands there.

The shape is tilted by a small angle in eight directions. Where both surfaces are curved the nearest point moves by the
angle times a radius, a tenth of a millimetre; where both are flat it moves to the other end of what touches. A line is
held by its two ends and a patch by up to four corners: more points add no wrench.

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
from handlcp.hand.objects.flat import SPREAD, TILT, corners, tilted
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.overlap import beyond, size_of, support
from handlcp.hand.robot.tip_geometry import Swept, TipShape

_INSET, _SHARE = 5e-4, 0.05  # [m], of the patch's size: how far inside its rim points lie, which its edge may leave
_TINY = 1e-4  # [m] radius of the ball that stands for a corner, and of edges


def patch(shape: TipShape, p: Array, R: Array, obj: Object) -> tuple[tuple[TipShape, float], ...]:
    """Shapes, one to four, in the frame of `shape`, and the gap of each [m]. The frame is at p (3,) with rotation R
    (3, 3).

    Raises Unsupported and InputError as `nearest`.
    """
    near = nearest((shape,), p, R, obj)
    if shape.radius is not None:
        return ((shape, near.gap),)
    normal = near.normal
    points, opposite = tilted((shape,), p, R, obj, near)
    along = _in_plane(points, near)
    length = np.ptp(along, axis=0)
    if length[1] <= SPREAD and (four := _leaning(shape, p, R, obj, near)):
        return four
    if length[0] <= SPREAD:
        return ((_at_point(shape, R.T @ (near.tip_point - p), R.T @ normal), near.gap),)
    ends = [int(along[:, 0].argmin()), int(along[:, 0].argmax())]
    chosen = ends if length[1] <= SPREAD else corners(along)
    centre, found = points[chosen].mean(axis=0), []
    stands = _carried(shape, p, R, obj, normal, opposite[chosen]) if length[1] > SPREAD else [None] * len(chosen)
    for k, carrying in zip(chosen, stands, strict=True):
        if carrying is not None:
            found.append((carrying, nearest((carrying,), p, R, obj).gap))
            continue
        inward = centre - points[k]
        size = float(np.linalg.norm(inward))
        point = points[k] + inward * min(_INSET / size, _SHARE)
        point = point + normal * (normal @ (near.tip_point - point))
        local, n = R.T @ (point - p), R.T @ normal
        across = np.cross(n, R.T @ (inward / size)) if length[1] <= SPREAD else None
        made = _stands(shape, local, n, across)
        found.append((made, nearest((made,), p, R, obj).gap))
    return tuple(found)


def _in_plane(points: Array, near: Proximity) -> Array:
    """(m, 2) of points (m, 3), across the normal from their middle: the longer way first."""
    x, y, _ = axes_of(near.normal).T
    flat = np.stack([(points - near.tip_point) @ x, (points - near.tip_point) @ y], axis=1)
    middle = flat.mean(axis=0)
    return np.asarray((flat - middle) @ np.linalg.svd(flat - middle)[2].T)


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
        return replace(shape, face=_swept(shape, np.zeros(3), np.array([[0, 0, half], [0, 0, 0]]), geometry.radius))
    if isinstance(geometry, coal.Box):
        sides = np.array(geometry.halfSide).reshape(3)
        on = abs(x) >= sides - 1e-6
        centre, spans = np.where(on, np.copysign(sides, x), 0.0), np.diag(sides)[~on]
        radius = 0.0 if len(spans) > 1 else min(_TINY, float(sides.min()))  # an edge or a corner is round
        spans = np.vstack([spans, np.zeros((2 - len(spans), 3))])
        return replace(shape, face=_swept(shape, centre - radius * n, spans, radius))
    return shape


def _swept(shape: TipShape, centre: Array, spans: Array, radius: float) -> Swept:
    """From the axes of coal's shape to the frame."""
    Q = shape.rotation
    return Swept(read_only(shape.translation + Q @ centre), read_only(spans @ Q.T), float(radius))


def _stands(shape: TipShape, point: Array, normal: Array, across: Array | None) -> TipShape:
    """What stands at an end of a line or a corner of a patch: a ball; at the end of a line that lies across a flat
    face, the line over the face. across (3,) : the tangent across the line that touches; None: a corner's.
    """
    radius: float = _TINY
    ends = np.zeros(2)
    if across is not None:
        local = shape.rotation.T
        ways = np.stack([normal + side * TILT * across for side in (-1.0, 1.0)]) @ local.T
        ends = (support(shape.geometry, ways) - local @ (point - shape.translation)) @ (local @ across)
        if np.ptp(ends) <= SPREAD:  # curved
            radius, ends = max(_TINY, float(np.ptp(ends)) / (2.0 * TILT)), np.zeros(2)
    radius = min(radius, size_of(shape.geometry))
    centre = point - radius * normal + (0.0 if across is None else 0.5 * ends.sum() * across)
    half = 0.5 * float(np.ptp(ends))
    if half == 0.0 or across is None:
        return TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(centre), radius, False, shape.name)
    turn = axes_of(across)
    face = Swept(read_only(centre), read_only(np.array([half * across, np.zeros(3)])), radius)
    return TipShape(coal.Capsule(radius, 2.0 * half), turn, read_only(centre), None, False, shape.name, face)


# ----------------------------------------------------------------
# A corner of the object on a face that goes on around it: the contact stays where it is on the object.

_LEANS = 0.05, 0.06  # [rad] a corner is the same point of the object with either tilt, unlike a curved side's
_SAME = 2e-6  # [m]
_AROUND = 1e-3  # [m] as far as the face goes on, at least
_FLAT, _THIN = 1e-4, 2e-3  # [m] how far inside its surface a face is looked for; thickness of what stands for it


def _leaning(shape: TipShape, p: Array, R: Array, obj: Object, near: Proximity) -> tuple[tuple[TipShape, float], ...]:
    """Corners of an object that leans on the shape with one of them or an edge, where its other corners are near, and
    the shape goes on below each; () where it is otherwise.
    """
    if not isinstance(shape.geometry, (coal.Box, coal.ConvexBase)):
        return ()
    (points, opposite), (_, other) = (tilted((shape,), p, R, obj, near, angle) for angle in _LEANS)
    along = _in_plane(points, near)
    apart = np.linalg.norm(other[:, None] - opposite, axis=2).min(axis=1)
    if np.ptp(along[:, 1]) <= SPREAD or apart.max() > _SAME:
        return ()
    stands = _carried(shape, p, R, obj, near.normal, opposite[corners(along)])
    return tuple([(one, nearest((one,), p, R, obj).gap) for one in stands if one is not None]) if all(stands) else ()


def _carried(shape: TipShape, p: Array, R: Array, obj: Object, normal: Array, places: Array) -> list[TipShape | None]:
    """For each of the object's points (m, 3), world axes, the face of the shape that it stands on, or None."""
    Q, o = obj.frame
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    part = 0.5 * float(apart[apart > 0.0].min())
    return [_carrying(shape, R.T @ (x - p), R.T @ normal, Q.T @ (x - o), part) for x in places]


def _carrying(shape: TipShape, at: Array, normal: Array, corner: Array, part: float) -> TipShape | None:
    """The face that a corner of the object stands on, at (3,) in the shape's frame with this normal (3,) out of the
    shape; None: it ends less than a millimetre from there. corner (3,) : in the axes of the object's shape. part : half
    a side of what stands for it where shapes are drawn or simulated [m].
    """
    turn = shape.rotation.T
    foot = turn @ (at - shape.translation)
    out = turn @ normal
    x, y, _ = axes_of(out).T
    if isinstance(shape.geometry, coal.Box):
        x, y = np.delete(np.eye(3), int(abs(out).argmax()), axis=0)
    foot = foot + out * (support(shape.geometry, out[None])[0] @ out - foot @ out)
    inside = foot - _FLAT * out
    reach = np.array([_reach(shape, inside, way) for way in (-x, x, -y, y)])
    if reach.min() < _AROUND:
        return None
    while max(
        beyond(shape.geometry, inside + a * x + b * y) for a in (-reach[0], reach[1]) for b in (-reach[2], reach[3])
    ) > 0.0:  # fmt: skip
        reach = 0.9 * reach
    middle = foot + 0.5 * ((reach[1] - reach[0]) * x + (reach[3] - reach[2]) * y) - _TINY * out
    spans = np.array([(0.5 * (reach[0] + reach[1]) - _TINY) * x, (0.5 * (reach[2] + reach[3]) - _TINY) * y])
    if np.cross(*spans) @ out < 0.0:
        spans[1] *= -1.0
    own = replace(shape, face=_swept(shape, middle, spans, _TINY), corner=read_only(corner))
    axes = np.stack([x, np.cross(out, x), out], axis=1)
    half = min(part, float(reach.min()))
    return replace(
        own, geometry=coal.Box(2.0 * half, 2.0 * half, _THIN), rotation=read_only(shape.rotation @ axes),
        translation=read_only(shape.translation + shape.rotation @ (foot - 0.5 * _THIN * out)), radius=None,
        central=False,
    )  # fmt: skip


def _reach(shape: TipShape, start: Array, way: Array) -> float:
    """How far the shape goes on from a point inside it (3,), along a direction (3,) [m]."""
    low, high = 0.0, 4.0 * size_of(shape.geometry)
    if beyond(shape.geometry, start) > 0.0:
        return 0.0
    while high - low > _TINY * _AROUND:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if beyond(shape.geometry, start + middle * way) <= 0.0 else (low, middle)
    return low
