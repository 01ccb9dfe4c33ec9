"""The grasp with which a hand does best what a brief asks, of all that a search finds.

Best is a grasp that holds the weight and each load as many times as is asked, and of these the one of the largest
payload; where none does, the one of the largest factor.

A search for pinches goes round by round. Grasps are followed along their paths, and most of them fall behind the best
one at the first load, which costs one path. Where a round finds a better one, places around it are tried, too. Each
round hangs on those before it alone: so with more tries the same search goes on, and what it finds is never worse.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from handlcp.check import Array
from handlcp.design.brief import WEIGHT_NAME, Brief
from handlcp.design.evaluation import NOT_FOUND, ObjectCase
from handlcp.design.judged import Known, judged, unloaded
from handlcp.geometry.object import Object
from handlcp.grasp.limits.followed import Before
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.verdict import HELD
from handlcp.hand.find.candidate import Candidate, candidate_of
from handlcp.hand.find.clear import Place
from handlcp.hand.find.find import PINCH, missed, searches_of
from handlcp.hand.find.pinch import SOLVED, Search, place_of
from handlcp.hand.hand import Hand
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.robot.hand_model import DEFAULT_GRAVITY
from handlcp.studies.payload.largest_mass import SIX, unit_mass_loads

_TRIALS = 24  # around a better grasp
_WIDE, _WIDER, _NARROWER = 0.5, 1.5, 0.9  # how far around: at first, after a better one, after any other
_BELOW = 1e-9  # relative: as much less than the safety need not be exceeded by more


def best_grasp(hand: Hand, brief: Brief, obj: Object, known: Known) -> ObjectCase:
    """Of this object, searched for and judged; NOT FOUND with its reason where there is none."""
    asked = {"friction": brief.friction, "gravity": DEFAULT_GRAVITY, **brief.closing}
    searches = searches_of(hand, obj, brief.kind, asked, hand.tip_numbers("fingers", None), brief.seed)
    best = Best(brief, obj)
    for search in searches:
        if isinstance(search, Search):
            pinches(best, search, brief.tries, brief.seed)
        else:
            for one in search.run(brief.tries):
                if best.may_be(one.grasp):
                    best.offer(one)
    if best.one is not None:
        return judged(brief, obj, best.one, known)
    names, why = (WEIGHT_NAME, *brief.loads), missed(obj, searches)
    return ObjectCase(NOT_FOUND, dict.fromkeys(names, NOT_FOUND), dict.fromkeys(names, 0.0), 0.0, why)


Held: TypeAlias = tuple[HandGrasp, GraspSolution]  # by one solve


def pinches(
    best: Best, search: Search, tries: int, seed: int, trials: int = _TRIALS,
    closed: Callable[[Held], list[Held]] = lambda held: [held],
) -> None:  # fmt: skip
    """All rounds of a search. trials : around a better grasp. closed : of a grasp with planned forces, those that are
    tried in its place.
    """
    places, rng = search.places(tries), np.random.default_rng(seed)

    def better(some: list[Place]) -> bool:
        """Whether one of the grasps from these places is."""
        found = False
        made = [one for held in search.held(some) for one in closed(held)]
        hopeful = [candidate_of(PINCH, *one) for one in made if best.may_be(one[0])]
        for one in sorted(hopeful, key=lambda one: one.rank):  # asked again once one of them is the best
            if (not found or best.may_be(one.grasp)) and search.checked([one], 1):
                found |= best.offer(one)
        return found

    for start in range(0, len(places), SOLVED):
        some, share = places[start : start + SOLVED], _WIDE
        if not better(some):
            if best.holds:
                return
        elif len(some) == SOLVED:
            for _ in range(trials):
                near = search.nearby(best.place, rng, share)
                share *= _WIDER if better([near]) else _NARROWER


class Best:
    """The best grasp so far. case : how it was judged; None before there is one."""

    def __init__(self, brief: Brief, obj: Object) -> None:
        self._brief, self._obj, self._fell_at = replace(brief, orientations=SIX), obj, 0
        self.case: ObjectCase | None = None

    @property
    def one(self) -> Candidate | None:
        """That grasp."""
        return None if self.case is None else self.case.candidate

    @property
    def place(self) -> Place:
        """Where it is."""
        assert self.one is not None
        return place_of(self.one.grasp)

    @property
    def holds(self) -> bool:
        """Whether it does all that is asked."""
        return self.case is not None and self.case.word == HELD

    def may_be(self, grasp: HandGrasp) -> bool:
        """Whether a grasp holds more than the best one; the load at which the last one fell behind comes first."""
        loads, befores = self._to_hold(grasp), dict[int, Before]()
        for k in sorted(range(len(loads)), key=lambda k: k != self._fell_at):
            spec, wrench, factor = loads[k]
            if id(spec) not in befores:
                befores[id(spec)] = unloaded(self._brief, spec)
            if not befores[id(spec)].holds_more(wrench, factor):
                self._fell_at = k
                return False
        return True

    def offer(self, one: Candidate) -> bool:
        """Take it where it is better than the best one."""
        known = Known(np.inf, self._brief.safety)  # loads need be followed no further
        case = judged(self._brief, self._obj, one, known)
        if self.case is not None and worth(case) <= worth(self.case):
            return False
        self.case = case
        return True

    def _to_hold(self, grasp: HandGrasp) -> list[tuple[GraspSpec, Array, float]]:
        """Loads (6,) on a grasp, each with the factor of which a better grasp holds more."""
        if self.case is None:
            return []
        enough = (1.0 - _BELOW) * self._brief.safety
        least = enough if self.holds else min(self.case.factor, enough)
        weight = self.case.payload if self.holds else least * self._obj.mass
        weights = [(*pull, weight) for pull in unit_mass_loads(grasp, self._brief.acceleration)]
        return weights + [(grasp.spec, load, least) for load in self._brief.loads.values()]


def worth(case: ObjectCase) -> tuple[bool, float]:
    """What grasps are compared by, the larger the better."""
    return (True, case.payload) if case.word == HELD else (False, case.factor)
