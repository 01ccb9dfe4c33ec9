"""`detect_tip_contacts`: where fingertips are nearest to an object."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.contact.closest_point import TILT_ANGLE, closest_on_surface, nearest_station, write_corner_contact
from handlcp.contact.friction import FrictionLaw
from handlcp.errors import InputError, NotReached, pip_command
from handlcp.geometry.distance import bounding_box, coal_distance, shape_size, signed_distance
from handlcp.geometry.object import Object
from handlcp.grasp.model.contact import Contact, cross_rows
from handlcp.robot.fingertip import TipShape
from handlcp.robot.hand_model import HandPosture
from handlcp.robot.link_surface import has_coacd
from handlcp.words import first_largest_index

# ----------------------------------------------------------------
# Detection of contacts: nearest points, normal and signed gap between a fingertip and an object.
#
# Those of spherical fingertips are closed forms of the object; those of others are coal's, checked.


_IDENTITY = np.eye(3)  # for balls, whose rotation does not matter


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


def nearest_proximity(shapes: tuple[TipShape, ...], position: Array, rotation: Array, obj: Object) -> Proximity:
    """The proximity of the nearest of a tip's shapes; position (3,) and rotation (3, 3) are those of the tip frame.

    Raises InputError for an object that is not convex where the tip is not a sphere; Unsupported where a distance
    cannot be computed.
    """
    return min([shape_proximity(shape, position, rotation, obj) for shape in shapes], key=lambda one: one.gap)


def shape_proximity(s: TipShape, position: Array, rotation: Array, obj: Object) -> Proximity:
    """As `nearest_proximity`, of one shape."""
    if s.is_central:
        return _measure_proximity(s, position, _IDENTITY, obj)
    if s.face is not None and s.corner is not None:
        (Q, q), normal, rows = obj.frame, np.empty(3), np.empty((2, 3, 6))
        x = Q @ s.corner + q
        gap = write_corner_contact(x, position, rotation, *s.face, normal, rows[0], rows[1])
        return Proximity(gap, x, x - gap * normal, normal)
    if s.face is not None and obj.known is not None:
        (kind, sizes), (Q, q), face, at = obj.known, obj.frame, s.face, np.zeros(2)
        centre = (position + rotation @ face.centre - q) @ Q
        station = nearest_station(kind, sizes, centre, face.spans @ rotation.T @ Q, at)
        away, on, out = closest_on_surface(kind, sizes, station)
        outward = Q @ out
        return Proximity(away - face.radius, Q @ on + q, Q @ station + q - face.radius * outward, -outward)
    return _measure_proximity(s, position + rotation @ s.translation, rotation @ s.rotation, obj)


def quick_proximity(shape: TipShape, p: Array, R: Array, obj: Object, gap: float, about: float) -> Proximity:
    """As `shape_proximity`, where the gap is `gap` give or take `about` [m]: then coal's own word is not confirmed."""
    by_face = shape.face is not None and (shape.corner is not None or obj.known is not None)
    if shape.radius is None and not by_face and obj.triangles is None:
        at = R @ shape.rotation, p + R @ shape.translation
        found, on_tip, on_object, normal = coal_distance(shape.geometry, at, obj.geometry, obj.frame)
        if abs(found - gap) <= about and abs(float(normal @ normal) - 1.0) < 1e-9:
            return Proximity(found, on_object, on_tip, normal)
    return shape_proximity(shape, p, R, obj)


def detect_tip_contacts(
    state: HandPosture, tips: tuple[int, ...], obj: Object, laws: Sequence[FrictionLaw], max_gap: float
) -> tuple[tuple[Contact, ...], Array]:
    """A contact and a signed gap [m] for each of the tips numbered `tips`, whose frictions are `laws`.

    Raises NotReached, naming all fingertips that are farther than `max_gap` [m] from the object.
    """
    hand = state.hand
    names = [hand.fingertips[i] for i in tips]
    near = [nearest_proximity(hand.tip_shapes(i), state.tip_positions[i], state.tip_rotations[i], obj) for i in tips]
    if far := {name: p.gap for name, p in zip(names, near, strict=True) if not p.gap <= max_gap}:
        raise NotReached("fingers", f"fingertips within max_gap = {max_gap * 1e3:g} mm of the object", far)
    # What `Contact(position, normal, law, None, name)` makes, with all frames at once and without its checks
    positions, z = np.array([p.position for p in near]), np.array([p.normal for p in near])
    z /= np.sqrt((z * z).sum(axis=1))[:, None]
    x = np.eye(3)[np.argmin(np.round(abs(z), 9), axis=1)]
    x -= z * (x * z).sum(axis=1)[:, None]
    x /= np.sqrt((x * x).sum(axis=1))[:, None]
    frames = np.stack([x, cross_rows(z, x), z], axis=2)
    positions.flags.writeable = frames.flags.writeable = False
    contacts = tuple(
        Contact.from_arrays(p, R, law, False, name) if law.x_axis is None else Contact(p, R[:, 2], law, None, name)
        for p, R, law, name in zip(positions, frames, laws, names, strict=True)
    )
    return contacts, np.array([p.gap for p in near])


def _measure_proximity(shape: TipShape, p: Array, R: Array, obj: Object) -> Proximity:
    if shape.radius is not None:
        known = obj.closest(p)
        if known is not None:
            away, x, outward = known
            return Proximity(away - shape.radius, x, p - shape.radius * outward, -outward)
    elif obj.triangles is not None and not has_coacd():
        expected = f"spherical fingertips for an object that is not convex, or its parts ({pip_command('coacd')})"
        raise InputError("tip_radius", expected, f"a {type(shape.geometry).__name__}")
    names, parts = (f"{shape.name} ({type(shape.geometry).__name__})", obj), obj.parts

    def measure_part(k: int) -> Proximity:
        gap, on_tip, on_object, normal = signed_distance(shape.geometry, (R, p), parts[k], obj.frame, names)
        return Proximity(gap, on_object, on_tip, normal)

    if len(parts) == 1:
        return measure_part(0)
    # How near parts are at least, by boxes around them and a ball around the shape
    (Q, o), low, high = obj.frame, *np.array([bounding_box(part) for part in parts]).transpose(1, 0, 2)
    x = (p - o) @ Q
    away = np.maximum(np.maximum(low - x, x - high), 0.0)
    least = np.sqrt((away * away).sum(axis=1)) - np.sqrt(3.0) * shape_size(shape.geometry)
    return search_nearest(least, measure_part)


def search_nearest(least: Array, measured: Callable[[int], Proximity]) -> Proximity:
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


# ----------------------------------------------------------------
# What of a shape touches an object where both are flat: the points that are nearest when it is tilted a little.


MIN_SPREAD = 1.5e-3  # [m] farther apart, points are not those of a curved surface
# Along no axis of a link: tilted toward an edge alone, a face touches anywhere on that edge, and not at its corners
_TANGENT_SEED = np.array([0.62, 0.34, 0.71])
_TILT_DIRECTIONS = np.array([(np.cos(a), np.sin(a)) for a in 0.2 + np.arange(8) * np.pi / 4])


def find_tilted_points(
    shapes: tuple[Any, ...], p: Array, R: Array, obj: Object, near: Proximity, angle: float = TILT_ANGLE
) -> tuple[Array, Array]:
    """Points (8, 3) of the shapes, where they are, that are nearest when they are tilted by an angle [rad] in eight
    directions about where they are nearest now, and the object's points (8, 3) opposite. The frame is at p (3,) with
    rotation R (3, 3).
    """
    x, n = tangent_in_frame(R, near.normal), near.normal
    axes = np.stack([x, cross_rows(n, x), n], axis=1)
    away = tilt_gap_change(max(shape_size(shape.geometry) for shape in shapes), angle)
    own, opposite = np.empty((8, 3)), np.empty((8, 3))
    for k, turn in enumerate(axes @ _tilt_rotations(angle) @ axes.T):
        lifted = near.tip_point - away * n
        there = nearest_proximity(shapes, lifted + turn @ (p - near.tip_point), turn @ R, obj)
        own[k] = near.tip_point + (there.tip_point - lifted) @ turn
        opposite[k] = there.position
    return own, opposite


def tilt_gap_change(size: float, angle: float = TILT_ANGLE) -> float:
    """[m] By how much the gap of a shape of this size [m] changes as it is tilted, at most."""
    return 2.0 * angle * size


@cache  # an eighth of the time of `find_tilted_points`
def _tilt_rotations(angle: float) -> Array:
    """(8, 3, 3) rotations by an angle [rad] that raise z in each of eight directions across it."""
    return np.array([pin.exp3(angle * np.array([-b, a, 0.0])) for a, b in _TILT_DIRECTIONS])


def tangent_in_frame(R: Array, normal: Array) -> Array:
    """(3,) a unit vector across the normal (3,), which turns with a frame whose rotation is R (3, 3)."""
    x = R @ _TANGENT_SEED
    x = x - normal * (normal @ x)
    return np.asarray(x / np.sqrt(x @ x))


def is_wide(along: Array, apart: float = MIN_SPREAD) -> bool:
    """Whether points at (m,) along an axis [m] are farther apart than those of a curved surface at one point of it."""
    return bool(np.ptp(along) > apart)


def choose_corners(flat: Array, apart: float = MIN_SPREAD) -> list[int]:
    """Numbers of two to four of points (m, 2) that span what all do, the farthest from those before first; none but
    the first two are nearer to each other than `apart` [m]. Of those that are as far but for rounding, the first.

    The points are more than `apart` wide, or one is enough, which `is_wide` says: no other measure decides it here.
    """
    chosen = [first_largest_index(np.linalg.norm(flat, axis=1))]
    while len(chosen) < 4:
        away = np.linalg.norm(flat[:, None] - flat[chosen], axis=2).min(axis=1)
        if away.max() <= (apart if len(chosen) > 1 else 0.0):
            break
        chosen.append(first_largest_index(away))
    return chosen
