"""A hand with other lengths, axes and places of joints: the robot as read is changed, what follows is made again."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, number
from handlcp.errors import InputError, Unsupported
from handlcp.hand.elasticity.tendon_stiffness import RoutedStiffness
from handlcp.hand.robot.fingertips import TipFrames, TipPlace
from handlcp.hand.robot.joints import Doubt, joint_facts
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.source.description import Description
from handlcp.hand.robot.source.units import check_units
from handlcp.hand.robot.tip_geometry import TipGeometry, read_radii
from handlcp.hand.robot.urdf import build_model
from handlcp.hand.vary import in_model, in_xml
from handlcp.hand.vary.names import AXIS, LENGTH, POSITION, Changes, argument
from handlcp.hand.vary.stretch import Stretch

_APART = 1e-6  # [m] joints that are closer stand in one place
_KEPT = "its length was varied, and its mesh kept its shape: no axis of the mesh runs along the length"


def reshaped(hand: HandModel, radius: Any, changes: Changes) -> dict[str, Any]:
    """The parts that change, by attribute. radius : of the fingertips, as passed. Raises InputError, Unsupported."""
    described = _placed(hand.description, changes)
    stretches = _stretches(described.model, _tips(hand, pin.Model(described.model), {}), changes.of(LENGTH))
    if stretches:
        described = _stretched(described, stretches)
    check_units("changes", described.model)
    model = pin.Model(described.model)
    tips = _tips(hand, model, stretches)
    kinematics, stiffness = Kinematics(model, described.facts), hand.stiffness
    if isinstance(stiffness, RoutedStiffness):
        own = _in_links(hand.description.model, stretches)
        stiffness = stiffness.laid_on(kinematics, lambda link, x: own[link].point(x) if link in own else x)
    geometry = TipGeometry(described, tips, read_radii(radius, tips.names))
    return {"kinematics": kinematics, "tips": tips, "stiffness": stiffness, "_geometry": geometry}


def _placed(described: Description, changes: Changes) -> Description:
    """With joints that stand elsewhere or turn about other axes."""
    places = {j: array(argument(j, POSITION), x, (3,), what="metres") for j, x in changes.of(POSITION).items()}
    axes = {joint: _axis(argument(joint, AXIS), x) for joint, x in changes.of(AXIS).items()}
    if not places and not axes:
        return described
    if described.root is None:
        if axes:
            raise Unsupported(f"changes: joints of a pinocchio.Model have their axes built in: {', '.join(axes)}")
        model = pin.Model(described.model)
        for joint, x in places.items():
            in_model.put_joint(model, joint, x)
        return replace(described, model=model)
    root = copy.deepcopy(described.root)
    for joint, x in places.items():
        in_xml.put_joint(root, joint, x)
    for joint, x in axes.items():
        in_xml.turn_joint(root, joint, x)
    return replace(described, root=root, model=build_model("changes", root, described.source), facts=joint_facts(root))


def _axis(name: str, value: Any) -> Array:
    axis = array(name, value, (3,), what="a direction")
    size = float(np.linalg.norm(axis))
    if size == 0.0:
        raise InputError(name, "a direction, not zero", repr(value)[:80])
    return axis / size


def _stretches(model: Any, tips: TipFrames, lengths: Mapping[str, Any]) -> dict[int, Stretch]:
    """By the number of the joint where a length begins. Raises InputError where a joint has none, or several."""
    found = dict[int, Stretch]()
    for joint, value in lengths.items():
        name, k = argument(joint, LENGTH), model.getJointId(joint)
        after, ends = number(name, value, above=0.0), _ends(model, tips, k)
        if len(ends) != 1:
            came = f"one that carries {', '.join(ends) or 'none'}"
            raise InputError(name, "a joint that carries one joint or fingertip, up to which it has a length", came)
        ((end, place),) = ends.items()
        before = float(np.linalg.norm(place.translation))
        if before < _APART:
            raise InputError(name, "a joint that stands apart from what it carries", f"{end} in the same place")
        found[k] = Stretch(place.translation / before, before, after)
    return found


def _ends(model: Any, tips: TipFrames, joint: int) -> dict[str, Any]:
    """The joints and fingertips that a joint carries, with their placements in its frame."""
    ends = {model.names[j]: model.jointPlacements[j] for j in range(1, model.njoints) if model.parents[j] == joint}
    every = zip(tips.names, tips.places, strict=True)
    return ends | {name: place.placement for name, place in every if place.joint == joint}


def length_of(hand: HandModel, joint: str) -> float | None:
    """[m] from a joint to the one joint or fingertip that it carries; None: it has no such length."""
    model = hand.model
    ends = _ends(model, hand.tips, model.getJointId(joint))
    if len(ends) != 1:
        return None
    ((_, place),) = ends.items()
    length = float(np.linalg.norm(place.translation))
    return length if length >= _APART else None


def _stretched(described: Description, stretches: Mapping[int, Stretch]) -> Description:
    if described.root is None:
        model = pin.Model(described.model)
        in_model.stretch_model(model, stretches)
        given, kept = in_model.stretch_parts(described.given, described.model, stretches)
        made = replace(described, model=model, given=given)
    else:
        root = copy.deepcopy(described.root)
        kept = in_xml.stretch_links(root, described.model, stretches)
        made = replace(described, root=root, model=build_model("changes", root, described.source))
    doubts = tuple([Doubt(link, _KEPT, "a hand whose mesh fits", "minor", "geometry") for link in kept])
    return replace(made, doubts=(*described.doubts, *[doubt for doubt in doubts if doubt not in described.doubts]))


def _in_links(model: Any, stretches: Mapping[int, Stretch]) -> dict[str, Stretch]:
    """In the frames of the links that become longer or shorter, by name; model : as it was before."""
    found = dict[str, Stretch]()
    for frame in model.frames:
        stretch = stretches.get(int(frame.parentJoint))
        if stretch is not None and (local := stretch.in_link(frame.placement)) is not None:
            found[frame.name] = local
    return found


def _tips(hand: HandModel, model: Any, stretches: Mapping[int, Stretch]) -> TipFrames:
    """The same fingertips in the model of the changed robot, to which points on links are added as frames."""
    places, frames = list[TipPlace](), list[int]()
    every = zip(hand.tips.names, hand.tips.frames, hand.tips.places, strict=True)
    for name, frame, place in every:
        if frame == place.link:
            at = model.frames[frame].placement
        else:
            stretch = stretches.get(place.joint)
            was = place.placement
            at = was if stretch is None else pin.SE3(was.rotation, stretch.point(was.translation))
            frame = int(model.addFrame(pin.Frame(name, place.joint, place.link, at, pin.FrameType.OP_FRAME)))
        frames.append(frame)
        places.append(TipPlace(place.link, place.joint, pin.SE3(at)))
    return TipFrames(hand.tips.names, tuple(frames), tuple(places), hand.tips.support)
