"""`evaluate_ball_contacts`: contacts that move, compiled: frames, Jacobian and flexibility anew, and slip."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from handlcp.check import Array
from handlcp.geometry.contact_detection import nearest_station, write_corner_contact, write_station_motion
from handlcp.geometry.contact_tracker import ContactArrays, ContactTracker
from handlcp.geometry.object import Object, closest_on_surface, write_contact
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.newton.tangent import skew
from handlcp.lcp.kernels.dense import kernel, product
from handlcp.robot.fingertip import TipShape
from handlcp.robot.kinematics import contact_jacobian

# ----------------------------------------------------------------
# Motions of a rigid object, compiled: x ↦ R x + t, world axes.


@kernel
def compose_motion(R: Array, t: Array, twist: Array, about: Array) -> tuple[Array, Array]:
    """The motion (R, t) and then a small one, x ↦ c + v + exp(ω) (x - c), (v, ω) = twist (6,) about c (3,)."""
    turn = _rotation_matrix(twist[3:])
    arm = np.empty(3)
    for a in range(3):
        arm[a] = t[a] - about[a]
    at = transform_point(turn, about, arm)
    for a in range(3):
        at[a] += twist[a]
    return product(turn, R), at


@kernel
def motion_between(R0: Array, t0: Array, R1: Array, t1: Array, point: Array) -> Array:
    """(6,) from one motion to another: of a point (3,) of the object, and turned [rad]."""
    out, turn = np.empty(6), rotation_vector(relative_rotation(R0, R1))
    before, now = transform_point(R0, t0, point), transform_point(R1, t1, point)
    for a in range(3):
        out[a], out[3 + a] = now[a] - before[a], turn[a]
    return out


@kernel
def point_displacement(R: Array, t: Array, point: Array) -> Array:
    """The motion (6,) of a point (3,) of the object, and its rotation vector."""
    out, turn, now = np.empty(6), rotation_vector(R), transform_point(R, t, point)
    for a in range(3):
        out[a], out[3 + a] = now[a] - point[a], turn[a]
    return out


@kernel
def relative_rotation(R0: Array, R1: Array) -> Array:
    """(3, 3) the rotation R1 R0ᵀ from one to another."""
    out = np.empty((3, 3))
    for a in range(3):
        for b in range(3):
            out[a, b] = R1[a, 0] * R0[b, 0] + R1[a, 1] * R0[b, 1] + R1[a, 2] * R0[b, 2]
    return out


@kernel
def extrapolate_motion(R0: Array, t0: Array, R1: Array, t1: Array, centre: Array, share: float) -> tuple[Array, Array]:
    """The motion that goes on from the first to the second by this share of the way between them."""
    R = product(_rotation_matrix(share * rotation_vector(relative_rotation(R0, R1))), R1)
    c0, c1 = transform_point(R0, t0, centre), transform_point(R1, t1, centre)
    return R, c1 + share * (c1 - c0) - transform_point(R, np.zeros(3), centre)


@kernel
def transform_point(R: Array, t: Array, point: Array) -> Array:
    """A point x moved with the object, R x + t (3,)."""
    out = np.empty(3)
    for a in range(3):
        out[a] = t[a] + R[a, 0] * point[0] + R[a, 1] * point[1] + R[a, 2] * point[2]
    return out


@kernel
def rotation_vector(R: Array) -> Array:
    """(3,) of a rotation by less than half a turn."""
    out = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = 0.5 * np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    angle = np.arctan2(sine, 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0))
    share = 0.5 if sine < 1e-8 else 0.5 * angle / sine
    for a in range(3):
        out[a] *= share
    return out


@kernel
def _rotation_matrix(omega: Array) -> Array:
    """(3, 3) of a rotation vector (3,): Rodrigues' formula."""
    square = omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2
    angle = np.sqrt(square)
    a, b = 1.0, 0.5
    if angle > 1e-4:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / square
    out = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            out[i, j] = b * omega[i] * omega[j]
        out[i, i] += 1.0 - b * square
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[j, k] -= a * omega[i]
        out[k, j] += a * omega[i]
    return out


# ----------------------------------------------------------------


class MovingBodies(NamedTuple):
    """R (3, 3), t (3,) of the object's motion x ↦ R x + t since the start; turns (n, 3, 3) and places (n, 3) of the
    fingertips as their pads are deformed. What belongs to the environment does not turn.
    """

    R: Array
    t: Array
    turns: Array
    places: Array


@kernel
def turn_frames(old: Array, normals: Array, out: Array) -> None:
    """Write frames `old` (n, 3, 3), turned by the smallest rotations that take their z axes to these normals (n, 3)."""
    for i in range(len(old)):
        x, y, z = old[i, 0, 2], old[i, 1, 2], old[i, 2, 2]
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
        cosine = x * a + y * b + z * c
        if cosine < -0.99:  # turned over: any axis would do
            p, q, r, cosine = 0.0, 0.0, 0.0, 1.0
        for k in range(2):
            u, v, w = old[i, 0, k], old[i, 1, k], old[i, 2, k]
            e, f, g = q * w - r * v, r * u - p * w, p * v - q * u
            out[i, 0, k] = u + e + (q * g - r * f) / (1.0 + cosine)
            out[i, 1, k] = v + f + (r * e - p * g) / (1.0 + cosine)
            out[i, 2, k] = w + g + (p * f - q * e) / (1.0 + cosine)
        out[i, 0, 2], out[i, 1, 2], out[i, 2, 2] = a, b, c


@kernel
def write_contact_arrays(
    J: Array,
    support: Array,
    coupling: Array,
    pads: Array,
    around: Array,
    turns: Array,
    positions: Array,
    old: Array,
    normals: Array,
    frames: Array,
    P: Array,
    every: Array,
    turning: Array,
) -> None:
    """Write frames (n, 3, 3), `old` ones turned to these normals (n, 3), and in their axes P (3n, 3n), the flexibility
    of pads and environment, `every` (3n, nv), the Jacobian, and the turning (n, nv) of fingertips about the normals.

    J (joints, 6), support (k, joints), coupling : as in `contact_jacobian`, of k fingers. pads (k, 3, 3) : their
    flexibility in tip axes; turns (n, 3, 3) : of those axes. around : flexibility of the environment, (3(n-k), 3(n-k)).
    """
    k, joints = support.shape
    turn_frames(old, normals, frames)
    turned, A, m = np.zeros((k, joints)), np.empty((3, 3)), 3 * k
    P[:], every[:], turning[:] = 0.0, 0.0, 0.0
    for i in range(k):
        for a in range(3):
            for b in range(3):
                A[a, b] = 0.0
                for c in range(3):
                    A[a, b] += frames[i, c, a] * turns[i, c, b]
        for a in range(3):
            for b in range(a + 1):
                total = 0.0
                for c in range(3):
                    for d in range(3):
                        total += A[a, c] * pads[i, c, d] * A[b, d]
                P[3 * i + a, 3 * i + b] = P[3 * i + b, 3 * i + a] = total
        for j in range(joints):
            if support[i, j] != 0.0:
                for a in range(3):
                    turned[i, j] += frames[i, a, 2] * J[j, 3 + a]
    fingers = contact_jacobian(J, support, coupling, positions[:k], frames[:k])
    if len(coupling) > 0:
        turned = product(turned, coupling)
    P[m:, m:] = around
    every[:m] = fingers
    turning[:k] = turned


@kernel
def compute_slip(
    at: Array, old: Array, A: MovingBodies, to: Array, new: Array, B: MovingBodies, slip_memory: Array
) -> Array:
    """(n, 3) how far the object has moved past the fingertips' surfaces, along x and y [m] and turned about z [rad],
    from contacts `at` (n, 3) with frames `old` (n, 3, 3) to contacts `to` with frames `new`.

    The mean of two: the points that touch at first, where they are in the end; and the points that touch in the end,
    where they were at first. From B to A it is the opposite, so that a path and its reverse cancel. slip_memory (n, 3)
    : is taken off.
    """
    n, out, moved, R = len(at), -slip_memory, np.empty(3), relative_rotation(A.R, B.R)
    t, omega = np.empty(3), rotation_vector(R)
    for b in range(3):
        t[b] = B.t[b] - R[b, 0] * A.t[0] - R[b, 1] * A.t[1] - R[b, 2] * A.t[2]
    for i in range(n):
        Q, p, q = relative_rotation(A.turns[i], B.turns[i]), A.places[i], B.places[i]
        spun = rotation_vector(Q)
        for b in range(3):
            moved[b] = t[b] - q[b] + p[b]
            for a in range(3):  # the points of the object, ahead and back, less those of the fingertip
                moved[b] += R[b, a] * at[i, a] - Q[b, a] * (at[i, a] - p[a])
                moved[b] += Q[a, b] * (to[i, a] - q[a]) - R[a, b] * (to[i, a] - t[a])
        for b in range(3):
            for a in range(2):
                out[i, a] += 0.25 * (old[i, b, a] + new[i, b, a]) * moved[b]
            out[i, 2] += 0.5 * (old[i, b, 2] + new[i, b, 2]) * (omega[b] - spun[b])
    return out


# ----------------------------------------------------------------
# Balls on surfaces that are known in closed form, compiled: contacts, and how they turn and shift as balls move.

_NO_CORNER = np.full(3, np.nan)
_NORMAL_STEP = 1e-6  # of the object's size: central differences of normals, good to ten digits


@kernel
def evaluate_ball_contacts(
    placements: Array,
    columns: Array,
    support: Array,
    coupling: Array,
    pads: Array,
    around: Array,
    kind: int,
    sizes: Array,
    own: Array,
    at: Array,
    swept: SweptTips,
    R: Array,
    t: Array,
    give: Array,
    old: Array,
    places: Array,
    turns: Array,
    positions: Array,
    normals: Array,
    gaps: Array,
    turn: Array,
    shift: Array,
    frames: Array,
    P: Array,
    J: Array,
    turning: Array,
) -> None:
    """Write all that an iterate knows of contacts that are swept balls of fingers alone: see `write_ball_contacts`,
    `write_contact_arrays`.

    placements (k, 4, 4) : of the fingertips, give (k, 3) : of their pads. The object has moved by x ↦ R x + t; own
    (3, 3), at (3,) : its shape's axes and frame before.
    """
    p = np.empty(3)
    for a in range(3):
        p[a] = t[a] + R[a, 0] * at[0] + R[a, 1] * at[1] + R[a, 2] * at[2]
    for i in range(len(swept.radii)):
        for a in range(3):
            places[i, a] = placements[i, a, 3] + give[i, a]
            for b in range(3):
                turns[i, a, b] = placements[i, a, b]
    write_ball_contacts(kind, sizes, product(R, own), p, places, turns, swept, positions, normals, gaps, turn, shift)
    write_contact_arrays(
        columns, support, coupling, pads, around, turns, positions, old, normals, frames, P, J, turning
    )


class SweptTips(NamedTuple):
    """Swept balls in tip axes (`SweptBall`): beside (k, 3) their middles, spans (k, 2, 3), radii (k,) [m]. corners (k,
    3) : of the object, in the axes of its shape, which stand on them; NaN: what is nearest touches.
    """

    middles: Array
    spans: Array
    radii: Array
    corners: Array


@kernel
def write_ball_contacts(
    kind: int,
    sizes: Array,
    R: Array,
    p: Array,
    places: Array,
    turns: Array,
    swept: SweptTips,
    positions: Array,
    normals: Array,
    gaps: Array,
    turn: Array,
    shift: Array,
) -> None:
    """Write the contacts of k swept balls with a shape of this kind and sizes (3,), whose axes are the columns of R and
    whose frame is at p: positions, normals, gaps, turn, shift as in `Touch`.

    places (n, 3), turns (n, 3, 3) : of the fingertips.
    """
    arm, c, out, step = np.empty(3), np.empty(3), np.empty(3), _NORMAL_STEP * sizes.max()
    H, N, moves = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 6))
    spans, own, at = np.empty((2, 3)), np.empty((2, 3)), np.zeros(2)
    for i in range(len(swept.radii)):
        if swept.corners[i, 0] == swept.corners[i, 0]:
            rotate_vector(R, swept.corners[i], c)
            positions[i] = p + c
            gaps[i] = write_corner_contact(
                positions[i],
                places[i],
                turns[i],
                swept.middles[i],
                swept.spans[i],
                swept.radii[i],
                normals[i],
                turn[i],
                shift[i],
            )
            continue
        rotate_vector(turns[i], swept.middles[i], arm)
        for a in range(3):
            c[a] = 0.0
            for b in range(3):
                c[a] += R[b, a] * (places[i, b] + arm[b] - p[b])
        line = False
        for k in range(2):
            rotate_vector(turns[i], swept.spans[i, k], spans[k])
            for a in range(3):
                line = line or swept.spans[i, k, a] != 0.0
                own[k, a] = R[0, a] * spans[k, 0] + R[1, a] * spans[k, 1] + R[2, a] * spans[k, 2]
        if line:
            c = nearest_station(kind, sizes, c, own, at)
            for a in range(3):
                arm[a] += at[0] * spans[0, a] + at[1] * spans[1, a]
        distance, x, out = closest_on_surface(kind, sizes, c)
        for a in range(3):
            kept = c[a]
            c[a] = kept + step
            _, _, ahead = closest_on_surface(kind, sizes, c)
            c[a] = kept - step
            _, _, back = closest_on_surface(kind, sizes, c)
            c[a] = kept
            for b in range(3):
                H[b, a] = -(ahead[b] - back[b]) / (2.0 * step)
        for a in range(3):
            for b in range(3):
                N[a, b] = 0.0
                for e in range(3):
                    if H[e, 0] != 0.0 or H[e, 1] != 0.0 or H[e, 2] != 0.0:
                        N[a, b] += R[a, e] * (H[e, 0] * R[b, 0] + H[e, 1] * R[b, 1] + H[e, 2] * R[b, 2])
        gaps[i] = distance - swept.radii[i]
        write_contact(R, p, x, out, positions[i], normals[i])
        if line:
            write_station_motion(N, normals[i], spans, at, arm, sizes.max(), moves)
            write_carried_contact(turn[i], shift[i], N, normals[i], distance, moves)
        else:
            write_following_contact(turn[i], shift[i], N, normals[i], distance, arm)


@kernel
def rotate_vector(R: Array, x: Array, out: Array) -> None:
    """Write a vector turned with the object, R x (3,), into `out`."""
    for a in range(3):
        out[a] = R[a, 0] * x[0] + R[a, 1] * x[1] + R[a, 2] * x[2]


@kernel
def write_carried_contact(turn: Array, shift: Array, N: Array, normal: Array, distance: float, moves: Array) -> None:
    """Write turn, shift (3, 6) as `write_following_contact`, of a point whose motion is moves (3, 6)."""
    for a in range(3):
        for j in range(6):
            turn[a, j] = shift[a, j] = 0.0
            for b in range(3):
                turn[a, j] += N[a, b] * moves[b, j]
                shift[a, j] += (distance * N[a, b] - normal[a] * normal[b]) * moves[b, j]
            shift[a, j] += moves[a, j]


@kernel
def write_following_contact(turn: Array, shift: Array, N: Array, normal: Array, distance: float, arm: Array) -> None:
    """Write turn, shift (3, 6) of a contact that follows a point of the fingertip, `arm` (3,) away from its place:
    N (3, 3) turns the normal by the point's motion, and with d the point's distance the contact at x = p + d n moves by
    (1 - n nᵀ + d N).
    """
    for a in range(3):
        for b in range(3):
            turn[a, b] = N[a, b]
            shift[a, b] = distance * N[a, b] - normal[a] * normal[b]
        shift[a, a] += 1.0
    for a in range(3):  # the point moves by v + ω × arm
        for rows in (turn, shift):
            x, y, z = rows[a, 0], rows[a, 1], rows[a, 2]
            rows[a, 3] = arm[1] * z - arm[2] * y
            rows[a, 4] = arm[2] * x - arm[0] * z
            rows[a, 5] = arm[0] * y - arm[1] * x


# ----------------------------------------------------------------
# How a hand's fingertips find their contacts while the object moves, and how these contacts turn: in compiled code for
# balls on primitives, by detection for other shapes, on planes for contacts that were given without an object.


class ContactFinder(Protocol):
    """Contacts of the first k of n fingertips. noise : of what is found, as a share of the object's size."""

    noise: float

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Fingertips stand at places (n, 3) with rotations turns (n, 3, 3); the object has moved by x ↦ R x + t. Writes
        the first k rows of positions (n, 3), normals (n, 3), gaps (n,), and of turn, shift (n, 3, 6) as `Touch` has
        them.
        """


def make_contact_finder(spec: GraspSpec, mechanism: Any) -> ContactFinder:
    """For the k fingers of a grasp. mechanism : its `HandMechanism`."""
    obj, hand = mechanism.target, mechanism.posture.hand
    if obj is None:
        return _GivenContactFinder(spec, mechanism)
    shapes = [hand.tip_shapes(i) for i in mechanism.tips]
    if obj.known is not None and all(len(s) == 1 and s[0].swept_ball is not None for s in shapes):
        return SweptBallFinder(obj, [s[0] for s in shapes])
    return ContactTracker(obj, shapes)


class SweptBallFinder:
    """Fingertips that are swept balls, on an object whose surface is known in closed form."""

    noise = 0.0

    def __init__(self, obj: Object, tips: list[TipShape]) -> None:
        assert obj.known is not None  # `make_contact_finder` saw to it
        self.kind, self.sizes = obj.known[0], np.array(obj.known[1], dtype=float)
        self.own, self.at = np.ascontiguousarray(obj.placement.rotation), obj.placement.translation.copy()
        every = [tip.swept_ball for tip in tips]
        beside, spans, radii = (np.array([one[k] for one in every if one is not None], dtype=float) for k in range(3))
        corners = np.array([_NO_CORNER if tip.corner is None else tip.corner for tip in tips])
        self.swept = SweptTips(beside, spans, radii, corners)

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Find the contacts in these places, as `ContactFinder` documents."""
        write_ball_contacts(self.kind, self.sizes, R @ self.own, R @ self.at + t, places, turns, self.swept, *out)


class _GivenContactFinder:
    """Points of the fingertips, on planes of the object. What a preload puts between point and plane lies half along
    the fingertip's axis, half along the normal: it grows as the fingertip turns, and neither slides nor rolls then.
    """

    noise = 0.0

    def __init__(self, spec: GraspSpec, mechanism: Any) -> None:
        k, tips, first = len(mechanism.tips), list(mechanism.tips), mechanism.posture
        turned = first.tip_rotations[tips]
        self.points = np.einsum("nji,nj->ni", turned, spec.positions[:k] - first.tip_positions[tips])
        self.planes, self.out = spec.positions[:k].copy(), spec.frames[:k, :, 2].copy()
        self.along = np.einsum("nji,nj->ni", turned, self.out)  # of fingertips, in their axes

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Find the contacts in these places, as `ContactFinder` documents."""
        positions, normals, gaps, turn, shift = out
        k = len(self.points)
        arms, along = (np.einsum("nij,nj->ni", turns[:k], own) for own in (self.points, self.along))
        normals[:k] = self.out @ R.T
        gaps[:k] = (normals[:k] * (self.planes @ R.T + t - places[:k] - arms)).sum(axis=1)
        half = along + normals[:k]
        size = gaps[:k] / (normals[:k] * half).sum(axis=1)
        positions[:k], turn[:k] = places[:k] + arms + size[:, None] * half, 0.0
        for i in range(k):
            shift[i, :, :3] = np.eye(3) - np.outer(half[i] / (normals[i] @ half[i]), normals[i])
            shift[i, :, 3:] = -shift[i, :, :3] @ skew(arms[i] + size[i] * along[i])
