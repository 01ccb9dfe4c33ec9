"""The object as a free body that moves quasi-statically; and what it touches besides the hand."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.objects.object import Object
from handlcp.simulator.settings import SimulatorSettings, add, add_shape, axes_along, placed
from handlcp.simulator.tips import CORNER, add_pad, round_shape, shape_words, weighty

OBJECT = "object"  # its body, and its shape
LOADED = "loaded point"  # body at the point that the load refers to, fixed to the object
_LEAST_MASS = 1e-9  # [kg] of a body without mass, which MuJoCo does not have
_LEAST_LENGTH = 1e-3  # [m]


def add_object(
    root: ET.Element, world: ET.Element, obj: Object, spec: GraspSpec, settings: SimulatorSettings
) -> ET.Element:
    """The object's body. In a planar scene it moves in the plane alone.

    It has the mass of the settings, and its own weight: MuJoCo's gravity compensation makes up for the difference.
    """
    at = obj.placement
    moving = settings.object_mass
    body = add(world, "body", name=OBJECT, gravcomp=1.0 - obj.mass / moving, **placed(at.rotation, at.translation))
    spread = max(float(np.linalg.norm(spec.positions - spec.reference, axis=1).max()), _LEAST_LENGTH)
    inertia = 0.4 * spread**2  # of a ball, for each kilogram
    _add_joints(body, at, spec, settings.object_damping, inertia * settings.object_damping)
    centre = at.actInv(np.array(obj.center_of_mass))
    add(body, "inertial", pos=centre, mass=moving, diaginertia=np.full(3, moving * inertia))
    words = shape_words(root, OBJECT, obj.geometry)
    add_shape(body, name=OBJECT, **words)
    loaded = add(body, "body", name=LOADED, pos=at.actInv(np.array(spec.reference)), gravcomp=1.0)
    add(loaded, "inertial", pos=np.zeros(3), mass=_LEAST_MASS, diaginertia=np.full(3, _LEAST_MASS * inertia))
    return body


def _add_joints(body: ET.Element, at: Any, spec: GraspSpec, damping: float, turning: float) -> None:
    """Slides and a turn, all at the point that the motion refers to: a free joint that is damped. In a planar scene two
    slides in the plane and a turn about its normal. Body axes.
    """
    centre = at.actInv(np.array(spec.reference))
    normal = np.array([0.0, 0.0, 1.0]) if spec.plane is None else at.rotation.T @ spec.plane
    x, y, _ = axes_along(normal).T
    slides = {"x": x, "y": y} | ({"z": normal} if spec.plane is None else {})
    for name, axis in slides.items():
        add(body, "joint", name=f"{OBJECT} {name}", type="slide", axis=axis, pos=centre, damping=damping)
    kind: dict[str, Any] = {"type": "ball"} if spec.plane is None else {"type": "hinge", "axis": normal}
    add(body, "joint", name=f"{OBJECT} turn", pos=centre, damping=turning, **kind)


# ----------------------------------------------------------------
# What the object touches besides the hand, as planes.
#
# A contact of the environment is a point of a table or a wall that gives way by itself. On a body with corners or
# rims each such point becomes a small ball at the object, on slides of its own where the support gives way. A ball or
# an ellipsoid rolls: it touches a plane, or where that gives way a block on slides.

_BLOCK = 0.5  # [m] half the size of a block that gives way, far larger than what it carries
_STANDING = 3  # points of a cylinder that stands on its rim; one that lies on its side has fewer


@dataclass(frozen=True)
class Support:
    """The names of the two shapes that touch; the ground has that of the contact."""

    ground: str
    ours: str


def add_supports(
    world: ET.Element, body: ET.Element, spec: GraspSpec, obj: Object, settings: SimulatorSettings
) -> tuple[Support, ...]:
    """Planes in the world and feet at the object's body. Raises Unsupported for supports that share their flexibility,
    and for a cylinder that lies on something flexible.
    """
    k, found = spec.of_hand, []
    E = spec.flexibility[3 * k :, 3 * k :]
    for i in range(spec.n - k):
        block = E[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
        shared = E[3 * i : 3 * i + 3].copy()
        shared[:, 3 * i : 3 * i + 3] = 0.0
        if shared.any():
            raise Unsupported("contacts of the environment that move under each other's forces cannot be written")
        R, gap = spec.frames[k + i], float(spec.offset[k + i, 2])
        surface = spec.positions[k + i] - gap * R[:, 2]
        place = _Place(spec.names[k + i], R, spec.positions[k + i], surface, block)
        rolls = round_shape(obj.geometry) or (isinstance(obj.geometry, coal.Cylinder) and spec.n - k < _STANDING)
        found.append(_rolling(world, place, obj, settings) if rolls else _foot(world, body, place, obj, settings))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class _Place:
    """A contact between the object and its environment, in world axes.

    name : of the contact. axes (3, 3) : contact axes in columns. point (3,) : of the object [m]. surface (3,) : the
    nearest point of the environment [m]. flexibility (3, 3) : of the environment there [m/N], contact axes.
    """

    name: str
    axes: Array
    point: Array
    surface: Array
    flexibility: Array


def _rolling(world: ET.Element, place: _Place, obj: Object, settings: SimulatorSettings) -> Support:
    if not place.flexibility.any():
        return Support(_plane(world, place), "object")
    if isinstance(obj.geometry, coal.Cylinder):
        raise Unsupported(
            "a cylinder that lies on a support that gives way cannot be written: its points of contact roll"
        )
    block = add(world, "body", name=place.name, gravcomp=1.0, **placed(place.axes, place.surface))
    add_pad(block, place.name, place.flexibility, settings, weighty(place.flexibility, settings))
    words: Any = {"type": "box", "pos": (0, 0, -_BLOCK), "size": np.full(3, _BLOCK)}
    add_shape(block, name=place.name, **words)
    return Support(place.name, "object")


def _foot(world: ET.Element, body: ET.Element, place: _Place, obj: Object, settings: SimulatorSettings) -> Support:
    """A ball whose lowest point is the contact, on slides in the contact's axes."""
    centre = obj.placement.actInv(place.point + CORNER * place.axes[:, 2])
    axes = obj.placement.rotation.T @ place.axes
    name = f"{place.name} foot"
    foot = add(body, "body", name=name, gravcomp=1.0, **placed(axes, centre))
    add_pad(foot, name, place.flexibility, settings)
    add_shape(foot, name=name, type="sphere", size=[CORNER])
    return Support(_plane(world, place), name)


def _plane(world: ET.Element, place: _Place) -> str:
    where = placed(place.axes, place.surface)
    add_shape(world, name=place.name, type="plane", size=(_BLOCK, _BLOCK, 0.01), **where)
    return place.name
