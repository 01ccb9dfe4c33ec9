"""Coulomb friction: a contact sticks, or slides against its friction at the limit.

    |r_T| ≤ μ r_N,    ε_T = -α r_T, α ≥ 0 on the limit

A solver takes the disc as it is, or a polygon in its place; in a plane the disc is an interval. As a plain LCP, the
polygon's faces have a multiplier each (`lcp.multipliers`). The paper's D is minus our outward normals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from handlcp.grasp.friction import Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown


@dataclass(frozen=True, slots=True)
class CoulombFriction(Effect):
    """Tangential forces of every contact with friction but no moment; `section` is the set that limits them."""

    section: Section

    title: ClassVar[str] = "Coulomb friction"
    equation: ClassVar[str] = "|r_T| ≤ μ r_N,  ε_T = -α r_T with α ≥ 0 on the limit"
    when: ClassVar[str] = "Dry friction, alike in all directions: on m faces, on the exact cone, or exact in a plane."
    in_python: ClassVar[str] = "friction=Coulomb(0.6), faces=8"
    in_file: ClassVar[str] = "grasp.friction = 0.6\nsolve.faces = 8"
    brings: ClassVar[str] = "2 a contact (1 in a plane); m more as a plain LCP"
    source: ClassVar[str] = "Ai & Li (2025), equations (7) to (12); De Saxcé & Feng, Math. Comput. Modelling 28 (1998)"
    order: ClassVar[int] = 30

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls(section) if scene.rough else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        return "every contact with friction is soft" if scene.soft else "no contact has μ > 0"

    def why(self, scene: Scene) -> str:
        return f"{len(scene.rough)} contacts with μ > 0, {self.section.name}"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        return {"contacts": tuple([c.with_friction(c.friction.with_mu(0.0)) if c.mu > 0.0 else c for c in contacts])}

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: two a contact, one in a plane."""
        return (Unknown("r_T", sum(scene.kind.tangents[i] for i in scene.rough), True, "force"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial tangential offsets."""
        system.load_tangents("r_T", scene)
