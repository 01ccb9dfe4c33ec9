"""The verdict on a grasp: one solve, then the loading followed in steps, then what would help."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.errors import Unsupported
from handlcp.grasp.analysis.suggestions import Suggestion, Suggestions, suggest
from handlcp.grasp.answer.reasons import equilibrium_reason
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.verdict import HELD, OVER_LIMIT, UNDECIDED, Reason, Verdict, verdict_of
from handlcp.grasp.assembly.build import build
from handlcp.grasp.effects.joint_offset import unsqueezed
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.advance import PATIENT, Patience
from handlcp.grasp.path.follow import Loading, follow, sliding
from handlcp.grasp.path.state import Outcome
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verdict.others import other_equilibria
from handlcp.grasp.verdict.path_reasons import (
    compared,
    lost_reason,
    place_reasons,
    reached_reasons,
    rigid_reasons,
    slides_reason,
)
from handlcp.grasp.verdict.trials import advice
from handlcp.lcp import Auto, Status
from handlcp.progress import told

# ----------------------------------------------------------------
# What to change: effects left out that matter to an answer, and where a grasp fails, what was tried and holds.


def suggested(
    spec: GraspSpec, section: Section, solution: GraspSolution, least: float, verdict: Verdict
) -> Suggestions:
    """Which effects that are left out matter, and what would help. verdict : of this grasp by `check`, or the
    solution's own where that is HELD. Without an answer no effect can be judged; then the advice of the verdict is all
    there is.
    """
    effects = suggest(spec, section, solution, least) if solution.held else Suggestions((), (), (), least)
    if verdict.ok and solution.held:
        return effects
    advice = verdict.about("advice")
    helps = tuple([_suggestion(r) for r in advice if "change" in r.values])
    tried = tuple([text for r in advice for text in r.values.get("tried", ())])
    return replace(effects, found=(*helps, *effects.found), word=verdict.word, tried=tried)


def _suggestion(r: Reason) -> Suggestion:
    change, value = r.values["change"], r.values["value"]
    ask = {
        "squeeze": f"squeeze or preload, {value:g} m more",
        "less squeeze": f"squeeze or preload × {value:g}",
        "friction": f"friction={value:g}",
        "stiffness": f"joint_stiffness × {value:g}",
        "grip": "another placement of the object",
        "out": f"the object moved {value:g} m out of the hand",
    }
    return Suggestion(change, np.inf, r.sentence, ask.get(change, f"{change} × {value:g}"))


# ----------------------------------------------------------------

# Which another number of steps contradicts
_OF_ONE_PATH = "no_squeeze", "lost", "slides_through", "no_equilibrium", "not_holdable"
_CHAIN = Auto(search_seconds=0.0)
_ONE_SOLVE = "one solve, with squeeze and load at once in this posture"
STEPS = 8  # of a stage; where something happens there are more
_MORE = 2  # how often the number of steps is doubled, where fewer steps end differently


@told("checking")
def check(spec: GraspSpec, scene: Scene, section: Section, order: Any, solution: GraspSolution) -> Verdict:
    """See `Grasp.check`; solution : one solve of this grasp."""
    verdict = judged(spec, scene, section, order, solution)
    if verdict.word in (HELD, UNDECIDED) or verdict.about("not_followed"):
        return verdict
    over, holdable = verdict.word == OVER_LIMIT, solution.status is not Status.NOT_HOLDABLE

    def of(changed: GraspSpec) -> Verdict:
        built = build(changed)
        return judged(changed, built, section, order, solve_spec(changed, section, _CHAIN, proof=False))

    kinds = ("squeeze",) if verdict.about("no_squeeze") else ()
    return verdict_of([*verdict.reasons, *advice(spec, section, order, over, holdable, of, kinds)], verdict.loading)


def judged(
    spec: GraspSpec, scene: Scene, section: Section, order: Any, solution: GraspSolution, patience: Patience = PATIENT
) -> Verdict:  # fmt: skip
    """The same without advice, which takes many times as long where the grasp does not hold. patience : as in
    `advance`.
    """
    try:
        path, agree = followed_to(spec, section, order, patience)
    except Unsupported as why:
        unfollowed = Reason("not_followed", "warning", f"the loading was not followed: {why}")
        return verdict_of([*solution.verdict.reasons, unfollowed])
    reasons = [*_reasons(spec, scene, section, solution, path)]
    if not agree:
        text = "fewer and more steps of loading end differently: one says that it holds, another that it does not"
        reasons.append(Reason("steps_differ", "decides", text))
        reasons = [r for r in reasons if r.code not in _OF_ONE_PATH]
    return verdict_of(reasons, path)


def followed_to(spec: GraspSpec, section: Section, order: Any, patience: Patience = PATIENT) -> tuple[Loading, bool]:
    """The loading in STEPS steps a stage, and whether it ends as with half as many. Where it does not, the number is
    doubled, up to twice. Where nothing slides and nothing happens, half as many steps are exact, and enough. Raises
    Unsupported.
    """
    coarse, count = follow(spec, section, None, order, None, STEPS // 2, None, patience=patience), STEPS
    if _sticks(coarse):
        return coarse, True  # such steps are exact, however long
    path = follow(spec, section, None, order, None, STEPS, None, patience=patience)
    if path.outcome is Outcome.GAVE_UP:
        return path, True
    for _ in range(_MORE):
        if coarse.held == path.held:
            return path, True
        count *= 2
        coarse, path = path, follow(spec, section, None, order, None, count, None, patience=patience)
    return path, coarse.held == path.held


def _sticks(path: Loading) -> bool:
    """Whether the end is reached, nothing slides on the way, and nothing else happens."""
    return path.held and not path.events and not sliding(path)


def _reasons(
    spec: GraspSpec, scene: Scene, section: Section, solution: GraspSolution, path: Loading
) -> Iterator[Reason]:
    if path.outcome is Outcome.GAVE_UP:
        yield Reason("follow_stopped", "decides", f"the loading was {path.why}")
        return
    if path.held:
        yield from reached_reasons(spec, scene, path)
        if solution.held:
            yield from compared(solution, path)
            yield from other_equilibria(spec, scene, section, solution, path.solution)
        elif solution.status is not Status.UNDECIDED:
            text = f"{_ONE_SOLVE}, finds no equilibrium: the grasp holds as it moves"
            yield Reason("only_followed", "warning", text, {"status": solution.status.name})
        return
    if solution.status is not Status.NOT_HOLDABLE and (text := unsqueezed(spec)):
        yield Reason("no_squeeze", "decides", text)
    if solution.status in (Status.NO_EQUILIBRIUM, Status.NOT_HOLDABLE):
        yield equilibrium_reason(solution.status, _without_advice(solution).diagnosis)
    yield slides_reason(path) if path.reached else lost_reason(path)
    if spec.mechanism is not None:
        yield from spec.mechanism.command_reasons(spec)
    yield from place_reasons(spec, path)
    yield from rigid_reasons(spec)
    if solution.held:
        text = f"{_ONE_SOLVE}, finds an equilibrium, which this loading does not reach"
        yield Reason("followed_forces", "note", text)


def _without_advice(solution: GraspSolution) -> GraspSolution:
    return replace(solution, advise=None)
