"""Soft fingers on the exact cone: the limit surface is an ellipsoid, and no multipliers are needed.

    |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²,    (v_T, ω_n) along minus its normal on the limit

Three tangential unknowns a contact, the third its moment about the normal over the lever μ_τ/μ; the solver projects on
the ball that the ellipsoid is then.
"""

from __future__ import annotations

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["SoftFingerCone"]


class SoftFingerCone(Effect):
    """Contacts whose law is `SoftFinger`."""

    title = "soft finger, cone"
    equation = "|r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²"
    when = "Soft fingertips that hold against spinning, exactly."
    in_python = 'friction=SoftFinger(0.6, 0.005), faces="cone"'
    in_file = 'grasp.friction = { mu = 0.6, mu_torsion_m = 0.005 }\nsolve.faces = "cone"'
    brings = "3 a contact"
    source = "Howe & Cutkosky, Int. J. Robotics Research 15 (1996)"

    @property
    def opens(self) -> bool:
        """Contact modes know two tangents."""
        return True

    def why(self, scene: Scene) -> str:
        """Which contacts."""
        return f"{len(scene.soft)} contacts with μ_τ > 0, exact ellipsoid"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_S: x, y and the moment over its lever, three a contact."""
        return (Unknown("r_S", 3 * len(scene.soft), True, "force", "motion"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial tangential offsets."""
        system.load("r_S", scene.soft_offset)
