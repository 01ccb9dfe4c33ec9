"""`linearise`: where the contacts of a grasp are in a configuration, and how they move, in one compiled call.

A geometry that is known in closed form is a tuple of arrays: `HandArrays` of a hand whose joints move its fingertips
over an object of a simple shape, `PostureArrays` of contacts that stay as they were given. A configuration is a row:
joint positions q (nv,) [rad, m], how far pads are pushed away (n, 3) [m], world axes, how far soft pads are turned (n,)
[rad], and the pose of the object: (R, t) of its motion x ↦ R x + t since the start, row by row (12,), or, where
contacts stay, its twist (6,) about the grasp's reference.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.contact.closest_point import rolling_point
from handlcp.contact.moving_contact import (
    GivenTips,
    MovingBodies,
    SweptTips,
    compute_slip,
    write_ball_contacts,
    write_contact_arrays,
    write_given_contacts,
)
from handlcp.grasp.path.newton.numbers import Elastic
from handlcp.grasp.path.newton.tangent import Moving, Touch
from handlcp.kinematics.joint_tree import (
    JointTree,
    TipPlacements,
    compose_placement,
    write_gravity_torque,
    write_joint_motions,
)
from handlcp.kinematics.rigid_motion import (
    compose_motion,
    extrapolate_motion,
    motion_between,
    point_displacement,
    rotation_matrix,
    transform_point,
)
from handlcp.lcp.kernels.dense import kernel, product

GIVEN = -1  # kind of an object of which only the planes of its contacts are known
_ROLLING_STEP = 1e-5  # [rad] differences of where a round object touches a plane


class Body(NamedTuple):
    """An object. kind, sizes (3,) : as in `closest_on_surface`, or GIVEN. axes (3, 3), origin (3,) : of its shape at
    the start. reference (3,) : the point that loads refer to; mass_arm (3,) : from there to its centre of mass; centre
    (3,) : the point that moves straight from one pose to another [m].
    """

    kind: int
    sizes: Array
    axes: Array
    origin: Array
    reference: Array
    mass_arm: Array
    centre: Array


class Supports(NamedTuple):
    """Contacts of the environment, whose planes stay but for how they give way. points (m, 3) : of the object, where it
    touched at first; normals (m, 3); offset (m,) [m] : from the plane to the point. rolls (m,) : 1 where the object is
    round there. flexibility (3m, 3m) [m/N].
    """

    points: Array
    normals: Array
    offset: Array
    rolls: Ints
    flexibility: Array


class HandArrays(NamedTuple):
    """A hand and its object. support (k, joints) : 1 where a joint moves a finger. pads (k, 3, 3) : their flexibility
    in tip axes [m/N]. compliance_factor (nv, m) : A of K⁻¹ = A Aᵀ. gravity (3,) [m/s²] : 0 where the fingers' weight is
    not asked for. swept : fingertips on an object that is known; given : others. radius (n,) : as in `Iterate`.
    """

    tree: JointTree
    tips: TipPlacements
    support: Array
    pads: Array
    compliance_factor: Array
    gravity: Array
    body: Body
    swept: SweptTips
    given: GivenTips
    supports: Supports
    radius: Array


class PostureArrays(NamedTuple):
    """Contacts that stay. rates (n, 4, 6 + nv) : how they move along x, y and z and turn about z, by the object's twist
    and the joints. apart (n,) : gaps at the start [m]. touch, moving, frames, elastic : as in `Iterate`.
    """

    rates: Array
    apart: Array
    touch: Touch
    moving: Moving
    frames: Array
    elastic: Elastic
    reference: Array
    mass_arm: Array
    radius: Array


class Poses(NamedTuple):
    """How configurations of n contacts are read. follows : whether contacts move. reference (3,) : the object's point
    that loads refer to; centre (3,) : the point that moves straight from one pose to another [m]; axes (3, 3) : the
    object's own. All at the start.
    """

    follows: bool
    n: int
    reference: Array
    centre: Array
    axes: Array


class GeometryArrays(NamedTuple):
    """A geometry that is known in closed form. Where contacts move, `hand` says how; else `posture`."""

    poses: Poses
    hand: HandArrays
    posture: PostureArrays


class Contacts(NamedTuple):
    """What `linearise` writes: contacts as in `Iterate`; axes (n, 3, 3) of the fingertips; slips (n, 3) : along x and y
    [m] and about z [rad], of contacts that stay; the object's reference (3,) and centre of mass (3,) [m].
    """

    touch: Touch
    moving: Moving
    frames: Array
    elastic: Elastic
    axes: Array
    slips: Array
    reference: Array
    mass_at: Array


class Place(NamedTuple):
    """A configuration: views into its row."""

    q: Array
    give: Array
    turn: Array
    pose: Array


_NOTHING = np.zeros((0, 0, 0))
NO_SUPPORTS = Supports(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros((0, 0)))
NO_SWEPT_TIPS = SweptTips(np.zeros((0, 3)), _NOTHING, np.zeros(0), np.zeros((0, 3)))
NO_GIVEN_TIPS = GivenTips(*[np.zeros((0, 3)) for _ in range(4)])
NO_HAND = HandArrays(
    JointTree(
        np.zeros(0, dtype=np.int64), _NOTHING, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=np.int64),
        np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros((0, 3)),
    ),
    TipPlacements(np.zeros(0, dtype=np.int64), _NOTHING, np.zeros((0, 3))), np.zeros((0, 0)), _NOTHING,
    np.zeros((0, 0)), np.zeros(3),
    Body(GIVEN, np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)),
    NO_SWEPT_TIPS, NO_GIVEN_TIPS, NO_SUPPORTS, np.zeros(0),
)  # fmt: skip
_STILL = Moving(np.zeros((0, 6)), np.zeros((0, 0)), np.zeros((0, 0)))
NO_POSTURE = PostureArrays(
    _NOTHING, np.zeros(0),
    Touch(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3, 6)), np.zeros((0, 3, 6))),
    _STILL, _NOTHING,
    Elastic(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0)),
    np.zeros(3), np.zeros(3), np.zeros(0),
)  # fmt: skip


def geometry_of_hand(poses: Poses, hand: HandArrays) -> GeometryArrays:
    """The geometry of a hand that moves its contacts."""
    return GeometryArrays(poses, hand, NO_POSTURE)


def geometry_of_posture(poses: Poses, posture: PostureArrays) -> GeometryArrays:
    """The geometry of contacts that stay."""
    return GeometryArrays(poses, NO_HAND, posture)


@kernel
def read_place(s: Poses, where: Array) -> Place:
    """A configuration, from its row."""
    n, p = s.n, 12 if s.follows else 6
    nv = len(where) - 4 * n - p
    give = where[nv : nv + 3 * n].reshape(n, 3)
    return Place(where[:nv], give, where[nv + 3 * n : nv + 4 * n], where[nv + 4 * n :])


@kernel
def new_contacts(g: GeometryArrays) -> Contacts:
    """Arrays that `linearise` can write to; what it never changes is the geometry's own."""
    h, f, none = g.hand, g.posture, np.zeros((0, 0))
    if not g.poses.follows:
        n = len(f.radius)
        touch = Touch(f.touch.positions, f.touch.normals, np.empty(n), f.touch.places, f.touch.turn, f.touch.shift)
        axes = np.zeros((n, 3, 3))
        return Contacts(
            touch, f.moving, f.frames, f.elastic, axes, np.empty((n, 3)), f.reference, f.reference + f.mass_arm
        )
    n, nv = len(h.radius), len(h.compliance_factor)
    touch = Touch(
        np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty((n, 3)), np.zeros((n, 3, 6)), np.zeros((n, 3, 6))
    )
    moving = Moving(np.empty((len(h.tree.parents), 6)), h.support, h.tree.coupling)
    elastic = Elastic(
        np.empty((3 * n, 3 * n)), np.empty((3 * n, nv)), np.empty((n, nv)), h.compliance_factor, np.zeros(nv), none
    )
    axes = np.zeros((n, 3, 3))
    for i in range(len(h.support), n):
        for a in range(3):
            axes[i, a, a] = 1.0
    frames, slips = np.empty((n, 3, 3)), np.zeros((n, 3))
    return Contacts(touch, moving, frames, elastic, axes, slips, np.empty(3), np.empty(3))


@kernel
def linearise(g: GeometryArrays, where: Array, out: Contacts) -> None:
    """Write the contacts in a configuration. Frames that stand in `out` turn from there, as little as they can; those
    of contacts that stay are not written.
    """
    at = read_place(g.poses, where)
    if g.poses.follows:
        _linearise_hand(g.hand, at, out)
    else:
        _linearise_posture(g.posture, at, out)


@kernel
def _linearise_posture(f: PostureArrays, at: Place, out: Contacts) -> None:
    """Write gaps and slips, which change in proportion to the motions."""
    nv = len(at.q)
    for i in range(len(f.radius)):
        for a in range(4):
            moves = 0.0
            for j in range(6):
                moves += f.rates[i, a, j] * at.pose[j]
            for j in range(nv):
                moves += f.rates[i, a, 6 + j] * at.q[j]
            if a < 3:
                for b in range(3):
                    moves -= f.frames[i, b, a] * at.give[i, b]
            else:
                moves -= at.turn[i]
            if a == 2:
                out.touch.gap[i] = f.apart[i] + moves
            else:
                out.slips[i, min(a, 2)] = moves


@kernel
def _linearise_hand(h: HandArrays, at: Place, out: Contacts) -> None:
    """Write all that an iterate knows of a hand's contacts and of those of the environment."""
    joints, k, n, body, t = len(h.tree.parents), len(h.support), len(h.radius), h.body, out.touch
    R, p, object_at = np.empty((joints, 3, 3)), np.empty((joints, 3)), at.pose[9:]
    turned = at.pose[:9].reshape(3, 3)
    write_joint_motions(h.tree, at.q, R, p, out.moving.columns)
    for i in range(k):
        compose_placement(R, p, h.tips.carriers[i], h.tips.rotations[i], h.tips.origins[i], out.axes[i], t.places[i])
        for a in range(3):
            t.places[i, a] += at.give[i, a]
    if body.kind == GIVEN:
        write_given_contacts(
            h.given, turned, object_at, t.places, out.axes, t.positions, t.normals, t.gap, t.turn, t.shift
        )
    else:
        origin = transform_point(turned, object_at, body.origin)
        write_ball_contacts(
            body.kind, body.sizes, product(turned, body.axes), origin, t.places, out.axes, h.swept, t.positions,
            t.normals, t.gap, t.turn, t.shift,
        )  # fmt: skip
    for i in range(k, n):
        t.gap[i] = write_support_contact(
            h.supports, i - k, body, turned, object_at, at.give[i], t.positions[i], t.normals[i], t.turn[i], t.shift[i]
        )
        for a in range(3):
            t.places[i, a] = h.supports.points[i - k, a] + at.give[i, a]
    write_contact_arrays(
        out.moving.columns, h.support, h.tree.coupling, h.pads, h.supports.flexibility, out.axes, t.positions,
        out.frames, t.normals, out.frames, out.elastic.P, out.elastic.J, out.elastic.turning,
    )  # fmt: skip
    if h.gravity.any():
        write_gravity_torque(h.tree, R, p, out.moving.columns, h.gravity, out.elastic.gravity)
    for a in range(3):
        out.reference[a], out.mass_at[a] = object_at[a], object_at[a]
        for b in range(3):
            out.reference[a] += turned[a, b] * body.reference[b]
            out.mass_at[a] += turned[a, b] * (body.reference[b] + body.mass_arm[b])


@kernel
def write_support_contact(
    s: Supports, i: int, body: Body, R: Array, t: Array, give: Array, position: Array, normal: Array, turn: Array,
    shift: Array,
) -> float:  # fmt: skip
    """The gap of the i-th contact of the environment, whose plane gives way by give (3,), world axes. Writes position
    (3,), normal (3,), and how they move, turn, shift (3, 6), as in `Touch`: a corner is a point of the object, and what
    is round rolls.
    """
    on, local, ends, spin = s.points[i].copy(), np.empty(3), np.empty((2, 3)), np.zeros(3)
    gap, rolls = float(s.offset[i]), s.rolls[i] != 0
    normal[:], turn[:], shift[:] = s.normals[i], 0.0, 0.0
    for a in range(3):
        local[a] = R[0, a] * normal[0] + R[1, a] * normal[1] + R[2, a] * normal[2]
    if rolls:
        rolls = rolling_point(body.kind, body.sizes, body.axes, body.origin, local, s.points[i], on)
    position[:] = transform_point(R, t, on)
    for a in range(3):
        gap += normal[a] * (position[a] - s.points[i, a] - give[a])
        b, c = (a + 1) % 3, (a + 2) % 3  # takes back that normals turn with the object
        turn[b, 3 + a], turn[c, 3 + a] = -normal[c], normal[b]
    if not rolls:
        return gap
    for a in range(3):
        for k in range(2):
            spin[a] = _ROLLING_STEP if k == 0 else -_ROLLING_STEP
            turned = product(rotation_matrix(spin), R)
            for e in range(3):
                local[e] = turned[0, e] * normal[0] + turned[1, e] * normal[1] + turned[2, e] * normal[2]
            rolling_point(body.kind, body.sizes, body.axes, body.origin, local, s.points[i], ends[k])
        spin[a] = 0.0
        for e in range(3):
            for b in range(3):
                shift[e, 3 + a] -= R[e, b] * (ends[0, b] - ends[1, b]) / (2.0 * _ROLLING_STEP)
    return gap


# ----------------------------------------------------------------
# What moved, from one configuration to another.


class Placed(NamedTuple):
    """What of contacts their slip depends on: positions (n, 3), frames (n, 3, 3); axes (n, 3, 3) and places (n, 3) of
    the fingertips; slips (n, 3), as in `Contacts`.
    """

    positions: Array
    frames: Array
    axes: Array
    places: Array
    slips: Array


@kernel
def placed_contacts(c: Contacts) -> Placed:
    """Those that `linearise` wrote."""
    return Placed(c.touch.positions, c.frames, c.axes, c.touch.places, c.slips)


@kernel
def slip_between(g: GeometryArrays, a: Placed, b: Placed, at: Place, to: Place, slip_memory: Array) -> Array:
    """(n, 3) how far the object has moved past the fingertips' surfaces from contacts a to b: along x and y [m], and
    turned about z [rad], less slip_memory (n, 3). at, to : their configurations.
    """
    if not g.poses.follows:
        return b.slips - a.slips - slip_memory
    A = MovingBodies(at.pose[:9].reshape(3, 3), at.pose[9:], a.axes, a.places)
    B = MovingBodies(to.pose[:9].reshape(3, 3), to.pose[9:], b.axes, b.places)
    slip = compute_slip(a.positions, a.frames, A, b.positions, b.frames, B, slip_memory)
    for i in range(len(slip)):
        slip[i, 2] -= to.turn[i] - at.turn[i]
    return slip


@kernel
def move_pose(s: Poses, pose: Array, twist: Array, centre: Array, out: Array) -> None:
    """Write the pose after a small motion (6,) about a point (3,)."""
    if s.follows:
        R, t = compose_motion(pose[:9].reshape(3, 3), pose[9:], twist, centre)
        out[:9], out[9:] = R.reshape(9), t
        return
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        arm, beside = s.reference[b] - centre[b], s.reference[c] - centre[c]
        out[a] = pose[a] + twist[a] + twist[3 + b] * beside - twist[3 + c] * arm
        out[3 + a] = pose[3 + a] + twist[3 + a]


@kernel
def pose_difference(s: Poses, a: Array, b: Array) -> Array:
    """(6,) of the object from pose a to pose b: of its reference point [m], and turned [rad], world axes."""
    if not s.follows:
        return b - a
    return motion_between(a[:9].reshape(3, 3), a[9:], b[:9].reshape(3, 3), b[9:], s.reference)


@kernel
def pose_displacement(s: Poses, pose: Array) -> Array:
    """(6,) motion of the object since the start: of its reference point [m], and the rotation vector [rad]."""
    if not s.follows:
        return pose.copy()
    return point_displacement(pose[:9].reshape(3, 3), pose[9:], s.reference)


@kernel
def place_between(s: Poses, a: Array, b: Array, share: float, out: Array) -> None:
    """Write the configuration at this share of the way from a to b, beyond b above 1."""
    for k in range(len(out)):
        out[k] = a[k] + share * (b[k] - a[k])
    if s.follows:
        p, q = a[len(a) - 12 :], b[len(b) - 12 :]
        R, t = extrapolate_motion(p[:9].reshape(3, 3), p[9:], q[:9].reshape(3, 3), q[9:], s.centre, share - 1.0)
        out[len(out) - 12 : len(out) - 3], out[len(out) - 3 :] = R.reshape(9), t
