"""Soft fingers on polyhedra: one multiplier for each face of the limit surface in (r_T, r_τ/ρ).

    (v_T, ρ ω_n) = -N λ,    0 ≤ λ ⟂ μ_m r_N - Nᵀ (r_T, r_τ/ρ) ≥ 0,    ρ = μ_τ/μ

with the outward normals of `limit_surface` in the columns of N.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.coulomb_pyramid import place_faces
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["SoftFingerPyramid"]


@dataclass(frozen=True, slots=True)
class SoftFingerPyramid(Effect):
    """Contacts whose law is `SoftFinger`."""

    pyramid: Pyramid

    title: ClassVar[str] = "soft finger, polyhedron"
    equation: ClassVar[str] = "(v_T, ρ ω_n) = -N λ,  0 ≤ λ ⟂ μ_m r_N - Nᵀ (r_T, r_τ/ρ) ≥ 0"
    when: ClassVar[str] = "Soft fingertips that hold against spinning; 8 faces lie inside the ellipsoid, by 14 %."
    in_python: ClassVar[str] = "friction=SoftFinger(0.6, 0.005), faces=8"
    in_file: ClassVar[str] = "grasp.friction = { mu = 0.6, mu_torsion_m = 0.005 }\nsolve.faces = 8"
    brings: ClassVar[str] = "3 + 26 a contact at m = 8"
    source: ClassVar[str] = (
        "Howe & Cutkosky, Int. J. Robotics Research 15 (1996), for the ellipsoid that their vertices lie on"
    )

    @property
    def opens(self) -> bool:
        """Contact modes know two tangents."""
        return True

    def why(self, scene: Scene) -> str:
        """Which contacts, what polyhedron."""
        where = "inscribed" if self.pyramid.inscribed else "circumscribed"
        faces = limit_surface(self.pyramid).faces
        return f"{len(scene.soft)} contacts with μ_τ > 0, {faces} faces, {where}"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_S: x, y and the moment over its lever, three a contact; λ_S: one a face."""
        k = len(scene.soft)
        return (
            Unknown("r_S", 3 * k, True, "force", "motion"),
            Unknown("λ_S", limit_surface(self.pyramid).faces * k, False, "motion", "force"),
        )

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the faces, and how far force and moment are inside each of them."""
        at, surface = system.at, limit_surface(self.pyramid)
        place_faces(
            system.M, at["r_S"].start, at["λ_S"].start, at["r_N"].start, scene.soft_rows,
            surface.limit(scene.mu[list(scene.soft)]), surface.normals,
        )  # fmt: skip
        system.load("r_S", scene.soft_offset)
