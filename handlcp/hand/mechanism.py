"""`HandMechanism`: how a hand's joints move the contacts, give way, and what they do at an answer.

    E = J K⁻¹ Jᵀ + pads,    τ = Jᵀ f + Tᵀ m + g + p

p holds springs beside the drives (`robot/servo_stiffness.py`). m are the moments about the normals of soft contacts,
T how fast the joints turn their fingertips about them. Source: docs/theory/model.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from handlcp.actuation.joint_stiffness import Effort, tip_flexibility
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array, read_only
from handlcp.geometry.object import Object, object_weight_wrench
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.joint_offset import commanded_offset, find_command
from handlcp.grasp.model.flexibility import FlexibilityFactor
from handlcp.grasp.model.mechanism import JointModel, Mechanism, evaluate_joints
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.hand.grasp_variation import GraspVariation
from handlcp.hand.report import HandReport
from handlcp.hand.solution import HandGraspSolution
from handlcp.hand.torque_check import MotorPull, TorqueCheck, compare_with_limits
from handlcp.lazy_property import lazy_property
from handlcp.robot.hand_model import HandPosture, contact_hessian

if TYPE_CHECKING:
    from handlcp.hand.moving_geometry import MovingHandGeometry


@dataclass(frozen=True, eq=False)
class HandMechanism(Mechanism):
    """A hand in a posture, as the mechanism of a grasp.

    posture : where the hand is. tips : numbers of the fingertips that take part, in the order of the contacts.
    positions (k, 3), frames (k, 3, 3) : of the fingers' contacts, contact axes. target : the object, if it is known.
    rest_posture (nv,) : where springs at the joints are at rest [rad, m]: in the grasp's posture, also on a path.
    gravity : (3,) as given [m/s²]. stand_off : (k, 3) offsets of the gaps and overlaps that were detected [m], part of
    the grasp's; 0 for contacts that were given.
    """

    solution_class: ClassVar[Any] = HandGraspSolution

    posture: HandPosture
    tips: tuple[int, ...]
    positions: Array
    frames: Array
    target: Object | None
    gravity: Array
    stand_off: Array
    rest_posture: Array

    @property
    def report(self) -> HandReport:
        """What verdicts, explanations and pictures say of the hand."""
        return HandReport(self)

    @property
    def variation(self) -> GraspVariation:
        """The same grasp with something changed."""
        return GraspVariation(self)

    @lazy_property
    def joint_model(self) -> JointModel:
        """Posture, ranges, friction and tendons of the hand's joints."""
        hand, cables = self.posture.hand, None
        limits, stiffness = hand.torques, hand.stiffness
        closes = None if limits.drives is None else limits.closing_limits
        if isinstance(stiffness, TendonStiffness):
            cables = stiffness.cables._replace(rest=read_only(self.rest_posture - self.posture.q))
            if limits.drives is not None or stiffness.drives is not None:
                closes = read_only(np.append(limits.closing_limits, stiffness.closing_tensions))
        return JointModel(self.posture.q, (hand.lower, hand.upper), hand.dry_friction, cables, closes)

    @property
    def fingertips(self) -> tuple[str, ...]:
        """Names of the fingertips that take part, in the order of the contacts."""
        every = self.posture.hand.fingertips
        return tuple([every[i] for i in self.tips])

    def jacobian_rows(self, soft: tuple[int, ...]) -> Array:
        """(3n + k, nv) [J; T], zero for contacts of the environment."""
        if not soft:
            return self.jacobian
        J = self.posture.angular_jacobian(self.tips)
        still = np.zeros(self.posture.hand.nv)
        rows = [self.frames[i, :, 2] @ J[i] if i < len(self.tips) else still for i in soft]
        return read_only(np.concatenate([self.jacobian, rows]))

    def flexibility(self) -> Array:
        """(3k, 3k) E of the fingers' joints and pads [m/N]."""
        return read_only(tip_flexibility(*self.flexibility_factor()))

    def flexibility_factor(self) -> FlexibilityFactor:
        """The same as the factors J, K⁻¹ = A Aᵀ and pads."""
        posture, tips, axes = self.posture, self.tips, self.frames.transpose(0, 2, 1)
        pads = posture.hand.pads.rotate_blocks(lambda: axes @ posture.tip_rotations[list(tips)], tips)
        return FlexibilityFactor(self.jacobian, self.compliance_factor, pads)

    def hessian(self) -> Array:
        """(3n, nv, nv) ∂J/∂q [m/rad²], zero for contacts of the environment."""
        return self._hessian

    @lazy_property
    def _hessian(self) -> Array:
        H = contact_hessian(self.posture, self.tips, self.positions, self.frames)
        still = np.zeros((len(self.jacobian) - len(H), *H.shape[1:]))
        return read_only(np.concatenate([H, still]))

    def gravity_torque(self) -> Array | None:
        """(nv,) g(q) that holds the fingers' own weight [N·m], where gravity is not zero."""
        return read_only(self.posture.gravity_torque(self.gravity)) if self.gravity.any() else None

    def parallel_spring_torque(self, q: Array | None = None) -> Array | None:
        """(nv,) [N·m] of springs beside servos, where the hand's file has them."""
        return self.posture.hand.stiffness.parallel_spring_torque(self.posture.q if q is None else q)

    def moving_geometry(self, spec: GraspSpec) -> MovingHandGeometry:
        """The geometry of this grasp as it moves."""
        from handlcp.hand.moving_geometry import MovingHandGeometry  # only who follows pays for its kernels

        return MovingHandGeometry(spec)

    def weight_of_object(self, point: Array) -> Array:
        """(6,) the object's mass times gravity at its centre of mass, about a point (3,) [N, N·m]."""
        return read_only(object_weight_wrench(self.target, self.gravity, point))

    def move_contacts(self, posture: HandPosture, positions: Array, frames: Array) -> HandMechanism:
        """The same fingers in another posture, with contacts of all fingers elsewhere, as in `make_hand_mechanism`."""
        made = make_hand_mechanism(posture, self.tips, positions, frames, self.target, self.gravity)
        made = replace(made, rest_posture=self.rest_posture, stand_off=self.stand_off)
        return made.with_environment(len(self.jacobian) // 3 - len(self.tips))

    def with_environment(self, environment: int) -> HandMechanism:
        """The same with so many contacts of the environment, which no joint moves."""
        still = np.zeros((3 * environment, len(self.names)))
        return replace(self, jacobian=read_only(np.concatenate([self.jacobian, still]))) if environment else self

    def solution_fields(
        self, scene: Scene, effects: tuple[Effect, ...], forces: Array, torsion: Array | None, extra: dict[str, Array]
    ) -> dict[str, Any]:
        """Torques, deflection, yielding, torque check and effort, as `HandGraspSolution` has them."""
        joints = evaluate_joints(self, scene, effects, forces, torsion, extra)
        total = read_only(joints.torque)
        return {
            "torques": total,
            "joint_deflection": read_only(joints.deflection),
            "joint_yield": read_only(joints.yielded),
            "torque_check": self.check_torques(total, joints.yielded),
            "effort": self._effort(total, effects),
        }

    def _effort(self, torque: Array, effects: tuple[Effect, ...]) -> Effort | None:
        """What tendons or synergies do for torques (nv,), or what is known of it from a path."""
        stiffness, command = self.posture.hand.stiffness, find_command(effects)
        if isinstance(stiffness, TendonStiffness) and command is not None and command.tension is not None:
            return stiffness.tension_effort(command.tension)
        from_rest = self.posture.q - self.rest_posture + commanded_offset(effects, len(self.names))
        return stiffness.effort(torque, from_rest)

    def motor_pull(self, spec: GraspSpec, torque: Array) -> tuple[MotorPull, Array] | None:
        """What a closing torque asked of joints; its shares (nv,) under torque (nv,) [N·m]; None: none was asked."""
        command, closed, hand = find_command(spec.effects), getattr(spec.asked, "closed", None), self.posture.hand
        if command is None or closed is None or closed.torque is None or (command.command != closed.command).any():
            return None
        found = MotorPull.from_torque(closed.torque, hand.moving_joints[list(self.tips)], hand.stiffness)
        return found, found.torque_shares(torque, command.motor_offset)

    def check_torques(self, torque: Array, yielded: Array) -> TorqueCheck:
        """Torques (nv,) [N·m] beside the limits of the joints, of which some yield (nv,) [rad]."""
        some = np.flatnonzero(abs(yielded) > 0.0)  # NaN without an answer
        return compare_with_limits(self.posture.hand, read_only(torque), tuple([self.names[k] for k in some]))


def hand_mechanism(spec: GraspSpec) -> HandMechanism:
    """The mechanism of a grasp that is known to be a hand's."""
    assert isinstance(spec.mechanism, HandMechanism)
    return spec.mechanism


def make_hand_mechanism(
    posture: HandPosture, tips: tuple[int, ...], positions: Array, frames: Array, target: Object | None, gravity: Array
) -> HandMechanism:
    """The mechanism of fingers whose contacts are at positions (k, 3) with frames (k, 3, 3), contact axes."""
    hand, k = posture.hand, len(tips)
    jacobian = (frames.transpose(0, 2, 1) @ posture.jacobian_at(positions, tips)).reshape(3 * k, hand.nv)
    return HandMechanism(
        hand.joint_names, read_only(jacobian), hand.stiffness.compliance_factor, hand.torques.limits, posture, tips,
        positions, frames, target, gravity, read_only(np.zeros((k, 3))), posture.q,
    )  # fmt: skip
