"""How well a hand does what a brief asks: grasps are found, or brought along from another hand, and judged.

A grasp of another hand is one candidate more, beside what the search finds: alone it may hold a seventh of that.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import check_call
from handlcp.design.best_grasp import best_grasp, worth
from handlcp.design.brief import Brief
from handlcp.design.evaluation import Evaluation, ObjectCase
from handlcp.design.judged import Known, judged
from handlcp.errors import InputError
from handlcp.hand.find.continued import continued
from handlcp.hand.find.find import ANY
from handlcp.hand.hand import Hand
from handlcp.progress import track_progress
from handlcp.robot.hand_model import DEFAULT_GRAVITY


@check_call()
@track_progress("evaluating")
def evaluate(hand: Hand, brief: Brief, near: Evaluation | None = None) -> Evaluation:
    """Find grasps of the brief's objects, and judge each by its loading followed in steps.

    Of the grasps that a search finds the one is told that holds all that is asked and then the largest mass; where none
    does, the one of the largest factor.

    near : of a hand that is much the same, such as the neighbour in a sweep: its grasps are brought along, joints and
        object moved until the tips touch, and checked. Each is told where it does better than what the search finds,
        which is made anyway: the answer is never worse than without `near`, and takes no less time.
    Raises InputError; what `find_grasp` raises, but for NoGraspFound: that is the word "NOT FOUND".
    """
    if not isinstance(hand, Hand):
        raise InputError("hand", "a Hand", repr(hand)[:80])
    if not isinstance(brief, Brief):
        raise InputError("brief", "a Brief", repr(brief)[:80])
    if near is not None and not isinstance(near, Evaluation):
        raise InputError("near", "an Evaluation of another hand, or None", repr(near)[:80])
    with track_progress("objects", len(brief.objects)) as done:
        cases = dict[str, ObjectCase]()
        for name in brief.objects:
            cases[name] = _evaluate_object(hand, brief, name, near, Known())
            done(1)
    return Evaluation(cases)


def evaluate_worst(hand: Hand, brief: Brief, near: Evaluation | None = None) -> Evaluation:
    """Evaluate a hand for comparing many: payload, factor, verdicts and what gives out first are those of `evaluate`.

    Objects that hold more than the worst are followed no further than that, or the safety: their own numbers are at
    least what they say. Arguments as in `evaluate`.
    """
    known, cases = Known(), dict[str, ObjectCase]()
    for name in sorted(
        brief.objects, key=lambda name: _nearby_factor(near, name)
    ):  # what was the worst nearby comes first
        cases[name] = _evaluate_object(hand, brief, name, near, known)
        known.add(cases[name])
    return Evaluation({name: cases[name] for name in brief.objects})


def _nearby_factor(near: Evaluation | None, name: str) -> float:
    """How many times an object was held in another evaluation, infinite where that is not known."""
    return np.inf if near is None or name not in near.cases else near.cases[name].factor


def evaluate_same_grasps(hand: Hand, brief: Brief, near: Evaluation) -> Evaluation:
    """Judge the grasps of `near` alone, otherwise as `evaluate_worst`: differences between hands need the same grasps.

    An object whose grasp is lost on the way is left out.
    """
    known, cases = Known(), dict[str, ObjectCase]()
    for name in sorted(brief.objects, key=lambda name: _nearby_factor(near, name)):
        if (case := _bring_grasp(hand, brief, name, near, known)) is not None:
            cases[name] = case
            known.add(case)
    return Evaluation({name: cases[name] for name in brief.objects if name in cases})


def _evaluate_object(hand: Hand, brief: Brief, name: str, near: Evaluation | None, known: Known) -> ObjectCase:
    """Judge the grasp that the search finds for one object, or that of `near` where it does better."""
    found = best_grasp(hand, brief, brief.objects[name], known)
    brought = None if near is None else _bring_grasp(hand, brief, name, near, known)
    return found if brought is None or worth(brought) <= worth(found) else brought


def _bring_grasp(hand: Hand, brief: Brief, name: str, near: Evaluation, known: Known) -> ObjectCase | None:
    """The grasp of another hand, brought along; None where there is none, or it is lost on the way."""
    obj, asked = brief.objects[name], {"friction": brief.friction, "gravity": DEFAULT_GRAVITY, **brief.closing}
    there = near.cases[name].candidate if name in near.cases else None
    if there is None or brief.kind not in (there.kind, ANY):
        return None
    one = continued(hand, obj, there, asked, brief.seed)
    return None if one is None else judged(brief, obj, one, known, near.cases[name])
