"""Where contacts are while a grasp is loaded: what a step needs to know, and the geometry that stays as it was given.

A geometry answers one question: with the joints at q, the pads deformed by s and the object in this pose, where are the
contacts, how far apart are their bodies, and how do joints move them? `FixedGeometry` answers from one posture, for
small motions. A hand that knows its object answers from kinematics and contact detection
(`handlcp.hand.moving_geometry`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.contact import MANY_CONTACTS, block_diagonal, shift_twist
from handlcp.grasp.model.flexibility import Flexibility, stored_flexibility
from handlcp.grasp.model.mechanism import Mechanism, joint_flexibility
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.joint_system import TendonRoutes
from handlcp.grasp.path.linearise import (
    GeometryArrays,
    Placed,
    Poses,
    PostureArrays,
    geometry_of_posture,
    linearise,
    new_contacts,
)
from handlcp.grasp.path.newton.numbers import Elastic
from handlcp.grasp.path.newton.tangent import Moving, Touch

RIGID = 1e-5  # of the mean flexibility: what gives way by less is rigid


class Where(NamedTuple):
    """A configuration. q (nv,) joint positions [rad, m]. give (n, 3) : how far each finger's pad, or the environment,
    is pushed away at its contact, world axes [m]. turn (n,) : how far soft pads are twisted about their normals [rad].
    pose : of the object, as its geometry has it.
    """

    q: Array
    give: Array
    turn: Array
    pose: Any


class Iterate(NamedTuple):
    """The contacts in one configuration, world axes.

    touch : where contacts are, and how they move; moving : how joints move fingertips. frames (n, 3, 3) : contact axes
    in columns. elastic : what gives way at the contacts.
    radius (n,) : length over which the contact's geometry changes [m]. reference (3,) : the object's point that loads
    refer to. weight_arm (3,) : from there to its centre of mass. bodies : what the geometry itself remembers.
    """

    at: Where
    touch: Touch
    moving: Moving
    frames: Array
    elastic: Elastic
    radius: Array
    reference: Array
    weight_arm: Array
    bodies: Any

    @property
    def positions(self) -> Array:
        """(n, 3) of the contacts [m]."""
        return self.touch.positions

    @property
    def gap(self) -> Array:
        """(n,) distance between object and deformed fingertip [m], < 0 where they overlap."""
        return self.touch.gap


class Geometry:
    """What moves where. start : the configuration before anything is loaded. follows : whether contacts move.
    weighs : whether the fingers' weight is asked for. noise : of the contacts, as a share of their radii.
    quick : whether contacts are known in closed form, so that a path takes a tenth of a second.
    arrays : the same as compiled code reads it, with which whole paths run in one call; None: steps call the methods.
    poses : how compiled code reads configurations.
    posture (nv,) : from which commands of the joints are counted; apart (n, 3) : the part of the grasp's offsets there
    that the geometry itself knows of: gaps and overlaps [m].
    """

    start: Where
    posture: Array
    apart: Array
    follows: bool
    weighs: bool
    noise: float = 0.0
    quick: bool = True
    poses: Poses
    arrays: GeometryArrays | None = None

    @property
    def tendon_routes(self) -> TendonRoutes | None:
        """Of tendons whose arms change with the posture; None: there are none."""
        return None

    def mechanism(self, iterate: Iterate) -> Mechanism | None:
        """What moves the fingers, at the contacts of an iterate."""
        raise NotImplementedError

    def iterate(self, at: Where, before: Iterate | None) -> Iterate:
        """The contacts there; frames turn as little as they can from those before."""
        raise NotImplementedError

    def iterate_again(self, at: Where, frames: Array) -> Iterate:
        """The contacts in a configuration where their frames are known to be these (n, 3, 3); for geometries with
        `arrays`.
        """
        return self.iterate(at, None)

    def slipped(self, a: Iterate, b: Iterate, slip_memory: Array) -> Array:
        """(n, 3) how far the object has moved past the fingertips' surfaces from a to b: along x and y [m], and turned
        about z [rad], less slip_memory (n, 3). From b to a it is the opposite.
        """
        raise NotImplementedError

    def moved(self, pose: Any, twist: Array, centre: Array) -> Any:
        """The pose after a small motion (6,) about a point (3,) from a pose."""
        raise NotImplementedError

    def between(self, a: Any, b: Any) -> Array:
        """(6,) of the object from pose a to pose b: of its reference point [m], and turned [rad], world axes."""
        raise NotImplementedError

    def further(self, before: Any, now: Any, share: float) -> Any:
        """The pose that goes on from `before` to `now` by this share of the way between them."""
        raise NotImplementedError

    def displacement(self, pose: Any) -> Array:
        """(6,) motion of the object since the start: of the reference point [m], and the rotation vector [rad]."""
        raise NotImplementedError

    # ---- the same as rows of numbers
    def pose_row(self, pose: Any) -> Array:
        """A pose as `linearise` reads it."""
        raise NotImplementedError

    def pose_of(self, row: Array) -> Any:
        """The pose that a row stands for."""
        raise NotImplementedError

    def placed(self, iterate: Iterate) -> Placed:
        """What of an iterate its slips are counted from."""
        raise NotImplementedError

    def where_row(self, where: Where) -> Array:
        """A configuration as a row."""
        return np.concatenate([where.q, where.give.reshape(-1), where.turn, self.pose_row(where.pose)])

    def where_of(self, row: Array) -> Where:
        """The configuration that a row stands for."""
        n, nv = len(self.apart), len(self.posture)
        give, turn = row[nv : nv + 3 * n].reshape(n, 3), row[nv + 3 * n : nv + 4 * n]
        return Where(row[:nv], give, turn, self.pose_of(row[nv + 4 * n :]))


def between(geometry: Geometry, a: Where, b: Where, share: float) -> Where:
    """The configuration at this share of the way from a to b, beyond b above 1."""

    def on(x: Array, y: Array) -> Array:
        return np.asarray(x + share * (y - x))

    pose = geometry.further(a.pose, b.pose, share - 1.0)
    return Where(on(a.q, b.q), on(a.give, b.give), on(a.turn, b.turn), pose)


def length_of(positions: Array) -> float:
    """[m] of contacts (n, 3) from their centre: the root of the mean square."""
    arms = positions - positions.mean(axis=0)
    return float(np.sqrt((arms**2).sum(axis=1).mean())) or 1.0


def least_flexibility(spec: GraspSpec) -> float:
    """[m/N] that whatever is rigid has while a path is followed: a hundred thousandth of what the fingers have."""
    m = 3 * spec.of_hand
    return RIGID * float(spec.flexibility[:m, :m].diagonal().mean())


def supports(spec: GraspSpec) -> Array:
    """(3(n - k), 3(n - k)) flexibility of what supports the object beside k fingers. What is rigid gives way by a
    hundred thousandth of what the fingers do: forces at several corners of something rigid are not determined, and
    would jump.
    """
    m = 3 * spec.of_hand
    around = spec.flexibility[m:, m:].copy()
    rows = np.arange(len(around))
    around[rows, rows] = np.maximum(around[rows, rows], least_flexibility(spec))
    return around


class FixedGeometry(Geometry):
    """Contacts, normals and levers stay as the grasp has them; gaps and slips change in proportion to the motions.

    A pose is the object's twist (6,) about the grasp's reference since the start.
    """

    follows = False

    def __init__(self, spec: GraspSpec) -> None:
        n, mechanism, E = spec.n, spec.mechanism, stored_flexibility(spec)
        self.spec = spec
        J, compliance_factor = np.zeros((3 * n, 0)), np.zeros((0, 0))
        if mechanism is not None:
            J, compliance_factor = mechanism.jacobian, mechanism.compliance_factor
        elif isinstance(E, Flexibility) and n >= MANY_CONTACTS:  # of joints that have no names
            J, compliance_factor = E.factor.rows, E.factor.root
        nv = len(compliance_factor)
        turning = np.zeros((n, nv)) if mechanism is None else _turning(mechanism, spec)
        self.weighs = any(isinstance(e, FingerWeight) for e in spec.effects)
        weight = None if mechanism is None or not self.weighs else mechanism.gravity_torque()
        if isinstance(E, Flexibility) and nv:
            P = block_diagonal(E.factor.pads, n)
        else:
            P = spec.flexibility - joint_flexibility(J, compliance_factor)
        P[3 * spec.of_hand :, 3 * spec.of_hand :] = supports(spec)
        elastic = Elastic(
            P, J.copy(), turning.copy(), np.array(compliance_factor, dtype=float, order="C"),
            np.zeros(nv) if weight is None else weight.copy(),
        )  # fmt: skip
        still, normals = np.zeros((0, 3, 6)), spec.frames[:, :, 2].copy()
        # How contacts move along x, y and z and turn about z, by the pose and the joints
        rates, axes = np.zeros((n, 4, 6 + nv)), spec.frames.transpose(0, 2, 1)
        rates[:, :3, :3] = axes
        rates[:, :3, 3:6] = np.cross((spec.positions - spec.reference)[:, None], axes)
        rates[:, :3, 6:] = -J.reshape(n, 3, nv)
        rates[:, 3, 3:6], rates[:, 3, 6:] = normals, -turning
        self.apart = np.zeros((n, 3))
        self.apart[:, 2] = np.maximum(spec.offset[:, 2], 0.0)
        weighs = np.zeros(6) if mechanism is None else mechanism.weight_of_object(spec.reference)
        size = float(weighs[:3] @ weighs[:3])  # any point on the line of the weight will do
        arm = np.cross(weighs[:3], weighs[3:]) / size if size else np.zeros(3)
        self.poses = Poses(False, n, np.array(spec.reference), np.array(spec.reference), np.eye(3))
        self.arrays = geometry_of_posture(
            self.poses,
            PostureArrays(
                rates, self.apart[:, 2].copy(),
                Touch(spec.positions.copy(), normals, np.zeros(n), spec.positions.copy(), still, still),
                Moving(np.zeros((0, 6)), np.zeros((0, 0)), np.zeros((0, 0))), spec.frames.copy(), elastic,
                np.array(spec.reference), arm, np.full(n, np.inf),
            ),
        )  # fmt: skip
        self.posture = read_only(np.zeros(nv))
        self.start = Where(self.posture, np.zeros((n, 3)), np.zeros(n), np.zeros(6))

    def iterate(self, at: Where, before: Iterate | None) -> Iterate:
        assert self.arrays is not None  # this geometry has them
        found = new_contacts(self.arrays)
        linearise(self.arrays, self.where_row(at), found)
        return Iterate(
            at, found.touch, found.moving, found.frames, found.elastic, self.arrays.posture.radius, found.reference,
            self.arrays.posture.mass_arm, found.slips,
        )  # fmt: skip

    def mechanism(self, iterate: Iterate) -> Mechanism | None:
        mechanism: Mechanism | None = self.spec.mechanism
        return None if mechanism is None else mechanism.variation.with_joint_shift(iterate.at.q)

    def slipped(self, a: Iterate, b: Iterate, slip_memory: Array) -> Array:
        return np.asarray(b.bodies - a.bodies - slip_memory)

    def moved(self, pose: Any, twist: Array, centre: Array) -> Any:
        return pose + shift_twist(twist, self.spec.reference - centre)

    def between(self, a: Any, b: Any) -> Array:
        return np.asarray(b - a)

    def further(self, before: Any, now: Any, share: float) -> Array:
        return np.asarray(now + share * (now - before))

    def displacement(self, pose: Any) -> Array:
        return read_only(np.array(pose))

    def pose_row(self, pose: Any) -> Array:
        return np.asarray(pose)

    def pose_of(self, row: Array) -> Any:
        return row

    def placed(self, iterate: Iterate) -> Placed:
        n = len(iterate.frames)
        return Placed(iterate.positions, iterate.frames, np.zeros((n, 3, 3)), iterate.touch.places, iterate.bodies)


def _turning(mechanism: Mechanism, spec: GraspSpec) -> Array:
    """(n, nv) how fast joints turn the fingertips of soft contacts about their normals; others do not matter."""
    soft = tuple([i for i, c in enumerate(spec.contacts) if c.friction.lever > 0.0])
    rows = np.zeros((spec.n, len(mechanism.names)))
    if soft:
        rows[list(soft)] = mechanism.jacobian_rows(soft)[3 * spec.n :]
    return rows
