"""How far the joints are commanded beyond the posture: δv = J (C K_g - 1) δq, C = (K + K_g)⁻¹."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.effects.joint_offset import joints_commanded, recommanded
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import TENTH, OfJoints, Shown, larger
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, in_plane, no_change


class JointCommand(OfJoints):
    """(nv,) δq [rad, m]."""

    name = "joint_offset"
    order, effort, common = 70, 0, "command of the joints"

    def values(self, spec: GraspSpec) -> Array:
        return joints_commanded(spec.effects, self.shape(spec)[0])

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(effects=recommanded(spec.effects, larger(self.values(spec), k, step)))

    def change(self, answer: Answer) -> Change:
        J = answer.rows
        nv = J.shape[1]
        change, follows = no_change(answer, nv), np.eye(nv)
        if answer.bent is not None:
            follows = follows - answer.compliance @ answer.bent
            change.torque[:] = answer.bent @ follows
        change.motion[:] = -answer.scale[:, None] * (J @ follows)
        return in_plane(answer, change)

    def shown(self, answer: Answer) -> Shown | None:
        if answer.spec.mechanism is None or not answer.command.any():
            return None
        given = ("squeeze", "squeeze"), ("grip_force", "grip force")
        what = next((words for name, words in given if getattr(answer.spec.asked, name, None) is not None), "command")
        return Shown(f"{what} +10 %", [("all joints", TENTH * answer.command)])
