"""What makes MuJoCo quasi-static: how stiff contacts are, how much motion is damped, how heavy an object feels.

MuJoCo simulates motion over time with contacts that give way a little. Statics is what is left of it when everything
moves slowly, motion is damped, and contacts are much stiffer than fingers and pads.
"""

from __future__ import annotations

from dataclasses import dataclass

from handlcp.check import number
from handlcp.errors import InputError

__all__ = ["SimulatorSettings"]

_STEPS = 10  # a contact that is softer than this many time steps does not chatter


@dataclass(frozen=True, slots=True)
class SimulatorSettings:
    """Numbers that statics does not have.

    timestep : [s] of the integration. contact_time : [s] in which an overlap of two surfaces decays; below some 10
    time steps contacts chatter, and friction forgets its load. impedance : below 1; nearer to 1 contacts are stiffer.
    friction_impedance : how many times stiffer friction is than the normal direction. friction_time : [s] as
    contact_time, of friction.
    damping : [s] of joints and pads: they come to rest in about this time, without swinging.
    object_mass : [kg] that the object has besides its own, without weight. Raises InputError.
    """

    timestep: float = 2e-4
    contact_time: float = 4e-3
    impedance: float = 0.999
    friction_impedance: float = 1e5
    friction_time: float = 4e-3
    damping: float = 0.01
    object_mass: float = 0.1

    def __post_init__(self) -> None:
        for name in ("timestep", "contact_time", "impedance", "friction_impedance", "damping"):
            number(f"SimulatorSettings.{name}", getattr(self, name), above=0.0)
        number("SimulatorSettings.object_mass", self.object_mass, minimum=0.0)
        if not self.impedance < 1.0:
            raise InputError("SimulatorSettings.impedance", "a number below 1", self.impedance)
        if not self.contact_time >= _STEPS * self.timestep:
            expected = f"at least {_STEPS} time steps, {_STEPS * self.timestep:g} s"
            raise InputError("SimulatorSettings.contact_time", expected, self.contact_time)

    def damped(self, stiffness: float) -> dict[str, float]:
        """Attributes of a joint with this stiffness that make it come to rest as fast as it can: k = c²/4m."""
        return {"damping": self.damping * stiffness, "armature": 0.25 * self.damping**2 * stiffness}
