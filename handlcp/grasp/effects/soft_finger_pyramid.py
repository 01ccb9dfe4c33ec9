"""Soft fingers on polyhedra: one multiplier for each face of the limit surface in (r_T, r_τ/ρ).

    (v_T, ρ ω_n) = -N λ,    0 ≤ λ ⟂ μ_m r_N - Nᵀ (r_T, r_τ/ρ) ≥ 0,    ρ = μ_τ/μ

with the outward normals of `limit_set` in the columns of N.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

from handlcp.grasp.effects.coulomb_pyramid import place_faces
from handlcp.grasp.friction import Cone, Coulomb, Pyramid, Section, limit_set
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown

__all__ = ["SoftFingerPyramid", "soft_without_moment", "torsional_forces", "why_not_soft"]


@dataclass(frozen=True, slots=True)
class SoftFingerPyramid(Effect):
    """Contacts whose law has a lever, such as `SoftFinger`."""

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
    order: ClassVar[int] = 60

    @classmethod
    def called_for(cls, scene: Scene, section: Section, multipliers: bool) -> Effect | None:
        """On pyramids, with multipliers."""
        return _of(section) if scene.soft and multipliers and isinstance(section, Pyramid) else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """No contact is soft, or the cone was asked for."""
        return why_not_soft(scene, section)

    def why(self, scene: Scene) -> str:
        """Which contacts, what polyhedron."""
        where = "inscribed" if self.pyramid.inscribed else "circumscribed"
        return f"{len(scene.soft)} contacts with μ_τ > 0, {limit_set(self.pyramid, 3).faces} faces, {where}"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Points."""
        return soft_without_moment(contacts)

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_S: x, y and the moment over its lever, three a contact; λ_S: one a face."""
        faces = limit_set(self.pyramid, 3).faces * len(scene.soft)
        return torsional_forces(scene), Unknown("λ_S", faces, False, "motion", "force")

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the faces, and how far force and moment are inside each of them."""
        place_faces(system, scene, scene.soft, ("r_S", "λ_S"), self.pyramid)
        system.load_tangents("r_S", scene)


_of = lru_cache(maxsize=64)(SoftFingerPyramid)


def torsional_forces(scene: Scene) -> Unknown:
    """r_S of the soft contacts."""
    return Unknown("r_S", 3 * len(scene.soft), True, "force", "motion")


def soft_without_moment(contacts: tuple[Contact, ...]) -> dict[str, Any]:
    """The contacts, soft ones under Coulomb's law."""
    return {"contacts": tuple([c.with_friction(Coulomb(c.mu)) if c.friction.lever > 0.0 else c for c in contacts])}


def why_not_soft(scene: Scene, section: Section) -> str:
    """Why a form of the soft finger is absent."""
    if not scene.soft:
        return "no contact is a SoftFinger"
    return "the exact cone was asked for" if isinstance(section, Cone) else "a pyramid was asked for"
