"""A grasp with links that begins where the hand is still open: where it comes to touch, and what commands it there.

The hand closes from the palm outwards until its links touch (`hand/sites/wrap.py`). The grasp is that of the posture
where they do, and its command goes on from there. A loading that is followed begins in the open posture instead, and
finds its own way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, array, dimensions, number, per_name, read_only
from handlcp.errors import InputError, NotReached
from handlcp.grasp.effects.joint_offset import JointOffset, command_of
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.command import read_joint_offset
from handlcp.hand.elasticity.motor import Motor
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture
from handlcp.hand.sites.sited import gaps_of, nearest_links
from handlcp.hand.sites.touchers import ALL, touchers
from handlcp.hand.sites.wrap import bending, wrap
from handlcp.tolerances import OVER

_TOUCHES = 1e-5  # [m] from a link to the object it touches, where a hand has closed
_ROUNDING = 1e-9  # of the largest tension: less is none
_MOVED = 1e-9  # [rad, m] a hand that closes by less is closed already


@dataclass(frozen=True, eq=False)
class Closed:
    """q (nv,) where links touch. opened (nv,) : where the hand began; None: there. command, against (nv,) : on from q,
    as of a `JointOffset`. torque (nv,) : with which motors pull [N·m]; None: joints were commanded. wound : whether the
    command is as far as motors turn on; or else it is K⁻¹ τ, as if nothing gave way. stuck : whether steps of turning
    on ended without an answer, so that more may be possible.
    """

    q: Array
    opened: Array | None
    command: Array
    against: Array | None = None
    torque: Array | None = None
    wound: bool = True
    stuck: bool = False

    @classmethod
    def by(cls, q: Array, command: JointOffset) -> Closed:
        """By a command of a grasp at q (nv,)."""
        return cls(q, command.opened, command.command, command.against)


def closed_by(state: Posture, obj: Object, joint_offset: Any, closing_torque: Any) -> Closed:
    """The hand closed from a posture, by a joint offset or by torques of its joints. Raises NotReached, InputError."""
    hand, q = state.hand, state.q
    if closing_torque is not None:
        way = bending(hand, q, obj)
        torque = closing_torques(hand, way, closing_torque)
        rates, until, offset = np.sign(torque) * abs(way), np.inf, None
    else:
        torque, offset = np.zeros(hand.nv), read_joint_offset(joint_offset, hand.joint_names)
        rates, until = offset, 1.0
    if not rates.any():
        return pulling(hand, q, None, torque) if offset is None else Closed(q, None, offset)
    found = wrap(hand, obj, q, rates, until, "target")
    opened = q if abs(found.q - q).max() > _MOVED else None
    if offset is not None:
        return Closed(found.q, opened, read_only(q + offset - found.q))
    return pulling(hand, found.q, opened, np.where(carries(state, found.q, obj), torque, 0.0))


def closing_torques(hand: HandModel, way: Array, value: Any) -> Array:
    """(nv,) [N·m] at the joints, with the sign in which each joint turns: a number or (nv,) of the joints that bend,
    positive towards the object; or a mapping by joint name (others: 0), where that of a joint that does not bend keeps
    its sign. The dry friction of a tendon's motor takes its part of the tension. Raises InputError, also where a motor
    has no such peak, or does not overcome that friction; UnknownName. way (nv,) : how the joints bend towards the
    object, as `bending` has it.
    """
    torque = _pulls(hand, way, value)
    _check_drives(hand, torque)
    return _through_tendons(hand, torque)


def _check_drives(hand: HandModel, torque: Array) -> None:
    """That motors pull with torques (nv,) at their joints, and overcome their dry friction. Raises InputError."""
    drives = hand.torques.drives
    if drives is None:
        return
    for joint, motor, pull in zip(hand.joint_names, drives.of, abs(torque).tolist(), strict=True):
        if motor is not None and pull > 0.0 and not motor.friction < pull <= motor.at_peak * (1.0 + OVER):
            unit = words.effort_unit(joint in hand.sliding)
            expected = f"{_overcomes(motor)}at most the peak of its motor, {motor.at_peak:g} {unit} at the joint"
            raise InputError(f"closing_torque[{joint!r}]", expected, f"{pull:g}")


def _through_tendons(hand: HandModel, torque: Array) -> Array:
    """(nv,) what is left at the joints of torques (nv,) that tendons make: Rᵀ (t - T₀) with t less the dry friction of
    the motor, for tendons that are drawn in.
    """
    if not isinstance(hand.stiffness, TendonStiffness) or hand.stiffness.drives is None:
        return torque
    cables, drives = hand.stiffness.cables, hand.stiffness.drives
    tension = cables.tensions(torque)
    more = np.where(np.isinf(cables.pretension), tension, np.maximum(tension - cables.begun, 0.0))
    more[abs(more) <= _ROUNDING * abs(more).max()] = 0.0
    every = zip(cables.names, drives.of, abs(more).tolist(), abs(tension).tolist(), strict=True)
    for name, motor, drawn, pull in every:
        if motor is not None and drawn > 0.0 and not (motor.friction < drawn and pull <= motor.at_peak * (1.0 + OVER)):
            expected = f"{_overcomes(motor)}at most the peak of its motor, {motor.at_peak:g} N in the tendon {name!r}"
            raise InputError("closing_torque", expected, f"{pull:g} N")
    return np.asarray(torque - cables.arms.T @ (np.sign(more) * np.minimum(abs(more), drives.friction)))


def _overcomes(motor: Motor) -> str:
    return f"more than the dry friction of its drive, {motor.friction:g}, and " if motor.friction else ""


def _pulls(hand: HandModel, way: Array, value: Any) -> Array:
    torque = read_closing_torque(value, hand.joint_names)
    signed = np.sign(way) * torque
    return np.where(way != 0.0, signed, torque) if isinstance(value, Mapping) else signed


def read_closing_torque(value: Any, joints: Sequence[str]) -> Array:
    """(nv,) [N·m] from a number ≥ 0, (nv,), or a mapping by joint name (others: 0). Raises InputError, UnknownName."""
    if isinstance(value, Mapping):
        named = per_name("closing_torque", value, joints, "a joint")
        given = {joint: number(f"closing_torque[{joint!r}]", v) for joint, v in named.items()}
        return np.array([given.get(joint, 0.0) for joint in joints])
    if dimensions(value) == 0:
        return np.full(len(joints), number("closing_torque", value, minimum=0.0))
    return array("closing_torque", value, (len(joints),))


def carries(state: Posture, q: Array, obj: Object) -> Bools:
    """(nv,) whether a joint carries a link that touches where the joints are at q."""
    hand = state.hand
    gaps = gaps_of(Posture(hand, q), touchers(hand, ALL), obj)
    there = [link.support[0] for link, gap in gaps if gap <= _TOUCHES]
    found = np.asarray(hand.kinematics.moved_by(np.array(there)).any(axis=0) if there else np.zeros(hand.nv, bool))
    if not found.any():
        expected = "a hand whose joints bring a link to the object"
        raise NotReached("closing_torque", expected, nearest_links(gaps))
    return found


def pulling(hand: HandModel, q: Array, opened: Array | None, torque: Array) -> Closed:
    """Commanded by K⁻¹ τ, as far as motors turn where neither links nor the object give way. Raises InputError."""
    command, against = (hand.stiffness.deflection(t) for t in _shared(torque, hand.dry_friction))
    if (rigid := (torque != 0.0) & (command + against == 0.0)).any():
        stuck = ", ".join(name for name, is_rigid in zip(hand.joint_names, rigid, strict=True) if is_rigid)
        raise InputError("closing_torque", "joints that give way, which a torque turns", f"{stuck}: rigid")
    return Closed(q, opened, read_only(command), read_only(against), read_only(torque), False)


def _shared(torque: Array, friction: Array) -> tuple[Array, Array]:
    """What is left of torques (nv,) at the joints, and what friction (nv,) takes as they close [N·m]."""
    takes = np.sign(torque) * np.minimum(abs(torque), friction)
    return torque - takes, takes


def begun_open(spec: GraspSpec, closed: Closed | None, keeps: bool) -> GraspSpec:
    """The grasp that begins to close elsewhere, with the object kept in place or not. Raises InputError."""
    opened, against = (None, None) if closed is None else (closed.opened, closed.against)
    if opened is None and not keeps and (against is None or not against.any()):
        return spec
    old = command_of(spec.effects)
    if old is None and keeps:
        expected = "False where nothing closes the hand: beside squeeze, grip_force, joint_offset or closing_torque"
        raise InputError("hold_object", f"{expected} that is not 0", "True" if closed is None else "True, with 0")
    command = JointOffset(read_only(np.zeros_like(opened if against is None else against))) if old is None else old
    new = replace(command, opened=opened, keeps=keeps, against=against)
    others = tuple([e for e in spec.effects if not isinstance(e, JointOffset)])
    return spec.replace(effects=(*others, new))
