"""Grips tried: does every load of a brief hold, followed from the first touch, and what do the motors need?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.analysis.least import least as searched
from handlcp.grasp.design.least import ORDER
from handlcp.grasp.design.pressed import pressed
from handlcp.grasp.friction import Section
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.path.trajectory import closing_efforts
from handlcp.grasp.verdict.check import STEPS
from handlcp.hand.command import gripped
from handlcp.hand.design.motors import Case

# ----------------------------------------------------------------
# The grip with which all loads hold and the motors need least, found by following every grip that is tried.

_MOST = 2.0**8  # times the grip that the search starts from
_CHANGES = (0.2, 0.08, 0.03)  # of one finger's grip
_BETTER = 1e-3  # a change that gains less is none


def least(trials: Trials, starts: list[Array], tolerance: float) -> tuple[Trial, Trial | None]:
    """The best grip found, and the largest smaller one of the same shape that does not hold; None: less grip holds,
    too, but the motors need no less. Where nothing holds, the first is the grip that gets furthest.

    starts : grips (k,) [N] to go on from, the most promising first; a later one counts only where none before it holds.
    """
    found = (_scaled(trials, start, tolerance)[0] for start in starts)
    best = next((one for one in found if one.holds), None)
    if best is None:
        return _furthest(list(trials.tried.values())), None
    better = _varied(trials, best)
    least_of_it = _scaled(trials, better.force, tolerance)
    return least_of_it if least_of_it[0].need <= better.need else (better, least_of_it[1])


def _furthest(tried: list[Trial]) -> Trial:
    """Of grips that do not hold, the one that gets furthest, and why no harder one does."""
    found = max(tried, key=lambda one: one.reached)
    hard = min([one for one in tried if one.pressed], key=lambda one: float(one.force.max()), default=found)
    if hard is found or found.lost is None:
        return found
    load, why = found.lost
    return replace(found, lost=(load, f"{why}; with {hard.force.max():.4g} N at most {hard.pressed}"))


def _scaled(trials: Trials, force: Array, tolerance: float) -> tuple[Trial, Trial | None]:
    """The least multiple of a grip that holds, to a relative tolerance; and the one below it that does not. Where none
    holds: the one that gets furthest.
    """

    def at(factor: float) -> Trial:
        return trials(factor * force)

    found = searched(lambda x: at(x).holds, 1.0, _MOST, tolerance, too_much=lambda x: at(x).reached < 0.0)
    below = None if found.fails is None else at(found.fails)
    if found.value is None:
        assert below is not None  # the start was tried
        return below, None
    return at(found.value), below


def _varied(trials: Trials, best: Trial) -> Trial:
    """One finger after the other, as long as that helps: with its new grip, all others as they were."""
    for change in _CHANGES:
        moved = True
        while moved:
            moved = False
            for finger in range(len(best.force)):
                for factor in (1.0 - change, 1.0 + change):
                    force = best.force.copy()
                    force[finger] *= factor
                    found = trials.below(force, (1.0 - _BETTER) * best.need)
                    if found is not None:
                        best, moved = found, True
                        break
    return best


# ----------------------------------------------------------------

_ALIKE = 1e-6  # torques that differ by less are the same


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One grip. force (k,) : normal forces commanded at the fingertips [N]. torque (m, nv) : the largest of each joint
    under each of m loads, from the first touch to the whole load [N·m]. squeeze (nv,) : the largest while the hand
    closes, or what the drive pulls with against dry friction at the joint, where that is more. need : the largest of
    both as a share of what is compared; inf where a load is lost. lost : that load, and why. reached : share of that
    load at which it is lost; below 0 where less grip may hold it: the object is lost as the hand closes, or is pressed
    too hard, or the hand cannot take the posture of the end. pressed : by which contact, in words; "": by none.
    """

    force: Array
    torque: Array
    squeeze: Array
    need: float
    lost: tuple[str, str] | None = None
    reached: float = 1.0
    pressed: str = ""

    @property
    def holds(self) -> bool:
        """Whether every load holds."""
        return self.lost is None

    @property
    def largest(self) -> Array:
        """(nv,) [N·m] under any load."""
        return np.asarray(self.torque.max(axis=0))

    @property
    def worst(self) -> Ints:
        """(nv,) the load that needs most of each joint; -1: closing the hand does."""
        while_closing = self.squeeze >= (1.0 - _ALIKE) * self.largest
        return np.where(while_closing, -1, self.torque.argmax(axis=0))


@dataclass(eq=False)
class Trials:
    """All that were tried. share (nv,) : torques that count as much as each other [N·m]. most (n,) : how hard contacts
    may press [N]. told : how many so far.
    """

    cases: tuple[Case, ...]
    section: Section
    share: Array
    most: Array
    told: Callable[[int], object] | None = None
    tried: dict[bytes, Trial] = field(default_factory=dict)
    first: int = 0  # the load that was lost last is the first to be tried
    passed: dict[bytes, float] = field(default_factory=dict)  # that need at least so much, whether or not they hold
    count: int = 0

    def __call__(self, force: Array) -> Trial:
        """With these grip forces (k,) [N]."""
        key = force.tobytes()
        if key not in self.tried:
            found = self._followed(force, np.inf)
            assert found is not None
            self.tried[key] = found
        return self.tried[key]

    def below(self, force: Array, need: float) -> Trial | None:
        """The same where every load holds and needs less than this; else None, as soon as that is known."""
        key = force.tobytes()
        if key not in self.tried and not self.passed.get(key, -np.inf) >= need:
            found = self._followed(force, need)
            if found is None:
                self.passed[key] = need
            else:
                self.tried[key] = found
        one = self.tried.get(key)
        return one if one is not None and one.need < need else None

    def _followed(self, force: Array, most: float) -> Trial | None:
        """None: it holds so far, and needs as much as `most`."""
        self.count += 1
        if self.told is not None:
            self.told(self.count)
        nv, m = len(self.share), len(self.cases)
        torque, squeeze = np.zeros((m, nv)), np.zeros(nv)
        for k in sorted(range(m), key=lambda k: k != self.first):
            path = self.path(k, force)
            if not path.held:
                self.first = k
                share = path.held_to - (path.lost_stage == ORDER[0])
                how = "not held: the object slides through" if path.reached else path.why
                return Trial(force, torque, squeeze, np.inf, (self.cases[k].name, how), share)
            hard = pressed(path, self.most)
            if (why := f"not held: {hard}" if hard else _beyond(path)) is not None:
                self.first = k
                return Trial(force, torque, squeeze, np.inf, (self.cases[k].name, why), -1.0, hard)  # less grip may do
            sizes = abs(path.steps.torques)
            torque[k] = sizes.max(axis=0)
            closing = sizes[path.steps.stage == 0] if path.stages[0] == ORDER[0] else sizes[:1]
            squeeze = np.max([squeeze, closing.max(axis=0), closing_efforts(path.steps.states)[:nv]], axis=0)
            if (np.maximum(torque[k], squeeze) / self.share).max() >= most:
                return None
        return Trial(force, torque, squeeze, float((np.vstack([torque, squeeze]) / self.share).max()))

    def path(self, number: int, force: Array) -> Loading:
        """The loading under one load, as `check` follows it."""
        spec = gripped(self.cases[number].spec, force)
        return follow(spec, self.section, None, ORDER, None, STEPS, None)


def _beyond(path: Loading) -> str | None:
    """Why the hand cannot be where the path ends, such as links inside the object; None: it can, or could not be where
    it begins either, which no grip changes.
    """
    mechanism = path.steps.grasp.spec.mechanism
    if mechanism is None or not path.steps.geometry.follows:
        return None
    for number in (0, -1):
        at = path.steps.states[number].where
        there = mechanism.at_end(at.q, at.pose)
        found = [r for r in mechanism.place_reasons(*there, "at the end of the loading") if r.severity == "decides"]
        if found:
            return None if number == 0 else f"not held: {found[0].sentence}"
    return None
