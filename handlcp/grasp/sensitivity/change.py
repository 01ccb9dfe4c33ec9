"""What parameters change in the laws of a grasp while forces and motion stay, and what an answer does about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.sensitivity.answer import Answer

__all__ = ["Change", "Rates", "no_change"]


@dataclass(frozen=True, eq=False)
class Change:
    """By p parameters, SI, each (…, p). Contacts' motions in the coordinates of the friction laws.

    motion (c, p) : δv, of the object relative to the tips [m]. balance (6, p) : δb, of the wrench that is left over,
    about the reference. friction (n, p) : δμ of the coefficients of the sections (`Scene.limits`) [-].
    torque (nv, p) : of what the joints hold [N·m].
    torque_limits (nv, p) : of the joints' limits [N·m].
    """

    motion: Array
    balance: Array
    friction: Array
    torque: Array
    torque_limits: Array

    def toward(self, direction: Array) -> Change:
        """(…, 1) along a direction (p,)."""
        parts = (self.motion, self.balance, self.friction, self.torque, self.torque_limits)
        return Change(*[(part @ direction)[:, None] for part in parts])

    def plus(self, other: Change) -> Change:
        """Both together."""
        return Change(
            self.motion + other.motion, self.balance + other.balance, self.friction + other.friction,
            self.torque + other.torque, self.torque_limits + other.torque_limits,
        )  # fmt: skip


def no_change(answer: Answer, p: int) -> Change:
    """Of p parameters that change nothing: a place to write to."""
    scene, nv = answer.scene, answer.rows.shape[1]
    sizes = (scene.components, 6, scene.n, nv, nv)
    return Change(*[np.zeros((size, p)) for size in sizes])


class Rates(NamedTuple):
    """What p parameters do to an answer, SI, each (…, p). forces (c, p) in contact axes, moments of soft contacts last;
    motion (6, p) of the object about the reference; slip (c, p) of v, contact axes. NaN where it is not determined.
    """

    forces: Array
    motion: Array
    slip: Array
