"""Soft fingers on the exact cone: the limit surface is an ellipsoid, and no multipliers are needed.

    |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²,    (v_T, ω_n) along minus its normal on the limit

Three tangential unknowns a contact, the third its moment about the normal over the lever μ_τ/μ; the solver projects on
the ball that the ellipsoid is then.
"""

from __future__ import annotations

from typing import Any

from handlcp.grasp.effects.soft_finger_pyramid import soft_without_moment, torsional_forces, why_not_soft
from handlcp.grasp.friction import Pyramid, Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown

__all__ = ["SoftFingerCone"]


class SoftFingerCone(Effect):
    """Contacts whose law has a lever, such as `SoftFinger`."""

    title = "soft finger, cone"
    equation = "|r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²"
    when = "Soft fingertips that hold against spinning, exactly."
    in_python = 'friction=SoftFinger(0.6, 0.005), faces="cone"'
    in_file = 'grasp.friction = { mu = 0.6, mu_torsion_m = 0.005 }\nsolve.faces = "cone"'
    brings = "3 a contact"
    source = "Howe & Cutkosky, Int. J. Robotics Research 15 (1996)"
    order = 70

    @classmethod
    def called_for(cls, scene: Scene, section: Section, multipliers: bool) -> Effect | None:
        """Where friction has no multipliers."""
        return _SOFT if scene.soft and not (multipliers and isinstance(section, Pyramid)) else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """No contact is soft, or a pyramid was asked for."""
        return why_not_soft(scene, section)

    def why(self, scene: Scene) -> str:
        """Which contacts."""
        return f"{len(scene.soft)} contacts with μ_τ > 0, exact ellipsoid"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Points."""
        return soft_without_moment(contacts)

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_S: x, y and the moment over its lever, three a contact."""
        return (torsional_forces(scene),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial tangential offsets."""
        system.load_tangents("r_S", scene)


_SOFT = SoftFingerCone()
