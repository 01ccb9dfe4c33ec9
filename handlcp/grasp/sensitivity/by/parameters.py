"""Everything that an answer can be differentiated by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.by.contacts import by_normals, by_positions
from handlcp.grasp.sensitivity.by.loads import (
    by_friction,
    by_joint_offset,
    by_pads,
    by_squeeze,
    by_stiffness,
    by_torque_limits,
    by_wrench,
)  # fmt: skip
from handlcp.grasp.sensitivity.by.places import by_lengths, by_moved_normals, by_moved_positions, by_posture
from handlcp.grasp.sensitivity.change import Change


@dataclass(frozen=True, slots=True)
class Parameter:
    """unit : of the parameter. shape : of its entries, from an answer. change : what they change, in that order.
    joints : whether only a hand has it. words : what one entry is.
    """

    unit: str
    shape: Callable[[Answer], tuple[int, ...]]
    change: Callable[[Answer], Change]
    joints: bool
    words: str


def _contacts(a: Answer) -> tuple[int, ...]:
    return (a.scene.n,)


def _vectors(a: Answer) -> tuple[int, ...]:
    return (a.scene.n, 3)


def _joints(a: Answer) -> tuple[int, ...]:
    return (a.rows.shape[1],)


def _lengths(a: Answer) -> tuple[int, ...]:
    return (0 if a.spec.mechanism is None else len(a.spec.mechanism.lengths), 3)


def _positions(a: Answer) -> Change:
    return by_positions(a) if a.bent is None else by_moved_positions(a)


def _normals(a: Answer) -> Change:
    return by_normals(a) if a.bent is None else by_moved_normals(a)


PARAMETERS = {
    "wrench": Parameter("N, N·m", lambda a: (6,), by_wrench, False, "the load about the reference"),
    "squeeze": Parameter("m", _contacts, by_squeeze, False, "how far a contact is squeezed along its normal"),
    "joint_offset": Parameter("rad", _joints, by_joint_offset, True, "how far a joint is commanded beyond the posture"),
    "stiffness": Parameter("N·m/rad", _joints, by_stiffness, True, "the spring of a joint"),
    "pads": Parameter("m/N", _contacts, by_pads, False, "the flexibility of a contact along all three axes"),
    "friction": Parameter("-", _contacts, by_friction, False, "the coefficient of a contact"),
    "torque_limits": Parameter("N·m", _joints, by_torque_limits, True, "the torque limit of a joint"),
    "positions": Parameter("m", _vectors, _positions, False, "the point of a contact, world axes"),
    "normals": Parameter("rad", _vectors, _normals, False, "a turn of a contact's axes about themselves"),
    "posture": Parameter("rad", _joints, by_posture, True, "the position of a joint"),
    "lengths": Parameter("m", _lengths, by_lengths, True, "the end of a link in its joint's frame"),
}
