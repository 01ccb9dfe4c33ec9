"""One pair of a hand and an object: the best grasp of each kind, what it holds, how sure that is, MuJoCo's verdict.

A search plans fingertip forces for the object's weight, which says little of what a hand could hold. So the pinches
that it finds are also closed as hard as a power grasp: until the weakest motor gives half of what it can, or 0.5 N·m.
The one that holds most counts, and is varied as long as there is time.

Both are judged as `evaluate` judges grasps: by their loading, followed in steps, with gravity along each axis of the
hand's base. What takes longer than it may is left out, and the row says so.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from handlcp.design.best_grasp import Best, Held, pinches
from handlcp.design.brief import Brief
from handlcp.design.evaluation import NOT_FOUND, ObjectCase
from handlcp.design.judged import Known, judged
from handlcp.design.sweep.work import DESIGN, Done, Task, unpacked
from handlcp.design.table.catalogue import hand_of, object_of
from handlcp.design.table.doubts import (
    FRICTION,
    LEAST_FRICTION,
    MOST_FRICTION,
    doubts_said,
    variations,
    with_friction,
)
from handlcp.design.table.recipe import Recipe
from handlcp.errors import HandLCPError, Unsupported
from handlcp.hand.find.candidate import Candidate, candidate_of
from handlcp.hand.find.find import PINCH, POWER, missed, searches_of
from handlcp.hand.find.pinch import Search
from handlcp.hand.find.power import MOST, SHARE, PowerSearch
from handlcp.hand.find.refused import skipping_refused
from handlcp.hand.hand import Hand
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.posture import GRAVITY
from handlcp.lcp.compiler.when import at_once
from handlcp.progress import OutOfTime, within
from handlcp.record import plain
from handlcp.simulator import simulate
from handlcp.study.reliability import reliability

Row = dict[str, Any]
KINDS = (PINCH, POWER)
GIVEN_UP, FAILED = "GIVEN UP", "FAILED"  # verdicts beside those of an `ObjectCase`
HELD, LOST = "HELD", "LOST"  # of MuJoCo

_ASKED = {"friction": FRICTION, "gravity": GRAVITY}
_TRIES = {PINCH: 256, POWER: 12}
_TRIALS = 8  # around a better pinch
_HARDER = 1.05  # times: with less a pinch is closed hard enough
_PINCHED, _DOUBTED = 0.5, 0.75  # of the time for finding power grasps: for pinches; to judge them, and for the interval
_ANY = 1e-6  # times the weight: no payload is too small to be told
_SAMPLES = 256
_SPREAD = {"friction": 0.2, "stiffness": 0.35, "pads": 0.35, "mass": 0.05}  # shares, one standard deviation
_SETTLES = 1.0  # [s] of each stage in MuJoCo


@dataclass(frozen=True, eq=False)
class Asked:
    """hands, objects : those that are not in the catalogue, by name. kinds : of grasps. seconds : of computing that
    finding and judging one grasp may take. simulated : whether MuJoCo is asked.
    """

    hands: Mapping[str, Hand]
    objects: Mapping[str, Object]
    kinds: tuple[str, ...]
    seconds: float
    simulated: bool

    def hand(self, name: str) -> Hand:
        """Raises what `example_hand` raises."""
        return self.hands[name] if name in self.hands else _hand(name)

    def object(self, name: str) -> Object:
        """Raises what `YCB` raises."""
        return self.objects[name] if name in self.objects else _object(name)


_hand, _object = lru_cache(maxsize=2)(hand_of), lru_cache(maxsize=128)(object_of)


def work(task: Task) -> Done:
    """In any process: the pairs of a task, each a row that holds one of each kind."""
    began, asked = time.perf_counter(), unpacked(task.maker)
    with at_once():  # what is interpreted would not come far within the time of a row
        rows = [{DESIGN: number, **values, "kinds": pair(asked, **values)} for number, values in task.designs]
    return Done(rows, None, time.perf_counter() - began)


def pair(asked: Asked, hand: Any, object: Any) -> list[Row]:
    """A row for each kind of grasp; the best one of them has MuJoCo's verdict."""
    found = list[tuple[Row, Candidate | None]]()
    for kind in asked.kinds:
        began = time.thread_time()
        try:
            row, candidate = _row(asked, asked.hand(hand), asked.object(object), kind)
        except OutOfTime:
            row, candidate = _nothing(GIVEN_UP, f"no grasp found and judged in {asked.seconds:g} s of computing"), None
        except Exception as error:  # whatever one pair raises, the others have their rows
            row, candidate = _nothing(FAILED, f"{type(error).__name__}: {error}"), None
        found.append(({"kind": kind, **row, "seconds": time.thread_time() - began}, candidate))
    known = [(row, one) for row, one in found if one is not None]
    if known:
        row, one = max(known, key=lambda each: each[0]["payload_kg"] or 0.0)
        row["best"] = True
        if asked.simulated:
            began = time.thread_time()
            row["mujoco"] = _simulated(one)
            row["mujoco_seconds"] = time.thread_time() - began
    return [plain(row) for row, _ in found]


def _nothing(verdict: str, why: str) -> Row:
    """Of a pair without a grasp."""
    return {"verdict": verdict, "reason": why, "best": False}


def _row(asked: Asked, hand: Hand, obj: Object, kind: str) -> tuple[Row, Candidate | None]:
    """Raises OutOfTime where finding a grasp or judging it takes too long; what `find_grasp` raises."""
    brief, left_out = Brief(obj, friction=FRICTION, kind=kind), list[str]()
    search = searches_of(hand, obj, kind, _ASKED, hand.tip_numbers("fingers", None), 0)[0]
    if isinstance(search, Search):
        case = _pinch(asked, search, hand, brief, left_out)
    else:
        case = _power(asked, search, brief, left_out)
    if case is None or case.candidate is None:
        return _nothing(NOT_FOUND, missed(obj, [search]).partition(" found: ")[2]), None
    recipe = Recipe.of(kind, case.candidate.grasp)
    audit = hand.audit()
    interval = _interval(asked, hand, brief, recipe, case)
    interval["left_out"] = "; ".join([*left_out, *interval["left_out"]])
    row = {
        "verdict": case.word, "reason": "", "payload_kg": case.payload, **interval,
        "gives_out": case.gives_out or "nothing", "motors_used": case.torque_used if _judged(hand) else None,
        "grip_N": case.force, "moves_m": case.motion, "chance": _chance(case.candidate),
        "doubts": doubts_said(hand, audit), "best": False, **recipe.to_row(),
    }  # fmt: skip
    return row, case.candidate


def _judged(hand: Hand) -> bool:
    """Whether any motor is."""
    return bool(np.isfinite(hand.torque_limits).any())


def _power(asked: Asked, search: PowerSearch, brief: Brief, left_out: list[str]) -> ObjectCase | None:
    """The power grasp that holds most in its worst direction; of those found so far where there is no more time."""
    try:
        with within(asked.seconds):
            found = search.run(_TRIES[POWER])
    except OutOfTime:
        if not (found := sorted(search.found, key=lambda one: one.rank)):
            raise
        left_out.append("further places")
    with within(_DOUBTED * asked.seconds):
        return judged(brief, brief.objects["object"], found[0], Known()) if found else None


def _pinch(asked: Asked, search: Search, hand: Hand, brief: Brief, left_out: list[str]) -> ObjectCase | None:
    """The pinch that holds most, closed firmly or as planned; of those judged so far where there is no more time."""
    best = Best(brief, brief.objects["object"])
    try:
        with within(_PINCHED * asked.seconds):
            pinches(best, search, _TRIES[PINCH], brief.seed, _TRIALS, lambda held: [*_firm(hand, brief, *held), held])
    except OutOfTime:
        if best.case is None:
            raise
        left_out.append("further places")
    return best.case


def _firm(hand: Hand, brief: Brief, grasp: HandGrasp, solution: Any) -> list[Held]:
    """A pinch closed until the weakest motor gives half of what it can; none where it does so already, or is lost."""
    allowed = np.minimum(SHARE * hand.torque_limits, MOST)
    times = float((allowed / np.maximum(abs(solution.torques), 1e-9)).min(initial=np.inf))
    if not _HARDER < times < np.inf:
        return []
    with skipping_refused():  # tips that no longer touch where they did
        closed = Recipe.of(PINCH, grasp).harder(times).grasp(hand, brief.objects["object"], brief.friction)
        solution = closed.solve(throw=False, proof=False)
        return [(closed, solution)] if solution.held else []
    return []


# ----------------------------------------------------------------
# How sure it is.


def _interval(asked: Asked, hand: Hand, brief: Brief, recipe: Recipe, case: ObjectCase) -> Row:
    """The least and the largest payload [kg] with what is doubted, with what, and what there was no time for. An end is
    not known without the friction that most often makes it.
    """
    obj, ends = brief.objects["object"], [(case.payload, "")]
    waiting = variations(hand, hand.audit())
    try:
        with within(_DOUBTED * asked.seconds):
            while waiting:
                says, make, lower = waiting[0]
                least = min(ends)[0] if lower else np.inf
                ends.append((_payload(make, hand, obj, recipe, brief, least), says))
                waiting.pop(0)
    except OutOfTime:
        pass
    left_out = [one.says for one in waiting]
    low = (None, "") if with_friction(LEAST_FRICTION) in left_out else min(ends)
    high = (None, "") if with_friction(MOST_FRICTION) in left_out else max(ends)
    return {
        "payload_low_kg": low[0], "low_with": low[1], "payload_high_kg": high[0], "high_with": high[1],
        "left_out": left_out,
    }  # fmt: skip


def _payload(make: Any, hand: Hand, obj: Object, recipe: Recipe, brief: Brief, least: float) -> float:
    """[kg] of a variation, 0 where it does not hold; of one that holds more than `least`, at least that."""
    try:
        grasp = make(hand, obj, recipe)
        solution = grasp.solve(throw=False, proof=False)
        known = Known(least, least / obj.mass) if np.isfinite(least) else Known()
        return judged(replace(brief, safety=1e-6), obj, candidate_of(recipe.kind, grasp, solution), known).payload
    except HandLCPError:  # no such grasp can be made, or it holds nothing
        return 0.0


def _chance(one: Candidate) -> float | None:
    """That the grasp surely holds its object. None where that cannot be asked, or every sample is undecided."""
    try:
        found = reliability(one.grasp, _SPREAD, _SAMPLES, workers=1, decide=0, progress=False)
    except HandLCPError:
        return None
    return None if np.isnan(found.chance_held.value) else found.chance_held.value


def _simulated(one: Candidate) -> str:
    """MuJoCo's verdict; why it has none."""
    try:
        found = simulate(one.grasp, seconds=_SETTLES)
    except Unsupported as error:
        return f"not asked: {error}"
    if not found.held and found.lost_at == 1.0 and found.record.forces[-1].any():
        return f"{LOST}: not at rest after {found.lost_stage}"
    return HELD if found.held else f"{LOST} at {100.0 * (found.lost_at or 0.0):.0f} % of {found.lost_stage}"


def flat(rows: list[Row], kinds: tuple[str, ...]) -> Iterator[Row]:
    """Of a journal: a row for each kind. A pair whose process ended has its reason in each."""
    for row in rows:
        names = {"hand": row["hand"], "object": row["object"]}
        for one in row.get("kinds") or [{"kind": kind, **_nothing(FAILED, row["error"])} for kind in kinds]:
            yield names | one
