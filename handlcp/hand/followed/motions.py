"""Motions of a rigid object, compiled: x ↦ R x + t, world axes."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel

__all__ = ["gone_on", "moved_on", "rotation_vector", "transported"]


@kernel
def moved_on(
    R: Array, t: Array, twist: Array, about: Array, R0: Array, t0: Array, centre: Array
) -> tuple[Array, Array, float, float]:
    """The motion (R, t) and then a small one, x ↦ c + v + exp(ω) (x - c), (v, ω) = twist (6,) about c (3,): its R and
    t; and how far its object with this centre (3,) is from the motion (R0, t0): moved [m], and turned [rad, nearly].
    """
    turn = _rotation(twist[3:])
    arm = np.empty(3)
    for a in range(3):
        arm[a] = t[a] - about[a]
    new = np.dot(turn, R)
    at = transported(turn, about, arm)
    moved, turned = 0.0, 0.0
    for a in range(3):
        at[a] += twist[a]
        step = at[a] - t0[a]
        for b in range(3):
            step += (new[a, b] - R0[a, b]) * centre[b]
            turned += (new[a, b] - R0[a, b]) ** 2
        moved += step**2
    return new, at, np.sqrt(moved), np.sqrt(0.5 * turned)


@kernel
def gone_on(R0: Array, t0: Array, R1: Array, t1: Array, centre: Array, share: float) -> tuple[Array, Array]:
    """The motion that goes on from the first to the second by this share of the way between them."""
    R = np.dot(_rotation(share * rotation_vector(np.dot(R1, np.ascontiguousarray(R0.T)))), R1)
    c0, c1 = transported(R0, t0, centre), transported(R1, t1, centre)
    return R, c1 + share * (c1 - c0) - np.dot(R, centre)


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
