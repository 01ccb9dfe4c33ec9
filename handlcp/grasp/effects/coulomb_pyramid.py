"""Coulomb friction on a pyramid of m faces: inside it sticks, on a face it slides against the face.

    ε_T = -N λ,    0 ≤ λ ⟂ μ_m r_N - Nᵀ r_T ≥ 0,    N = (cos α_j; sin α_j), α_j = 2πj/m

with the outward face normals in the columns of N; μ_m = μ cos(π/m) for the inscribed pyramid, μ for the circumscribed.
Source: paper, equations (7) to (12), with the signs of the model (its D is our -N).
"""

from __future__ import annotations

from dataclasses import dataclass


from handlcp.grasp.effects.base import Effect
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["CoulombPyramid"]


@dataclass(frozen=True, slots=True)
class CoulombPyramid(Effect):
    """Two tangential forces and m face multipliers for each contact with friction."""

    pyramid: Pyramid

    title = "Coulomb friction, pyramid"
    equation = "ε_T = -N λ,  0 ≤ λ ⟂ μ_m r_N - Nᵀ r_T ≥ 0"

    def why(self, scene: Scene) -> str:
        """Which contacts, what pyramid."""
        return f"{len(scene.rough)} contacts with μ > 0, {self.pyramid.name}"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: two a contact; λ: m a contact."""
        s, k, m = scene.units, len(scene.rough), int(self.pyramid.faces)
        return (
            Unknown("r_T", 2 * k, True, "N", "m", s.force, s.motion),
            Unknown("λ", m * k, False, "m", "N", s.motion, s.force),
        )

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the faces, and how far the force is inside each of them."""
        N, m = self.pyramid.normals, int(self.pyramid.faces)
        limits = self.pyramid.limit(scene.mu)
        tangential, faces, normals = system.at["r_T"].start, system.at["λ"].start, system.at["r_N"].start
        place = {c // 3: i for i, c in enumerate(scene.normal_index.tolist())}
        M = system.M
        for k, contact in enumerate(scene.rough):
            t, f = slice(tangential + 2 * k, tangential + 2 * k + 2), slice(faces + m * k, faces + m * k + m)
            M[t, f] = N
            M[f, t] = -N.T
            M[f, normals + place[contact]] = limits[contact]
        system.load("r_T", scene.natural.d[scene.natural.split :])


