"""The object: a free body with its shape and weight, and a mass and a damping with which it moves quasi-statically."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np

from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.objects.object import Object
from handlcp.simulator.mjcf.hand_tree import shape_words
from handlcp.simulator.mjcf.settings import SimulatorSettings, add, placed

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
    add(body, "geom", name=OBJECT, contype="0", conaffinity="0", mass=0.0, **words)
    loaded = add(body, "body", name=LOADED, pos=at.actInv(np.array(spec.reference)), gravcomp=1.0)
    add(loaded, "inertial", pos=np.zeros(3), mass=_LEAST_MASS, diaginertia=np.full(3, _LEAST_MASS * inertia))
    return body


def _add_joints(body: ET.Element, at: Any, spec: GraspSpec, damping: float, turning: float) -> None:
    """Slides and a turn, all at the point that the motion refers to: a free joint that is damped. In a planar scene two
    slides in the plane and a turn about its normal. Body axes.
    """
    centre = at.actInv(np.array(spec.reference))
    normal = np.array([0.0, 0.0, 1.0]) if spec.plane is None else at.rotation.T @ spec.plane
    least = np.eye(3)[int(np.argmin(abs(normal)))]
    x = np.cross(normal, least)
    x /= np.linalg.norm(x)
    slides = {"x": x, "y": np.cross(normal, x)} | ({"z": normal} if spec.plane is None else {})
    for name, axis in slides.items():
        add(body, "joint", name=f"{OBJECT} {name}", type="slide", axis=axis, pos=centre, damping=damping)
    kind: dict[str, Any] = {"type": "ball"} if spec.plane is None else {"type": "hinge", "axis": normal}
    add(body, "joint", name=f"{OBJECT} turn", pos=centre, damping=turning, **kind)
