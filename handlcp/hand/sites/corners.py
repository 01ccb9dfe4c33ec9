"""Corners where a link and an object meet with faces, edges and corners: which there are, and what stands there.

A corner is the same point however far the shape is tilted, unlike the nearest point of a curved surface. So the shape
is tilted twice, by a little less and a little more. A corner of the object that stands on a face which goes on around
it is a contact that moves with the object (`TipShape.corner`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import coal
import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.grasp.model.contact import frame as axes_of
from handlcp.hand.objects.detect import Proximity
from handlcp.hand.objects.flat import across_in, corners, is_wide, tilted
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.solid import beyond, size_of, support
from handlcp.hand.robot.tip_geometry import Swept, TipShape

SAME = 1e-4  # [m] corners nearer to each other are one
_CORNERED = coal.Box, coal.Cylinder, coal.ConvexBase
_LEANS = 0.05, 0.06  # [rad]
_STILL = 2e-5  # [m] as far as the nearest point of a corner moves between them, by rounding of distances at a rim
_START = 0.7  # [rad] where counting round begins: corners of boxes are elsewhere

TINY = 1e-4  # [m] radius of the ball that stands for a corner, and of edges


class Around(NamedTuple):
    """Points (8, 3) of a shape, and the object's points opposite, that are nearest when it is tilted in eight ways; and
    which of each are corners (8,).
    """

    points: Array
    opposite: Array
    of_shape: Bools
    of_object: Bools


def around(shape: TipShape, p: Array, R: Array, obj: Object, near: Proximity) -> Around | None:
    """Where faces, edges and corners alone meet; None: some surface is curved. The shape's frame is at p (3,) with
    rotation R (3, 3).
    """
    if not isinstance(shape.geometry, _CORNERED) or not isinstance(obj.geometry, _CORNERED):
        return None
    (points, opposite), (further, other) = (tilted((shape,), p, R, obj, near, angle) for angle in _LEANS)
    of_shape = np.linalg.norm(further - points, axis=1) <= _STILL
    of_object = np.linalg.norm(other - opposite, axis=1) <= _STILL
    return Around(points, opposite, of_shape, of_object) if (of_shape | of_object).all() else None


def in_plane(points: Array, near: Proximity) -> Array:
    """(m, 2) of points (m, 3), across the normal from their middle: the longer way first."""
    x, y, _ = axes_of(near.normal).T
    flat = np.stack([(points - near.tip_point) @ x, (points - near.tip_point) @ y], axis=1)
    middle = flat.mean(axis=0)
    return np.asarray((flat - middle) @ np.linalg.svd(flat - middle)[2].T)


def spanning(points: Array, near: Proximity, R: Array, apart: float) -> list[int]:
    """Numbers of one to four of points (m, 3) that span them, nearer than `apart` [m] one; counted round the normal in
    the frame of the shape, R (3, 3), so that rounding changes no order.
    """
    along = in_plane(points, near)
    if not is_wide(along[:, 0], apart):
        return [0]
    chosen = corners(along, apart)
    if not is_wide(along[:, 1], apart):
        chosen = [int(along[:, 0].argmin()), int(along[:, 0].argmax())]
    x = across_in(R, near.normal)
    y = np.cross(near.normal, x)
    arms = points[chosen] - points[chosen].mean(axis=0)
    turns = (np.arctan2(arms @ y, arms @ x) - _START) % (2.0 * np.pi)
    return [chosen[k] for k in np.argsort(turns, kind="stable").tolist()]


# ----------------------------------------------------------------
# The face of a shape on which a corner of the object stands.

_AROUND = 1e-3  # [m] as far as the face goes on, at least
_FLAT, _THIN = 1e-4, 2e-3  # [m] how far inside its surface a face is looked for; thickness of what stands for it
_UPRIGHT = 1e-3  # [rad] as far as a normal may lean from a cylinder's axis where its end is meant
_TURNS = np.pi / 16.0 * np.arange(8)  # [rad] of rectangles that are tried on the face of a hull


def carrying(
    shape: TipShape, p: Array, R: Array, obj: Object, normal: Array, place: Array, flat: bool
) -> TipShape | None:
    """The shape as a face that the object's corner at `place` (3,) stands on, world axes; None: the face ends less than
    a millimetre from there. normal (3,) : out of the shape. flat : whether more corners show that a hull is flat there.
    """
    turn, geometry = (R @ shape.rotation).T, shape.geometry
    out = turn @ normal
    foot = turn @ (place - p - R @ shape.translation)
    if isinstance(geometry, coal.Box) or (isinstance(geometry, coal.Cylinder) and abs(out[2]) > 1.0 - _UPRIGHT**2):
        k = int(abs(out).argmax())
        out = np.asarray(np.sign(out[k]) * np.eye(3)[k])
        x, ways = np.roll(abs(out), 1), _TURNS[:1]
    elif flat and isinstance(geometry, coal.ConvexBase):
        x, ways = axes_of(out)[:, 0], _TURNS
    else:
        return None
    foot = foot + out * (support(geometry, out[None])[0] @ out - foot @ out)
    y = np.cross(out, x)
    tried = [np.stack([np.cos(a) * x + np.sin(a) * y, np.cos(a) * y - np.sin(a) * x]) for a in ways]
    reaches = [_rectangle(geometry, foot - _FLAT * out, axes) for axes in tried]
    best = int(np.argmax([reach.min() for reach in reaches]))
    axes, reach = tried[best], reaches[best]
    x, y = axes
    if reach.min() < _AROUND:
        return None
    middle = foot + 0.5 * ((reach[1] - reach[0]) * x + (reach[3] - reach[2]) * y) - TINY * out
    spans = np.array([(0.5 * (reach[0] + reach[1]) - TINY) * x, (0.5 * (reach[2] + reach[3]) - TINY) * y])
    Q, o = obj.frame
    half = min(_AROUND, float(reach.min()))
    return replace(
        shape, face=swept(shape, middle, spans, TINY), corner=read_only(Q.T @ (place - o)),
        geometry=coal.Box(2.0 * half, 2.0 * half, _THIN),
        rotation=read_only(shape.rotation @ np.stack([x, y, out], axis=1)),
        translation=read_only(shape.translation + shape.rotation @ (foot - 0.5 * _THIN * out)),
        radius=None, central=False,
    )  # fmt: skip


def swept(shape: TipShape, centre: Array, spans: Array, radius: float) -> Swept:
    """From the axes of coal's shape to the frame."""
    Q = shape.rotation
    return Swept(read_only(shape.translation + Q @ centre), read_only(spans @ Q.T), float(radius))


def _rectangle(geometry: coal.ShapeBase, start: Array, axes: Array) -> Array:
    """(4,) how far a rectangle about a point just below a face goes on along -x, x, -y, y within the shape [m]; axes
    (2, 3).
    """
    x, y = axes
    reach = np.array([_reach(geometry, start, way) for way in (-x, x, -y, y)])
    if reach.min() < _AROUND:
        return np.zeros(4)
    while max(
        beyond(geometry, start + a * x + b * y) for a in (-reach[0], reach[1]) for b in (-reach[2], reach[3])
    ) > 0.0:  # fmt: skip
        reach = 0.95 * reach
    return reach


def _reach(geometry: coal.ShapeBase, start: Array, way: Array) -> float:
    """How far the shape goes on from a point (3,), along a direction (3,) [m]; 0 where the point is outside."""
    low, high = 0.0, 4.0 * size_of(geometry)
    if beyond(geometry, start) > 0.0:
        return 0.0
    while high - low > TINY * _AROUND:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if beyond(geometry, start + middle * way) <= 0.0 else (low, middle)
    return low
