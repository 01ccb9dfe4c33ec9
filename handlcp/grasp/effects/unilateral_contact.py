"""Unilateral contact: a finger pushes, never pulls, and only where it touches.

    0 ≤ r_N ⟂ ε_N ≥ 0,    ε_N = (Gᵀu + E r + d)_N

d_N > 0 is an initial gap, d_N < 0 a preload.
"""

from __future__ import annotations

from typing import Any

from handlcp.grasp.friction import Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown
from handlcp.tolerances import ACTIVE


class UnilateralContact(Effect):
    """Normal force and gap, complementary, with gap and preload as data."""

    title = "unilateral contact"
    equation = "0 ≤ r_N ⟂ ε_N ≥ 0,  ε_N = (Gᵀu + E r + d)_N"
    when = "Fingers push and never pull; gaps and preloads are data."
    brings = "1 a contact"
    source = "Ai & Li (2025), equations (3) and (4)"
    order = 20

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls()

    def why(self, scene: Scene) -> str:
        normal = scene.offset[2 : 3 * scene.n : 3]
        nothing = ACTIVE * scene.units.motion
        gaps, loads = int((normal > nothing).sum()), int((normal < -nothing).sum())
        return f"{len(scene.kind.normal_index)} contacts, {gaps} with a gap, {loads} with a preload"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any] | None:
        return None

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_N: (n_N,) normal forces."""
        return (Unknown("r_N", len(scene.kind.normal_index), False, "force"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial gaps."""
        system.load("r_N", scene.natural.d[: len(scene.kind.normal_index)])
