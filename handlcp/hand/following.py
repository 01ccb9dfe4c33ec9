"""A hand and its object in motion: kinematics and contact detection anew in every configuration of a loading path.

A fingertip is where the joints put it, pushed away by what its pad gives way. Contacts are detected there, between the
deformed fingertip and the object where it is now; contacts that were given without an object stay points of their
fingertips, on a plane of the object. What rests on the environment stays on the plane of its contact: a corner of a box
is a point of the box, and what is round rolls.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.grasp.loading.geometry import Geometry, Look, Where
from handlcp.grasp.model.environment import beside
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import cross_rows
from handlcp.hand.elasticity.pads import tip_flexibility
from handlcp.hand.objects.detect import nearest
from handlcp.hand.objects.plane_contacts import rolling_point
from handlcp.hand.robot.posture import Posture

__all__ = ["FollowedHand"]


class _Bodies(NamedTuple):
    """Of a look: R (3, 3), t (3,) of the object's motion since the start; turns (n, 3, 3) and places (n, 3) of the
    fingertips as they are deformed; those of the environment do not turn.
    """

    R: Array
    t: Array
    turns: Array
    places: Array


class FollowedHand(Geometry):
    """Of a hand's grasp. A pose is (R, t) of the object's motion x ↦ R x + t since the start, world axes."""

    follows = True

    def __init__(self, spec: GraspSpec) -> None:
        mechanism: Any = spec.mechanism  # a `HandMechanism`, which makes this geometry
        self.spec, self.mechanism, self.hand = spec, mechanism, mechanism.posture.hand
        self.object, self.k, self.n = mechanism.target, len(mechanism.tips), spec.n
        k = self.k
        self._around = read_only(spec.flexibility[3 * k :, 3 * k :].copy())
        self._reference = spec.reference
        centre = spec.positions[:k].mean(axis=0) if self.object is None else self.object.center_of_mass
        self._centre = centre
        self._arm = np.zeros(3) if self.object is None else self.object.center_of_mass - spec.reference
        self._radius = read_only(np.sqrt(((spec.positions - centre) ** 2).sum(axis=1)) + 1e-9)
        first = mechanism.posture
        if self.object is None:  # points of the fingertips, in their axes
            places, turns = first.tip_positions[list(mechanism.tips)], first.tip_rotations[list(mechanism.tips)]
            self._points = np.einsum("nji,nj->ni", turns, spec.positions[:k] - places)
        still = (np.eye(3), np.zeros(3))
        self.start = Where(first.q, np.zeros((self.n, 3)), np.zeros(self.n), still)

    # ---- where the contacts are
    def look(self, at: Where, before: Look | None) -> Look:
        R, t = at.pose
        posture, k, n = Posture(self.hand, np.array(at.q)), self.k, self.n
        tips = self.mechanism.tips
        places, turns = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
        places[:k] = posture.tip_positions[list(tips)]
        turns[:k] = posture.tip_rotations[list(tips)]
        places += at.give
        positions, normals, gap = np.empty((n, 3)), np.empty((n, 3)), np.empty(n)
        for i in range(k):
            positions[i], normals[i], gap[i] = self._finger(i, places[i], turns[i], R, t)
        for i in range(k, n):
            positions[i], normals[i], gap[i] = self._support(i, at.give[i], R, t)
        frames = self._frames(normals, before)
        positions, frames = read_only(positions), read_only(frames)
        made = self.mechanism.moved(posture, positions[:k], frames[:k])
        axes = frames[:k].transpose(0, 2, 1)
        pads = self.hand.pads.in_axes(lambda: axes @ turns[:k], tips)
        flexibility = read_only(tip_flexibility(made.jacobian[: 3 * k], made.root, pads))
        if n > k:
            flexibility = beside(flexibility, self._around)
        return Look(
            at, positions, frames, gap, made, flexibility, self._radius, read_only(R @ self._reference + t),
            R @ self._arm, made.weight(), _Bodies(R, t, turns, places),
        )  # fmt: skip

    def _finger(self, i: int, place: Array, turn: Array, R: Array, t: Array) -> tuple[Array, Array, float]:
        """Contact point on the object, normal and gap of a fingertip; detected where the object was at the start."""
        if self.object is None:
            tip, normal = place + turn @ self._points[i], R @ self.spec.frames[i][:, 2]
            on = R @ self.spec.positions[i] + t
            gap = float(normal @ (on - tip))
            return tip + gap * normal, normal, gap
        near = nearest(self.hand.tip_shapes(self.mechanism.tips[i]), R.T @ (place - t), R.T @ turn, self.object)
        return R @ near.position + t, R @ near.normal, near.gap

    def _support(self, i: int, give: Array, R: Array, t: Array) -> tuple[Array, Array, float]:
        """The same of a contact of the environment, whose plane stays where it is but for how it gives way."""
        normal = self.spec.frames[i][:, 2]
        height = self.spec.positions[i] - self.spec.offset[i, 2] * normal + give
        on = self.spec.positions[i]
        rolled = None if self.object is None else rolling_point(self.object, R.T @ normal, on)
        point = R @ (on if rolled is None else rolled) + t
        return point, normal, float(normal @ (point - height))

    def _frames(self, normals: Array, before: Look | None) -> Array:
        """(n, 3, 3) the frames before, turned by the smallest rotations that take their normals to these."""
        old = self.spec.frames if before is None else before.frames
        z = old[:, :, 2]
        axis = cross_rows(z, normals)
        cosine = (z * normals).sum(axis=1)
        if (cosine < -0.99).any():
            axis, cosine = np.zeros_like(axis), np.ones_like(cosine)
        K = _skew(axis)
        turned = old + K @ old + (K @ K @ old) / (1.0 + cosine)[:, None, None]
        turned[:, :, 2] = normals
        return np.asarray(turned)

    # ---- what moved
    def slipped(self, a: Look, b: Look) -> Array:
        A, B = a.bodies, b.bodies
        R = B.R @ A.R.T
        t = B.t - R @ A.t
        turns = B.turns @ A.turns.transpose(0, 2, 1)
        # Material points at the contacts of a where they are in b, and those at the contacts of b where they were in a
        ahead = a.positions @ R.T + t - a.positions
        back = b.positions - (b.positions - t) @ R
        tip_ahead = np.einsum("nij,nj->ni", turns, a.positions - A.places) + B.places - a.positions
        tip_back = b.positions - (np.einsum("nji,nj->ni", turns, b.positions - B.places) + A.places)
        relative = 0.5 * (ahead + back - tip_ahead - tip_back)
        slips = 0.5 * np.einsum("nji,nj->ni", a.frames + b.frames, relative)
        omega = pin.log3(R)
        spin = np.array([
            0.5 * float((x + y) @ (omega - (pin.log3(turn) if i < self.k else 0.0)))
            for i, (x, y, turn) in enumerate(zip(a.frames[:, :, 2], b.frames[:, :, 2], turns, strict=True))
        ])  # fmt: skip
        slips[:, 2] = spin
        return np.asarray(slips)

    def moved(self, pose: Any, twist: Array, centre: Array) -> tuple[Array, Array]:
        """X ↦ c + v + exp(ω) (x - c)."""
        R, t = pose
        turn = pin.exp3(np.ascontiguousarray(twist[3:]))
        return turn @ R, turn @ (t - centre) + centre + twist[:3]

    def further(self, before: Any, now: Any, share: float) -> tuple[Array, Array]:
        (R0, t0), (R1, t1) = before, now
        c0, c1 = R0 @ self._centre + t0, R1 @ self._centre + t1
        turn = pin.exp3(share * pin.log3(R1 @ R0.T))
        R = turn @ R1
        return R, c1 + share * (c1 - c0) - R @ self._centre

    def displacement(self, pose: Any) -> Array:
        R, t = pose
        return read_only(np.concatenate([R @ self._reference + t - self._reference, pin.log3(R)]))


def _skew(a: Array) -> Array:
    """(n, 3, 3) matrices of the cross products with rows (n, 3)."""
    K = np.zeros((len(a), 3, 3))
    K[:, 2, 1], K[:, 0, 2], K[:, 1, 0] = a.T
    K[:, 1, 2], K[:, 2, 0], K[:, 0, 1] = -a.T
    return K
