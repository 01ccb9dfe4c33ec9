"""A posture of a hand from which it grasps."""

from __future__ import annotations

from handlcp.hand.make_grasp import make_grasp
from handlcp.hand.robot.posture import Posture

__all__ = ["HandState"]


class HandState(Posture):
    """A hand in one posture, made by `hand.at(q)`; `grasp` makes its grasps. Immutable.

    All arrays are read-only, in world axes, metres and radians:

    hand : the hand. q : (nv,) positions of the independent joints.
    tip_positions : (n, 3). tip_rotations : (n, 3, 3), columns the tip frame's axes.
    jacobian : (3n, nv) velocity of the tip origins in world axes (Pinocchio's LOCAL_WORLD_ALIGNED), tip by tip.
    flexibility : (3n, 3n) E = J K⁻¹ Jᵀ + pads [m/N], the displacement of the tips in world axes under forces on them.
    """

    grasp = make_grasp
