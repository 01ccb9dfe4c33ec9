"""Soft fingers: patches that bear a moment about their normal besides the tangential force.

    |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²,    (v_T, ω_n) along minus the ellipsoid's normal on the limit

Three tangential unknowns a contact, the third its moment over the lever μ_τ/μ: the ellipsoid is then a ball, which a
solver takes as it is, or a polyhedron in its place (`friction.limit_set`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from handlcp.grasp.friction import Coulomb, Pyramid, Section, limit_set
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown


@dataclass(frozen=True, slots=True)
class SoftFingerFriction(Effect):
    """Contacts whose law has a lever, such as `SoftFinger`; `section` is the set that limits them."""

    section: Section

    title: ClassVar[str] = "soft finger"
    equation: ClassVar[str] = "|r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²"
    when: ClassVar[str] = "Soft fingertips that hold against spinning; 8 faces lie inside the ellipsoid, by 14 %."
    in_python: ClassVar[str] = "friction=SoftFinger(0.6, 0.005), faces=8"
    in_file: ClassVar[str] = "grasp.friction = { mu = 0.6, mu_torsion_m = 0.005 }\nsolve.faces = 8"
    brings: ClassVar[str] = "3 a contact; 26 more as a plain LCP at m = 8"
    source: ClassVar[str] = "Howe & Cutkosky, Int. J. Robotics Research 15 (1996)"
    order: ClassVar[int] = 60

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls(section) if scene.soft else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        return "no contact is a SoftFinger"

    def why(self, scene: Scene) -> str:
        shape = "exact ellipsoid"
        if isinstance(self.section, Pyramid):
            where = "inscribed" if self.section.inscribed else "circumscribed"
            shape = f"{limit_set(self.section, 3).normals.shape[1]} faces, {where}"
        return f"{len(scene.soft)} contacts with μ_τ > 0, {shape}"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Points under Coulomb's law."""
        return {"contacts": tuple([c.with_friction(Coulomb(c.mu)) if c.friction.lever > 0.0 else c for c in contacts])}

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """r_S: x, y and the moment over its lever, three a contact."""
        return (Unknown("r_S", 3 * len(scene.soft), True, "force"),)

    def stamp(self, scene: Scene, system: System) -> None:
        """The initial tangential offsets."""
        system.load_tangents("r_S", scene)
