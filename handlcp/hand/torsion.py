"""Soft fingers on a hand: the moment about a contact's normal loads the joints, which turn the fingertip under it.

    τ = Jᵀ f + Tᵀ r_τ,    T = nᵀ J_ω,    E = [J; T] K⁻¹ [J; T]ᵀ + pads

Source: model, table of effects ("soft finger") and "Flexibility from the hand", for one more direction a contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["turning_jacobian", "with_turning"]


def turning_jacobian(state: HandState, tips: Sequence[int], frames: Array, soft: tuple[int, ...]) -> Array:
    """(k, nv) T [rad/rad], how fast the fingertips of the soft contacts turn about their normals; frames (n, 3, 3) of
    all contacts, the fingers' first; contacts of the environment turn by nothing.
    """
    J = state.turning(tips)
    return np.array([frames[i, :, 2] @ J[i] if i < len(tips) else np.zeros(state.hand.nv) for i in soft])


def with_turning(state: HandState, jacobian: Array, turning: Array, flexibility: Array) -> Array:
    """(c, c) E with the joints' share of the last k rows and columns, in contact axes; jacobian (3n, nv), turning
    (k, nv), flexibility (c, c) of the points and of pads alone. Points that don't give way have joints that don't.
    """
    n, out = len(jacobian), flexibility.copy()
    if out[:n, :n].any():
        every = state.hand.stiffness.compliance(np.vstack([jacobian, turning]))
        every[:n, :n] = 0.0
        out += every
    return out
