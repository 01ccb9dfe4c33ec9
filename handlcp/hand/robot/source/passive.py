"""Springs at joints that an MJCF file states: what they add to the stiffness of a hand, and what they pull with.

    K_p = Cᵀ diag(k) C,    τ = Cᵀ k (C q + c - θ)

with k and rest angle θ of each joint, and the coupling q_full = C q + c of joints that follow others.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.hand.robot.kinematics import Kinematics


def passive_springs(kinematics: Kinematics) -> Array:
    """(nv, nv) K_p [N·m/rad] of the springs at joints that the file states."""
    k, C = _springs(kinematics)[0], kinematics.all_joints.C
    return np.asarray(C.T @ (k[:, None] * C))


def rest_angles(kinematics: Kinematics) -> Array:
    """(nv,) of independent joints [rad, m]: where the springs of each and of those that follow it pull with nothing in
    all; 0 without springs.
    """
    (k, rest), coupling = _springs(kinematics), kinematics.all_joints
    stiff = passive_springs(kinematics).diagonal()
    at_zero = coupling.C.T @ (k * (coupling.offset - rest))
    return np.asarray(-at_zero / np.where(stiff > 0.0, stiff, 1.0))


def preload(kinematics: Kinematics) -> Array:
    """(nv,) τ [N·m] with which springs pull in the middle of the ranges; without ends, in the neutral posture."""
    (k, rest), coupling = _springs(kinematics), kinematics.all_joints
    bounded = np.isfinite(kinematics.lower) & np.isfinite(kinematics.upper)
    ends = np.where(bounded, [kinematics.lower, kinematics.upper], kinematics.neutral)
    return np.asarray(coupling.C.T @ (k * (coupling.C @ ends.mean(axis=0) + coupling.offset - rest)))


def _springs(kinematics: Kinematics) -> tuple[Array, Array]:
    """(joints,) stiffness [N·m/rad] and rest angle [rad] of all movable joints."""
    stated = {f.name: f.stated for f in kinematics.facts}
    every = [stated[name] for name in kinematics.movable]
    return np.array([s.stiffness for s in every]), np.array([s.rest for s in every])
