"""`check`: the verdict on a grasp, from one solve, the loading followed in steps, and what would help.

Other equilibria of a grasp with few contacts are looked for by a handful of solves, because Newton's method goes to the
one near where it starts. They start from the end of the loading, and from answers of the same grasp under other loads
and squeezes, where one equilibrium may be the only one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import read_only
from handlcp.contact.friction import Section
from handlcp.errors import Unsupported
from handlcp.grasp.analysis.suggestions import Suggestion, Suggestions, suggest
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.parameter.parameter import (
    MISSING_BALANCE,
    MISSING_FORCES,
    MISSING_TORQUE,
    Trial,
    parameters_by_effort,
    round_two_digits,
)
from handlcp.grasp.effects.joint_offset import describe_missing_squeeze
from handlcp.grasp.failure.failure_mode import find_exceeded, state_limits
from handlcp.grasp.failure.reason import Reason, make_reason
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.path.advance import PATIENT, Patience
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.path.watch import MAX_SLIP
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.verdict import (
    HELD,
    OVER_LIMIT,
    UNDECIDED,
    Verdict,
    equilibrium_reason,
    make_verdict,
    solution_motions,
)
from handlcp.grasp.solve.compiled_answer import start_values
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verdict.path_reasons import (
    comparison_reasons,
    lost_reason,
    place_reasons,
    reached_reasons,
    rigid_reasons,
    slides_reason,
)
from handlcp.lcp import Auto, Status
from handlcp.progress import report_progress, track_progress

_MAX_CONTACTS = 4  # with more, equilibria are too many to look for
_LOAD_SHARES, _SQUEEZE_SHARES = (0.0, 0.5, 2.0), (0.5, 2.0)  # shares of the grasp's own
_OTHER_FORCE_SHARE = 0.01  # of the largest force

_QUICK_CHAIN = Auto(search_seconds=0.0)


def other_equilibria(
    spec: GraspSpec, scene: Scene, section: Section, solution: GraspSolution, end: GraspSolution
) -> Iterator[Reason]:
    """A note where another one than `solution` is found. end : of the loading."""
    if spec.n > _MAX_CONTACTS or not scene.frictional or (solution.uniqueness and solution.uniqueness.others):
        return
    size = float(np.linalg.norm(solution.forces, axis=1).max(initial=0.0))
    starts = [end] if end.held else []
    nearby = [spec.replace(wrench=read_only(share * spec.wrench)) for share in _LOAD_SHARES]
    nearby += [spec.replace(offset=read_only(share * spec.offset)) for share in _SQUEEZE_SHARES]
    starts += [s for s in (solve_spec(other, section, _QUICK_CHAIN, proof=False) for other in nearby) if s.held]
    near = far = 0.0  # by how much forces differ, where motions are small, and anywhere
    for start in starts:
        found = solve_spec(spec, section, _QUICK_CHAIN, start_values(start, scene), scene, proof=False)
        if found.held and (found.uniqueness is None or found.uniqueness.forces_determined):
            differ = float(np.linalg.norm(found.forces - solution.forces, axis=1).max()) / (size or 1.0)
            if differ > _OTHER_FORCE_SHARE:
                near, far = near if solution_motions(found).too_large else max(near, differ), max(far, differ)
    if far > 0.0:
        yield make_reason("others", "note", {"forces_differ": near or far}, "near" if near > 0.0 else "far")


# ----------------------------------------------------------------
# What would help a grasp that does not hold, or not within its torque limits: changes that were tried, and hold.
#
# Each change is tried at a few values, the smallest first: by one solve, and where that holds by following the
# loading in few steps. Only what then has the verdict HELD itself is advice.


_TRIAL_STEPS = 5  # of a stage
_SHIFT_SHARES = (0.1, 0.2)  # of the size, of the place where the object is gripped
_MAX_FOLLOWED = 3  # loadings followed for one kind of change, at most


def advice_reasons(
    spec: GraspSpec,
    section: Section,
    order: Any,
    over: bool,
    holdable: bool,
    judged: Callable[[GraspSpec], Verdict],
    kinds: tuple[str, ...] = (),
) -> Iterator[Reason]:
    """What would hold, one sentence for each kind of change; or that nothing tried does. judged : the verdict on a
    grasp, without advice. kinds : names of the parameters that alone are tried, where the reason is plain; () : all.

    over : whether the grasp holds but for its torque limits. holdable : whether any force within friction balances the
    load; if not, friction alone can help.
    """
    why = MISSING_TORQUE if over else MISSING_FORCES if holdable else MISSING_BALANCE
    limited = spec.mechanism is not None and bool(np.isfinite(spec.mechanism.limits).any())
    within, found, tried = " within the torque limits" if limited else "", False, list[str]()
    changes = [list(p.trials(spec, why)) for p in parameters_by_effort() if p.name in kinds or not kinds]
    if spec.mechanism is not None and not kinds:
        if (out := spec.mechanism.variation.move_object_out(spec)) is not None:
            text, far, moved = out  # of the links that the object begins inside
            changes.insert(0, [Trial("out", far, text, moved)])
        changes.append(list(_shift_trials(spec, spec.mechanism)))
    for trials in changes:
        if trials:
            tried.append(trials[-1].text)
        judgements = ((t, judged(t.spec)) for t in _trials_that_hold(trials, section, order))
        if (helps := next(((t, verdict) for t, verdict in judgements if verdict.ok), None)) is not None:
            trial, verdict = helps
            events = () if verdict.loading is None else verdict.loading.events
            snap = next((f", where {event.sentence}" for event in events if event.kind == "snaps"), "")
            values = {"change": trial.change, "value": trial.value}
            yield make_reason("advice", "advice", values, text=trial.text, within=within, snap=snap)
            found = True
    if tried and not found and not kinds:
        yield make_reason("advice", "advice", {"tried": tried}, "none", within=within)


def _trials_that_hold(trials: list[Trial], section: Section, order: Any) -> Iterator[Trial]:
    """Those that hold to the end of the loading."""
    promising = [t for t in trials if _solves_within_limits(t.spec, section)]
    if (count := len(promising)) > _MAX_FOLLOWED:  # as many as are followed, the first and the last included
        promising = [promising[round(k * (count - 1) / (_MAX_FOLLOWED - 1))] for k in range(_MAX_FOLLOWED)]
    for trial in promising:
        report_progress(f"trying {trial.text}")
        if _holds_within_limits(trial.spec, section, order):
            yield trial


def _solves_within_limits(spec: GraspSpec, section: Section) -> bool:
    """Whether one solve finds an equilibrium within the torque limits."""
    found = solve_spec(spec, section, _QUICK_CHAIN, proof=False)
    check = getattr(found, "torque_check", None)
    return found.held and (check is None or not check.over)


def _holds_within_limits(spec: GraspSpec, section: Section, order: Any) -> bool:
    """Whether the end of the loading is reached within the torque limits."""
    try:
        path = follow(spec, section, None, order, None, _TRIAL_STEPS, None)
    except Unsupported:
        return False
    if not path.in_place or spec.mechanism is None:
        return path.in_place
    return not find_exceeded(state_limits(spec), path.last.efforts)


def _shift_trials(spec: GraspSpec, mechanism: Mechanism) -> Iterator[Trial]:
    """The object gripped elsewhere along the load."""
    load = spec.wrench[:3]
    if (strength := float(np.linalg.norm(load))) == 0.0:
        return
    for share in _SHIFT_SHARES:
        for way, name in ((1.0, "along"), (-1.0, "against")):
            far = round_two_digits(share * build_scene(spec).units.length_unit)
            other = mechanism.variation.regrip_shifted(spec, way * far * load / strength)
            if other is not None:
                text = f"the object {words.format_length(far)} farther {name} the load in the hand"
                yield Trial("grip", way * far, text, other)


# ----------------------------------------------------------------
# What to change: effects left out that matter to an answer, and where a grasp fails, what was tried and holds.


def make_suggestions(
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
    helps, tried = [], tuple([text for r in advice for text in r.values.get("tried", ())])
    for r in advice:
        if (change := r.values.get("change")) is not None:
            ask = _REQUESTS.get(change, f"{change} × {{:g}}").format(r.values["value"])
            helps.append(Suggestion(change, np.inf, r.sentence, ask))
    return replace(effects, found=(*helps, *effects.found), word=verdict.word, tried=tried)


_REQUESTS = {  # by what is changed
    "squeeze": "squeeze or preload, {:g} m more",
    "less squeeze": "squeeze or preload × {:g}",
    "friction": "friction={:g}",
    "stiffness": "joint_stiffness × {:g}",
    "grip": "another placement of the object",
    "out": "the object moved {:g} m out of the hand",
}


# ----------------------------------------------------------------
# The verdict on a grasp: one solve, then the loading followed in steps, then what would help.

STEPS_PER_STAGE = 4  # of a stage, at least: their errors decide how many there are


@track_progress("checking")
def check(
    spec: GraspSpec, scene: Scene, section: Section, order: Any, solution: GraspSolution, max_slip: Any = MAX_SLIP
) -> Verdict:
    """See `Grasp.check`; solution : one solve of this grasp."""
    verdict = judge_grasp(spec, scene, section, order, solution, max_slip)
    if verdict.word in (HELD, UNDECIDED) or verdict.about("not_followed"):
        return verdict
    over, holdable = verdict.word == OVER_LIMIT, solution.status is not Status.NOT_HOLDABLE

    def of(changed: GraspSpec) -> Verdict:
        built = build_scene(changed)
        found = solve_spec(changed, section, _QUICK_CHAIN, proof=False)
        return judge_grasp(changed, built, section, order, found, max_slip)

    kinds = ("squeeze",) if verdict.about("no_squeeze") else ()
    return make_verdict(
        [*verdict.reasons, *advice_reasons(spec, section, order, over, holdable, of, kinds)], verdict.loading
    )


def judge_grasp(
    spec: GraspSpec, scene: Scene, section: Section, order: Any, solution: GraspSolution, max_slip: Any = MAX_SLIP,
    patience: Patience = PATIENT,
) -> Verdict:  # fmt: skip
    """The same without advice, which takes many times as long where the grasp does not hold. patience : as in
    `advance`.
    """
    try:
        path = follow(spec, section, None, order, None, STEPS_PER_STAGE, None, None, max_slip, patience)
    except Unsupported as why:
        return make_verdict([*solution.verdict.reasons, make_reason("not_followed", "warning", why=why)])
    return make_verdict([*_reasons(spec, scene, section, solution, path)], path)


def _reasons(
    spec: GraspSpec, scene: Scene, section: Section, solution: GraspSolution, path: Loading
) -> Iterator[Reason]:
    if path.outcome.is_given_up:
        yield make_reason("follow_stopped", "decides", why=path.why)
        return
    if path.in_place:
        yield from reached_reasons(spec, scene, path)
        if solution.held:
            yield from comparison_reasons(solution, path)
            yield from other_equilibria(spec, scene, section, solution, path.solution)
        elif solution.status is not Status.UNDECIDED:
            yield make_reason("only_followed", "warning", {"status": solution.status.name})
        return
    if solution.status is not Status.NOT_HOLDABLE and (text := describe_missing_squeeze(spec)):
        yield make_reason("no_squeeze", "decides", text=text)
    if solution.status in (Status.NO_EQUILIBRIUM, Status.NOT_HOLDABLE):
        yield equilibrium_reason(solution.status, replace(solution, advise=None).diagnosis)
    yield slides_reason(path) if path.reached else lost_reason(path)
    if spec.mechanism is not None:
        yield from spec.mechanism.report.command_reasons(spec)
    yield from place_reasons(spec, path)
    yield from rigid_reasons(spec)
    if solution.held:
        yield make_reason("followed_forces", "note")
