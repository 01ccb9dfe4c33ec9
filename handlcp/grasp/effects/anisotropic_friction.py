"""Anisotropic friction: a contact that holds better one way than the other, such as ribbed rubber.

    (r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,    v_T = -α (r_x/μ_x², r_y/μ_y²), α ≥ 0 on the limit

No unknowns and no rows of its own: the scene is posed in coordinates in which the ellipse is a disc (`coordinates`),
and the friction of the section, disc or polygon, does the rest.
"""

from __future__ import annotations

from handlcp.grasp.effects.base import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System

__all__ = ["AnisotropicFriction"]


class AnisotropicFriction(Effect):
    """Contacts whose law is `AnisotropicCoulomb`."""

    title = "anisotropic friction"
    equation = "(r_x/μ_x)² + (r_y/μ_y)² ≤ r_N²,  v_T along minus its normal on the limit"
    when = "Ribbed or woven pads that hold better one way than the other."
    in_python = "friction=AnisotropicCoulomb(0.6, 0.4, along=(0, 0, 1))"
    in_file = "grasp.friction = { mu_x = 0.6, mu_y = 0.4, along = [0, 0, 1] }"
    brings = "none: other coordinates"
    source = "Goyal, Ruina & Papadopoulos, Wear 143 (1991)"

    def why(self, scene: Scene) -> str:
        """How many."""
        return f"μ_x and μ_y differ at {scene.anisotropic} contacts: solved where the ellipse is a disc"

    def stamp(self, scene: Scene, system: System) -> None:
        """Nothing: the scene's coordinates have it."""
