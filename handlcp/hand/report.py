"""What is said of a hand beside the mechanics: reasons of verdicts, lines of explanations, places for pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array
from handlcp.geometry.link_penetration import find_impossible_links, posture_reasons
from handlcp.geometry.object import Object, describe_missing_weight
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.failure.failure_mode import FailureMode
from handlcp.grasp.failure.reason import Reason, make_reason
from handlcp.grasp.model.request import GraspSpec
from handlcp.hand.explanation_lines import ExplanationLine, explanation_lines
from handlcp.hand.squeeze import reach_reasons, start_penetration_reasons
from handlcp.hand.torque_check import (
    JOINT_EFFORT,
    TENDON_EFFORT,
    closing_reasons,
    motor_pull_reasons,
    open_torque_reasons,
    tension_reasons,
    torque_reasons,
    unmade_reasons,
)
from handlcp.robot.audit import doubt_reasons
from handlcp.robot.hand_model import HandPosture


@dataclass(frozen=True, slots=True)
class HandReport:
    """What verdicts, explanations and pictures say of the hand that holds an object.

    mechanism : its `HandMechanism`.
    """

    mechanism: Any

    @property
    def links(self) -> dict[str, str]:
        """The link of each fingertip that is a place on a link, by the fingertip's name; {} where tips alone touch."""
        hand = self.mechanism.posture.hand
        return {} if hand.links_of_sites is None else dict(zip(hand.fingertips, hand.links_of_sites, strict=True))

    def explanation_lines(self) -> tuple[ExplanationLine, ...]:
        """(title, equation, whether it is on, why, answers that count it) of joints, motors and tendons."""
        return explanation_lines(self.mechanism.posture.hand, self.mechanism.parallel_spring_torque())

    def reasons(self, solution: Any) -> Iterator[Reason]:
        """What its torques, its limits and its posture say of whether a solution of its grasp holds."""
        if solution.held:
            yield from torque_reasons(solution.torque_check)
            yield from self.open_reasons(solution)
            yield from doubt_reasons(self.mechanism.posture.hand.doubts)
        yield from self.command_reasons(solution.spec)
        yield from self.place_reasons(self.mechanism.posture, self.mechanism.target, "in the given posture")

    def open_reasons(self, solution: Any) -> Iterator[Reason]:
        """Between what and what torques are, where a solution of its grasp leaves forces open."""
        yield from open_torque_reasons(solution)

    def command_reasons(self, spec: GraspSpec) -> Iterator[Reason]:
        """What of a squeeze no command of the joints makes; the weight, where the load leaves it out."""
        yield from self.start_inside_reasons(spec)
        yield from reach_reasons(spec)
        if (command := find_command(spec.effects)) is not None and command.keeps:
            yield make_reason("object_kept", "note")
        if command is not None:
            hand = self.mechanism.posture.hand
            yield from unmade_reasons(self.mechanism.names, hand.stiffness, command.command, hand.sliding)
        if text := describe_missing_weight(spec, self.mechanism.weight_of_object(spec.reference)):
            yield make_reason("weight_left_out", "note", text=text)

    def start_inside_reasons(self, spec: GraspSpec) -> Iterator[Reason]:
        """Links that the object begins inside, before the hand closes."""
        yield from start_penetration_reasons(spec)

    def end_reasons(self, torque: Array, yielded: Array, place: tuple[Any, Any]) -> Iterator[Reason]:
        """What a loading's end says: torques (nv,), how far joints yield (nv,), and `place_at` there."""
        most = self.mechanism.limits
        at_limit = np.where(yielded != 0.0, np.clip(torque, -most, most), torque)  # but for rounding
        yield from torque_reasons(self.mechanism.check_torques(at_limit, yielded))
        yield from doubt_reasons(self.mechanism.posture.hand.doubts)
        yield from self.place_reasons(*place, "at the end of the loading")

    def closing_reasons(self, beyond: Iterable[FailureMode]) -> Iterator[Reason]:
        """Joints and tendons that closing took more of than their motors give, as reasons."""
        hand, all_of_them = self.mechanism.posture.hand, tuple(beyond)
        if (drives := hand.torques.drives) is not None:
            yield from closing_reasons(JOINT_EFFORT, self.mechanism.names, all_of_them, drives, hand.sliding)
        if isinstance(hand.stiffness, TendonStiffness) and (drives := hand.stiffness.drives) is not None:
            yield from closing_reasons(TENDON_EFFORT, hand.stiffness.cables.names, all_of_them, drives)

    def tension_reasons(self, tension: Array) -> Iterator[Reason]:
        """What tendons pull with at the end, (t,) [N], beside what they bear and their motors hold."""
        if isinstance(stiffness := self.mechanism.posture.hand.stiffness, TendonStiffness):
            yield from tension_reasons(stiffness, tension)

    def pulling_reasons(self, spec: GraspSpec, torque: Array) -> Iterator[Reason]:
        """Torques (nv,) [N·m] where the hand has closed, beside those that it was to close with."""
        if (found := self.mechanism.motor_pull(spec, torque)) is not None:
            (pulling, shares), hand = found, self.mechanism.posture.hand
            yield from motor_pull_reasons(self.mechanism.names, pulling, shares, spec.asked.closed.stuck, hand.sliding)

    def place_reasons(self, posture: HandPosture | None, obj: Object | None, when: str) -> Iterator[Reason]:
        """What a posture alone says, with the object where it is then; None for what is not known. when : that is,
        such as "at the end of the loading".
        """
        if posture is not None:
            yield from posture_reasons(posture, obj, self.mechanism.tips, when)

    def place_at(self, q: Array, pose: Any) -> tuple[HandPosture, Object | None]:
        """The posture with joints at q (nv,), and the object in this pose of a moving geometry; None if unknown."""
        placed = None
        if self.mechanism.target is not None:
            R, t = pose
            placed = self.mechanism.target.moved_to(pin.SE3(R, t) * self.mechanism.target.placement)
        return type(self.mechanism.posture)(self.mechanism.posture.hand, q), placed

    def find_links_inside(self, q: Array, pose: Any) -> tuple[set[str], str]:
        """Links that are deep in the object where no contact is, and a sentence about them; arguments of `place_at`."""
        posture, obj = self.place_at(q, pose)
        return (set(), "") if obj is None else find_impossible_links(posture, obj, self.mechanism.tips)
