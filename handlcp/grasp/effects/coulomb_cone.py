"""Coulomb friction on the exact cone, without multipliers: the law stays with the solver as a projection.

    ε_T = 0 inside,    ε_T = -α r_T, α ≥ 0 on the limit |r_T| = μ r_N

It brings the two tangential forces of each contact (one in a plane) and nothing else, whatever the section: disc,
polygon or interval.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

from handlcp.grasp.effects.coulomb_pyramid import points_without_friction, tangential_forces, why_no_points
from handlcp.grasp.friction import Cone, Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown

__all__ = ["CoulombCone"]


@dataclass(frozen=True, slots=True)
class CoulombCone(Effect):
    """Tangential forces of every contact with friction; `section` is the set that limits them."""

    section: Section

    title: ClassVar[str] = "Coulomb friction, cone"
    equation: ClassVar[str] = "|r_T| ≤ μ r_N,  ε_T = -α r_T with α ≥ 0 on the limit"
    when: ClassVar[str] = "Friction as it is, alike in all directions, with the best accuracy for the time."
    in_python: ClassVar[str] = 'friction=Coulomb(0.6), faces="cone"'
    in_file: ClassVar[str] = 'grasp.friction = 0.6\nsolve.faces = "cone"'
    brings: ClassVar[str] = "2 a contact"
    source: ClassVar[str] = "De Saxcé & Feng, Mathematical and Computer Modelling 28 (1998)"
    order: ClassVar[int] = 40

    @classmethod
    def called_for(cls, scene: Scene, section: Section, multipliers: bool) -> Effect | None:
        """Where friction has no multipliers."""
        return _of(section) if scene.rough and not (multipliers and not isinstance(section, Cone)) else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Another form of friction was asked for."""
        return why_no_points(scene, section)

    def why(self, scene: Scene) -> str:
        """Which contacts, what section."""
        return f"{len(scene.rough)} contacts with μ > 0, {self.section.name}"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Frictionless."""
        return points_without_friction(contacts)

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: two a contact, one in a plane."""
        return (tangential_forces(scene),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial tangential offsets."""
        system.load_tangents("r_T", scene)


_of = lru_cache(maxsize=64)(CoulombCone)
