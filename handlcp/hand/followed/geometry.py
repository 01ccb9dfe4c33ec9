"""A hand and its object in motion: kinematics and contact detection anew in every configuration of a loading path.

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
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.loading.geometry import Geometry, Look, Where, least_flexibility, supports
from handlcp.grasp.loading.numbers import Elastic
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.followed.contacts import Bodies, contacts_at, slip_between
from handlcp.hand.followed.fingertips import finger_contacts
from handlcp.hand.followed.motions import gone_on, moved_on
from handlcp.hand.objects.plane_contacts import rolling_point
from handlcp.hand.robot.posture import Posture
from handlcp.hand.squeeze import TipMotions, overlaps

__all__ = ["FollowedHand"]


class FollowedHand(Geometry):
    """Of a hand's grasp. A pose is (R, t) of the object's motion x ↦ R x + t since the start, world axes."""

    follows = True

    def __init__(self, spec: GraspSpec) -> None:
        mechanism: Any = spec.mechanism  # a `HandMechanism`, which makes this geometry
        self.spec, self._mechanism, hand = spec, mechanism, mechanism.posture.hand
        self.hand, self.object, self.k, self.n = hand, mechanism.target, len(mechanism.tips), spec.n
        k, tips = self.k, list(mechanism.tips)
        self._find = finger_contacts(hand, spec, mechanism)
        self._frames = [hand.tips.frames[i] for i in tips]
        self._support = np.ascontiguousarray(hand.tips.support[tips, 0])
        self._coupling = np.empty((0, 0)) if hand.kinematics.coupling is None else np.array(hand.kinematics.coupling)
        self._pads = _never_rigid(hand.pads.blocks[tips], least_flexibility(spec))
        self._around = supports(spec)
        self.weighs = any(isinstance(e, FingerWeight) for e in spec.effects)
        self._reference = spec.reference
        self._centre = spec.positions[:k].mean(axis=0) if self.object is None else self.object.center_of_mass
        self._arm = self._centre - spec.reference if self.object is not None else np.zeros(3)
        self._radius = read_only(np.sqrt(((spec.positions - self._centre) ** 2).sum(axis=1)) + 1e-9)
        self._least = float(self._radius.min())
        self._places, self._turns = np.zeros((self.n, 3)), np.tile(np.eye(3), (self.n, 1, 1))
        self._none = np.zeros(hand.nv)
        still = (np.eye(3), np.zeros(3))
        self.posture = mechanism.posture.q
        self.start = Where(self.posture, np.zeros((self.n, 3)), np.zeros(self.n), still)
        there = self.look(self.start, None)
        self.apart = np.zeros((self.n, 3))
        self.apart[:k, :2] = mechanism.stand_off[:, :2]
        self.apart[:, 2] = there.gap
        self.start = self.start._replace(q=self._open(there))

    def _open(self, there: Look) -> Array:
        """(nv,) the posture, opened where fingertips overlap the object until they touch it, joint by joint as in
        closing. What joints cannot open stays.
        """
        inside = overlaps(there.gap[: self.k])
        if not inside.any():
            return self.posture
        names, alone = self._mechanism.fingertips, np.eye(self.hand.nv)
        tips = TipMotions.of(names, there.elastic.J, alone, self.spec.planar)
        return read_only(self.posture - tips.deeper(inside))

    # ---- where the contacts are
    def look(self, at: Where, before: Look | None) -> Look:
        R, t = at.pose
        k, n, kinematics = self.k, self.n, self.hand.kinematics
        placements, columns = kinematics.frames_at(at.q, self._frames)
        places, turns = self._places.copy(), self._turns.copy()
        places[:k], turns[:k] = placements[:, :3, 3], placements[:, :3, :3]
        places += at.give
        positions, normals, gap = np.empty((n, 3)), np.empty((n, 3)), np.empty(n)
        self._find(places, turns, R, t, positions, normals, gap)
        for i in range(k, n):
            positions[i], normals[i], gap[i] = self._supported(i, at.give[i], R, t)
        frames, E, J, turning = contacts_at(
            columns.T, self._support, self._coupling, self._mechanism.root, self._pads, self._around, turns, positions,
            self.spec.frames if before is None else before.frames, normals,
        )  # fmt: skip
        weight = self._none
        if self.weighs:
            weight = kinematics.gravity_torque(at.q, self._mechanism.gravity)
        return Look(
            at, read_only(positions), read_only(frames), gap, Elastic(E, J, turning, self._mechanism.root, weight),
            self._radius, R @ self._reference + t, R @ self._arm, Bodies(R, t, turns, places),
        )  # fmt: skip

    def _supported(self, i: int, give: Array, R: Array, t: Array) -> tuple[Array, Array, float]:
        """Contact point, normal and gap of a contact of the environment, whose plane stays but for how it gives way."""
        on, normal = self.spec.positions[i], self.spec.frames[i][:, 2]
        plane = on - self.spec.offset[i, 2] * normal + give
        rolled = None if self.object is None else rolling_point(self.object, R.T @ normal, on)
        point = R @ (on if rolled is None else rolled) + t
        return point, normal, float(normal @ (point - plane))

    def mechanism(self, look: Look) -> Mechanism:
        k = self.k
        posture = Posture(self.hand, np.array(look.at.q))
        made: Mechanism = self._mechanism.moved(posture, look.positions[:k], look.frames[:k])
        return made

    # ---- what moved
    def slipped(self, a: Look, b: Look, carry: Array) -> Array:
        return slip_between(a.positions, a.frames, a.bodies, b.positions, b.frames, b.bodies, carry)

    def moved(self, pose: Any, twist: Array, centre: Array, since: Any) -> tuple[Any, float]:
        (R, t), (R0, t0) = pose, since
        R, t, far, turned = moved_on(R, t, twist, centre, R0, t0, self._centre)
        return (R, t), max(far / self._least, turned)

    def further(self, before: Any, now: Any, share: float) -> tuple[Array, Array]:
        (R0, t0), (R1, t1) = before, now
        return gone_on(R0, t0, R1, t1, self._centre, share)

    def displacement(self, pose: Any) -> Array:
        R, t = pose
        return read_only(np.concatenate([R @ self._reference + t - self._reference, pin.log3(R)]))


def _never_rigid(pads: Array, least: float) -> Array:
    """(k, 3, 3) with `least` [m/N] more where a direction has less: along parallel joints of two fingers nothing else
    gives way, and forces there would not be determined.
    """
    rigid = np.linalg.eigvalsh(pads)[:, 0] < least
    return np.ascontiguousarray(pads + np.where(rigid, least, 0.0)[:, None, None] * np.eye(3))
