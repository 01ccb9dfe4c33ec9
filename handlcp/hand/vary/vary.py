"""`vary_parts`: the numbers of a hand by the names with which `Hand.vary` changes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.actuation.joint_stiffness import JointStiffness, read_spring, with_motor_stiffness
from handlcp.actuation.motor import Drives
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.errors import InputError, UnknownName
from handlcp.hand.hand_parts import replace_parts
from handlcp.hand.vary import hand_shape
from handlcp.hand.vary.hand_shape import LENGTH, LIMIT, MOTOR, PAD, RADIUS, STIFFNESS, HandChanges, change_label
from handlcp.robot.description import COLLISION
from handlcp.robot.hand_model import HandModel

# What a whole argument of `Hand.replace` is the common number of
ARGUMENT_NUMBERS = {"joint_stiffness": STIFFNESS, "pad_flexibility": PAD, "torque_limits": LIMIT, "tip_radius": RADIUS}
NUMBER_UNITS = {LENGTH: "m", STIFFNESS: "N·m/rad", LIMIT: "N·m", RADIUS: "m", PAD: "m/N"}


def hand_numbers(hand: HandModel) -> dict[str, float]:
    """Lengths [m], springs [N·m/rad] and torque limits [N·m] of joints, radii [m] and pads [m/N] of fingertips, by
    name; those alone that are one number: not of springs that joints share, pads that differ by direction, …
    """
    joints, found = hand.joint_names, dict[str, float]()
    for joint in hand.kinematics.movable:
        if (length := hand_shape.joint_length(hand, joint)) is not None:
            found[f"{joint}.{LENGTH}"] = length
    if isinstance(hand.stiffness, JointStiffness) and np.count_nonzero(hand.stiffness.stiffness_matrix) == len(joints):
        springs = np.diagonal(hand.stiffness.stiffness_matrix).tolist()
        found |= {f"{joint}.{STIFFNESS}": spring for joint, spring in zip(joints, springs, strict=True)}
    for joint, limit in zip(joints, hand.torques.limits.tolist(), strict=True):
        if np.isfinite(limit):
            found[f"{joint}.{LIMIT}"] = limit
    for k, tip in enumerate(hand.fingertips):
        shapes = hand.tip_shapes(k) if hand.tip_kind(k) in ("radius", COLLISION) else ()
        if len(shapes) == 1 and shapes[0].is_central and shapes[0].radius is not None:
            found[f"{tip}.{RADIUS}"] = shapes[0].radius
        pad = hand.pads.blocks[k]
        if (pad == pad[0, 0] * np.eye(3)).all():
            found[f"{tip}.{PAD}"] = float(pad[0, 0])
    return found


def hand_number(hand: HandModel, name: str) -> float:
    """One of these, or a whole argument such as "joint_stiffness" that is alike everywhere. Raises UnknownName."""
    numbers = hand_numbers(hand)
    if name in numbers:
        return numbers[name]
    ending = f".{ARGUMENT_NUMBERS.get(name, '?')}"
    if len(alike := {value for other, value in numbers.items() if other.endswith(ending)}) == 1:
        return alike.pop()
    raise UnknownName("changes", "a number of the hand", [str(name)], [*numbers, *ARGUMENT_NUMBERS])


def number_unit(name: str) -> str:
    """Of a number by this name."""
    return NUMBER_UNITS[ARGUMENT_NUMBERS.get(name, name.rpartition(".")[2])]


# ----------------------------------------------------------------
# The same hand with other numbers, by name: first lengths, axes and places, then whole arguments, then others.


def vary_parts(hand: HandModel, by_tip: Mapping[str, Any], changes: Any) -> dict[str, Any]:
    """What changes of a hand, by attribute; changes as of `Hand.vary`. by_tip : what was passed fingertip by fingertip.

    Raises InputError, UnknownName, Unsupported, URDFError.
    """
    asked = hand_shape.read_changes(hand, changes)
    step = _VariationStep(hand, by_tip)
    if any(asked.values_of(what) for what in (LENGTH, hand_shape.AXIS, hand_shape.POSITION)):
        step.take_parts(hand_shape.reshape_hand(hand, by_tip["radius"], asked))
    if asked.arguments:
        step.replace_arguments(**asked.arguments)
    step.change_tips(asked)
    step.change_springs(asked.values_of(STIFFNESS))
    step.change_limits(asked.values_of(LIMIT))
    step.change_motors(asked.values_of(MOTOR))
    return step.parts


class _VariationStep:
    """The hand on its way: `hand` as it is so far, and the parts that differ."""

    def __init__(self, hand: HandModel, by_tip: Mapping[str, Any]) -> None:
        self.hand, self.by_tip = hand, by_tip
        self.parts: dict[str, Any] = {}

    def take_parts(self, parts: dict[str, Any]) -> None:
        """Other parts, by attribute."""
        self.hand, self.by_tip = self.hand.with_parts(**parts), parts.get("_by_tip", self.by_tip)
        self.parts |= parts

    def replace_arguments(self, **given: Any) -> None:
        """Arguments of `Hand.replace`."""
        self.take_parts(replace_parts(self.hand, self.by_tip, given))

    def change_tips(self, asked: HandChanges) -> None:
        """Radii of fingertips and pads, beside those of the others."""
        tips = self.hand.fingertips
        if radii := asked.values_of(RADIUS):
            was = self.by_tip["radius"]
            own = {} if was is None else was if isinstance(was, Mapping) else dict.fromkeys(tips, was)
            self.replace_arguments(tip_radius={**own, **radii})
        if pads := asked.values_of(PAD):
            links = {link: self.hand.pads.link_pad(link) for link in self.hand.description.links_with(COLLISION)}
            own = dict(zip(tips, self.hand.pads.blocks, strict=True))
            self.replace_arguments(pad_flexibility={**links, **own, **pads})

    def change_springs(self, springs: Mapping[str, Any]) -> None:
        """Joints with springs of their own. Raises InputError for one that shares them with others."""
        if not springs:
            return
        read = {joint: read_spring(change_label(joint, STIFFNESS), k) for joint, k in springs.items()}
        try:
            self.take_parts({"stiffness": with_motor_stiffness(self.hand.stiffness, read, self.hand.joint_names)})
        except InputError:
            expected = "a joint with a spring of its own (joint_stiffness changes springs that joints share)"
            raise InputError(change_label(next(iter(springs)), STIFFNESS), expected, ", ".join(springs)) from None

    def change_limits(self, limits: Mapping[str, Any]) -> None:
        """Torque limits, beside those that were passed of other joints."""
        if not limits:
            return
        joints, torques = self.hand.joint_names, self.hand.torques
        bare = torques if torques.without_motors is None else torques.without_motors
        driven = () if torques.drives is None else torques.drives.motor_joints(joints)
        every = zip(joints, bare.limits.tolist(), strict=True)
        passed = {joint: x for joint, x in every if joint in bare.given and joint not in driven}
        self.replace_arguments(torque_limits={**passed, **limits})

    def change_motors(self, motors: Mapping[str, Any]) -> None:
        """Motors of joints and tendons, beside those of the others."""
        joints, stiffness = self.hand.joint_names, self.hand.stiffness
        if own := {name: motor for name, motor in motors.items() if name in joints}:
            self.replace_arguments(motors=_merge_motors(joints, self.hand.torques.drives, own))
            said = {joint: m.stiffness for joint, m in own.items() if m is not None and m.stiffness is not None}
            # Of other joints, joint_stiffness may be newer
            self.take_parts({"stiffness": with_motor_stiffness(stiffness, said, joints)})
        of_tendons = {name: motor for name, motor in motors.items() if name not in joints}
        if of_tendons and isinstance(stiffness, TendonStiffness):
            made = stiffness.motored(_merge_motors(stiffness.names, stiffness.drives, of_tendons))
            made.check_driven_once(self.hand.torques.drives, joints)
            self.take_parts({"stiffness": made})


def _merge_motors(names: Sequence[str], drives: Drives | None, motors: Mapping[str, Any]) -> dict[str, Any]:
    """Motors by name beside those that were there, of names in their order; None of a motor: it goes."""
    was = {} if drives is None else dict(zip(names, drives.motors, strict=True))
    return {name: motor for name, motor in {**was, **motors}.items() if motor is not None}
