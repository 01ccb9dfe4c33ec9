"""Unilateral contact: a finger pushes, never pulls, and only where it touches.

    0 ≤ r_N ⟂ ε_N ≥ 0,    ε_N = (Gᵀu + E r + d)_N

d_N > 0 is an initial gap, d_N < 0 a preload.
"""

from __future__ import annotations

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown
from handlcp.tolerances import ACTIVE

__all__ = ["UnilateralContact"]


class UnilateralContact(Effect):
    """Normal force and gap, complementary, with gap and preload as data."""

    title = "unilateral contact"
    equation = "0 ≤ r_N ⟂ ε_N ≥ 0,  ε_N = (Gᵀu + E r + d)_N"
    when = "Fingers push and never pull; gaps and preloads are data."
    in_python = ""
    in_file = ""
    brings = "1 a contact"
    source = "Ai & Li (2025), equations (3) and (4)"

    def why(self, scene: Scene) -> str:
        """How many contacts, with what gap or preload."""
        normal = scene.offset[:, 2]
        nothing = ACTIVE * scene.units.motion
        gaps, loads = int((normal > nothing).sum()), int((normal < -nothing).sum())
        return f"{len(scene.normal_index)} contacts, {gaps} with a gap, {loads} with a preload"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_N: (n_N,) normal forces."""
        return (Unknown("r_N", len(scene.normal_index), False, "force", "motion"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial gaps."""
        a = scene.natural
        system.load("r_N", a.d[: a.split])
