"""A grasp on its way under a growing load, led by the object's motion: point by point past every largest load.

A point of the path is reached from the last by a motion of the object, not by a load: so the path also goes on where
the load falls again.

Friction opposes the slip at the end of a step, not the slip of the whole step: where a contact goes on sliding, its
slip rate is extrapolated from this step and the last one (as in backward differences of second order). Otherwise a
slip that turns while it goes on would lag behind by half a step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.loading.geometry import between
from handlcp.grasp.loading.state import OPEN, SLIDES, STICKS, STILL, Failure, Guess, State
from handlcp.grasp.loading.step import Stepper
from handlcp.grasp.loading.step_answer import Push

__all__ = ["LoadedPath", "Point", "PushedPath"]

CAUGHT = 0.06  # of the farthest contact's distance: an object that comes to rest again within this motion is held
_FAR = 3.0  # times its step: how far an object may move in it
_PROBE = 1e-4  # of the load: a state stays under so much more


class Point(NamedTuple):
    """state : of the grasp. factor : of the load there. size : of the step that led here [m], from `before`.
    snapped : whether the object snapped from there, and came to rest here.
    """

    state: State
    factor: float
    size: float
    before: Point | None
    snapped: bool = False

    @property
    def kinds(self) -> tuple[str, ...]:
        """(n,) states of the contacts."""
        return self.state.kinds


class PushedPath:
    """load (6,) : that a factor of 1 stands for, about the object's reference. strength : the size of that load [N],
    torques over the contacts' mean distance from the object's centre.
    """

    def __init__(self, stepper: Stepper, start: State, load: Array) -> None:
        self.stepper, self.load = stepper, load
        length = float(stepper.first.radius.mean())
        self._squares = np.array([1.0, 1.0, 1.0, *[length**2] * 3])  # makes turns comparable with motions
        self.strength = float(np.sqrt((load**2 / self._squares).sum()))
        first = stepper.first
        self._caught = CAUGHT * float(np.sqrt(((first.positions - first.reference) ** 2).sum(axis=1).max()))
        self.start = Point(start, 0.0, 0.0, None)

    def beyond(self, point: Point, size: float) -> Point | Failure:
        """The point further on by so much [m]."""
        state, before = point.state, point.before
        guess, factor, lead = state.same, point.factor, np.zeros((len(state.kinds), 3))
        if before is not None and not point.snapped:
            ahead = size / point.size
            factor += ahead * (point.factor - before.factor)
            guess = self._further(before.state, state, ahead)
            slides = [i for i, kind in enumerate(state.kinds) if kind == SLIDES]
            lead[slides] = -ahead * ahead / (1.0 + 2.0 * ahead) * state.slid[slides]
        found = self.stepper.pushed(state, Push(self.load, self._along(point), size, lead), factor, guess)
        if isinstance(found, Failure):
            return found
        return Point(found, self.factor(found), size, point)

    def under(self, point: Point, factor: float) -> Point | None:
        """The state under so much of the load, searched with all that finds an answer; None: there is none near."""
        controls = point.state.controls._replace(load=factor * self.load)
        found = self.stepper.step(point.state, controls, point.state.same, patient=True)
        if isinstance(found, Failure):
            return None
        new = Point(found, factor, self._size(point.state, found), point)
        return new if self.near(point, new) else None

    def near(self, a: Point, b: Point) -> bool:
        """Whether an object that snaps from one to the other counts as held, as `CAUGHT` says."""
        way = self._way(a.state, b.state)
        length = self._caught / CAUGHT
        return float(np.sqrt(way[:3] @ way[:3]) + length * np.sqrt(way[3:] @ way[3:])) <= self._caught

    def caught(self, point: Point, factor: float) -> Point | None:
        """Where the object comes to rest from a point when so much of the load is given; None: not near it."""
        controls = point.state.controls._replace(load=factor * self.load)
        found = self.stepper.caught(point.state, controls)
        if isinstance(found, Failure) or not found.loaded:
            return None
        new = Point(found, factor, self._size(point.state, found), point, snapped=True)
        return new if self.near(point, new) else None

    def stays(self, point: Point) -> bool:
        """Whether the state is also found when the load is given, and a little more of it."""
        more = point.factor * (1.0 + _PROBE)
        controls = point.state.controls._replace(load=more * self.load)
        return isinstance(self.stepper.step(point.state, controls, point.state.same), State)

    def foreseen(self, base: Point, now: Point, size: float, changed: Point) -> Array:
        """(n,) sizes of a step from `base` at which contacts begin to slip or open, of those that do it until
        `changed`: as margins go on from `base` to `now`, `size` further, or else from the point before to `base`.
        inf for what they do not tell.
        """
        found = np.full(len(base.kinds), np.inf)
        early, late, span = (base, now, size) if now is not base else (base.before, base, base.size)
        if early is None or not len(early.state.start):
            return found
        before, then = self.stepper.solver.margins(early.state.start), self.stepper.solver.margins(late.state.start)
        for i, (was, becomes) in enumerate(zip(base.kinds, changed.kinds, strict=True)):
            if was in (becomes, OPEN) or becomes == STICKS:
                continue
            which = 0 if becomes == OPEN else 1
            falls = (before[which][i] - then[which][i]) / span
            if falls > 0.0:
                found[i] = size + then[which][i] / falls
        return found

    def factor(self, state: State) -> float:
        """Of the load in a state."""
        return float(self.load @ state.controls.load) / float(self.load @ self.load)

    def _along(self, point: Point) -> Array:
        """(6,) the wrench whose work measures a step from there [m]: along the last step, at first along the load."""
        if point.before is None or point.snapped:
            return np.asarray(self.load / self.strength)
        step = self._squares * self._way(point.before.state, point.state)
        return np.asarray(step / np.sqrt((step**2 / self._squares).sum()))

    def strays(self, point: Point) -> bool:
        """Whether the object has moved much further than the step that led here: it has come to another path."""
        return point.before is not None and self.moved(point.before, point) > _FAR * point.size

    def moved(self, a: Point, b: Point) -> float:
        """How far the object moves between points [m], as steps are measured."""
        return self._size(a.state, b.state)

    def _size(self, a: State, b: State) -> float:
        return float(np.sqrt((self._way(a, b) ** 2 * self._squares).sum()))

    def _way(self, a: State, b: State) -> Array:
        """(6,) motion of the object from one state to another: of the reference point [m], and of rotation vectors."""
        displacement = self.stepper.geometry.displacement
        return np.asarray(displacement(b.where.pose) - displacement(a.where.pose))

    def _further(self, before: State, now: State, share: float) -> Guess:
        """What goes on from `before` to `now` by this share of the way between them."""
        where = between(self.stepper.geometry, before.where, now.where, 1.0 + share)
        if len(before.start) != len(now.start):
            return Guess(where, now.start, STILL)
        return Guess(where, now.start + share * (now.start - before.start), STILL)


class LoadedPath(PushedPath):
    """The same where steps are led by the load, for grasps with effects that have rows of their own. It ends where no
    state follows, and knows nothing of what is beyond. per : of the load's factor, for each metre of a step [1/m].
    """

    def __init__(self, stepper: Stepper, start: State, load: Array, per: float) -> None:
        super().__init__(stepper, start, load)
        self._per = per

    def beyond(self, point: Point, size: float) -> Point | Failure:
        state, before, factor = point.state, point.before, point.factor + size * self._per
        guess = state.same if before is None or point.snapped else self._further(before.state, state, size / point.size)
        controls = state.controls._replace(load=factor * self.load)
        found = self.stepper.step(state, controls, guess)
        return found if isinstance(found, Failure) else Point(found, factor, size, point)

    def stays(self, point: Point) -> bool:
        return True

    def strays(self, point: Point) -> bool:
        return False

    def caught(self, point: Point, factor: float) -> Point | None:
        return None

    def under(self, point: Point, factor: float) -> Point | None:
        return None
