"""Squeeze given in joint space: the joints are commanded beyond where they stand, and the contacts are preloaded.

    d -= J δq

The motors pull towards q + δq while the hand stands at q. Left alone the tips would move by J δq; the object's motion
relative to them falls short by as much. It is data, like any preload.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.friction import Section
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.placement import Placement
from handlcp.grasp.model.scene import Scene
from handlcp.words import listed

__all__ = ["JointOffset"]


@dataclass(frozen=True, eq=False)
class JointOffset(Effect):
    """Asked for with `joint_offset=` of `state.grasp`. command : (nv,) δq [rad, m], beyond the posture."""

    command: Array

    title = "commanded joint offset"
    equation = "d -= J δq"
    when = "The hand squeezes because its joints are told to close further than they can."
    in_python = 'joint_offset={"finger_1_distal": 0.05}'
    in_file = "grasp.joint_offset_rad = { finger_1_distal = 0.05 }"
    brings = "none: data"
    source = "Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989): joints under position control are springs"
    order = 120
    needs_joints = True
    by_name = False

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Only a hand has joints to command."""
        return None if scene.mechanism is None else "none given"

    def why(self, scene: Scene) -> str:
        assert scene.mechanism is not None  # `needs_joints` saw to it
        moved = [f"{name} {x:+.3g}" for name, x in zip(scene.mechanism.names, self.command.tolist(), strict=True) if x]
        return f"{listed(moved)} rad: data, in the offsets"

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """-J δq, and the turns of soft fingertips likewise."""
        assert at.mechanism is not None
        return np.asarray(-(at.mechanism.rows(soft) @ self.command))
