"""Coulomb friction in a plane: one tangent, two directions, exact.

    ε_T = λ⁻ - λ⁺,    0 ≤ λ^± ⟂ μ r_N ∓ r_T ≥ 0

No cone is linearised: a friction interval has two ends.
"""

from __future__ import annotations

from typing import Any

from handlcp.grasp.effects.coulomb_pyramid import (
    place_faces,
    points_without_friction,
    tangential_forces,
    why_no_points,
)
from handlcp.grasp.friction import Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown

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
    order = 50

    @classmethod
    def called_for(cls, scene: Scene, section: Section, multipliers: bool) -> Effect | None:
        """In a plane, with multipliers."""
        return _PLANAR if scene.rough and multipliers and scene.kind.planar else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """The scene is not planar, or has no friction."""
        return why_no_points(scene, section) if scene.kind.planar or not scene.rough else "the scene is not planar"

    def why(self, scene: Scene) -> str:
        """Which contacts."""
        return f"{len(scene.rough)} contacts with μ > 0 in a planar scene"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Frictionless."""
        return points_without_friction(contacts)

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_T: one a contact; λ: two a contact."""
        return tangential_forces(scene), Unknown("λ", 2 * len(scene.rough), False, "motion", "force")

    def stamp(self, scene: Scene, system: System) -> None:
        """Slip along the tangent, and how far the force is from both ends."""
        place_faces(system, scene, scene.rough, ("r_T", "λ"))
        system.load_tangents("r_T", scene)


_PLANAR = CoulombPlanar()
