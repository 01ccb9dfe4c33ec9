"""`HandChanges`: changes of a hand by name, of arguments of `Hand.replace` and "<joint>.length" and the like."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp.actuation.tendon_stiffness import RoutedStiffness, TendonStiffness
from handlcp.check import Array, check_array, check_number
from handlcp.errors import InputError, UnknownName, Unsupported
from handlcp.hand.vary.link_stretch import LinkStretch, place_urdf_joints, stretch_model, stretch_parts, stretch_urdf
from handlcp.robot.description import COLLISION, RobotDescription
from handlcp.robot.fingertip import TipFrames, TipGeometry, TipPlacement, read_tip_radii
from handlcp.robot.hand_model import HandModel
from handlcp.robot.joint import Doubt, read_joint_facts
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.link_shape import check_units
from handlcp.robot.urdf import build_model

HAND_ARGUMENTS = ("joint_stiffness", "pad_flexibility", "torque_limits", "tip_radius", "motors", "joint_friction")
LENGTH, AXIS, POSITION = "length", "axis", "position"
STIFFNESS, LIMIT, MOTOR, RADIUS, PAD = "stiffness", "torque_limit", "motor", "radius", "pad"


class HandChanges(NamedTuple):
    """Arguments of `Hand.replace`, and by name what is changed → of which joint, fingertip, … → to what."""

    arguments: dict[str, Any]
    named: dict[str, dict[str, Any]]

    def values_of(self, what: str) -> dict[str, Any]:
        """By name; {} where nothing is changed."""
        return self.named.get(what, {})


def change_label(of: str, what: str) -> str:
    """What messages call a change."""
    return f"changes[{f'{of}.{what}'!r}]"


def read_changes(hand: HandModel, changes: Any) -> HandChanges:
    """Raises UnknownName, InputError; Unsupported for a hand whose fingertips are contacts on its links."""
    if not isinstance(changes, Mapping):
        raise InputError("changes", 'a mapping by name, such as {"joint_stiffness": 4.0}', repr(changes)[:80])
    if changes and hand.links_of_sites is not None:
        raise Unsupported("the hand of a grasp on links has its contacts as fingertips: vary the hand that made it")
    known, found = _changeable_numbers(hand), HandChanges({}, {})
    for name, value in changes.items():
        of, dot, what = name.rpartition(".") if isinstance(name, str) else ("", "", "")
        if isinstance(name, str) and name in HAND_ARGUMENTS:
            found.arguments[name] = value
        elif what in known and of in known[what]:
            found.named.setdefault(what, {})[of] = value
        else:
            raise _unknown_change(name, of, what if dot else "", known)
    if both := [joint for joint in found.values_of(LIMIT) if found.values_of(MOTOR).get(joint) is not None]:
        raise InputError(change_label(both[0], LIMIT), "no limit of a joint with a motor, which gives it", "both")
    return found


def _changeable_numbers(hand: HandModel) -> dict[str, Sequence[str]]:
    """What can be changed, of which."""
    joints, movable = hand.joint_names, hand.kinematics.movable
    tendons = hand.stiffness.names if isinstance(hand.stiffness, TendonStiffness) else ()
    links = tuple(dict.fromkeys((*hand.fingertips, *hand.description.links_with(COLLISION))))
    driven = tuple(dict.fromkeys((*joints, *tendons)))
    named = {STIFFNESS: joints, LIMIT: joints, MOTOR: driven, RADIUS: hand.fingertips, PAD: links}
    return {LENGTH: movable, AXIS: movable, POSITION: movable, **named}


def _unknown_change(name: Any, of: str, what: str, known: Mapping[str, Sequence[str]]) -> UnknownName:
    """With the names that are near: of what exists with such a number, or the numbers that it has."""
    if what in known:
        return UnknownName("changes", f"a name with a {what}", [str(name)], [f"{one}.{what}" for one in known[what]])
    if numbers := [f"{of}.{number}" for number, names in known.items() if of in names]:
        return UnknownName("changes", f"a number of {of}", [str(name)], numbers)
    expected = "an argument of Hand.replace, or a number of a joint or fingertip"
    return UnknownName("changes", expected, [str(name)], (*HAND_ARGUMENTS, *[f"<name>.{number}" for number in known]))


# ----------------------------------------------------------------
# A hand with other lengths, axes and places of joints: the robot as read is changed, what follows is made again.


_MIN_LENGTH = 1e-6  # [m] joints that are closer stand in one place
_KEPT_MESH = "its length was varied, and its mesh kept its shape: no axis of the mesh runs along the length"


def reshape_hand(hand: HandModel, radius: Any, changes: HandChanges) -> dict[str, Any]:
    """The parts that change, by attribute. radius : of the fingertips, as passed. Raises InputError, Unsupported."""
    described = _place_joints(hand.description, changes)
    before = _rebuild_tips(hand, pin.Model(described.model), {})
    stretches = _read_stretches(described.model, before, changes.values_of(LENGTH))
    if stretches:
        described = _stretch_description(described, stretches)
    check_units("changes", described.model)
    model = pin.Model(described.model)
    tips = _rebuild_tips(hand, model, stretches)
    kinematics, stiffness = Kinematics(model, described.facts), hand.stiffness
    if isinstance(stiffness, RoutedStiffness):
        own = dict[str, LinkStretch]()  # of links that become longer or shorter, in their frames as they were before
        for frame in hand.description.model.frames:
            stretch = stretches.get(int(frame.parentJoint))
            if stretch is not None and (local := stretch.in_link(frame.placement)) is not None:
                own[frame.name] = local
        stiffness = stiffness.remap_points(kinematics, lambda link, x: own[link].map_point(x) if link in own else x)
    geometry = TipGeometry(described, tips, read_tip_radii(radius, tips.names))
    return {"kinematics": kinematics, "tips": tips, "stiffness": stiffness, "_geometry": geometry}


def _place_joints(described: RobotDescription, changes: HandChanges) -> RobotDescription:
    """With joints that stand elsewhere or turn about other axes."""
    moved = changes.values_of(POSITION)
    places = {j: check_array(change_label(j, POSITION), x, (3,), what="metres") for j, x in moved.items()}
    axes = dict[str, Array]()
    for joint, value in changes.values_of(AXIS).items():
        axis = check_array(change_label(joint, AXIS), value, (3,), what="a direction")
        if (size := float(np.linalg.norm(axis))) == 0.0:
            raise InputError(change_label(joint, AXIS), "a direction, not zero", repr(value)[:80])
        axes[joint] = axis / size
    if not places and not axes:
        return described
    if described.root is None:
        if axes:
            raise Unsupported(f"changes: joints of a pinocchio.Model have their axes built in: {', '.join(axes)}")
        model = pin.Model(described.model)
        for name, x in places.items():
            frame = model.frames[model.getFrameId(name, pin.FrameType.JOINT)]
            position = model.frames[frame.parentFrame].placement.act(x)
            model.jointPlacements[model.getJointId(name)].translation = position
        return replace(described, model=model)
    root = copy.deepcopy(described.root)
    place_urdf_joints(root, places, axes)
    model = build_model("changes", root, described.source)
    return replace(described, root=root, model=model, facts=read_joint_facts(root))


def _read_stretches(model: Any, tips: TipFrames, lengths: Mapping[str, Any]) -> dict[int, LinkStretch]:
    """By the number of the joint where a length begins. Raises InputError where a joint has none, or several."""
    found = dict[int, LinkStretch]()
    for joint, value in lengths.items():
        name, k = change_label(joint, LENGTH), model.getJointId(joint)
        after, ends = check_number(name, value, above=0.0), _carried_ends(model, tips, k)
        if len(ends) != 1:
            came = f"one that carries {', '.join(ends) or 'none'}"
            raise InputError(name, "a joint that carries one joint or fingertip, up to which it has a length", came)
        ((end, place),) = ends.items()
        before = float(np.linalg.norm(place.translation))
        if before < _MIN_LENGTH:
            raise InputError(name, "a joint that stands apart from what it carries", f"{end} in the same place")
        found[k] = LinkStretch(place.translation / before, before, after)
    return found


def _carried_ends(model: Any, tips: TipFrames, joint: int) -> dict[str, Any]:
    """The joints and fingertips that a joint carries, with their placements in its frame."""
    ends = {model.names[j]: model.jointPlacements[j] for j in range(1, model.njoints) if model.parents[j] == joint}
    every = zip(tips.names, tips.places, strict=True)
    return ends | {name: place.placement for name, place in every if place.joint == joint}


def joint_length(hand: HandModel, joint: str) -> float | None:
    """[m] from a joint to the one joint or fingertip that it carries; None: it has no such length."""
    model = hand.model
    ends = _carried_ends(model, hand.tips, model.getJointId(joint))
    if len(ends) != 1:
        return None
    ((_, place),) = ends.items()
    length = float(np.linalg.norm(place.translation))
    return length if length >= _MIN_LENGTH else None


def _stretch_description(described: RobotDescription, stretches: Mapping[int, LinkStretch]) -> RobotDescription:
    if described.root is None:
        model = pin.Model(described.model)
        stretch_model(model, stretches)
        given, kept = stretch_parts(described.given_shapes, described.model, stretches)
        made = replace(described, model=model, given_shapes=given)
    else:
        root = copy.deepcopy(described.root)
        kept = stretch_urdf(root, described.model, stretches)
        made = replace(described, root=root, model=build_model("changes", root, described.source))
    doubts = tuple([Doubt(link, _KEPT_MESH, "a hand whose mesh fits", "minor", "geometry") for link in kept])
    return replace(made, doubts=(*described.doubts, *[doubt for doubt in doubts if doubt not in described.doubts]))


def _rebuild_tips(hand: HandModel, model: Any, stretches: Mapping[int, LinkStretch]) -> TipFrames:
    """The same fingertips in the model of the changed robot, to which points on links are added as frames."""
    places, frames = list[TipPlacement](), list[int]()
    for name, frame, place in zip(hand.tips.names, hand.tips.frames, hand.tips.places, strict=True):
        if frame == place.link:
            at = model.frames[frame].placement
        else:
            stretch = stretches.get(place.joint)
            was = place.placement
            at = was if stretch is None else pin.SE3(was.rotation, stretch.map_point(was.translation))
            frame = int(model.addFrame(pin.Frame(name, place.joint, place.link, at, pin.FrameType.OP_FRAME)))
        frames.append(frame)
        places.append(TipPlacement(place.link, place.joint, pin.SE3(at)))
    return TipFrames(hand.tips.names, tuple(frames), tuple(places), hand.tips.support)
