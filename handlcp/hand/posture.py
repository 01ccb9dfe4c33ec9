"""From a posture's Jacobian to the flexibility at the contacts, compiled."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel

__all__ = ["contact_jacobian", "flexibility", "flexibility_through"]


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


@kernel
def flexibility(J: Array, L: Array, pads: Array, E: Array) -> None:
    """E ← J K⁻¹ Jᵀ + pads, J (3n, nv), K = L Lᵀ (L lower, inf on the diagonal of a rigid joint), pads (n, 3, 3) in
    contact axes: with B = J L⁻ᵀ by substitution, J K⁻¹ Jᵀ = B Bᵀ, symmetric to the last bit.
    """
    rows, nv = J.shape
    B = np.empty((rows, nv))
    for j in range(nv):
        for i in range(rows):
            total = J[i, j]
            for k in range(j):
                if L[j, k] != 0.0:
                    total -= B[i, k] * L[j, k]
            B[i, j] = total / L[j, j]
    _add(B, pads, E)


@kernel
def flexibility_through(J: Array, A: Array, pads: Array, E: Array) -> None:
    """E ← J C Jᵀ + pads where C = A Aᵀ may be singular, A (nv, m): with B = J A, again B Bᵀ."""
    _add(np.dot(J, A), pads, E)


@kernel
def _add(B: Array, pads: Array, E: Array) -> None:
    """E ← B Bᵀ + pads."""
    rows, inner = B.shape
    for i in range(rows):
        for j in range(i + 1):
            total = 0.0
            for k in range(inner):
                total += B[i, k] * B[j, k]
            E[i, j] = E[j, i] = total
    for f in range(len(pads)):
        for a in range(3):
            for b in range(3):
                E[3 * f + a, 3 * f + b] += pads[f, a, b]
