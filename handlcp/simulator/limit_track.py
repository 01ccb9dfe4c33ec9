"""How an object moves while its load grows: smoothly, or in jumps while the load waits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only

_JUMP = 1e-3  # [m] that an object moves while the load waits: it has jumped
_TURN = np.radians(2.0)  # [rad] that it turns


@dataclass(frozen=True, eq=False)
class LimitTrack:
    """factors (m,) of the load, each larger than the one before. motion (m, 6) of the object since the load began to
    grow, when it had become slow under that load: translation of the reference point [m], rotation vector [rad], world
    axes. Between two factors with a jump the motion jumps.
    """

    factors: Array
    motion: Array

    def at(self, factor: float) -> Array:
        """(6,) how far the object had moved under this factor [m, rad], interpolated; NaN beyond the last one."""
        if not (len(self.factors) and 0.0 <= factor <= self.factors[-1]):
            return np.full(6, np.nan)
        return np.array([np.interp(factor, self.factors, column) for column in self.motion.T])


class Tracking:
    """Motion as it comes. jump : the first factor at which the object has jumped; inf so far.

    start (6,) : of the object when the load begins to grow.
    """

    def __init__(self, start: Array) -> None:
        self.jump = np.inf
        self._start = self._calm = start
        self._factors: list[float] = []
        self._motion: list[Array] = []

    def rests(self, factor: float, motion: Array) -> None:
        """The object moves slowly under this factor; motion (6,)."""
        self._calm = motion
        if not self._factors or factor > self._factors[-1]:
            self._factors.append(factor)
            self._motion.append(moved(self._start, motion))

    def moves(self, factor: float, motion: Array) -> None:
        """The object moves fast under this factor; motion (6,)."""
        if np.isfinite(self.jump):
            return
        way = moved(self._calm, motion)
        if np.linalg.norm(way[:3]) > _JUMP or np.linalg.norm(way[3:]) > _TURN:
            self.jump = factor

    def track(self) -> LimitTrack:
        """So far."""
        return LimitTrack(read_only(np.array(self._factors)), read_only(np.array(self._motion).reshape(-1, 6)))


def moved(before: Array, after: Array) -> Array:
    """(6,) from one motion to another: difference of translations, rotation vector of one turn after the other."""
    turn = pin.exp3(np.array(after[3:])) @ pin.exp3(np.array(before[3:])).T
    return np.append(after[:3] - before[:3], pin.log3(turn))
