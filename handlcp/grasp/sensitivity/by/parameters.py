"""Everything that an answer can be differentiated by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handlcp.errors import Unsupported
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.by.contacts import by_normals, by_positions
from handlcp.grasp.sensitivity.by.places import by_lengths, by_moved_normals, by_moved_positions, by_posture
from handlcp.grasp.sensitivity.change import Change, no_change

# ----------------------------------------------------------------
# What loads, squeezes, springs, pads, friction and torque limits change in the laws of a grasp, in closed form.
#
# load            δb = δw                       squeeze     δv_N = -δs
# joint offset    δv = J (C K_g - 1) δq         stiffness   δv = -J C δK C τ = -J C e_j δ_j
# pads            δv = S r                      friction    δμ
#
# C = (K + K_g)⁻¹, δ_j how far joint j gives way, K_g the geometric stiffness where it is asked for, else 0.


def by_wrench(answer: Answer) -> Change:
    """Of the (6,) load about the reference [1/N, 1/(N·m)]."""
    change = no_change(answer, 6)
    change.balance[:] = np.eye(6)
    return change


def by_squeeze(answer: Answer) -> Change:
    """Of the squeeze of each normal, (n,): how far the fingertips are commanded into the object [1/m]."""
    n = answer.scene.n
    change = no_change(answer, n)
    change.motion[2 : 3 * n : 3] = -np.eye(n)
    return change


def by_joint_offset(answer: Answer) -> Change:
    """Of δq (nv,), how far the joints are commanded beyond the posture [1/rad]."""
    J = answer.rows
    nv = J.shape[1]
    change, follows = no_change(answer, nv), np.eye(nv)
    if answer.bent is not None:
        follows = follows - answer.compliance @ answer.bent
        change.torque[:] = answer.bent @ follows
    change.motion[:] = -answer.scale[:, None] * (J @ follows)
    return _in_plane(answer, change)


def by_stiffness(answer: Answer) -> Change:
    """Of a spring more at each joint (nv,) that pulls it to where it is commanded [rad/(N·m)].

    Raises Unsupported where the flexibility was given and is not that of the joints.
    """
    if not answer.elastic_joints:
        raise Unsupported("a grasp whose flexibility was given has no derivative by the stiffness of joints")
    J, give = answer.rows, answer.compliance * answer.joints.deflection
    change = no_change(answer, J.shape[1])
    change.motion[:] = -answer.scale[:, None] * (J @ give)
    if answer.bent is not None:
        change.torque[:] = answer.bent @ give
    return _in_plane(answer, change)


def by_pads(answer: Answer) -> Change:
    """Of flexibility more at each contact (n,), the same along all three axes [N/m]."""
    n = answer.scene.n
    change = no_change(answer, n)
    each = np.arange(3 * n)
    change.motion[each, each // 3] = answer.scale[: 3 * n] * answer.forces.reshape(-1)
    return _in_plane(answer, change)


def by_friction(answer: Answer) -> Change:
    """Of the coefficient of each contact (n,), the whole law growing with it; NaN for contacts without friction."""
    scene, change = answer.scene, no_change(answer, answer.scene.n)
    change.friction[np.arange(scene.n), np.arange(scene.n)] = answer.friction_shares
    return change


def by_torque_limits(answer: Answer) -> Change:
    """Of the joints' torque limits (nv,) [1/(N·m)]: only those of joints that yield move anything."""
    nv = answer.rows.shape[1]
    change = no_change(answer, nv)
    change.torque_limits[:] = np.eye(nv)
    return change


def _in_plane(answer: Answer, change: Change) -> Change:
    """In a planar scene nothing moves across the plane."""
    if answer.spec.planar:
        change.motion[1 : 3 * answer.scene.n : 3] = 0.0
    return change


# ----------------------------------------------------------------


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
