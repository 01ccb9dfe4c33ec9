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
from handlcp.hand.objects.detect import nearest
from handlcp.hand.objects.flat import SPREAD, TILT, corners, tilted
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.overlap import size_of, support
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
    x, y, _ = axes_of(normal).T
    points, _ = tilted((shape,), p, R, obj, near)
    flat = np.stack([(points - near.tip_point) @ x, (points - near.tip_point) @ y], axis=1)
    middle = flat.mean(axis=0)
    V = np.linalg.svd(flat - middle)[2]
    along = (flat - middle) @ V.T
    length = np.ptp(along, axis=0)
    if length[0] <= SPREAD:
        return ((_at_point(shape, R.T @ (near.tip_point - p), R.T @ normal), near.gap),)
    ends = [int(along[:, 0].argmin()), int(along[:, 0].argmax())]
    chosen = ends if length[1] <= SPREAD else corners(along)
    centre, found = points[chosen].mean(axis=0), []
    for k in chosen:
        inward = centre - points[k]
        size = float(np.linalg.norm(inward))
        point = points[k] + inward * min(_INSET / size, _SHARE)
        point = point + normal * (normal @ (near.tip_point - point))
        local, n = R.T @ (point - p), R.T @ normal
        across = np.cross(n, R.T @ (inward / size)) if length[1] <= SPREAD else None
        made = _stands(shape, local, n, across)
        found.append((made, nearest((made,), p, R, obj).gap))
    return tuple(found)


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
