"""What effects are told of a hand's joints."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from handlcp.check import Array
from handlcp.grasp.joints import Joints
from handlcp.hand.curvature import contact_hessian

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["joints_of"]


def joints_of(
    state: HandState, tips: Sequence[int], positions: Array, frames: Array, jacobian: Array, weight: Array
) -> Joints:
    """The joints of a posture, for n contacts of which the first are those of the fingertips numbered `tips`; jacobian
    (3n + k, nv) and weight (nv,) as in `Joints`.
    """
    hand = state.hand
    k = len(tips)
    hessian = partial(contact_hessian, state, tips, positions[:k], frames[:k])
    return Joints(hand.joint_names, jacobian, weight, hand.torques.limits, hand.stiffness.root, hessian)
