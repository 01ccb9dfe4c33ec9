"""How well a hand does what a brief asks: grasps are found, or brought along from another hand, and judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlcp.design.best_grasp import best_grasp
from handlcp.design.brief import Brief
from handlcp.design.evaluation import Evaluation, ObjectCase
from handlcp.design.judged import Known, judged
from handlcp.errors import InputError
from handlcp.hand.find.continued import continued
from handlcp.hand.find.find import ANY
from handlcp.hand.hand import Hand
from handlcp.keywords import helped
from handlcp.progress import told

_FEWER = 8  # times fewer places are tried where a grasp is lost on the way from a neighbour


@helped()
@told("evaluating")
def evaluate(hand: Hand, brief: Brief, near: Evaluation | None = None) -> Evaluation:
    """Find grasps of the brief's objects, and judge each by its loading followed in steps.

    Of the grasps that a search finds the one is told that holds all that is asked and then the largest mass; where none
    does, the one of the largest factor.

    near : of a hand that is much the same, such as the neighbour in a sweep: its grasps are brought along, joints and
        object moved until the tips touch, and checked; where one is lost on the way, and for other objects, a grasp is
        searched for, which takes ten times as long. So the answer hangs on `near`: a search may find better.
    Raises InputError; what `find_grasp` raises, but for NoGraspFound: that is the word "NOT FOUND".
    """
    if not isinstance(hand, Hand):
        raise InputError("hand", "a Hand", repr(hand)[:80])
    if not isinstance(brief, Brief):
        raise InputError("brief", "a Brief", repr(brief)[:80])
    if near is not None and not isinstance(near, Evaluation):
        raise InputError("near", "an Evaluation of another hand, or None", repr(near)[:80])
    with told("objects", len(brief.objects)) as done:
        cases = dict[str, ObjectCase]()
        for name in brief.objects:
            cases[name] = _case(hand, brief, name, near, Known())
            done(1)
    return Evaluation(cases)


def evaluate_worst(hand: Hand, brief: Brief, near: Evaluation | None = None) -> Evaluation:
    """The same for comparing many hands: payload and factor are those of `evaluate`, as are verdicts and what gives out
    first. Objects that hold more than the worst are followed no further than that, or the safety: their own numbers
    are at least what they say. A grasp that is lost on the way is searched for with an eighth of the tries. Arguments
    as in `evaluate`.
    """
    known, cases = Known(), dict[str, ObjectCase]()
    if near is not None:
        brief = replace(brief, tries=max(brief.tries // _FEWER, 1))
    for name in sorted(brief.objects, key=lambda name: _factor(near, name)):  # what was the worst nearby comes first
        cases[name] = _case(hand, brief, name, near, known)
        known.add(cases[name])
    return Evaluation({name: cases[name] for name in brief.objects})


def _factor(near: Evaluation | None, name: str) -> float:
    """Of an object in another evaluation."""
    return np.inf if near is None or name not in near.cases else near.cases[name].factor


def _case(hand: Hand, brief: Brief, name: str, near: Evaluation | None, known: Known) -> ObjectCase:
    """Of one object."""
    obj, asked = brief.objects[name], {"friction": brief.friction, "gravity": (0.0, 0.0, -9.81), **brief.closing}
    there = None if near is None or name not in near.cases else near.cases[name].candidate
    fits = there if there is not None and brief.kind in (there.kind, ANY) else None
    brought = None if fits is None else continued(hand, obj, fits, asked, brief.seed)
    if near is None or brought is None:
        return best_grasp(hand, brief, obj, known)
    return judged(brief, obj, brought, known, near.cases[name])
