"""Finger flexibility: a finger under load retreats.

    ε += E r,    E = J K⁻¹ Jᵀ + pads (+ compliances asked for) ⪰ 0 over all contacts

E couples normal and tangential directions and, where fingers share joints, different fingers; it may be singular
(two-joint fingers without pads always are). Nothing here inverts it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System


class FingerFlexibility(Effect):
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

    def stamp(self, scene: Scene, system: System) -> None:
        """E between all force components."""
        system.add_between_forces(scene.natural.E)
