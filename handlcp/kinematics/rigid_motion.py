"""Motions of a rigid body, compiled: x ↦ R x + t, world axes."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel, product

_HALF_TURN_TRACE = -0.9  # trace of a rotation by almost half a turn, whose axis takes more care


@kernel
def compose_motion(R: Array, t: Array, twist: Array, about: Array) -> tuple[Array, Array]:
    """The motion (R, t) and then a small one, x ↦ c + v + exp(ω) (x - c), (v, ω) = twist (6,) about c (3,)."""
    turn = rotation_matrix(twist[3:])
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
def extrapolate_motion(R0: Array, t0: Array, R1: Array, t1: Array, centre: Array, share: float) -> tuple[Array, Array]:
    """The motion that goes on from the first to the second by this share of the way between them."""
    R = product(rotation_matrix(share * rotation_vector(relative_rotation(R0, R1))), R1)
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
def rotate_vector(R: Array, x: Array, out: Array) -> None:
    """Write a vector turned with the object, R x (3,), into `out`."""
    for a in range(3):
        out[a] = R[a, 0] * x[0] + R[a, 1] * x[1] + R[a, 2] * x[2]


@kernel
def relative_rotation(R0: Array, R1: Array) -> Array:
    """(3, 3) the rotation R1 R0ᵀ from one to another."""
    out = np.empty((3, 3))
    for a in range(3):
        for b in range(3):
            out[a, b] = R1[a, 0] * R0[b, 0] + R1[a, 1] * R0[b, 1] + R1[a, 2] * R0[b, 2]
    return out


@kernel
def rotation_vector(R: Array) -> Array:
    """(3,) of a rotation by at most half a turn."""
    out = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    if trace < _HALF_TURN_TRACE:
        return _large_rotation_vector(R, trace, out)
    sine = 0.5 * np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    angle = np.arctan2(sine, 0.5 * (trace - 1.0))
    share = 0.5 if sine < 1e-8 else 0.5 * angle / sine
    for a in range(3):
        out[a] *= share
    return out


@kernel
def _large_rotation_vector(R: Array, trace: float, skewed: Array) -> Array:
    """(3,) of a rotation by almost half a turn, from its quaternion; skewed (3,) : of R - Rᵀ."""
    a = 0
    for b in range(1, 3):
        if R[b, b] > R[a, a]:
            a = b
    out, largest = np.empty(3), 0.5 * np.sqrt(max(1.0 + 2.0 * R[a, a] - trace, 0.0))
    for b in range(3):
        out[b] = largest if b == a else 0.25 * (R[a, b] + R[b, a]) / largest
    cosine = 0.25 * skewed[a] / largest
    sine = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    share = 2.0 * np.arctan2(sine, abs(cosine)) / sine
    if cosine < 0.0:
        share = -share
    for b in range(3):
        out[b] *= share
    return out


@kernel
def rotation_matrix(omega: Array) -> Array:
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
