"""A posture of the hand and a placement of the object, together: what a search for grasps varies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.model import HandModel

_SPARE = 0.03  # of a joint's range, kept free at both ends so that the fingers can still be squeezed
_THICK = (3e-3, 12e-3)  # [m] half of a fingertip's thickness, at least and at most


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """q (nv,) [rad, m] of the hand. rotation (3, 3), position (3,) [m]: of the object's frame, world axes."""

    q: Array
    rotation: Array
    position: Array

    def moved(self, joints: Array, twist: Array) -> Place:
        """After small motions of the joints (nv,), and of the object about its own frame's origin (6,)."""
        turn = np.asarray(pin.exp3(np.asarray(twist[3:])))
        return Place(self.q + joints, turn @ self.rotation, self.position + twist[:3])

    def of(self, obj: Object) -> Object:
        """The object at this placement."""
        return obj.moved_to(pin.SE3(self.rotation, self.position))


def free_ranges(hand: HandModel) -> tuple[Array, Array]:
    """(nv,) lower and upper ends of what a search uses of the joint ranges; a joint without limits turns by ±π."""
    lower = np.where(np.isfinite(hand.lower), hand.lower, -np.pi)
    upper = np.where(np.isfinite(hand.upper), hand.upper, np.pi)
    spare = _SPARE * (upper - lower)
    return lower + spare, upper - spare


def box_around(shape: Any) -> tuple[Array, Array]:
    """(3,) and (3,) the lowest and the highest corner of a box around coal's shape, along its own axes [m]."""
    shape.computeLocalAABB()  # coal keeps it with the shape
    return np.array(shape.aabb_local.min_), np.array(shape.aabb_local.max_)


def size_of_object(obj: Object) -> float:
    """Half of the object's mean width [m]."""
    low, high = box_around(obj.geometry)
    return float(np.mean(high - low)) / 2


def end_of(hand: HandModel, tip: int) -> tuple[Array, float]:
    """The middle of a fingertip in its frame (3,) [m], and how far its surface is from there [m], roughly.

    A ball's centre. Of another shape a point near its far end, seen from the last joint of the finger: that of its
    surface which is furthest along the finger, drawn in by half of the shape's thickness.
    """
    shapes = hand.tip_shapes(tip)
    if len(shapes) == 1 and shapes[0].radius is not None:
        return shapes[0].translation, shapes[0].radius
    points = np.concatenate([_corners(s.geometry) @ s.rotation.T + s.translation for s in shapes])
    joint = hand.kinematics.model.frames[hand.tips.frames[tip]].placement.inverse().translation  # in the tip's frame
    along = points.mean(axis=0) - joint
    along /= max(float(np.linalg.norm(along)), 1e-12)
    thick = float(np.clip(np.sqrt(np.linalg.eigvalsh(np.cov(points.T))[0]), *_THICK))
    far = float((points @ along).max())
    centre = points[points @ along > far - 2 * thick].mean(axis=0)
    return centre + along * (far - thick - float(centre @ along)), thick


def _corners(shape: Any) -> Array:
    """(m, 3) corners of a convex shape, or of a box around it."""
    if hasattr(shape, "points"):
        return np.array(shape.points(), dtype=float)
    low, high = box_around(shape)
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
