"""`write_ball_contacts`: contacts that move, compiled: places, frames, Jacobian and flexibility, and slip."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.contact.closest_point import (
    closest_on_surface,
    nearest_station,
    write_contact,
    write_corner_contact,
    write_station_motion,
)
from handlcp.kinematics.joint_tree import contact_jacobian
from handlcp.kinematics.rigid_motion import relative_rotation, rotate_vector, rotation_vector, transform_point
from handlcp.lcp.kernels.dense import kernel, product


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
# Balls on surfaces that are known in closed form: contacts, and how they turn and shift as balls move.

_NORMAL_STEP = 1e-6  # of the object's size: central differences of normals, good to ten digits


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
# Contacts that were given without an object.


class GivenTips(NamedTuple):
    """Points of fingertips, on planes of the object. points (k, 3), along (k, 3) : in tip axes, the point and the
    contact's normal. planes (k, 3), out (k, 3) : a point of each plane and its normal at the start, world axes.
    """

    points: Array
    along: Array
    planes: Array
    out: Array


@kernel
def write_given_contacts(
    tips: GivenTips,
    R: Array,
    t: Array,
    places: Array,
    turns: Array,
    positions: Array,
    normals: Array,
    gaps: Array,
    turn: Array,
    shift: Array,
) -> None:
    """Write the contacts of k points of fingertips with planes of the object, which has moved by x ↦ R x + t.

    places (n, 3), turns (n, 3, 3) : of the fingertips. What a preload puts between point and plane lies half along the
    fingertip's axis, half along the normal: it grows as the fingertip turns, and neither slides nor rolls then.
    """
    arm, along, half, plane, zero = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.zeros(3)
    for i in range(len(tips.points)):
        rotate_vector(turns[i], tips.points[i], arm)
        rotate_vector(turns[i], tips.along[i], along)
        rotate_vector(R, tips.planes[i], plane)
        normals[i] = transform_point(R, zero, tips.out[i])
        gap, across = 0.0, 0.0
        for a in range(3):
            gap += normals[i, a] * (plane[a] + t[a] - places[i, a] - arm[a])
            half[a] = along[a] + normals[i, a]
            across += normals[i, a] * half[a]
        gaps[i], turn[i] = gap, 0.0
        size = gap / across
        for a in range(3):
            positions[i, a] = places[i, a] + arm[a] + size * half[a]
            arm[a] += size * along[a]
            for b in range(3):
                shift[i, a, b] = (1.0 if a == b else 0.0) - half[a] * normals[i, b] / across
        for a in range(3):
            x, y, z = shift[i, a, 0], shift[i, a, 1], shift[i, a, 2]
            shift[i, a, 3] = arm[1] * z - arm[2] * y
            shift[i, a, 4] = arm[2] * x - arm[0] * z
            shift[i, a, 5] = arm[0] * y - arm[1] * x
