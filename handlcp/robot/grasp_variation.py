"""The grasp of a hand made again with another posture, or with links of other lengths.

A link's length is where its end is: the placement of the next joint in the frame of the one before, or of a fingertip
in the frame of the last joint. Its three coordinates are varied in Pinocchio's model; what it carries moves along.
That is all that derivatives take; a whole hand of other lengths, shapes and routes along, is made by `hand/vary`.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.request import GraspSpec
from handlcp.robot.hand_model import HandModel, HandPosture
from handlcp.robot.kinematics import Kinematics


def lengthen_link(hand: HandModel, k: int, step: float) -> HandModel:
    """The hand with coordinate k of its lengths, three for each of `GraspVariation.lengths`, larger by a step [m]."""
    model, which, axis = hand.model, k // 3, k % 3
    joints = hand.kinematics.movable
    if which < len(joints):
        joint = model.getJointId(joints[which])
        place = pin.SE3(model.jointPlacements[joint])
        place.translation[axis] += step
        model.jointPlacements[joint] = place
    else:
        frame = model.frames[hand.tips.frames[which - len(joints)]]
        place = pin.SE3(frame.placement)
        place.translation[axis] += step
        frame.placement = place
    made = copy(hand)
    made.__dict__["kinematics"] = Kinematics(model, hand.kinematics.facts)
    return made


def _add_spring(hand: HandModel, k: int, step: float) -> HandModel:
    """With a spring more at joint k: C' = C - C e eᵀ C / (1/step + C_kk), written as the square of its root."""
    made, springs, C = copy(hand), copy(hand.stiffness), hand.stiffness.compliance(np.eye(hand.nv))
    if C[k, k] > 0.0:
        less = (1.0 - 1.0 / np.sqrt(1.0 + step * C[k, k])) / C[k, k]
        springs.root = read_only(springs.root - less * np.outer(C[:, k], springs.root[k]))
    made.__dict__["stiffness"] = springs
    return made


class GraspVariation:
    """The part of a hand's `Mechanism` that makes its grasp again. posture, tips, jacobian : as in `HandMechanism`."""

    posture: HandPosture
    tips: tuple[int, ...]
    jacobian: Array

    def angular_jacobian(self) -> Array:
        """(n, 3, nv), zero for contacts of the environment."""
        J = self.posture.angular_jacobian(self.tips)
        still = len(self.jacobian) // 3 - len(self.tips)
        return read_only(np.concatenate([J, np.zeros((still, *J.shape[1:]))]) if still else J)

    @property
    def lengths(self) -> tuple[str, ...]:
        """Names of joints and fingertips, in the order of `lengthen_link`."""
        return (*self.posture.hand.kinematics.movable, *self.posture.hand.fingertips)

    def vary_parameter(self, spec: GraspSpec, what: str, k: int, step: float, inside: Array | None = None) -> GraspSpec:
        """Vary one number of the grasp, as `Mechanism.varied` documents.

        Where nobody knows what was asked, contacts and commands of the joints stay.
        """
        hand, q = self.posture.hand, self.posture.q
        if what == "posture":
            q = q.copy()
            q[k] += step
        elif what == "stiffness":
            hand = _add_spring(hand, k, step)
        else:
            hand = lengthen_link(hand, k, step)
        posture = type(self.posture)(hand, read_only(q))
        if hasattr(spec.asked, "state"):
            made: GraspSpec = replace(spec.asked, state=posture, inside=inside).spec()
            return made
        return _rebuild_in_posture(self, spec, posture)

    def replace_contacts(self, spec: GraspSpec, positions: Array, frames: Array) -> GraspSpec:
        """Move the contacts of a grasp, as `Mechanism.replaced` documents."""
        contacts = [
            c.from_arrays(
                p, read_only(R @ before.T @ c.rotation), c.friction, c.planar, c.name
            )  # its own axes turn along
            for c, p, R, before in zip(spec.contacts, positions, frames, spec.frames, strict=True)
        ]
        moved = spec.replace(contacts=tuple(contacts), positions=positions, frames=frames, asked=spec.asked)
        return _rebuild_in_posture(self, moved, self.posture)


def _rebuild_in_posture(before: Any, spec: GraspSpec, posture: HandPosture) -> GraspSpec:
    """The grasp with a `HandMechanism` in another posture, its flexibility and its fingers' weight."""
    k, E = spec.of_hand, spec.flexibility
    made = before.move_contacts(posture, spec.positions[:k], spec.frames[:k])
    if before.has_joint_flexibility(spec):
        E = E.copy()
        E[: 3 * k, : 3 * k] = made.flexibility()[: 3 * k, : 3 * k]
    effects = tuple(
        replace(e, torque=read_only(posture.gravity_torque(made.gravity))) if isinstance(e, FingerWeight) else e
        for e in spec.effects
    )
    return spec.replace(mechanism=made, flexibility=read_only(E), effects=effects, asked=spec.asked)
