"""The arithmetic of contacts that move, compiled: frames, Jacobian and flexibility anew, and what slipped."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.hand.robot.kinematics import contact_jacobian
from handlcp.lcp.kernels.dense import kernel, product

# ----------------------------------------------------------------
# Motions of a rigid object, compiled: x ↦ R x + t, world axes.


@kernel
def moved_on(R: Array, t: Array, twist: Array, about: Array) -> tuple[Array, Array]:
    """The motion (R, t) and then a small one, x ↦ c + v + exp(ω) (x - c), (v, ω) = twist (6,) about c (3,)."""
    turn = _rotation(twist[3:])
    arm = np.empty(3)
    for a in range(3):
        arm[a] = t[a] - about[a]
    at = transported(turn, about, arm)
    for a in range(3):
        at[a] += twist[a]
    return product(turn, R), at


@kernel
def motion_between(R0: Array, t0: Array, R1: Array, t1: Array, point: Array) -> Array:
    """(6,) from one motion to another: of a point (3,) of the object, and turned [rad]."""
    out, turn = np.empty(6), rotation_vector(turned_from(R0, R1))
    before, now = transported(R0, t0, point), transported(R1, t1, point)
    for a in range(3):
        out[a], out[3 + a] = now[a] - before[a], turn[a]
    return out


@kernel
def displaced(R: Array, t: Array, point: Array) -> Array:
    """(6,) the motion: of a point (3,) of the object, and its rotation vector."""
    out, turn, now = np.empty(6), rotation_vector(R), transported(R, t, point)
    for a in range(3):
        out[a], out[3 + a] = now[a] - point[a], turn[a]
    return out


@kernel
def turned_from(R0: Array, R1: Array) -> Array:
    """(3, 3) the rotation R1 R0ᵀ from one to another."""
    out = np.empty((3, 3))
    for a in range(3):
        for b in range(3):
            out[a, b] = R1[a, 0] * R0[b, 0] + R1[a, 1] * R0[b, 1] + R1[a, 2] * R0[b, 2]
    return out


@kernel
def gone_on(R0: Array, t0: Array, R1: Array, t1: Array, centre: Array, share: float) -> tuple[Array, Array]:
    """The motion that goes on from the first to the second by this share of the way between them."""
    R = product(_rotation(share * rotation_vector(turned_from(R0, R1))), R1)
    c0, c1 = transported(R0, t0, centre), transported(R1, t1, centre)
    return R, c1 + share * (c1 - c0) - transported(R, np.zeros(3), centre)


@kernel
def transported(R: Array, t: Array, point: Array) -> Array:
    """(3,) R x + t."""
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
def _rotation(omega: Array) -> Array:
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


class Bodies(NamedTuple):
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
def contacts_at(
    J: Array, support: Array, coupling: Array, pads: Array, around: Array, turns: Array, positions: Array, old: Array,
    normals: Array, frames: Array, P: Array, every: Array, turning: Array,
) -> None:  # fmt: skip
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
def slip_between(at: Array, old: Array, A: Bodies, to: Array, new: Array, B: Bodies, slip_memory: Array) -> Array:
    """(n, 3) how far the object has moved past the fingertips' surfaces, along x and y [m] and turned about z [rad],
    from contacts `at` (n, 3) with frames `old` (n, 3, 3) to contacts `to` with frames `new`.

    The mean of two: the points that touch at first, where they are in the end; and the points that touch in the end,
    where they were at first. From B to A it is the opposite, so that a path and its reverse cancel. slip_memory (n, 3)
    : is taken off.
    """
    n, out, moved, R = len(at), -slip_memory, np.empty(3), turned_from(A.R, B.R)
    t, omega = np.empty(3), rotation_vector(R)
    for b in range(3):
        t[b] = B.t[b] - R[b, 0] * A.t[0] - R[b, 1] * A.t[1] - R[b, 2] * A.t[2]
    for i in range(n):
        Q, p, q = turned_from(A.turns[i], B.turns[i]), A.places[i], B.places[i]
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
