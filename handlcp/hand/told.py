"""What effects are told of a hand's joints."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array
from handlcp.grasp.contact import Contact
from handlcp.grasp.coordinates import soft_contacts
from handlcp.grasp.joints import Joints
from handlcp.hand.curvature import contact_hessian
from handlcp.hand.torsion import turning_jacobian

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["joints_of"]


def joints_of(
    state: HandState, tips: Sequence[int], contacts: tuple[Contact, ...], frames: Array, jacobian: Array,
    weight: Array, planar: bool,
) -> Joints:  # fmt: skip
    """The joints of a posture, for n contacts of which the first are those of the fingertips numbered `tips`; frames
    (n, 3, 3) in contact axes, jacobian (3n, nv) and weight (nv,) as in `Joints`.
    """
    hand, k = state.hand, len(tips)
    hessian = partial(contact_hessian, state, tips, np.array([c.position for c in contacts[:k]]), frames[:k])
    turning: dict[int, Array] = {}
    if not all([c.plain for c in contacts]):
        soft = soft_contacts(contacts, (True,) * len(contacts), planar)
        turning = dict(zip(soft, turning_jacobian(state, tips, frames, soft), strict=True))
    return Joints(hand.joint_names, jacobian, weight, hand.torques.limits, hand.stiffness.root, hessian, turning)
