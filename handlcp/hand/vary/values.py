"""The numbers of a hand by the names with which `Hand.vary` changes them."""

from __future__ import annotations

import numpy as np

from handlcp.errors import UnknownName
from handlcp.hand.elasticity.stiffness import JointStiffness
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.source.description import COLLISION
from handlcp.hand.vary.names import LENGTH, LIMIT, PAD, RADIUS, STIFFNESS
from handlcp.hand.vary.shape import length_of

# What a whole argument of `Hand.replace` is the common number of
COMMON = {"joint_stiffness": STIFFNESS, "pad_flexibility": PAD, "torque_limits": LIMIT, "tip_radius": RADIUS}
UNITS = {LENGTH: "m", STIFFNESS: "N·m/rad", LIMIT: "N·m", RADIUS: "m", PAD: "m/N"}


def numbers_of(hand: HandModel) -> dict[str, float]:
    """Lengths [m], springs [N·m/rad] and torque limits [N·m] of joints, radii [m] and pads [m/N] of fingertips, by
    name; those alone that are one number: not of springs that joints share, pads that differ by direction, …
    """
    joints, found = hand.joint_names, dict[str, float]()
    for joint in hand.kinematics.movable:
        if (length := length_of(hand, joint)) is not None:
            found[f"{joint}.{LENGTH}"] = length
    if isinstance(hand.stiffness, JointStiffness) and np.count_nonzero(hand.stiffness.matrix) == len(joints):
        springs = np.diagonal(hand.stiffness.matrix).tolist()
        found |= {f"{joint}.{STIFFNESS}": spring for joint, spring in zip(joints, springs, strict=True)}
    for joint, limit in zip(joints, hand.torques.limits.tolist(), strict=True):
        if np.isfinite(limit):
            found[f"{joint}.{LIMIT}"] = limit
    for k, tip in enumerate(hand.fingertips):
        shapes = hand.tip_shapes(k) if hand.tip_kind(k) in ("radius", COLLISION) else ()
        if len(shapes) == 1 and shapes[0].central and shapes[0].radius is not None:
            found[f"{tip}.{RADIUS}"] = shapes[0].radius
        pad = hand.pads.blocks[k]
        if (pad == pad[0, 0] * np.eye(3)).all():
            found[f"{tip}.{PAD}"] = float(pad[0, 0])
    return found


def number_of(hand: HandModel, name: str) -> float:
    """One of these, or a whole argument such as "joint_stiffness" that is alike everywhere. Raises UnknownName."""
    numbers = numbers_of(hand)
    if name in numbers:
        return numbers[name]
    ending = f".{COMMON.get(name, '?')}"
    if len(alike := {value for other, value in numbers.items() if other.endswith(ending)}) == 1:
        return alike.pop()
    raise UnknownName("changes", "a number of the hand", [str(name)], [*numbers, *COMMON])


def unit_of(name: str) -> str:
    """Of a number by this name."""
    return UNITS[COMMON.get(name, name.rpartition(".")[2])]
