"""How well a hand does what a brief asks: grasps are found, judged by the path of their loading, and told in numbers.

    weight    factor = payload / mass        the least over the orientations of gravity
    a load    factor                         of a load that grows beside the weight, the hand upright

Each factor is held if it is at least the safety that was asked for.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.design.brief import WEIGHT, Brief
from handlcp.design.evaluation import NOT_FOUND, Evaluation, ObjectCase
from handlcp.errors import InputError
from handlcp.grasp import LoadLimit
from handlcp.grasp.answer.verdict import HELD, NOT_HELD, OVER_LIMIT, UNDECIDED
from handlcp.grasp.cause.judge import TENSION, TORQUE, UNDECIDED as UNKNOWN, Cause, exceeded
from handlcp.grasp.cause.wording import said
from handlcp.grasp.friction import as_section
from handlcp.grasp.limits.followed import Before
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.continued import continued
from handlcp.hand.find.find import find_grasp
from handlcp.hand.hand import Hand
from handlcp.hand.objects.object import Object
from handlcp.progress import told
from handlcp.study.payload.ask import payload

_MOTORS = {TORQUE, TENSION}
_WORST = (NOT_FOUND, NOT_HELD, UNDECIDED, OVER_LIMIT, HELD)


@told("evaluating")
def evaluate(hand: Hand, brief: Brief, near: Evaluation | None = None) -> Evaluation:
    """Find grasps of the brief's objects, and judge each by its loading followed in steps.

    near : of a hand that is much the same, such as the neighbour in a sweep: its grasps are brought along, joints and
        object moved until the tips touch, and checked; where one is lost on the way, and for other objects, a grasp is
        searched for, which takes 20 times as long and more. So the answer hangs on `near`: a search may find better.
    Raises InputError; what `find_grasp` raises, but for NoGraspFound: that is the word "NOT FOUND".
    """
    if not isinstance(hand, Hand):
        raise InputError("hand", "a Hand", repr(hand)[:80])
    if not isinstance(brief, Brief):
        raise InputError("brief", "a Brief", repr(brief)[:80])
    if near is not None and not isinstance(near, Evaluation):
        raise InputError("near", "an Evaluation of another hand, or None", repr(near)[:80])
    before = {} if near is None else {name: case.candidate for name, case in near.cases.items()}
    with told("objects", len(brief.objects)) as done:
        cases = dict[str, ObjectCase]()
        for name, obj in brief.objects.items():
            cases[name] = _case(hand, brief, obj, before.get(name))
            done(1)
    return Evaluation(cases)


def _case(hand: Hand, brief: Brief, obj: Object, near: Candidate | None) -> ObjectCase:
    """Of one object."""
    asked = {"friction": brief.friction, "gravity": (0.0, 0.0, -9.81), **brief.closing}
    brought = None if near is None else continued(hand, obj, near, asked, brief.seed)
    if brought is None:
        found = find_grasp(hand, obj, kind=brief.kind, tries=brief.tries, seed=brief.seed, throw=False, **asked)
        if not found:
            names = (WEIGHT, *brief.loads)
            return ObjectCase(NOT_FOUND, dict.fromkeys(names, NOT_FOUND), dict.fromkeys(names, 0.0), 0.0, found.why)
    one = found[0] if brought is None else brought
    return _judged(brief, obj, one, brought is not None)


def _judged(brief: Brief, obj: Object, one: Candidate, continued: bool) -> ObjectCase:
    """Of a grasp that was found."""
    spec, safety = one.grasp.spec, brief.safety
    payloads = payload(one.grasp, brief.orientations, brief.acceleration, motion=brief.motion)
    before = Before(spec, as_section("cone", planar=False), (brief.most_motion, np.inf))
    limits = {name: before.limit(load) for name, load in brief.loads.items()}
    factors = {WEIGHT: payloads.mass / obj.mass if obj.mass else np.inf}
    factors |= {name: limit.factor for name, limit in limits.items()}
    causes = {WEIGHT: payloads.binds, **{name: limit.binds for name, limit in limits.items()}}
    ends = {WEIGHT: _most([_up_to(row.limit, safety * obj.mass) for row in payloads.by_orientation])}
    ends |= {name: _up_to(limit, safety) for name, limit in limits.items()}
    verdicts = {name: _word(factors[name], safety, causes[name]) for name in factors}
    verdicts[WEIGHT] = _worst((verdicts[WEIGHT], one.verdict.word))
    worst = min(factors, key=lambda name: factors[name])
    gives_out = payloads.says if worst == WEIGHT else said(causes[worst], spec)
    bears = np.inf if brief.most_force is None else brief.most_force
    if pressed := [name for name, end in ends.items() if exceeded(end.force / bears)]:
        verdicts |= {name: _worst((verdicts[name], NOT_HELD)) for name in pressed}
        hardest = max(ends[name].force for name in pressed)
        gives_out = f"the object bears {bears:.3g} N, and is pressed with {hardest:.3g} N"
    end, torques = _most(ends.values()), one.grasp.state.hand.torques
    used = np.where(np.isfinite(torques.limits), abs(end.torque) / torques.limits, 0.0)
    return ObjectCase(
        _worst(verdicts.values()), verdicts, factors, payloads.mass, gives_out, one.kind, continued, end.force,
        float(end.torque.max(initial=0.0)), float(used.max(initial=0.0)), end.motion, one, payloads,
    )  # fmt: skip


class _End(NamedTuple):
    """The largest normal force [N], torques (nv,) [N·m, N] and motion of the object [m] on a path."""

    force: float
    torque: Array
    motion: float


def _up_to(limit: LoadLimit, asked: float) -> _End:
    """On the path of a load up to this factor, or to its limit."""
    path, end = limit.path, min(asked, limit.factor)
    if not len(path.factors):  # the hand does not come to hold anything
        there: Any = limit.at_limit
        return _End(float(there.normal_force.max(initial=0.0)), abs(there.torques), 0.0)

    def seen(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        there = [np.interp(end, path.factors, column) for column in flat.T]
        return np.vstack([flat[path.factors < end], there]).reshape(-1, *values.shape[1:])

    moved = seen(path.displacement[:, :3])
    return _End(
        float(seen(path.forces)[:, :, 2].max(initial=0.0)), abs(seen(path.torques)).max(axis=0),
        float(np.linalg.norm(moved - moved[0], axis=1).max()),
    )  # fmt: skip


def _most(ends: Iterable[_End]) -> _End:
    """The largest of all."""
    force, torque, motion = zip(*ends, strict=True)
    return _End(max(force), np.max(torque, axis=0), max(motion))


def _word(factor: float, safety: float, causes: Iterable[Cause]) -> str:
    """For a load that is held so many times."""
    if factor >= safety:
        return HELD
    kinds = {cause.kind for cause in causes}
    return UNDECIDED if UNKNOWN in kinds or np.isnan(factor) else OVER_LIMIT if kinds and kinds <= _MOTORS else NOT_HELD


def _worst(found: Iterable[str]) -> str:
    """The worst of these words."""
    return min(found, key=_WORST.index)
