"""Coulomb friction in a plane: one tangent, two directions, exact.

    ε_T = λ⁻ - λ⁺,    0 ≤ λ^± ⟂ μ r_N ∓ r_T ≥ 0

No cone is linearised: a friction interval has two ends. Source: model, table of effects.
"""

from __future__ import annotations

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["CoulombPlanar"]


class CoulombPlanar(Effect):
    """One tangential force and two multipliers for each contact with friction."""

    title = "Coulomb friction, planar"
    equation = "ε_T = λ⁻ - λ⁺,  0 ≤ λ^± ⟂ μ r_N ∓ r_T ≥ 0"

    def why(self, scene: Scene) -> str:
        """Which contacts."""
        return f"{len(scene.rough)} contacts with μ > 0 in a planar scene"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: one a contact; λ: two a contact."""
        s, k = scene.units, len(scene.rough)
        return (
            Unknown("r_T", k, True, "N", "m", s.force, s.motion),
            Unknown("λ", 2 * k, False, "m", "N", s.motion, s.force),
        )

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the tangent, and how far the force is from both ends."""
        t, f, normals = system.at["r_T"].start, system.at["λ"].start, system.at["r_N"].start
        place = {c // 3: i for i, c in enumerate(scene.normal_index.tolist())}
        M = system.M
        for k, contact in enumerate(scene.rough):
            M[t + k, f + 2 * k], M[t + k, f + 2 * k + 1] = 1.0, -1.0
            M[f + 2 * k, t + k], M[f + 2 * k + 1, t + k] = -1.0, 1.0
            M[f + 2 * k : f + 2 * k + 2, normals + place[contact]] = scene.mu[contact]
        system.load("r_T", scene.natural.d[scene.natural.split :])
