"""Coulomb friction on the exact cone, without multipliers: the law stays with the solver as a projection.

    ε_T = 0 inside,    ε_T = -α r_T, α ≥ 0 on the limit |r_T| = μ r_N

It brings the two tangential forces of each contact (one in a plane) and nothing else, whatever the section: disc,
polygon or interval.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

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

    def why(self, scene: Scene) -> str:
        """Which contacts, what section."""
        return f"{len(scene.rough)} contacts with μ > 0, {self.section.name}"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: two a contact, one in a plane."""
        return (Unknown("r_T", scene.tangents * len(scene.rough), True, "force", "motion"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial tangential offsets."""
        system.load("r_T", scene.tangential_offset)
