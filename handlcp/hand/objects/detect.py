"""Detection of contacts: nearest points, normal and signed gap between a fingertip and an object.

Those of spherical fingertips are closed forms of the object; those of others are coal's, checked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, NotReached
from handlcp.extras import pip_install
from handlcp.grasp.friction import FrictionLaw
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.kind import cross_rows
from handlcp.hand.objects.distance import by_coal, distance
from handlcp.hand.objects.object import Object, on_surface
from handlcp.hand.objects.solid import box_of, size_of
from handlcp.hand.objects.swept import corner_contact, nearest_station
from handlcp.hand.robot.convex import available
from handlcp.hand.robot.posture import Posture
from handlcp.hand.robot.tip_geometry import Swept, TipShape

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
    return min([nearest_to(shape, position, rotation, obj) for shape in shapes], key=lambda one: one.gap)


def nearest_to(s: TipShape, position: Array, rotation: Array, obj: Object) -> Proximity:
    """As `nearest`, of one shape."""
    if s.central:
        return _nearest(s, position, _UNTURNED, obj)
    if s.face is not None and s.corner is not None:
        return _on_face(s.face, s.corner, position, rotation, obj)
    if s.face is not None and obj.known is not None:
        return _by_face(s.face, position, rotation, obj)
    return _nearest(s, position + rotation @ s.translation, rotation @ s.rotation, obj)


def nearest_beside(shape: TipShape, p: Array, R: Array, obj: Object, gap: float, about: float) -> Proximity:
    """As `nearest`, of one shape whose gap is known to be `gap`, give or take `about` [m]: where coal says so, too, and
    the object is convex, that is not confirmed any further.
    """
    by_face = shape.face is not None and (shape.corner is not None or obj.known is not None)
    if shape.radius is None and not by_face and obj.triangles is None:
        at = R @ shape.rotation, p + R @ shape.translation
        found, on_tip, on_object, normal = by_coal(shape.geometry, at, obj.geometry, obj.frame)
        if abs(found - gap) <= about and abs(float(normal @ normal) - 1.0) < 1e-9:
            return Proximity(found, on_object, on_tip, normal)
    return nearest_to(shape, p, R, obj)


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
    elif obj.triangles is not None and not available():
        expected = f"spherical fingertips for an object that is not convex, or its parts ({pip_install('coacd')})"
        raise InputError("tip_radius", expected, f"a {type(shape.geometry).__name__}")
    names, parts = (f"{shape.name} ({type(shape.geometry).__name__})", obj), obj.parts

    def measured(k: int) -> Proximity:
        gap, on_tip, on_object, normal = distance(shape.geometry, (R, p), parts[k], obj.frame, names)
        return Proximity(gap, on_object, on_tip, normal)

    return measured(0) if len(parts) == 1 else nearest_of(_least(shape.geometry, p, obj), measured)


def _least(geometry: Any, p: Array, obj: Object) -> Array:
    """How near the object's parts are at least to a shape at p (3,) [m], by a ball and boxes around them."""
    (R, o), low, high = obj.frame, *np.array([box_of(part) for part in obj.parts]).transpose(1, 0, 2)
    x = (p - o) @ R
    away = np.maximum(np.maximum(low - x, x - high), 0.0)
    return np.asarray(np.sqrt((away * away).sum(axis=1)) - np.sqrt(3.0) * size_of(geometry))


def nearest_of(least: Array, measured: Callable[[int], Proximity]) -> Proximity:
    """The nearest of m things; least (m,) : how near each is at least [m]. They are measured in that order, as long as
    the next could be nearer than what was found.
    """
    found: Proximity | None = None
    for k in np.argsort(least, kind="stable").tolist():
        if found is not None and found.gap < least[k]:
            break
        one = measured(k)
        found = one if found is None or one.gap < found.gap else found
    assert found is not None  # there is one at least
    return found


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


def _by_face(face: Swept, p: Array, R: Array, obj: Object) -> Proximity:
    """Of a swept ball in a frame at p (3,) with rotation R (3, 3), and an object that `on_surface` knows."""
    (kind, sizes), (Q, q), at = obj.known, obj.frame, np.zeros(2)  # type: ignore[misc]  # the caller saw to it
    station = nearest_station(kind, sizes, (p + R @ face.centre - q) @ Q, face.spans @ R.T @ Q, at)
    away, on, out = on_surface(kind, sizes, station)
    outward = Q @ out
    return Proximity(away - face.radius, Q @ on + q, Q @ station + q - face.radius * outward, -outward)


def _on_face(face: Swept, corner: Array, p: Array, R: Array, obj: Object) -> Proximity:
    """Of a corner of the object, in the axes of its shape, and a face in a frame at p (3,) with rotation R (3, 3)."""
    (Q, q), normal, rows = obj.frame, np.empty(3), np.empty((2, 3, 6))
    x = Q @ corner + q
    gap = corner_contact(x, p, R, *face, normal, rows[0], rows[1])
    return Proximity(gap, x, x - gap * normal, normal)
