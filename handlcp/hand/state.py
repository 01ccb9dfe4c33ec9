"""A posture of a hand from which it grasps."""

from __future__ import annotations

from handlcp.hand.make_grasp import make_grasp
from handlcp.hand.robot.posture import Posture

__all__ = ["HandState"]


class HandState(Posture):
    """A hand in one posture, made by `hand.at(q)`; `grasp` makes its grasps. Immutable.

    Data as in `Posture`: hand, q, tip_positions, tip_rotations, jacobian, flexibility.
    """

    grasp = make_grasp
