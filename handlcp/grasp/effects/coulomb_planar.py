"""Coulomb friction in a plane: one tangent, two directions, exact.

    ε_T = λ⁻ - λ⁺,    0 ≤ λ^± ⟂ μ r_N ∓ r_T ≥ 0

No cone is linearised: a friction interval has two ends.
"""

from __future__ import annotations

import numpy as np

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.coulomb_pyramid import place_faces
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["CoulombPlanar"]


class CoulombPlanar(Effect):
    """One tangential force and two multipliers for each contact with friction."""

    title = "Coulomb friction, planar"
    equation = "ε_T = λ⁻ - λ⁺,  0 ≤ λ^± ⟂ μ r_N ∓ r_T ≥ 0"
    when = "A scene in a plane, whose friction is exact without faces."
    in_python = "friction=Coulomb(0.6), plane=(0, 1, 0)"
    in_file = "grasp.friction = 0.6\ngrasp.plane = [0, 1, 0]"
    brings = "1 + 2 a contact"
    source = "Ai & Li (2025), equations (7) to (12) with two directions"

    def why(self, scene: Scene) -> str:
        """Which contacts."""
        return f"{len(scene.rough)} contacts with μ > 0 in a planar scene"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: one a contact; λ: two a contact."""
        k = len(scene.rough)
        return (
            Unknown("r_T", k, True, "force", "motion"),
            Unknown("λ", 2 * k, False, "motion", "force"),
        )

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the tangent, and how far the force is from both ends."""
        at = system.at
        place_faces(
            system.M,
            at["r_T"].start,
            at["λ"].start,
            at["r_N"].start,
            scene.rough_rows,
            scene.mu[list(scene.rough)],
            _ENDS,
        )
        system.load("r_T", scene.tangential_offset)


_ENDS = np.array([[1.0, -1.0]])  # outward normals of the friction interval
