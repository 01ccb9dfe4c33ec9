"""The arithmetic of contacts that move, compiled: frames, Jacobian and flexibility anew, and what slipped."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.hand.elasticity.pads import tip_flexibility
from handlcp.hand.followed.motions import rotation_vector, transported
from handlcp.hand.robot.contact_jacobian import contact_jacobian
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Bodies", "contacts_at", "slip_between"]


class Bodies(NamedTuple):
    """R (3, 3), t (3,) of the object's motion x ↦ R x + t since the start; turns (n, 3, 3) and places (n, 3) of the
    fingertips as their pads are deformed. What belongs to the environment does not turn.
    """

    R: Array
    t: Array
    turns: Array
    places: Array


@kernel
def turned_frames(old: Array, normals: Array) -> Array:
    """(n, 3, 3) frames `old`, turned by the smallest rotations that take their z axes to these normals (n, 3)."""
    out = np.empty_like(old)
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
    return out


@kernel
def contacts_at(
    J: Array, support: Array, coupling: Array, root: Array, pads: Array, around: Array, turns: Array, positions: Array,
    old: Array, normals: Array,
) -> tuple[Array, Array, Array, Array]:  # fmt: skip
    """Frames (n, 3, 3), `old` ones turned to these normals (n, 3), and in their axes E (3n, 3n), J (3n, nv) and the
    turning (n, nv) of fingertips about the normals.

    J (joints, 6), support (k, joints), coupling : as in `contact_jacobian`, of k fingers. pads (k, 3, 3) : their
    flexibility in tip axes; turns (n, 3, 3) : of those axes. around : flexibility of the environment, (3(n-k), 3(n-k)).
    """
    k, n, joints = len(support), len(positions), support.shape[1]
    frames = turned_frames(old, normals)
    own, turned, A = np.zeros((k, 3, 3)), np.zeros((k, joints)), np.empty((3, 3))
    for i in range(k):
        for a in range(3):
            for b in range(3):
                A[a, b] = 0.0
                for c in range(3):
                    A[a, b] += frames[i, c, a] * turns[i, c, b]
        for a in range(3):
            for b in range(a + 1):
                for c in range(3):
                    for d in range(3):
                        own[i, a, b] += A[a, c] * pads[i, c, d] * A[b, d]
                own[i, b, a] = own[i, a, b]
        for j in range(joints):
            if support[i, j] != 0.0:
                for a in range(3):
                    turned[i, j] += frames[i, a, 2] * J[j, 3 + a]
    fingers = contact_jacobian(J, support, coupling, positions[:k], frames[:k])
    if len(coupling) > 0:
        turned = np.dot(turned, coupling)
    nv, m = fingers.shape[1], 3 * k
    E, every, turning = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, nv)), np.zeros((n, nv))
    E[:m, :m] = tip_flexibility(fingers, root, own)
    E[m:, m:] = around
    every[:m] = fingers
    turning[:k] = turned
    return frames, E, every, turning


@kernel
def slip_between(at: Array, old: Array, A: Bodies, to: Array, new: Array, B: Bodies, carry: Array) -> Array:
    """(n, 3) how far the object has moved past the fingertips' surfaces, along x and y [m] and turned about z [rad],
    from contacts `at` (n, 3) with frames `old` (n, 3, 3) to contacts `to` with frames `new`.

    The mean of two: the points that touch at first, where they are in the end; and the points that touch in the end,
    where they were at first. From B to A it is the opposite, so that a path and its reverse cancel. carry (n, 3) : is
    taken off.
    """
    n, out = len(at), -carry
    R = np.dot(B.R, np.ascontiguousarray(A.R.T))
    t = B.t - transported(R, np.zeros(3), A.t)
    omega = rotation_vector(R)
    none = np.zeros(3)
    for i in range(n):
        Q = np.dot(np.ascontiguousarray(B.turns[i]), np.ascontiguousarray(A.turns[i].T))
        ahead = transported(R, t, at[i])
        back = transported(np.ascontiguousarray(R.T), none, to[i] - t)
        tip_ahead = transported(Q, B.places[i], at[i] - A.places[i])
        tip_back = transported(np.ascontiguousarray(Q.T), A.places[i], to[i] - B.places[i])
        moved = 0.5 * (ahead - tip_ahead + tip_back - back)
        spun = omega - rotation_vector(Q)
        for b in range(3):
            for a in range(2):
                out[i, a] += 0.5 * (old[i, b, a] + new[i, b, a]) * moved[b]
            out[i, 2] += 0.5 * (old[i, b, 2] + new[i, b, 2]) * spun[b]
    return out
