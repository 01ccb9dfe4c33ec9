"""`close_by_torque`: where a hand that closes from open comes to touch, and what commands it there.

The hand closes from the palm outwards until its links touch (`hand/closing.py`). The grasp is that of the posture
where they do, and its command goes on from there. A loading that is followed begins in the open posture instead, and
finds its own way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp import words
from handlcp.actuation.motor import Motor
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array, Bools, NumbersByName, read_only
from handlcp.contact.friction import Section, as_section
from handlcp.errors import InputError, NotReached, Unsupported
from handlcp.geometry.link_contacts import ALL_LINKS, body_gaps, contact_bodies, nearest_links
from handlcp.geometry.object import Object
from handlcp.grasp.effects.joint_offset import JointOffset, find_command
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.advance import Leg, Open
from handlcp.grasp.path.follow import TOLERANCE, begun, geometry_of
from handlcp.grasp.path.state import Goal, Run, State
from handlcp.grasp.path.watch import watch_of
from handlcp.hand.closing import bending_rates, wrap_hand
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.squeeze import read_joint_offset
from handlcp.hand.torque_check import MotorPull
from handlcp.progress import track_progress
from handlcp.robot.hand_model import HandModel, HandPosture
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

_TOUCH_DISTANCE = 1e-5  # [m] from a link to the object it touches, where a hand has closed
_TENSION_ROUNDING = 1e-9  # of the largest tension: less is none
_MIN_CLOSING_MOTION = 1e-9  # [rad, m] a hand that closes by less is closed already


@dataclass(frozen=True, eq=False)
class ClosedPosture:
    """q (nv,) where links touch. opened (nv,) : where the hand began; None: there. command, against (nv,) : on from q,
    as of a `JointOffset`. torque (nv,) : with which motors pull [N·m]; None: joints were commanded. is_command_final :
    whether the command is as far as motors turn on; or else it is K⁻¹ τ, as if nothing gave way. stuck : whether steps
    of turning on ended without an answer, so that more may be possible.
    """

    q: Array
    opened: Array | None
    command: Array
    against: Array | None = None
    torque: Array | None = None
    is_command_final: bool = True
    stuck: bool = False


def close_by_torque(state: HandPosture, obj: Object, joint_offset: Any, closing_torque: Any) -> ClosedPosture:
    """The hand closed from a posture, by a joint offset or by torques of its joints. Raises NotReached, InputError."""
    hand, q = state.hand, state.q
    if closing_torque is not None:
        way = bending_rates(hand, q, obj)
        torque = read_closing_torques(hand, way, closing_torque)
        rates, until, offset = np.sign(torque) * abs(way), np.inf, None
    else:
        torque, offset = np.zeros(hand.nv), read_joint_offset(joint_offset, hand.joint_names)
        rates, until = offset, 1.0
    if not rates.any():
        return command_closing_torque(hand, q, None, torque) if offset is None else ClosedPosture(q, None, offset)
    end = wrap_hand(hand, obj, q, rates, until, "target")
    opened = q if abs(end - q).max() > _MIN_CLOSING_MOTION else None
    if offset is not None:
        return ClosedPosture(end, opened, read_only(q + offset - end))
    carrying = _find_carrying_joints(hand, end, obj)
    return command_closing_torque(hand, end, opened, np.where(carrying, torque, 0.0))


def read_closing_torques(hand: HandModel, way: Array, value: Any) -> Array:
    """(nv,) [N·m] at the joints, with the sign in which each joint turns: a number or (nv,) of the joints that bend,
    positive towards the object; or a mapping by joint name (others: 0), where that of a joint that does not bend keeps
    its sign. The dry friction of a tendon's motor takes its part of the tension: Rᵀ (t - T₀) with t less that friction
    is left, for tendons that are drawn in. Raises InputError, also where a motor has no such peak, or does not overcome
    that friction; UnknownName. way (nv,) : how the joints bend towards the object, as `bending_rates` has it.
    """
    torque = read_torque_by_joint(value, hand.joint_names)
    signed = np.sign(way) * torque
    torque = np.where(way != 0.0, signed, torque) if isinstance(value, Mapping) else signed
    if (drives := hand.torques.drives) is not None:
        for joint, motor, pull in zip(hand.joint_names, drives.motors, abs(torque).tolist(), strict=True):
            where = f"{words.effort_unit(joint in hand.sliding)} at the joint"
            _check_pull(f"closing_torque[{joint!r}]", motor, pull, pull, where, f"{pull:g}")
    if not isinstance(hand.stiffness, TendonStiffness) or (drives := hand.stiffness.drives) is None:
        return torque
    cables = hand.stiffness.cables
    tension = cables.tensions(torque)
    more = np.where(np.isinf(cables.pretension), tension, np.maximum(tension - cables.initial_tension, 0.0))
    more[abs(more) <= _TENSION_ROUNDING * abs(more).max()] = 0.0
    every = zip(cables.names, drives.motors, abs(more).tolist(), abs(tension).tolist(), strict=True)
    for name, motor, drawn, pull in every:
        _check_pull("closing_torque", motor, drawn, pull, f"N in the tendon {name!r}", f"{pull:g} N")
    return np.asarray(torque - cables.arms.T @ (np.sign(more) * np.minimum(abs(more), drives.friction)))


def _check_pull(argument: str, motor: Motor | None, drawn: float, pull: float, where: str, got: str) -> None:
    """Raises InputError for a motor that is to pull beyond its peak, or draws in with no more than its dry friction."""
    if motor is None or drawn == 0.0:
        return
    if drawn <= motor.friction or pull > motor.at_peak * (1.0 + OVER_LIMIT_TOLERANCE):
        rubs = f"more than the dry friction of its drive, {motor.friction:g}, and " if motor.friction else ""
        raise InputError(argument, f"{rubs}at most the peak of its motor, {motor.at_peak:g} {where}", got)


CLOSING_TORQUES = NumbersByName("joint", minimum=0.0, only_common_bounded=True)


def read_torque_by_joint(value: Any, joints: Sequence[str] | None = None) -> Array:
    """(nv,) [N·m] from a number ≥ 0, (nv,), or a mapping by joint name (others: 0). Raises InputError, UnknownName."""
    return CLOSING_TORQUES.read("closing_torque", value, joints)


def _find_carrying_joints(hand: HandModel, q: Array, obj: Object) -> Bools:
    """(nv,) whether a joint carries a link that touches where the joints are at q."""
    gaps = body_gaps(HandPosture(hand, q), contact_bodies(hand, ALL_LINKS), obj)
    there = [link.support[0] for link, gap in gaps if gap <= _TOUCH_DISTANCE]
    if there and (found := hand.kinematics.find_moving_joints(np.array(there)).any(axis=0)).any():
        return np.asarray(found)
    raise NotReached("closing_torque", "a hand whose joints bring a link to the object", nearest_links(gaps))


def command_closing_torque(hand: HandModel, q: Array, opened: Array | None, torque: Array) -> ClosedPosture:
    """Commanded by K⁻¹ τ, as far as motors turn where neither links nor the object give way. Raises InputError."""
    rubs = np.sign(torque) * np.minimum(abs(torque), hand.dry_friction)  # what friction takes as they close
    command, against = hand.stiffness.deflection(torque - rubs), hand.stiffness.deflection(rubs)
    if (rigid := (torque != 0.0) & (command + against == 0.0)).any():
        stuck = ", ".join(name for name, is_rigid in zip(hand.joint_names, rigid, strict=True) if is_rigid)
        raise InputError("closing_torque", "joints that give way, which a torque turns", f"{stuck}: rigid")
    return ClosedPosture(q, opened, read_only(command), read_only(against), read_only(torque), False)


def start_open(spec: GraspSpec, closed: ClosedPosture | None, keeps: bool) -> GraspSpec:
    """The grasp that begins to close elsewhere, with the object kept in place or not. Raises InputError."""
    opened, against = (None, None) if closed is None else (closed.opened, closed.against)
    if opened is None and not keeps and (against is None or not against.any()):
        return spec
    old = find_command(spec.effects)
    if old is None and keeps:
        expected = "False where nothing closes the hand: beside squeeze, grip_force, joint_offset or closing_torque"
        raise InputError("hold_object", f"{expected} that is not 0", "True" if closed is None else "True, with 0")
    command = JointOffset(read_only(np.zeros_like(opened if against is None else against))) if old is None else old
    new = replace(command, opened=opened, keeps=keeps, friction_offset=against)
    others = tuple([e for e in spec.effects if not isinstance(e, JointOffset)])
    return spec.replace(effects=(*others, new))


# ----------------------------------------------------------------
# How far motors turn on once the hand touches, until they pull with the torque that was asked for.
#
# A motor that has turned on by δq pulls with K (δq - Δq) where its joint has turned on by Δq meanwhile: K⁻¹ τ alone is
# right only where nothing gives way. So the closing is followed: the motors of each finger turn on together, in
# proportion to K⁻¹ τ, until the first of them pulls with its torque; then that finger holds. What its other joints pull
# with is for the contacts to say: a fingertip's force needs torques in one proportion.


_COMMAND_STEP = 1.0 / 20.0  # of K⁻¹ τ
_MAX_COMMAND_FACTOR = 100.0  # times K⁻¹ τ: joints that turn as far and do not pull meet nothing
_TORQUE_TOLERANCE = 1e-3  # of the torque: as near to it is there
_MAX_OTHER_TORQUE_SHARE = 1.1  # times its torque: no finger turns on that drives a joint of another beyond this


@track_progress("closing the hand")
def follow_torque_closing(spec: GraspSpec, torque: Array) -> tuple[GraspSpec, bool]:
    """The grasp, commanded by K⁻¹ τ beyond where the hand touches, with motors that have turned on until they pull with
    torque (nv,) [N·m]; and whether steps of it ended without an answer before. A finger that pulls no harder for
    turning on stays at K⁻¹ τ; so do all where no loading can be followed.
    """
    mechanism = spec.mechanism
    if not torque.any():
        return spec, False
    assert isinstance(mechanism, HandMechanism)  # which pulls
    hand = mechanism.posture.hand
    pulling = MotorPull.from_torque(torque, hand.moving_joints[list(mechanism.tips)], hand.stiffness)
    try:
        closing = _TorqueClosing(spec, as_section("cone", planar=spec.plane is not None), pulling)
    except Unsupported:
        return spec, False
    driven, rubs = closing.find_end_command()
    against = hand.stiffness.deflection(rubs)
    command = find_command(spec.effects)
    assert command is not None  # `spec` begins with it
    new = replace(command, command=read_only(driven - against), friction_offset=read_only(against))
    return spec.replace(effects=tuple([new if e is command else e for e in spec.effects])), closing.stuck


class _TorqueClosing:
    """A closing that is followed."""

    def __init__(self, spec: GraspSpec, section: Section, pulling: MotorPull) -> None:
        body = geometry_of(spec, None)
        first, goals, self.stepper = begun(spec, section, body, TOLERANCE, "squeeze", None)
        self.watch, self.pulling = watch_of(spec, body, np.full(spec.n, np.inf)), pulling
        self.end = goals[0].end
        self.run = Run.beginning_at(self.stepper.beginning(first))
        self.stuck = False

    def find_end_command(self) -> tuple[Array, Array]:
        """How far motors turn beyond the posture (nv,) [rad, m], and friction at the joints then (nv,) [N·m]."""
        rate, run, fingers = self.end.command, self.run, self.pulling.fingers
        if run.states[0].controls.command.any():  # the hand closes until it touches
            goal = Goal("squeeze", self.end._replace(command=np.zeros_like(rate)))
            if not Leg(self.stepper, self.watch, run, 0, goal, _COMMAND_STEP).through():
                return rate, run.states[-1].rubs
        found, turning = rate.copy(), set(self.pulling.finger_numbers)
        while turning:
            on, before = np.isin(fingers, list(turning)), run.states[-1]
            self._turn_motors(on)
            last, shares = run.states[-1], self._torque_shares(run.states[-1])
            self.stuck |= run.status.is_given_up
            there = set(fingers[on & (shares > 1.0 - _TORQUE_TOLERANCE)].tolist())
            done = there or turning  # a finger whose turning on drives another one too far; or nothing more to be had
            for finger in done:
                its = fingers == finger
                if run.status == PathStatus.LIMIT or shares[its].max() > self._torque_shares(before)[its].max():
                    found[its] = last.controls.command[its]
            if run.status.is_lost:  # the closing itself loses the object
                found[on] = last.controls.command[on] + rate[on]
            turning = turning - done
        return found, run.states[-1].rubs

    def _turn_motors(self, on: Bools) -> None:
        """These joints (nv,), until one of them pulls with its torque, or others are driven too far."""
        now = self.run.states[-1].controls.command
        goal = Goal("squeeze", self.end._replace(command=now + np.where(on, self.end.command, 0.0)))
        most = np.where(on, 1.0, _MAX_OTHER_TORQUE_SHARE)
        beyond = Open(
            _COMMAND_STEP, _MAX_COMMAND_FACTOR, lambda state: float((self._torque_shares(state) - most).max())
        )
        self.run.status = PathStatus.REACHED
        Leg(self.stepper, self.watch, self.run, 0, goal, _COMMAND_STEP, beyond).through()

    def _torque_shares(self, state: State) -> Array:
        """(nv,) of its torque that each joint pulls with."""
        return self.pulling.torque_shares(state.stretched, state.controls.command)
