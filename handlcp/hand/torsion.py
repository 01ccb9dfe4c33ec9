"""Soft fingers on a hand: the moment about a contact's normal loads the joints, which turn the fingertip under it.

    τ = Jᵀ f + Tᵀ r_τ,    T = nᵀ J_ω,    E = [J; T] K⁻¹ [J; T]ᵀ + pads

Source: model, table of effects ("soft finger") and "Flexibility from the hand", for one more direction a contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array, read_only

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["NO_TURNING", "turning_jacobian", "with_turning"]

NO_TURNING = read_only(np.zeros((0, 0)))  # of a hand without soft fingers


def turning_jacobian(state: HandState, tips: Sequence[int], frames: Array, soft: tuple[int, ...]) -> Array:
    """(k, nv) T [rad/rad], how fast the fingertips of the soft contacts turn about their normals; frames (n, 3, 3) of
    all contacts, the fingers' first; contacts of the environment turn by nothing.
    """
    J = state.turning(tips)
    return np.array([frames[i, :, 2] @ J[i] if i < len(tips) else np.zeros(state.hand.nv) for i in soft])


def with_turning(state: HandState, jacobian: Array, turning: Array, flexibility: Array) -> Array:
    """(c, c) E from that of the points (3n, 3n), in contact axes."""
    n = len(jacobian)
    every = state.hand.stiffness.compliance(np.vstack([jacobian, turning]))
    every[:n, :n] = flexibility
    return every
