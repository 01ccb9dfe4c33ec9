"""Object balance: the contact forces and the world's wrench cancel.

    G_N r_N + G_T r_T + w = 0          u ∈ R⁶ (R³ in a plane) free

and, by virtue of the same matrix (virtual work), the object's motion u moves the contacts by Gᵀ u.
Source: paper, equations (1) and (2); model, "Equilibrium".
"""

from __future__ import annotations

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["ObjectBalance"]


class ObjectBalance(Effect):
    """Force and moment balance of a rigid object, with its small motion as multipliers."""

    title = "object balance"
    equation = "G_N r_N + G_T r_T + w = 0,  u free"

    def why(self, scene: Scene) -> str:
        """Every scene has an object."""
        return "the object is rigid and free to move" + ("" if scene.plane is None else " in its plane")

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """u: (dof,) motion of the object about the contacts' centre."""
        s = scene.units
        row = [s.force] * (2 if scene.plane is not None else 3)
        sizes = scene.twist_units.copy()
        sizes[: len(row)], sizes[len(row) :] = s.force, s.force * s.length
        return (Unknown("u", scene.dof, True, "m, rad", "N, N·m", scene.twist_units, sizes),)

    def stamp(self, scene: Scene, system: System) -> None:
        """Balance rows and, transposed, the object's motion in the contact rows."""
        a = scene.natural
        G_N, G_T = a.G[:, : a.split], a.G[:, a.split :]
        system.add("u", "r_N", G_N)
        system.add("u", "r_T", G_T)
        system.add("r_N", "u", G_N.T)
        system.add("r_T", "u", G_T.T)
        system.load("u", a.w)
