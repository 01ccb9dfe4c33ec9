"""The same hand with other numbers, by name: first lengths, axes and places, then whole arguments, then others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from handlcp.errors import InputError
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.elasticity.stiffness import read_spring, stiff_as
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.parts import replaced
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.source.description import COLLISION
from handlcp.hand.vary.names import (
    AXIS,
    LENGTH,
    LIMIT,
    MOTOR,
    PAD,
    POSITION,
    RADIUS,
    STIFFNESS,
    Changes,
    argument,
    read_changes,
)
from handlcp.hand.vary.shape import reshaped


def varied(hand: HandModel, by_tip: Mapping[str, Any], changes: Any) -> dict[str, Any]:
    """What changes of a hand, by attribute; changes as of `Hand.vary`. by_tip : what was passed fingertip by fingertip.

    Raises InputError, UnknownName, Unsupported, URDFError.
    """
    asked = read_changes(hand, changes)
    step = _Step(hand, by_tip)
    if any(asked.of(what) for what in (LENGTH, AXIS, POSITION)):
        step.take(reshaped(hand, by_tip["radius"], asked))
    if asked.whole:
        step.replace(**asked.whole)
    step.touch(asked)
    step.spring(asked.of(STIFFNESS))
    step.limit(asked.of(LIMIT))
    step.drive(asked.of(MOTOR))
    return step.parts


class _Step:
    """The hand on its way: `hand` as it is so far, and the parts that differ."""

    def __init__(self, hand: HandModel, by_tip: Mapping[str, Any]) -> None:
        self.hand, self.by_tip = hand, by_tip
        self.parts: dict[str, Any] = {}

    def take(self, parts: dict[str, Any]) -> None:
        """Other parts, by attribute."""
        self.hand, self.by_tip = self.hand.with_parts(**parts), parts.get("_by_tip", self.by_tip)
        self.parts |= parts

    def replace(self, **given: Any) -> None:
        """Arguments of `Hand.replace`."""
        self.take(replaced(self.hand, self.by_tip, given))

    def touch(self, asked: Changes) -> None:
        """Radii of fingertips and pads, beside those of the others."""
        tips = self.hand.fingertips
        if radii := asked.of(RADIUS):
            was = self.by_tip["radius"]
            own = {} if was is None else was if isinstance(was, Mapping) else dict.fromkeys(tips, was)
            self.replace(tip_radius={**own, **radii})
        if pads := asked.of(PAD):
            links = {link: self.hand.pads.of_link(link) for link in self.hand.description.has(COLLISION)}
            own = dict(zip(tips, self.hand.pads.blocks, strict=True))
            self.replace(pad_flexibility={**links, **own, **pads})

    def spring(self, springs: Mapping[str, Any]) -> None:
        """Joints with springs of their own. Raises InputError for one that shares them with others."""
        if not springs:
            return
        read = {joint: read_spring(argument(joint, STIFFNESS), k) for joint, k in springs.items()}
        try:
            self.take({"stiffness": stiff_as(self.hand.stiffness, read, self.hand.joint_names)})
        except InputError:
            expected = "a joint with a spring of its own (joint_stiffness changes springs that joints share)"
            raise InputError(argument(next(iter(springs)), STIFFNESS), expected, ", ".join(springs)) from None

    def limit(self, limits: Mapping[str, Any]) -> None:
        """Torque limits, beside those that were passed of other joints."""
        if not limits:
            return
        joints, torques = self.hand.joint_names, self.hand.torques
        bare = torques if torques.without is None else torques.without
        driven = () if torques.drives is None else torques.drives.names(joints)
        every = zip(joints, bare.limits.tolist(), strict=True)
        passed = {joint: x for joint, x in every if joint in bare.given and joint not in driven}
        self.replace(torque_limits={**passed, **limits})

    def drive(self, motors: Mapping[str, Any]) -> None:
        """Motors of joints and tendons, beside those of the others."""
        joints, stiffness = self.hand.joint_names, self.hand.stiffness
        if own := {name: motor for name, motor in motors.items() if name in joints}:
            self.replace(motors=_beside(joints, self.hand.torques.drives, own))
            said = {joint: m.stiffness for joint, m in own.items() if m is not None and m.stiffness is not None}
            self.take({"stiffness": stiff_as(stiffness, said, joints)})  # of other joints, joint_stiffness may be newer
        of_tendons = {name: motor for name, motor in motors.items() if name not in joints}
        if of_tendons and isinstance(stiffness, TendonStiffness):
            made = stiffness.motored(_beside(stiffness.names, stiffness.drives, of_tendons))
            made.check_driven_once(self.hand.torques.drives, joints)
            self.take({"stiffness": made})


def _beside(names: Sequence[str], drives: Drives | None, motors: Mapping[str, Any]) -> dict[str, Any]:
    """Motors by name beside those that were there, of names in their order; None of a motor: it goes."""
    was = {} if drives is None else dict(zip(names, drives.of, strict=True))
    return {name: motor for name, motor in {**was, **motors}.items() if motor is not None}
