"""Anisotropic friction: a contact that holds better one way than the other, such as ribbed rubber.

    (r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,    v_T = -α (r_x/μ_x², r_y/μ_y²), α ≥ 0 on the limit

No unknowns and no rows of its own: the scene is built in coordinates in which the ellipse is a disc (`assembly.build`),
and the friction of the section, disc or polygon, does the rest.
"""

from __future__ import annotations

from typing import Any

from handlcp.grasp.friction import Coulomb, Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene


class AnisotropicFriction(Effect):
    """Contacts whose law has two scales, such as `AnisotropicCoulomb`."""

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
