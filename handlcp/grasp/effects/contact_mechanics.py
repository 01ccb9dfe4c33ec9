"""`ObjectBalance`, `UnilateralContact`, the friction laws' effects and `FingerFlexibility`: what every grasp has.

Object balance: the contact forces and the world's wrench cancel.

    G_N r_N + G_T r_T + w = 0          u ∈ R⁶ (R³ in a plane) free

and, by virtue of the same matrix (virtual work), the object's motion u moves the contacts by Gᵀ u.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from handlcp.check import read_only
from handlcp.contact.friction import Coulomb, Pyramid, Section, limit_set
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.equation_system import EquationSystem, Unknown
from handlcp.grasp.model.scene import Scene
from handlcp.tolerances import ACTIVE_TOLERANCE


class BasicLaw(Effect):
    """A law of balance, contact, friction or flexibility: its unknowns are forces and the object's motion. Every scene
    has it, unless a law says otherwise.
    """

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls()

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any] | None:
        return None

    @property
    def only_limits(self) -> bool:
        """Every search knows these unknowns."""
        return True


class ObjectBalance(BasicLaw):
    """Force and moment balance of a rigid object, with its small motion as multipliers."""

    title = "object balance"
    equation = "G_N r_N + G_T r_T + w = 0,  u free"
    when = "The object is rigid and at rest under all that pushes it."
    brings = "6 (3 in a plane)"
    source = "Ai & Li (2025), equations (1) and (2)"
    order = 10

    def why(self, scene: Scene) -> str:
        return "the object is rigid and free to move" + ("" if scene.plane is None else " in its plane")

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """The motion u (dof,) of the object about the contacts' centre."""
        return (Unknown("u", scene.dof, True, "twist"),)

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """Balance rows and, transposed, the object's motion in the contact rows."""
        system.couple("u", scene.natural.G, 1.0)
        system.load("u", scene.natural.w)


# ----------------------------------------------------------------
# Unilateral contact: a finger pushes, never pulls, and only where it touches.
#
#     0 ≤ r_N ⟂ ε_N ≥ 0,    ε_N = (Gᵀu + E r + d)_N
#
# d_N > 0 is an initial gap, d_N < 0 a preload.


class UnilateralContact(BasicLaw):
    """Normal force and gap, complementary, with gap and preload as data."""

    title = "unilateral contact"
    equation = "0 ≤ r_N ⟂ ε_N ≥ 0,  ε_N = (Gᵀu + E r + d)_N"
    when = "Fingers push and never pull; gaps and preloads are data."
    brings = "1 a contact"
    source = "Ai & Li (2025), equations (3) and (4)"
    order = 20

    def why(self, scene: Scene) -> str:
        normal = scene.offset[2 : 3 * scene.n : 3]
        nothing = ACTIVE_TOLERANCE * scene.units.motion_unit
        gaps, loads = int((normal > nothing).sum()), int((normal < -nothing).sum())
        return f"{len(scene.kind.normal_index)} contacts, {gaps} with a gap, {loads} with a preload"

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """The normal forces r_N (n_N,) of the contacts."""
        return (Unknown("r_N", len(scene.kind.normal_index), False, "force"),)

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """Add the initial gaps to the rows of the normal forces."""
        system.load("r_N", scene.natural.d[: len(scene.kind.normal_index)])


# ----------------------------------------------------------------
# Coulomb friction: a contact sticks, or slides against its friction at the limit.
#
#     |r_T| ≤ μ r_N,    ε_T = -α r_T, α ≥ 0 on the limit
#
# A solver takes the disc as it is, or a polygon in its place; in a plane the disc is an interval. As a plain LCP, the
# polygon's faces have a multiplier each (`MultiplierLCP`). The paper's D is minus our outward normals.


@dataclass(frozen=True, slots=True)
class CoulombFriction(BasicLaw):
    """Tangential forces of every contact with friction but no moment; `section` is the set that limits them."""

    section: Section

    title: ClassVar[str] = "Coulomb friction"
    equation: ClassVar[str] = "|r_T| ≤ μ r_N,  ε_T = -α r_T with α ≥ 0 on the limit"
    when: ClassVar[str] = "Dry friction, alike in all directions: on m faces, on the exact cone, or exact in a plane."
    in_python: ClassVar[str] = "friction=Coulomb(0.6), faces=8"
    in_file: ClassVar[str] = "grasp.friction = 0.6\nsolve.faces = 8"
    brings: ClassVar[str] = "2 a contact (1 in a plane); m more as a plain LCP"
    source: ClassVar[str] = "Ai & Li (2025), equations (7) to (12); De Saxcé & Feng, Math. Comput. Modelling 28 (1998)"
    order: ClassVar[int] = 30

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls(section) if scene.rough else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        return "every contact with friction is soft" if scene.soft else "no contact has μ > 0"

    def why(self, scene: Scene) -> str:
        return f"{len(scene.rough)} contacts with μ > 0, {self.section.name}"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        return {"contacts": tuple([c.with_friction(c.friction.with_mu(0.0)) if c.mu > 0.0 else c for c in contacts])}

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """The tangential forces r_T, two a contact, one in a plane."""
        return (Unknown("r_T", sum(scene.kind.tangent_count[i] for i in scene.rough), True, "force"),)

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """The initial tangential offsets."""
        system.load_tangents("r_T", scene)


# ----------------------------------------------------------------
# Anisotropic friction: a contact that holds better one way than the other, such as ribbed rubber.
#
#     (r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,    v_T = -α (r_x/μ_x², r_y/μ_y²), α ≥ 0 on the limit
#
# No unknowns and no rows of its own: the scene is built in coordinates in which the ellipse is a disc
# (`build_scene`), and the friction of the section, disc or polygon, does the rest.


class AnisotropicFriction(BasicLaw):
    """Contacts whose law has two scales, such as `AnisotropicCoulomb`.

    A law needs no effect to be solved; this one is its row in `explain()`.
    """

    title = "anisotropic friction"
    equation = "(r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,  v_T along minus its normal on the limit"
    when = "Ribbed or woven pads that hold better one way than the other."
    in_python = "friction=AnisotropicCoulomb(0.6, 0.4, along=(0, 0, 1))"
    in_file = "grasp.friction = { mu_x = 0.6, mu_y = 0.4, along = [0, 0, 1] }"
    brings = "none: other coordinates"
    source = "Goyal, Ruina & Papadopoulos, Wear 143 (1991)"
    order = 80

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls() if scene.anisotropic else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        return "every contact holds alike in all directions"

    def why(self, scene: Scene) -> str:
        return f"μ_x and μ_y differ at {scene.anisotropic} contacts: solved where the ellipse is a disc"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        """Coulomb's law with the larger coefficient."""
        alike = zip(contacts, [c.friction.scale[0] == c.friction.scale[1] for c in contacts], strict=True)
        return {"contacts": tuple([c if a else c.with_friction(Coulomb(c.mu)) for c, a in alike])}


# ----------------------------------------------------------------
# Soft fingers: patches that bear a moment about their normal besides the tangential force.
#
#     |r_T|²/μ² + r_τ²/μ_τ² ≤ r_N²,    (v_T, ω_n) along minus the ellipsoid's normal on the limit
#
# Three tangential unknowns a contact, the third its moment over the lever μ_τ/μ: the ellipsoid is then a ball, which a
# solver takes as it is, or a polyhedron in its place (`friction.limit_set`).


@dataclass(frozen=True, slots=True)
class SoftFingerFriction(BasicLaw):
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
        """The tangential forces and the moment r_S of soft fingers, x, y and the moment over its lever: three a
        contact.
        """
        return (Unknown("r_S", 3 * len(scene.soft), True, "force"),)

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """The initial tangential offsets."""
        system.load_tangents("r_S", scene)


# ----------------------------------------------------------------
# Finger flexibility: a finger under load retreats.
#
#     ε += E r,    E = J K⁻¹ Jᵀ + pads (+ compliances asked for) ⪰ 0 over all contacts
#
# E couples normal and tangential directions and, where fingers share joints, different fingers; it may be singular
# (two-joint fingers without pads always are). Nothing here inverts it.


class FingerFlexibility(BasicLaw):
    """Full coupled flexibility in contact axes. It brings no unknowns: the forces are there already."""

    title = "finger flexibility"
    equation = "ε += E r,  E ⪰ 0, coupled"
    when = "Joints and pads give way: what decides how fingers share the load."
    in_python = "joint_stiffness=6.0"
    in_file = "hand.joint_stiffness_Nm_per_rad = 6.0"
    brings = "none: part of E"
    source = (
        "Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989); Ai & Li (2025), equation (13), without coupling"
    )
    order = 90

    @classmethod
    def called_for(cls, scene: Scene, section: Section) -> Effect | None:
        return cls() if scene.kind.flexible else None

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        return "E is zero: rigid fingers"

    def why(self, scene: Scene) -> str:
        return f"E is not zero (mean {scene.flexibility.trace() / (3 * scene.n):.3g} m/N)"

    def without(self, contacts: tuple[Contact, ...]) -> dict[str, Any]:
        return {"flexibility": read_only(np.zeros((3 * len(contacts), 3 * len(contacts))))}

    def stamp(self, scene: Scene, system: EquationSystem) -> None:
        """E between all force components."""
        system.add_between_forces(scene.natural.E)
