"""`MovingHandGeometry`: kinematics and contact detection anew in every configuration of a loading path.

A fingertip is where the joints put it, pushed away by what its pad gives way. Contacts are detected there, between the
deformed fingertip and the object where it is now; contacts that were given without an object stay points of their
fingertips, on a plane of the object. What rests on the environment stays on the plane of its contact: a corner of a box
is a point of the box, and what is round rolls.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.actuation.tendon_stiffness import RoutedStiffness
from handlcp.check import Array, read_only
from handlcp.contact.closest_point import rolling_point
from handlcp.contact.moving_contact import MovingBodies, compute_slip, write_contact_arrays
from handlcp.geometry.contact_kinematics import GivenContactFinder, SweptBallFinder, make_contact_finder
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.geometry import Geometry, Iterate, Where, least_flexibility, supports
from handlcp.grasp.path.joint_system import TendonRoutes
from handlcp.grasp.path.linearise import (
    GIVEN,
    NO_GIVEN_TIPS,
    NO_SWEPT_TIPS,
    Body,
    GeometryArrays,
    HandArrays,
    Placed,
    Poses,
    Supports,
    geometry_of_hand,
    linearise,
    new_contacts,
    write_support_contact,
)
from handlcp.grasp.path.newton.numbers import Elastic
from handlcp.grasp.path.newton.tangent import Moving, Touch
from handlcp.hand.squeeze import TipMotions, overlap_depths
from handlcp.kinematics.rigid_motion import (
    compose_motion,
    extrapolate_motion,
    motion_between,
    point_displacement,
)
from handlcp.robot.hand_model import HandPosture


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
        self.weighs = any(isinstance(e, FingerWeight) for e in spec.effects)
        self._reference = np.array(spec.reference)
        self._centre = spec.positions[:k].mean(axis=0) if self.object is None else np.array(self.object.center_of_mass)
        self._arm = self._centre - spec.reference if self.object is not None else np.zeros(3)
        self._first_frames = spec.frames.copy()
        self._compliance_factor = np.array(mechanism.compliance_factor, dtype=float, order="C")
        self._body = self._read_body()
        self._supports = self._read_supports()
        self._radius = np.sqrt(((spec.positions - self._centre) ** 2).sum(axis=1)) + 1e-9
        self._axes = np.tile(np.eye(3), (self.n, 1, 1))
        axes = np.eye(3) if self.object is None else np.array(self.object.frame[0])
        self.poses = Poses(True, self.n, self._reference, np.array(self._centre), np.ascontiguousarray(axes))
        self.arrays = self._read_arrays()
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

    def _read_body(self) -> Body:
        """The object as compiled code reads it."""
        kind, sizes, axes, origin = GIVEN, np.zeros(3), np.eye(3), np.zeros(3)
        if self.object is not None and self.object.known is not None:
            (kind, known), (R, p) = self.object.known, self.object.frame
            sizes, axes, origin = np.array(known, dtype=float), np.ascontiguousarray(np.array(R)), np.array(p)
        return Body(int(kind), sizes, axes, origin, self._reference, self._arm, np.array(self._centre))

    def _read_supports(self) -> Supports:
        """The environment's contacts."""
        spec, k, body = self.spec, self.k, self._body
        points, normals = spec.positions[k:].copy(), spec.frames[k:, :, 2].copy()
        rolls = [
            int(rolling_point(body.kind, body.sizes, body.axes, body.origin, normal, point, np.empty(3)))
            for point, normal in zip(points, normals, strict=True)
        ]
        return Supports(points, normals, spec.offset[k:, 2].copy(), np.array(rolls, dtype=np.int64), supports(spec))

    def _read_arrays(self) -> GeometryArrays | None:
        """All of it as compiled code reads it; None: contacts are not known in closed form."""
        find, kinematics, swept, given = self._find, self.hand.kinematics, NO_SWEPT_TIPS, NO_GIVEN_TIPS
        if isinstance(find, SweptBallFinder):
            swept = find.swept
        elif isinstance(find, GivenContactFinder):
            given = find.tips
        else:
            return None
        if kinematics.tree is None:
            return None
        gravity = np.array(self._mechanism.gravity, dtype=float) if self.weighs else np.zeros(3)
        hand = HandArrays(
            kinematics.tree, kinematics.tip_placements(self._frames), self._support, self._pads,
            self._compliance_factor, gravity, self._body, swept, given, self._supports, self._radius,
        )  # fmt: skip
        return geometry_of_hand(self.poses, hand)

    def _open_posture(self, there: Iterate) -> Array:
        """(nv,) the posture, opened joint by joint until overlapping fingertips touch, as far as joints can."""
        inside = overlap_depths(there.gap[: self.k])
        if not inside.any():
            return self.posture
        names, alone = self._mechanism.fingertips, np.eye(self.hand.nv)
        tips = TipMotions.from_jacobian(names, there.elastic.J, alone, self.spec.planar)
        return read_only(self.posture - tips.command_for_depth(inside))

    @property
    def tendon_routes(self) -> TendonRoutes | None:
        """Of tendons whose arms change with the posture."""
        stiffness, kinematics = self.hand.stiffness, self.hand.kinematics
        if not isinstance(stiffness, RoutedStiffness):
            return None
        tendons, links = stiffness.routed_tendons
        return TendonRoutes(kinematics.tip_placements(links), tendons)

    # ---- where the contacts are
    def iterate(self, at: Where, before: Iterate | None) -> Iterate:
        return self.iterate_again(at, self._first_frames if before is None else before.frames)

    def iterate_again(self, at: Where, frames: Array) -> Iterate:
        if self.arrays is None:
            return self._detect_contacts(at, frames)
        R, t = at.pose
        found = new_contacts(self.arrays)
        found.frames[:] = frames
        linearise(self.arrays, self.where_row(at), found)
        elastic, arm = found.elastic, R.dot(self._arm)
        posed = self.hand.posed(at.q)
        if posed is not self.hand:  # tendons along routes, whose arms change
            elastic = elastic._replace(compliance_factor=np.array(posed.stiffness.compliance_factor, order="C"))
        bodies = MovingBodies(R, t, found.axes, found.touch.places)
        return Iterate(at, found.touch, found.moving, found.frames, elastic, self._radius, found.reference, arm, bodies)

    def _detect_contacts(self, at: Where, old: Array) -> Iterate:
        """The contacts, found by detection; frames turn from the old ones."""
        R, t = at.pose
        posed = self.hand.posed(at.q)
        factor = (
            self._compliance_factor if posed is self.hand else np.array(posed.stiffness.compliance_factor, order="C")
        )
        n, nv, k, kinematics = self.n, self.hand.nv, self.k, self.hand.kinematics
        placements, columns = kinematics.frames_at(at.q, self._frames)
        moving = Moving(np.ascontiguousarray(columns.T), self._support, self._coupling)
        places, axes = at.give.copy(), self._axes.copy()
        places[:k] += placements[:, :3, 3]
        places[k:] += self._supports.points
        axes[:k] = placements[:, :3, :3]
        touch = Touch(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), places, np.zeros((n, 3, 6)), np.zeros((n, 3, 6)))
        weight = kinematics.gravity_torque(at.q, self._mechanism.gravity) if self.weighs else self._none
        frames = np.empty((n, 3, 3))
        el = Elastic(np.empty((3 * n, 3 * n)), np.empty((3 * n, nv)), np.empty((n, nv)), factor, weight)
        self._find(places, axes, R, t, (touch.positions, touch.normals, touch.gap, touch.turn, touch.shift))
        for i in range(k, n):
            touch.gap[i] = write_support_contact(
                self._supports, i - k, self._body, R, t, at.give[i], touch.positions[i], touch.normals[i],
                touch.turn[i], touch.shift[i],
            )  # fmt: skip
        write_contact_arrays(
            *moving, self._pads, self._supports.flexibility, axes, touch.positions, old, touch.normals, frames, el.P,
            el.J, el.turning,
        )  # fmt: skip
        reference = R.dot(self._reference) + t
        return Iterate(
            at, touch, moving, frames, el, self._radius, reference, R.dot(self._arm), MovingBodies(R, t, axes, places)
        )

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

    def further(self, before: Any, now: Any, share: float) -> tuple[Array, Array]:
        (R0, t0), (R1, t1) = before, now
        return extrapolate_motion(R0, t0, R1, t1, self._centre, share)

    def displacement(self, pose: Any) -> Array:
        R, t = pose
        return read_only(point_displacement(R, t, self._reference))

    # ---- the same as rows of numbers
    def pose_row(self, pose: Any) -> Array:
        R, t = pose
        return np.concatenate([R.reshape(-1), t])

    def pose_of(self, row: Array) -> tuple[Array, Array]:
        return row[:9].reshape(3, 3), row[9:]

    def placed(self, iterate: Iterate) -> Placed:
        bodies = iterate.bodies
        slips = np.zeros((self.n, 3))
        return Placed(iterate.positions, iterate.frames, bodies.turns, bodies.places, slips)


def _with_least_flexibility(pads: Array, least: float) -> Array:
    """(k, 3, 3) with `least` [m/N] more where a direction has less: along parallel joints of two fingers nothing else
    gives way, and forces there would not be determined.
    """
    rigid = np.linalg.eigvalsh(pads)[:, 0] < least
    return np.ascontiguousarray(pads + np.where(rigid, least, 0.0)[:, None, None] * np.eye(3))
