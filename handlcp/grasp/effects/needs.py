"""What effects ask of the grasp that completes them: a contact that there is, joints that a hand knows."""

from __future__ import annotations

from handlcp.errors import InputError
from handlcp.grasp.joints import Joints

__all__ = ["need_contact", "need_joints"]


def need_contact(argument: str, contact: int, n: int) -> None:
    """Raises InputError unless one of n contacts has this number."""
    if contact >= n:
        raise InputError(argument, f"a contact's number from 0 to {n - 1}", contact)


def need_joints(argument: str, joints: Joints | None, effect: object) -> Joints:
    """The joints of the hand that grasps. Raises InputError where no hand does."""
    if joints is None:
        expected = "an effect that needs no joints; a hand knows its own: hand.at(q).grasp(..., effects=[...])"
        raise InputError(argument, expected, repr(effect))
    return joints
