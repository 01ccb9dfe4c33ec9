"""The grasp of a hand made again with another posture, or with links of other lengths.

A link's length is where its end is: the placement of the next joint in the frame of the one before, or of a fingertip
in the frame of the last joint. Its three coordinates are varied in Pinocchio's model; what it carries moves along.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture

__all__ = ["in_posture", "length_names", "longer", "varied", "with_contacts"]


def length_names(hand: HandModel) -> tuple[str, ...]:
    """Of all movable joints, then of the fingertips."""
    return (*hand.kinematics.movable, *hand.fingertips)


def longer(hand: HandModel, k: int, step: float) -> HandModel:
    """The hand with coordinate k of its lengths, three for each of `length_names`, larger by a step [m]."""
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


def _sprung(hand: HandModel, k: int, step: float) -> HandModel:
    """With a spring more at joint k: C' = C - C e eᵀ C / (1/step + C_kk), written as the square of its root."""
    made, springs, C = copy(hand), copy(hand.stiffness), hand.stiffness.compliance(np.eye(hand.nv))
    if C[k, k] > 0.0:
        less = (1.0 - 1.0 / np.sqrt(1.0 + step * C[k, k])) / C[k, k]
        springs.root = read_only(springs.root - less * np.outer(C[:, k], springs.root[k]))
    made.__dict__["stiffness"] = springs
    return made


def _stronger(hand: HandModel, k: int, step: float) -> HandModel:
    """With a larger torque limit of joint k."""
    made, limits = copy(hand), hand.torques.limits.copy()
    limits[k] += step
    made.__dict__["torques"] = replace(hand.torques, limits=read_only(limits))
    made.__dict__["torque_limits"] = read_only(limits)
    return made


def varied(mechanism: Any, spec: GraspSpec, what: str, k: int, step: float) -> GraspSpec:
    """See `Mechanism.varied`, of a `HandMechanism`."""
    posture: Posture = mechanism.posture
    hand, q = posture.hand, posture.q
    if what == "posture":
        q = q.copy()
        q[k] += step
    elif what == "stiffness":
        hand = _sprung(hand, k, step)
    elif what == "torque_limits":
        hand = _stronger(hand, k, step)
    else:
        hand = longer(hand, k, step)
    return in_posture(mechanism, spec, type(posture)(hand, read_only(q)))


def in_posture(mechanism: Any, spec: GraspSpec, posture: Posture) -> GraspSpec:
    """The grasp asked for again in another posture; where nobody knows what was asked, its contacts stay."""
    if hasattr(spec.asked, "state"):
        made: GraspSpec = replace(spec.asked, state=posture).spec()
        return made
    k = spec.of_fingers
    return _follow(mechanism.moved(posture, spec.positions[:k], spec.frames[:k]), spec, mechanism)


def with_contacts(mechanism: Any, spec: GraspSpec, positions: Array, frames: Array) -> GraspSpec:
    """See `Mechanism.replaced`, of a `HandMechanism`."""
    k = spec.of_fingers
    placed = [
        c.placed(p, R, c.friction, c.planar, c.name) for c, p, R in zip(spec.contacts, positions, frames, strict=True)
    ]
    spec = spec.replace(contacts=tuple(placed), positions=positions, frames=frames, asked=spec.asked)
    return _follow(mechanism.moved(mechanism.posture, positions[:k], frames[:k]), spec, mechanism)


def _follow(made: Any, spec: GraspSpec, before: Any) -> GraspSpec:
    """The grasp with another mechanism, its flexibility and its fingers' weight."""
    m, E = 3 * spec.of_fingers, spec.flexibility
    if before.gives(spec):
        E = E.copy()
        E[:m, :m] = made.flexibility()[:m, :m]
    effects = tuple([
        replace(e, torque=read_only(made.posture.gravity_torque(made.gravity))) if isinstance(e, FingerWeight) else e
        for e in spec.effects
    ])  # fmt: skip
    return spec.replace(mechanism=made, flexibility=read_only(E), effects=effects, asked=spec.asked)
