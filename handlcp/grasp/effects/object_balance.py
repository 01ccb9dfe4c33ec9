"""Object balance: the contact forces and the world's wrench cancel.

    G_N r_N + G_T r_T + w = 0          u ∈ R⁶ (R³ in a plane) free

and, by virtue of the same matrix (virtual work), the object's motion u moves the contacts by Gᵀ u.
"""

from __future__ import annotations

from typing import Any

from handlcp.grasp.friction import Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown


class ObjectBalance(Effect):
    """Force and moment balance of a rigid object, with its small motion as multipliers."""

    title = "object balance"
    equation = "G_N r_N + G_T r_T + w = 0,  u free"
    when = "The object is rigid and at rest under all that pushes it."
    brings = "6 (3 in a plane)"
    source = "Ai & Li (2025), equations (1) and (2)"
    order = 10

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls()

    def why(self, scene: Scene) -> str:
        return "the object is rigid and free to move" + ("" if scene.plane is None else " in its plane")

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any] | None:
        return None

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """u: (dof,) motion of the object about the contacts' centre."""
        return (Unknown("u", scene.dof, True, "twist"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """Balance rows and, transposed, the object's motion in the contact rows."""
        system.couple("u", scene.natural.G, 1.0)
        system.load("u", scene.natural.w)
