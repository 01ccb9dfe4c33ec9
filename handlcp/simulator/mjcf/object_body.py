"""The object: a free body with its shape and mass, and inertia without weight that makes it move slowly."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.objects.object import Object
from handlcp.simulator.mjcf.fingertips import shape_words
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.mjcf.words import add, placed

__all__ = ["LOADED", "OBJECT", "add_object"]

OBJECT = "object"  # its body, and its shape
LOADED = "loaded point"  # body at the point that the load refers to, fixed to the object
_LEAST_MASS = 1e-9  # [kg] of an object without mass, which MuJoCo does not have
_LEAST_LENGTH = 1e-3  # [m]


def add_object(
    root: ET.Element, world: ET.Element, obj: Object, spec: GraspSpec, settings: SimulatorSettings
) -> ET.Element:
    """The object's body. In a planar scene it moves in the plane alone."""
    at = obj.placement
    body = add(world, "body", name=OBJECT, **placed(at.rotation, at.translation))
    if spec.plane is None:
        add(body, "freejoint", name=OBJECT)
    else:
        _add_planar_joints(body, at.rotation.T @ spec.plane, at.actInv(np.array(spec.reference)))
    mass = max(obj.mass, _LEAST_MASS)
    spread = max(float(np.linalg.norm(spec.positions - spec.reference, axis=1).max()), _LEAST_LENGTH)
    inertia = 0.4 * spread**2  # of a ball, for each kilogram
    add(
        body, "inertial", pos=at.actInv(np.array(obj.center_of_mass)), mass=mass, diaginertia=np.full(3, mass * inertia)
    )
    words = shape_words(root, OBJECT, obj.geometry)
    add(body, "geom", name=OBJECT, contype="0", conaffinity="0", mass=0.0, **words)
    loaded = add(body, "body", name=LOADED, pos=at.actInv(np.array(spec.reference)), gravcomp=1.0)
    extra = max(settings.object_mass, _LEAST_MASS)
    add(loaded, "inertial", pos=np.zeros(3), mass=extra, diaginertia=np.full(3, extra * inertia))
    return body


def _add_planar_joints(body: ET.Element, normal: Array, centre: Array) -> None:
    """Two slides in the plane and a turn about its normal, all at the point that the motion refers to; body axes."""
    least = np.eye(3)[int(np.argmin(abs(normal)))]
    x = np.cross(normal, least)
    x /= np.linalg.norm(x)
    for name, axis in (("x", x), ("y", np.cross(normal, x))):
        add(body, "joint", name=f"{OBJECT} {name}", type="slide", axis=axis, pos=centre)
    add(body, "joint", name=f"{OBJECT} turn", type="hinge", axis=normal, pos=centre)
