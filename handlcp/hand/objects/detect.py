"""Detection of contacts: nearest points, normal and signed gap between a fingertip and an object.

Those of spherical fingertips are closed forms of the object; those of others are coal's, checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, NotReached
from handlcp.grasp.friction import FrictionLaw
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.kind import cross_rows
from handlcp.hand.objects.distance import distance
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.posture import Posture
from handlcp.hand.robot.tip_geometry import TipShape

_UNTURNED = np.eye(3)  # for balls, whose rotation does not matter


@dataclass(frozen=True, slots=True)
class Proximity:
    """Where a fingertip and an object are nearest to each other: world axes, metres.

    gap : signed distance, negative when they overlap. position : (3,) on the object's surface. tip_point : (3,) on
    the fingertip's surface. normal : (3,) unit, from the tip into the object.
    """

    gap: float
    position: Array
    tip_point: Array
    normal: Array


def nearest(shapes: tuple[TipShape, ...], position: Array, rotation: Array, obj: Object) -> Proximity:
    """The proximity of the nearest of a tip's shapes; position (3,) and rotation (3, 3) are those of the tip frame.

    Raises InputError for an object that is not convex where the tip is not a sphere; Unsupported where a distance
    cannot be computed.
    """
    if len(shapes) == 1 and shapes[0].central:
        return _nearest(shapes[0], position, _UNTURNED, obj)
    found = [_nearest(s, position + rotation @ s.translation, rotation @ s.rotation, obj) for s in shapes]
    return min(found, key=lambda one: one.gap)


def touching(
    state: Posture, tips: tuple[int, ...], obj: Object, laws: Sequence[FrictionLaw], max_gap: float
) -> tuple[tuple[Contact, ...], Array]:
    """A contact and a signed gap [m] for each of the tips numbered `tips`, whose frictions are `laws`.

    Raises NotReached, naming all fingertips that are farther than `max_gap` [m] from the object.
    """
    hand = state.hand
    names = [hand.fingertips[i] for i in tips]
    near = [nearest(hand.tip_shapes(i), state.tip_positions[i], state.tip_rotations[i], obj) for i in tips]
    if far := {name: p.gap for name, p in zip(names, near, strict=True) if not p.gap <= max_gap}:
        raise NotReached("fingers", f"fingertips within max_gap = {max_gap * 1e3:g} mm of the object", far)
    positions, normals = np.array([p.position for p in near]), np.array([p.normal for p in near])
    return _contacts(positions, normals, laws, names), np.array([p.gap for p in near])


def _nearest(shape: TipShape, p: Array, R: Array, obj: Object) -> Proximity:
    if shape.radius is not None:
        known = obj.closest(p)
        if known is not None:
            away, x, outward = known
            return Proximity(away - shape.radius, x, p - shape.radius * outward, -outward)
    elif obj.triangles is not None:
        expected = "spherical fingertips for an object that is not convex"
        raise InputError("tip_radius", expected, f"a {type(shape.geometry).__name__}")
    names = f"{shape.name} ({type(shape.geometry).__name__})", repr(obj)
    gap, on_tip, on_object, normal = distance(shape.geometry, (R, p), obj.geometry, obj.frame, names)
    return Proximity(gap, on_object, on_tip, normal)


def _contacts(positions: Array, normals: Array, laws: Sequence[FrictionLaw], names: list[str]) -> tuple[Contact, ...]:
    """What `Contact(position, normal, law, None, name)` makes, with all frames at once and without its checks."""
    z = normals / np.sqrt((normals * normals).sum(axis=1))[:, None]
    x = np.eye(3)[np.argmin(np.round(abs(z), 9), axis=1)]
    x -= z * (x * z).sum(axis=1)[:, None]
    x /= np.sqrt((x * x).sum(axis=1))[:, None]
    frames = np.stack([x, cross_rows(z, x), z], axis=2)
    positions.flags.writeable = frames.flags.writeable = False
    return tuple([
        Contact.placed(p, R, law, False, name) if law.x_axis is None else Contact(p, R[:, 2], law, None, name)
        for p, R, law, name in zip(positions, frames, laws, names, strict=True)
    ])  # fmt: skip
