"""The Jacobian at the contacts of a posture, compiled: what a stream computes for each new posture."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel


@kernel
def contact_jacobian(J: Array, support: Array, coupling: Array, positions: Array, frames: Array) -> Array:
    """(3n, nv) velocity of the contact points in contact axes: Rᵀ (v + ω × p), joint by joint.

    J (joints, 6) : rows of the world Jacobian, linear part (of the world's origin) first. support (n, joints) : 1 where
    a joint moves a finger. coupling (joints, nv) : of the independent joints; empty where they are all of them.
    positions (n, 3), frames (n, 3, 3) : of the contacts.
    """
    n, joints = support.shape
    full = np.zeros((3 * n, joints))
    v = np.empty(3)
    for i in range(n):
        x, y, z = positions[i, 0], positions[i, 1], positions[i, 2]
        for j in range(joints):
            if support[i, j] != 0.0:
                v[0] = J[j, 0] + J[j, 4] * z - J[j, 5] * y
                v[1] = J[j, 1] + J[j, 5] * x - J[j, 3] * z
                v[2] = J[j, 2] + J[j, 3] * y - J[j, 4] * x
                for k in range(3):
                    full[3 * i + k, j] = frames[i, 0, k] * v[0] + frames[i, 1, k] * v[1] + frames[i, 2, k] * v[2]
    return full if len(coupling) == 0 else np.dot(full, coupling)
