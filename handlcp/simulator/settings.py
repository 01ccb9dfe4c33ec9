"""`SimulatorSettings`: what makes MuJoCo quasi-static: contact stiffness, damping, and the object's inertia.

MuJoCo simulates motion over time with contacts that give way a little. Statics is what is left of it when everything
moves slowly, motion is damped, and contacts are much stiffer than fingers and pads.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, fields
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, check_number
from handlcp.errors import InputError, Unsupported, missing_library
from handlcp.grasp import Coulomb, Frictionless, Grasp, SoftFinger, TorqueSaturation
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.hand import HandGrasp
from handlcp.hand.mechanism import HandMechanism

# ---------------------------------------------------------------- Numbers and elements as MJCF writes them.


def format_numbers(value: Any) -> str:
    """One number or several, to the last bit."""
    return " ".join(repr(float(x)) for x in np.ravel(value))


def add_element(parent: ET.Element, tag: str, **attributes: Any) -> ET.Element:
    """A new element below `parent`; strings are written as they are, numbers by `text`. A trailing _ of a name goes."""
    written = {k.rstrip("_"): v if isinstance(v, str) else format_numbers(v) for k, v in attributes.items()}
    return ET.SubElement(parent, tag, written)


def add_shape(parent: ET.Element, **attributes: Any) -> None:
    """A shape without mass, which touches nothing but in the pairs that are listed; attributes as of `add`."""
    add_element(parent, "geom", **attributes, contype="0", conaffinity="0", mass=0.0)


def placement_attributes(rotation: Array, translation: Array) -> dict[str, Any]:
    """Attributes of an element that stands elsewhere than its parent."""
    x, y, z, w = pin.Quaternion(np.array(rotation)).normalized().coeffs()
    return {"pos": translation, "quat": np.array([w, x, y, z])}  # as MuJoCo orders it


def axes_along(z: Array) -> Array:
    """(3, 3) axes as columns, the third of which is z (3,), a unit vector."""
    least = np.eye(3)[int(np.argmin(abs(z)))]
    x = np.cross(z, least)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


# ----------------------------------------------------------------

_MIN_CONTACT_STEPS = 10  # a contact that is softer than this many time steps does not chatter


@dataclass(frozen=True, slots=True)
class SimulatorSettings:
    """Numbers that statics does not have.

    timestep : [s] of the integration. contact_time : [s] in which an overlap of two surfaces decays; at least some 10
    time steps, or contacts chatter. friction_time : [s] the same for slip. In MuJoCo a contact that slides opens by
    about 2 μ · speed · contact_time² / friction_time; where that is more than the force pushes in, it hops.
    impedance, support_impedance : of fingers, and of supports and equations; nearer to 1 they are stiffer, at 0.99 a
    finger's contact gives way by about 1e-6 m/N. friction_impedance : how many times stiffer friction is.
    damping : [s] of joints and pads: they come to rest in about this time, without swinging.
    object_mass : [kg] with which the object moves, whatever it weighs. object_damping : [N·s/m] against its motion; its
    turning is damped as much in proportion to its inertia. Raises InputError.
    """

    timestep: float = 1e-4
    contact_time: float = 2e-3
    impedance: float = 0.99
    support_impedance: float = 0.999
    friction_impedance: float = 3e4
    friction_time: float = 0.1
    damping: float = 0.02
    object_mass: float = 0.1
    object_damping: float = 20.0

    def __post_init__(self) -> None:
        for f in fields(self):
            check_number(f"SimulatorSettings.{f.name}", getattr(self, f.name), above=0.0)
        for name in ("impedance", "support_impedance"):
            if not getattr(self, name) < 1.0:
                raise InputError(f"SimulatorSettings.{name}", "a number below 1", getattr(self, name))
        if not self.contact_time >= _MIN_CONTACT_STEPS * self.timestep:
            expected = f"at least {_MIN_CONTACT_STEPS} time steps, {_MIN_CONTACT_STEPS * self.timestep:g} s"
            raise InputError("SimulatorSettings.contact_time", expected, self.contact_time)

    def critical_damping(self, stiffness: float) -> dict[str, float]:
        """Attributes of a joint with this stiffness that make it come to rest as fast as it can: k = c²/4m."""
        return {"damping": self.damping * stiffness, "armature": 0.25 * self.damping**2 * stiffness}


# ---------------------------------------------------------------- MuJoCo is an extra: imported when it is needed.


def import_mujoco() -> ModuleType:
    """Import the package mujoco, which is an extra. Raises Unsupported where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise missing_library("no simulation without MuJoCo", "mujoco") from None
    module: ModuleType = mujoco
    return module


# ----------------------------------------------------------------

# MuJoCo writes balance in the deformed posture: geometric stiffness is always in it
_WRITABLE_EFFECTS = (JointOffset, FingerWeight, GeometricStiffness, TorqueSaturation)
_EQUAL_FLEXIBILITY_TOLERANCE = 1e-9  # of the largest entry: flexibilities that differ by less are one
_EQUAL_OFFSET_TOLERANCE = 1e-9  # [m] offsets that differ by less from the gaps are those


def check_writable(grasp: HandGrasp) -> None:
    """Whether each part of a grasp of `require_hand_grasp` can be written. Raises Unsupported."""
    spec = grasp.spec
    for effect in spec.effects:
        if not isinstance(effect, _WRITABLE_EFFECTS):
            raise Unsupported(f"MuJoCo has no exact counterpart of {effect.title}")
    for name, contact in zip(spec.names, spec.contacts, strict=True):
        friction_attributes(name, contact.friction)
    cables = grasp.mechanism.joint_model.cables
    if cables is not None and len(cables.post_tendon):  # MuJoCo's friction of a tendon is no share of its tension
        rubbing = ", ".join([cables.names[i] for i in np.unique(cables.post_tendon)])
        raise Unsupported(f"tendons that rub on what they wrap around cannot be written: {rubbing}")
    k = spec.of_hand
    if abs(spec.offset[:k] - grasp.mechanism.stand_off).max(initial=0.0) > _EQUAL_OFFSET_TOLERANCE:
        what = "a preload or an offset of the tips, which no joint makes, cannot be written"
        raise Unsupported(f"{what}: command the joints (squeeze, grip_force, joint_offset)")
    alone = spec.fingers_alone().mechanism
    assert isinstance(alone, HandMechanism)
    own, flexibility = alone.flexibility(), spec.flexibility[: 3 * k, : 3 * k]
    if abs(own - flexibility).max() > _EQUAL_FLEXIBILITY_TOLERANCE * abs(own).max():
        raise Unsupported("a flexibility other than that of the hand's joints and pads cannot be written")
    if spec.offset[k:, :2].any():
        raise Unsupported("an offset of the environment along its tangents cannot be written")


def require_hand_grasp(grasp: Any) -> HandGrasp:
    """The grasp, if a hand made it and its object has a shape that MuJoCo knows.

    Raises InputError for what is no grasp, Unsupported for contacts without a hand or without geometry.
    """
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a grasp made by hand.at(q).grasp(obj)", repr(grasp)[:80])
    if not isinstance(grasp, HandGrasp):
        raise Unsupported("contacts without a hand cannot be simulated: MuJoCo needs a hand and an object")
    if grasp.target is None:
        raise Unsupported("contacts given one by one cannot be simulated: pass an object, whose geometry is known")
    if grasp.target.triangles is not None:
        raise Unsupported("a mesh that is not convex cannot be simulated: MuJoCo fills its hull")
    return grasp


def friction_attributes(name: str, law: Any) -> dict[str, Any]:
    """Attributes of a contact pair with this friction law; name : of the contact. Raises Unsupported."""
    if isinstance(law, SoftFinger):
        if law.torsional_flexibility:
            raise Unsupported(f"the torsional flexibility of soft finger {name!r} cannot be written")
        if law.lever > 0.0:
            return {"condim": "4", "friction": [law.mu, law.mu, law.mu_torsion, 1e-4, 1e-4]}
    elif not isinstance(law, (Coulomb, Frictionless)):
        why = "MuJoCo chooses the tangents of a contact itself"
        raise Unsupported(f"friction {law!r} of {name!r} cannot be written: {why}")
    if law.mu == 0.0:
        return {"condim": "1"}
    return {"condim": "3", "friction": [law.mu, law.mu, 1e-4, 1e-4, 1e-4]}
