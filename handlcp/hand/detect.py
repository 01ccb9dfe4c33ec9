"""Contacts by coal: nearest points, normal and signed gap between a fingertip and an object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, NotReached
from handlcp.grasp.contact import Contact
from handlcp.grasp.friction import AnisotropicCoulomb, Friction
from handlcp.grasp.scene import cross_rows
from handlcp.hand.meshes import winding
from handlcp.hand.objects import Object
from handlcp.hand.tips import TipShape

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["Proximity", "nearest", "touching"]

# GJK and EPA: tolerance on the distance [m]. Tighter ones gain nothing in the points and lose digits in the distance
# (measured on ellipsoids: 1e-10 → distance 1e-10, points 1e-6; 1e-14 → distance 3e-7).
GJK_TOLERANCE = 1e-10
GJK_ITERATIONS = 1000


_UNTURNED = np.eye(3)  # how a ball is turned does not matter


@dataclass(frozen=True, slots=True)
class Proximity:
    """How a fingertip stands to an object: world axes, metres.

    gap : signed distance, negative when they overlap. position : (3,) on the object's surface. tip_point : (3,) on
        the fingertip's surface. normal : (3,) unit, from the tip into the object.
    """

    gap: float
    position: Array
    tip_point: Array
    normal: Array


def nearest(shapes: tuple[TipShape, ...], position: Array, rotation: Array, obj: Object) -> Proximity:
    """The nearest of a tip's shapes, the tip frame standing at `position` (3,) and `rotation` (3, 3).

    Raises InputError for an object that is not convex and overlaps (or faces) a tip that is no sphere.
    """
    if len(shapes) == 1 and shapes[0].central:
        return _nearest(shapes[0], position, _UNTURNED, obj)
    found = [_nearest(s, position + rotation @ s.translation, rotation @ s.rotation, obj) for s in shapes]
    return min(found, key=lambda one: one.gap)


def touching(
    state: HandState, tips: tuple[int, ...], obj: Object, laws: Sequence[Friction], max_gap: float
) -> tuple[tuple[Contact, ...], Array]:
    """A contact and a signed gap [m] for each of the tips numbered `tips`; `laws` are their frictions.

    Raises NotReached, naming all fingertips that are farther than `max_gap` [m] from the object.
    """
    hand = state.hand
    names = [hand.fingertips[i] for i in tips]
    near = [nearest(hand.tip_shapes(i), state.tip_positions[i], state.tip_rotations[i], obj) for i in tips]
    far = {name: p.gap for name, p in zip(names, near, strict=True) if not p.gap <= max_gap}
    if far:
        raise NotReached("fingers", f"fingertips within max_gap = {max_gap * 1e3:g} mm of the object", far)
    positions, normals = np.array([p.position for p in near]), np.array([p.normal for p in near])
    return _contacts(positions, normals, laws, names), np.array([p.gap for p in near])


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
    distance, _, x, normal = _ask(coal.Sphere(tiny), coal.Transform3s(_UNTURNED, p), obj)
    local = obj.placement.actInv(p)
    inside = abs(winding(local, triangles)) > 0.5
    apart = p - x
    length = float(np.sqrt(apart @ apart))
    outward = -normal if length <= 2 * tiny else apart / length * (-1.0 if inside else 1.0)
    return (-1.0 if inside else 1.0) * max(distance + tiny, length), x, outward


def _ask(geometry: Any, transform: Any, obj: Object) -> tuple[float, Array, Array, Array]:
    result = coal.DistanceResult()
    gap = float(coal.distance(geometry, transform, obj.geometry, obj.transform, _REQUEST, result))
    return gap, np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2()), np.array(result.normal)


def _request() -> Any:
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = GJK_TOLERANCE
    request.gjk_max_iterations = request.epa_max_iterations = GJK_ITERATIONS
    return request


_REQUEST = _request()  # coal only reads it


def _contacts(positions: Array, normals: Array, laws: Sequence[Friction], names: list[str]) -> tuple[Contact, ...]:
    """What `Contact(position, normal, law, None, name)` makes, with all frames at once and without its checks."""
    rows = np.arange(len(names))
    z = normals / np.sqrt((normals * normals).sum(axis=1))[:, None]
    nearest_axis = np.argmin(np.round(abs(z), 9), axis=1)
    x = z * -z[rows, nearest_axis][:, None]
    x[rows, nearest_axis] += 1.0
    x /= np.sqrt((x * x).sum(axis=1))[:, None]
    frames = np.stack([x, cross_rows(z, x), z], axis=2)
    positions.flags.writeable = frames.flags.writeable = False
    made = []
    for position, frame, law, name in zip(positions, frames, laws, names, strict=True):
        if isinstance(law, AnisotropicCoulomb) and law.along is not None:  # it has a say in where x lies
            made.append(Contact(position, frame[:, 2], law, None, name))
            continue
        contact = Contact.__new__(Contact)
        contact.position, contact.rotation, contact.planar, contact.name = position, frame, False, name
        contact.bears(law)
        made.append(contact)
    return tuple(made)
