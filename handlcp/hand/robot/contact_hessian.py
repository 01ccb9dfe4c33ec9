"""How the Jacobian of contact points changes with the joints.

    ∂J_j/∂q_i = ω_i × J_j  where joint i carries joint j or is it,  J_j = v_j + ω_j × p;  symmetric in i and j

J_j is the motion of a point p of the finger under joint j; turning joint i turns all of it, point, axis and motion. A
slide (ω_i = 0) turns nothing. The columns (v_j; ω_j) are Pinocchio's, in the world frame: a joint is carried by those
of its finger with smaller numbers. Mimic joints q_full = C q + offset give Cᵀ (…) C. Source: Featherstone, Rigid Body
Dynamics Algorithms (2008), chapter 2, derivatives of vectors that move with a body.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp.check import Array
from handlcp.hand.robot.posture import Posture


def contact_hessian(state: Posture, tips: Sequence[int], positions: Array, frames: Array) -> Array:
    """(3n, nv, nv) ∂J/∂q [m/rad²] of points (n, 3) [m] on the tips numbered `tips`, in frames (n, 3, 3) that stay."""
    hand = state.hand
    _, columns = hand.kinematics.frames_at(state.q, ())
    v, w = columns[:3].T, columns[3:].T  # (joints, 3)
    motion = (v + np.cross(w, positions[:, None])) * hand.tips.support[list(tips)].transpose(0, 2, 1)
    first, last = np.triu_indices(len(w))  # pairs of which the first, on one finger, carries the last
    turned = np.cross(w[first], motion[:, last]) * hand.tips.support[list(tips), 0][:, first, None]
    world = np.zeros((len(positions), len(w), len(w), 3))
    world[:, first, last] = world[:, last, first] = turned
    H = np.einsum("nxc,njkx->ncjk", frames, world)
    C = hand.kinematics.coupling
    if C is not None:
        H = C.T @ H @ C
    return np.asarray(H.reshape(-1, *H.shape[2:]))
