"""A contact whose force is known (measured, or commanded by force control): its wrench joins the load.

    w += G_i r_i,    ε += E_(·i) r_i

No unknowns, no unilateral law and no friction law at that contact; the other fingers still feel it through shared
joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

from handlcp.check import Array, array, integer
from handlcp.errors import InputError
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.needs import need_contact
from handlcp.grasp.joints import Joints
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System

__all__ = ["PrescribedForce"]


@dataclass(frozen=True, init=False, eq=False)
class PrescribedForce(Effect):
    """Contact number `contact` (from 0) pushes with `force` (3,) N in its contact axes (x, y, normal)."""

    contact: int
    force: Array

    title = "prescribed contact force"
    equation = "w += G_i r_i,  ε += E_(·i) r_i"
    when = "A finger under force control, or one whose force is measured."
    in_python = "effects=[PrescribedForce(0, (0, 0, 1.5))]"
    in_file = "effects.prescribed_force = [{ contact = 0, force_N = [0, 0, 1.5] }]"
    brings = "takes the contact's away"
    source = "Ai & Li (2025), Example 2"

    def __init__(self, contact: int, force: Any) -> None:
        object.__setattr__(self, "contact", integer("PrescribedForce.contact", contact, 0))
        object.__setattr__(self, "force", array("PrescribedForce.force", force, (3,)))

    @property
    def key(self) -> object:
        """One a contact."""
        return type(self), self.contact

    def for_grasp(self, argument: str, n: int, joints: Joints | None, others: tuple[Effect, ...]) -> Self:
        """At a contact that there is."""
        need_contact(f"{argument}.contact", self.contact, n)
        return self

    def why(self, scene: Scene) -> str:
        """Asked for."""
        return f"asked for: contact {self.contact} pushes with {self.force.tolist()} N"

    def stamp(self, scene: Scene, system: System) -> None:
        """Known parts of balance and of the other fingers' retreat."""
        mine = slice(3 * self.contact, 3 * self.contact + 3)
        if scene.plane is not None and self.force[1] != 0.0:
            raise InputError(
                "PrescribedForce.force", "no force out of the plane (y) in a planar scene", self.force.tolist()
            )
        s, a, force = scene.units, scene.natural, scene.lawful_at(self.contact, self.force)
        system.load("u", a.every[:, mine] @ (force / s.force))
        retreat = scene.flexibility[:, mine] @ force / s.motion
        system.load_forces(retreat[scene.normal_index], retreat[scene.tangent_index])

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """Whether the answer carries this very force."""
        mine = forces[3 * self.contact : 3 * self.contact + 3]
        return float(abs(mine - scene.lawful_at(self.contact, self.force)).max()) / force_size
