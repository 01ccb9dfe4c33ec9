"""The fingers' own weight: torques that hold it, and joints that sag under it before anything is loaded.

    τ = Jᵀ f + g(q),    d += J K⁻¹ g(q)

g(q) is the torque that holds the links in the posture q. A joint of stiffness K that is told to be at q holds it by
giving way: it ends at q - K⁻¹ g, its fingertip J K⁻¹ g lower, so that the object lies that far off, seen from the tip.
The same K⁻¹ (Jᵀ f + g) is the deflection of the joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import Array
from handlcp.grasp.friction import Section
from handlcp.grasp.model.effect import Effect, Trial
from handlcp.grasp.model.kind import Placement
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.model.scene import Scene


@dataclass(frozen=True, eq=False)
class FingerWeight(Effect):
    """Asked for with `finger_weight=True` or `"torques"` of `state.grasp`.

    torque : (nv,) g(q) [N·m]. sags : whether the joints give way to it, because the posture is the one commanded.
    """

    torque: Array
    sags: bool = True

    title = "finger weight"
    equation = "τ += g(q),  d += J K⁻¹ g(q)"
    when = "Fingers heavy beside what they hold, or joints soft enough to sag."
    in_python = "finger_weight=True"
    in_file = "grasp.finger_weight = true"
    brings = "none: data"
    source = "Siciliano et al., Robotics (2009), chapter 7"
    order = 110
    needs_joints = True
    by_name = False

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Only a hand has fingers that weigh anything."""
        return None if scene.mechanism is None else "not asked for"

    @classmethod
    def trial(cls, at: Placement, others: tuple[Effect, ...], forces: Array, torque: Array) -> Trial | None:
        """In torques and elastic balance, where gravity was given."""
        weight = None if at.mechanism is None else at.mechanism.weight()
        if weight is None or any(e.depends_on_forces for e in others):
            return None
        k = int(abs(weight).argmax())
        share = float(abs(weight[k])) / (float(abs(torque).max()) or 1.0)
        words = f"{100 * share:.2g} % of the largest torque, at {at.mechanism.names[k]}"  # type: ignore[union-attr]
        return Trial(cls(weight), share, words, instead=True)

    def why(self, scene: Scene) -> str:
        why = f"asked for: up to {abs(self.torque).max(initial=0.0):.3g} N·m in a joint"
        if not self.sags:
            return f"{why}; the posture has sagged already"
        assert scene.mechanism is not None  # `needs_joints` saw to it
        tips = (scene.mechanism.jacobian @ scene.mechanism.deflection(self.torque)).reshape(-1, 3)
        moved = float(np.sqrt((tips * tips).sum(axis=1)).max(initial=0.0))
        return f"{why}, a fingertip sags by up to {moved:.3g} m"

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """How far the object lies off the tips that sag away from it."""
        if not self.sags:
            return None
        assert at.mechanism is not None
        return np.asarray(at.mechanism.rows(soft) @ at.mechanism.deflection(self.torque))

    def added_torque(self) -> Array | None:
        """g(q), which the actuators hold."""
        return self.torque

    def read(self, scene: Scene, forces: Array, extra: dict[str, Array], joints: JointReading) -> JointReading:
        """Joints that sag."""
        if not self.sags or scene.mechanism is None:
            return joints
        return replace(joints, deflection=joints.deflection + scene.mechanism.deflection(self.torque))
