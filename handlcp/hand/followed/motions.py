"""Motions of a rigid object, compiled: x ↦ R x + t, world axes."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel, product


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
