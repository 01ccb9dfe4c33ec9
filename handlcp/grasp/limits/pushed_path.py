"""A grasp on its way under a growing load, led by the object's motion: point by point past every largest load.

A point of the path is reached from the last by a motion of the object, not by a load: so the path also goes on where
the load falls again. A step is as long as the path is smooth, and ends where the next contact is about to slip or open.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.loading.geometry import between
from handlcp.grasp.loading.state import STILL, Failure, Guess, State
from handlcp.grasp.loading.step import Stepper
from handlcp.grasp.loading.step_answer import Push

__all__ = ["Point", "PushedPath"]


class Point(NamedTuple):
    """state : of the grasp. factor : of the load there. size : of the step that led here [m], from `before`."""

    state: State
    factor: float
    size: float
    before: Point | None


class PushedPath:
    """load (6,) : that a factor of 1 stands for, about the object's reference."""

    def __init__(self, stepper: Stepper, start: State, load: Array) -> None:
        self.stepper, self.load = stepper, load
        self._length = float(stepper.first.radius.mean())  # makes turns comparable with motions
        self.start = Point(start, 0.0, 0.0, None)

    def beyond(self, point: Point, size: float) -> Point | Failure:
        """The point further on by so much [m]."""
        state, before = point.state, point.before
        guess, factor = state.same, point.factor
        if before is not None:
            ahead = size / point.size
            factor += ahead * (point.factor - before.factor)
            guess = self._further(before.state, state, ahead)
        found = self.stepper.pushed(state, Push(self.load, self._along(point), size), factor, guess)
        if isinstance(found, Failure):
            return found
        return Point(found, self.factor(found), size, point)

    def factor(self, state: State) -> float:
        """Of the load in a state."""
        return float(self.load @ state.controls.load) / float(self.load @ self.load)

    def _along(self, point: Point) -> Array:
        """(6,) the wrench whose work measures a step from there [m]: along the last step, or at first along the load.

        A motion of 1 m has it, and a turn by 1 m over the contacts' mean distance from the object's centre.
        """
        squares = np.array([1.0, 1.0, 1.0, *[self._length**2] * 3])
        if point.before is None:
            return np.asarray(self.load / np.sqrt((self.load**2 / squares).sum()))
        displacement = self.stepper.geometry.displacement
        moved = displacement(point.state.where.pose) - displacement(point.before.state.where.pose)
        return np.asarray(squares * moved / np.sqrt((squares * moved**2).sum()))

    def _further(self, before: State, now: State, share: float) -> Guess:
        """What goes on from `before` to `now` by this share of the way between them."""
        where = between(self.stepper.geometry, before.where, now.where, 1.0 + share)
        if len(before.start) != len(now.start):
            return Guess(where, now.start, STILL)
        return Guess(where, now.start + share * (now.start - before.start), STILL)
