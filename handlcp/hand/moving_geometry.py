"""`MovingHandGeometry`: kinematics and contact detection anew in every configuration of a loading path.

A fingertip is where the joints put it, pushed away by what its pad gives way. Contacts are detected there, between the
deformed fingertip and the object where it is now; contacts that were given without an object stay points of their
fingertips, on a plane of the object. What rests on the environment stays on the plane of its contact: a corner of a box
is a point of the box, and what is round rolls.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.geometry.contact_kinematics import (
    MovingBodies,
    SweptBallFinder,
    compose_motion,
    compute_slip,
    evaluate_ball_contacts,
    extrapolate_motion,
    make_contact_finder,
    motion_between,
    point_displacement,
    write_contact_arrays,
)
from handlcp.geometry.table import rolling_point
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.geometry import Geometry, Iterate, Where, least_flexibility, supports
from handlcp.grasp.path.newton.numbers import Elastic
from handlcp.grasp.path.newton.tangent import Moving, Touch
from handlcp.hand.squeeze import TipMotions, overlap_depths
from handlcp.robot.hand_model import HandPosture

_HALF_TURN_TRACE = -0.9  # trace of a rotation by almost half a turn, whose axis takes more care
_ROLLING_STEP = 1e-5  # [rad] differences of where a round object touches a plane


class MovingHandGeometry(Geometry):
    """Of a hand's grasp. A pose is (R, t) of the object's motion x ↦ R x + t since the start, world axes."""

    follows = True

    def __init__(self, spec: GraspSpec) -> None:
        mechanism: Any = spec.mechanism  # a `HandMechanism`, which makes this geometry
        self.spec, self._mechanism, hand = spec, mechanism, mechanism.posture.hand
        self.hand, self.object, self.k, self.n = hand, mechanism.target, len(mechanism.tips), spec.n
        k, tips = self.k, list(mechanism.tips)
        self._find = make_contact_finder(spec, mechanism)
        self.noise = self._find.noise
        self._frames = [hand.tips.frames[i] for i in tips]
        self._support = np.array(hand.tips.support[tips, 0], dtype=float, order="C")
        self._coupling = np.empty((0, 0)) if hand.kinematics.coupling is None else np.array(hand.kinematics.coupling)
        self._pads = _with_least_flexibility(hand.pads.blocks[tips], least_flexibility(spec))
        self._around = supports(spec)
        self.weighs = any(isinstance(e, FingerWeight) for e in spec.effects)
        self._reference = spec.reference
        self._centre = spec.positions[:k].mean(axis=0) if self.object is None else self.object.center_of_mass
        self._arm = self._centre - spec.reference if self.object is not None else np.zeros(3)
        self._first_frames = spec.frames.copy()
        self._root = np.array(mechanism.compliance_factor, dtype=float, order="C")
        axes = spec.frames[:, :, 2]
        self._round = [
            i >= k and self.object is not None and rolling_point(self.object, axes[i], spec.positions[i]) is not None
            for i in range(self.n)
        ]
        self._radius = np.sqrt(((spec.positions - self._centre) ** 2).sum(axis=1)) + 1e-9
        self._least = float(self._radius.min())
        self._turns = np.tile(np.eye(3), (self.n, 1, 1))
        self.quick = self.k == self.n and isinstance(self._find, SweptBallFinder)
        self._none = np.zeros(hand.nv)
        still = (np.eye(3), np.zeros(3))
        self.posture = mechanism.posture.q
        self.start = Where(self.posture, np.zeros((self.n, 3)), np.zeros(self.n), still)
        there = self.iterate(self.start, None)
        self.apart = np.zeros((self.n, 3))
        self.apart[:k, :2] = mechanism.stand_off[:, :2]
        self.apart[:, 2] = there.gap
        command = find_command(spec.effects)
        opened = None if command is None else command.opened
        self.start = self.start._replace(q=self._open_posture(there) if opened is None else opened)

    def _open_posture(self, there: Iterate) -> Array:
        """(nv,) the posture, opened joint by joint until overlapping fingertips touch, as far as joints can."""
        inside = overlap_depths(there.gap[: self.k])
        if not inside.any():
            return self.posture
        names, alone = self._mechanism.fingertips, np.eye(self.hand.nv)
        tips = TipMotions.from_jacobian(names, there.elastic.J, alone, self.spec.planar)
        return read_only(self.posture - tips.command_for_depth(inside))

    # ---- where the contacts are
    def iterate(self, at: Where, before: Iterate | None) -> Iterate:
        R, t = at.pose
        posed = self.hand.posed(at.q)
        root = self._root if posed is self.hand else np.array(posed.stiffness.compliance_factor, order="C")
        n, nv, kinematics, balls = self.n, self.hand.nv, self.hand.kinematics, self._find
        placements, columns = kinematics.frames_at(at.q, self._frames)
        moving = Moving(np.ascontiguousarray(columns.T), self._support, self._coupling)
        places, turns = np.zeros((n, 3)), self._turns.copy()
        touch = Touch(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), places, np.zeros((n, 3, 6)), np.zeros((n, 3, 6)))
        weight = kinematics.gravity_torque(at.q, self._mechanism.gravity) if self.weighs else self._none
        frames = np.empty((n, 3, 3))
        el = Elastic(np.empty((3 * n, 3 * n)), np.empty((3 * n, nv)), np.empty((n, nv)), root, weight)
        old = self._first_frames if before is None else before.frames
        found = touch.positions, touch.normals, touch.gap, touch.turn, touch.shift
        if self.quick and isinstance(balls, SweptBallFinder):
            evaluate_ball_contacts(
                placements, *moving, self._pads, self._around, balls.kind, balls.sizes, balls.own, balls.at,
                balls.swept, R, t, at.give, old, places, turns, *found, frames, el.P, el.J, el.turning,
            )  # fmt: skip
        else:
            self._detect(at, placements, touch, turns)
            write_contact_arrays(
                *moving, self._pads, self._around, turns, touch.positions, old, touch.normals, frames, el.P, el.J,
                el.turning,
            )  # fmt: skip
        reference, bodies = R.dot(self._reference) + t, MovingBodies(R, t, turns, places)
        return Iterate(at, touch, moving, frames, el, self._radius, reference, R.dot(self._arm), bodies)

    def _detect(self, at: Where, placements: Array, touch: Touch, turns: Array) -> None:
        """Write the contacts of fingers and environment, one after the other."""
        (R, t), k, places = at.pose, self.k, touch.places
        places[:k], turns[:k] = placements[:, :3, 3], placements[:, :3, :3]
        places += at.give
        self._find(places, turns, R, t, (touch.positions, touch.normals, touch.gap, touch.turn, touch.shift))
        for i in range(k, self.n):
            touch.positions[i], touch.normals[i], touch.gap[i] = self._support_contact(i, at.give[i], R, t)
            self._write_rolling(i, R, t, touch.normals[i], touch.turn[i], touch.shift[i])
            places[i] += self.spec.positions[i]

    def _write_rolling(self, i: int, R: Array, t: Array, normal: Array, turn: Array, shift: Array) -> None:
        """Write how a contact of the environment moves as the object turns on its plane, whose normal stays."""
        for a in range(3):
            turn[:, 3 + a] = np.cross(np.eye(3)[a], normal)  # takes back that normals turn with the object
        if self.object is None or not self._round[i]:
            return
        for a in range(3):
            by = np.zeros(3)
            by[a] = _ROLLING_STEP
            ends = list[Array]()
            for sign in (1.0, -1.0):
                on = rolling_point(self.object, (pin.exp3(sign * by) @ R).T @ normal, self.spec.positions[i])
                assert on is not None  # `_round` says so
                ends.append(on)
            shift[:, 3 + a] = -R @ (ends[0] - ends[1]) / (2.0 * _ROLLING_STEP)

    def _support_contact(self, i: int, give: Array, R: Array, t: Array) -> tuple[Array, Array, float]:
        """Contact point, normal and gap of a contact of the environment, whose plane stays but for how it gives way."""
        on, normal = self.spec.positions[i], self.spec.frames[i][:, 2]
        plane = on - self.spec.offset[i, 2] * normal + give
        rolled = None if self.object is None else rolling_point(self.object, R.T @ normal, on)
        point = R @ (on if rolled is None else rolled) + t
        return point, normal, float(normal @ (point - plane))

    def mechanism(self, iterate: Iterate) -> Mechanism:
        k = self.k
        posture = HandPosture(self.hand, np.array(iterate.at.q))
        made: Mechanism = self._mechanism.move_contacts(posture, iterate.positions[:k], iterate.frames[:k])
        return made

    # ---- what moved
    def slipped(self, a: Iterate, b: Iterate, slip_memory: Array) -> Array:
        slip = compute_slip(a.positions, a.frames, a.bodies, b.positions, b.frames, b.bodies, slip_memory)
        slip[:, 2] -= b.at.turn - a.at.turn
        return slip

    def moved(self, pose: Any, twist: Array, centre: Array) -> Any:
        R, t = pose
        return compose_motion(R, t, twist, centre)

    def between(self, a: Any, b: Any) -> Array:
        (R0, t0), (R1, t1) = a, b
        return motion_between(R0, t0, R1, t1, self._reference)

    def turned(self, pose: Any) -> Array:
        R, _ = pose
        return np.asarray(R if self.object is None else R @ self.object.frame[0])

    def further(self, before: Any, now: Any, share: float) -> tuple[Array, Array]:
        (R0, t0), (R1, t1) = before, now
        return extrapolate_motion(R0, t0, R1, t1, self._centre, share)

    def displacement(self, pose: Any) -> Array:
        R, t = pose
        moved = point_displacement(R, t, self._reference)
        if R[0, 0] + R[1, 1] + R[2, 2] < _HALF_TURN_TRACE:
            moved[3:] = pin.log3(R)
        return read_only(moved)


def _with_least_flexibility(pads: Array, least: float) -> Array:
    """(k, 3, 3) with `least` [m/N] more where a direction has less: along parallel joints of two fingers nothing else
    gives way, and forces there would not be determined.
    """
    rigid = np.linalg.eigvalsh(pads)[:, 0] < least
    return np.ascontiguousarray(pads + np.where(rigid, least, 0.0)[:, None, None] * np.eye(3))
