"""What makes MuJoCo quasi-static: how stiff contacts are, how much motion is damped, how heavy an object feels.

MuJoCo simulates motion over time with contacts that give way a little. Statics is what is left of it when everything
moves slowly, motion is damped, and contacts are much stiffer than fingers and pads.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, number
from handlcp.errors import InputError

# ---------------------------------------------------------------- Numbers and elements as MJCF writes them.


def text(value: Any) -> str:
    """One number or several, to the last bit."""
    return " ".join(repr(float(x)) for x in np.ravel(value))


def add(parent: ET.Element, tag: str, **attributes: Any) -> ET.Element:
    """A new element below `parent`; strings are written as they are, numbers by `text`. A trailing _ of a name goes."""
    written = {k.rstrip("_"): v if isinstance(v, str) else text(v) for k, v in attributes.items()}
    return ET.SubElement(parent, tag, written)


def quaternion(rotation: Array) -> Array:
    """(4,) w, x, y, z, as MuJoCo orders it."""
    x, y, z, w = pin.Quaternion(np.array(rotation)).normalized().coeffs()
    return np.array([w, x, y, z])


def placed(rotation: Array, translation: Array) -> dict[str, Any]:
    """Attributes of an element that stands elsewhere than its parent."""
    return {"pos": translation, "quat": quaternion(rotation)}


# ----------------------------------------------------------------

_STEPS = 10  # a contact that is softer than this many time steps does not chatter


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
            number(f"SimulatorSettings.{f.name}", getattr(self, f.name), above=0.0)
        for name in ("impedance", "support_impedance"):
            if not getattr(self, name) < 1.0:
                raise InputError(f"SimulatorSettings.{name}", "a number below 1", getattr(self, name))
        if not self.contact_time >= _STEPS * self.timestep:
            expected = f"at least {_STEPS} time steps, {_STEPS * self.timestep:g} s"
            raise InputError("SimulatorSettings.contact_time", expected, self.contact_time)

    def damped(self, stiffness: float) -> dict[str, float]:
        """Attributes of a joint with this stiffness that make it come to rest as fast as it can: k = c²/4m."""
        return {"damping": self.damping * stiffness, "armature": 0.25 * self.damping**2 * stiffness}
