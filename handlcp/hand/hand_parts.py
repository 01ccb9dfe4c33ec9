"""`read_hand_parts`: the parts of a hand from what users pass, and those that change with something else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import pinocchio as pin

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity, FingertipPads, read_pads, with_motor_stiffness
from handlcp.actuation.motor import Drives, Motor, read_motors
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.actuation.transmission import Tendons
from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.robot.description import COLLISION, RobotDescription
from handlcp.robot.fingertip import TipFrames, TipGeometry, find_tips, read_tip_radii
from handlcp.robot.hand_model import HandModel
from handlcp.robot.joint import TorqueLimits, read_joint_friction, read_torque_limits
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.servo_stiffness import FROM_FILE, read_elasticity, read_file_stiffness

HandParts = tuple[Kinematics, TipFrames, Elasticity, FingertipPads, TorqueLimits, TipGeometry]


def read_hand_parts(
    described: RobotDescription, fingertips: Any, stiffness: Any, pads: Any, limits: Any, radius: Any, motors: Any
) -> HandParts:
    """In the order of `HandModel`; arguments as of `Hand.from_urdf`. stiffness Ellipsis : what the motors say. Raises
    InputError, UnknownName, URDFError.
    """
    model = pin.Model(described.model)
    kinematics = Kinematics(model, described.facts)
    tips = find_tips(model, described, fingertips)
    joints = kinematics.joint_names
    stiffness, motors = _split_motors(stiffness, motors, kinematics, described)
    drives = read_motors(motors, joints)
    elasticity = read_elasticity(stiffness, kinematics, described, drives)
    if isinstance(elasticity, TendonStiffness):
        elasticity.check_driven_once(drives, joints)
    return (
        kinematics,
        tips,
        elasticity,
        _read_hand_pads(pads, tips.names, described),
        read_torque_limits(limits, joints, {f.name: f for f in described.facts}, drives),
        TipGeometry(described, tips, read_tip_radii(radius, tips.names)),
    )


def replace_parts(hand: HandModel, by_tip: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """What changes of a hand, by attribute, with arguments of `Hand.replace`; by_tip : what was passed by fingertip."""
    described, tips = hand.description, hand.tips
    own = {"pads": "pad_flexibility", "radius": "tip_radius"}
    passed = {key: deepcopy(given[name]) if name in given else by_tip[key] for key, name in own.items()}
    parts: dict[str, Any] = {"_by_tip": passed}
    if "fingertips" in given:
        model = pin.Model(described.model)
        tips = find_tips(model, described, given["fingertips"])
        parts |= {"tips": tips, "fingertips": tips.names, "kinematics": Kinematics(model, described.facts)}
    if "fingertips" in given or "pad_flexibility" in given:
        parts["pads"] = _read_hand_pads(passed["pads"], tips.names, described)
    if "fingertips" in given or "tip_radius" in given:
        parts["_geometry"] = TipGeometry(described, tips, read_tip_radii(passed["radius"], tips.names))
    if "motors" in given:
        given = _assign_motors(hand, given)
    drives = read_motors(given.get("motors"), hand.joint_names)
    if "joint_stiffness" in given:
        parts["stiffness"] = read_elasticity(given["joint_stiffness"], hand.kinematics, described, drives)
    elif "motors" in given:  # joints are as stiff as their motors say
        of_motors = {} if drives is None else drives.stiffness(hand.joint_names)
        parts["stiffness"] = with_motor_stiffness(hand.stiffness, of_motors, hand.joint_names)
    if "torque_limits" in given or "motors" in given:
        torques = _replaced_limits(hand, given, drives)
        parts |= {"torques": torques, "torque_limits": torques.limits}
    stiffness, torques = parts.get("stiffness", hand.stiffness), parts.get("torques", hand.torques)
    if isinstance(stiffness, TendonStiffness):
        stiffness.check_driven_once(torques.drives, hand.joint_names)
    if "joint_friction" in given:
        parts["joint_friction"] = read_hand_friction(hand, given["joint_friction"])
    return parts


def _read_hand_pads(value: Any, tips: Sequence[str], described: RobotDescription) -> FingertipPads:
    """Read the flexibility of pads as `read_pads` does. Raises InputError for links without collision geometry, too."""
    touch = described.links_with(COLLISION)
    if isinstance(value, Mapping):
        links = {f.name for f in described.model.frames if f.type == pin.FrameType.BODY} - {*tips, *touch}
        if bare := [name for name in value if name in links]:
            known = words.list_names(list(touch)) or "there is none"
            expected = f"fingertips, or links with collision geometry ({known})"
            has = "has" if len(bare) == 1 else "have"
            raise InputError("pad_flexibility", expected, f"{words.list_names(bare)}, which {has} none")
    return read_pads(value, tips, touch)


def _assign_motors(hand: HandModel, given: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `Hand.replace`, `motors` among them, those of tendons with the stiffness."""
    stiffness, motors = given.get("joint_stiffness", hand.stiffness), given["motors"]
    if motors is None:
        own = stiffness is hand.stiffness and isinstance(stiffness, TendonStiffness) and stiffness.drives is not None
        return {**given, "joint_stiffness": stiffness.motored(None)} if own else dict(given)
    stiffness, of_joints = _split_motors(stiffness, motors, hand.kinematics, hand.description)
    if of_joints is motors:
        return dict(given)
    driven = {**given, "joint_stiffness": stiffness, "motors": of_joints}
    if of_joints is None:  # tendons alone are named: joints keep theirs
        del driven["motors"]
    return driven


def _split_motors(stiffness: Any, motors: Any, kinematics: Kinematics, described: RobotDescription) -> tuple[Any, Any]:
    """A stiffness with the motors of its tendons, and the motors of joints, from motors by joint and tendon. Raises
    InputError for one motor of all where there are tendons: it could be of every joint, or of every tendon.
    """
    if motors is not None and isinstance(stiffness, str) and stiffness == FROM_FILE:
        stiffness = read_file_stiffness(described, kinematics)
    tendons = isinstance(stiffness, (Tendons, TendonStiffness))
    if tendons and isinstance(motors, Motor):
        name = next(iter(stiffness.names))
        expected = f"motors by name on a hand with tendons: motors={{{name!r}: Motor(...)}}, or Tendons(motors=...)"
        raise InputError("motors", expected, "one Motor, which could be of every joint or of every tendon")
    if not tendons or not isinstance(motors, Mapping):
        return stiffness, motors
    own = {name: motor for name, motor in motors.items() if name in stiffness.names}
    if not own:
        return stiffness, motors
    rest = {name: motor for name, motor in motors.items() if name not in own}
    return stiffness.motored(own), rest or None


def read_hand_friction(hand: HandModel, value: Any) -> Array:
    """(nv,) dry friction at the joints, from what is passed. Raises InputError, UnknownName."""
    return read_joint_friction(value, hand.joint_names, {f.name: f for f in hand.description.facts})


def _replaced_limits(hand: HandModel, given: Mapping[str, Any], drives: Drives | None) -> TorqueLimits:
    """Limits and motors that are passed, in place of earlier ones of the same joints."""
    joints, drives = hand.joint_names, drives if "motors" in given else hand.torques.drives
    if "torque_limits" not in given:
        return hand.torques.with_motors(drives, joints)
    limits = given["torque_limits"]
    if "motors" not in given and drives is not None and limits is not None:
        drives = drives.drop_motors(joints, tuple(limits) if isinstance(limits, Mapping) else joints)
    return read_torque_limits(limits, joints, {f.name: f for f in hand.description.facts}, drives)
