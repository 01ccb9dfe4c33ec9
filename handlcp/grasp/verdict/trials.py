"""What would help a grasp that does not hold, or not within its torque limits: changes that were tried, and hold.

Each change is tried at a few values, the smallest first: by one solve, and where that holds by following the loading in
few steps. Only what then has the verdict HELD itself is advice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from handlcp import words
from handlcp.errors import Unsupported
from handlcp.grasp.answer.verdict import Reason, Verdict
from handlcp.grasp.assembly.build import build
from handlcp.grasp.cause.judge import limits_of, over
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import BALANCE, FORCES, TORQUE, Trial, by_effort, two_digits
from handlcp.grasp.path.follow import follow
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Auto
from handlcp.progress import tick

_STEPS = 5  # of a stage
_SHIFTS = (0.1, 0.2)  # of the size, of the place where the object is gripped
_FOLLOWED = 3  # loadings followed for one kind of change, at most


def advice(
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
    why = TORQUE if over else FORCES if holdable else BALANCE
    limited = spec.mechanism is not None and bool(np.isfinite(spec.mechanism.limits).any())
    within, found, tried = " within the torque limits" if limited else "", False, list[str]()
    changes = [list(p.trials(spec, why)) for p in by_effort() if p.name in kinds or not kinds]
    for trials in changes if kinds else (list(_moved_out(spec)), *changes, list(_moved(spec))):
        if trials:
            tried.append(trials[-1].text)
        judgements = ((t, judged(t.spec)) for t in _followed(trials, section, order))
        if (helps := next(((t, verdict) for t, verdict in judgements if verdict.ok), None)) is not None:
            trial, verdict = helps
            values = {"change": trial.change, "value": trial.value}
            yield Reason("advice", "advice", f"{trial.text} would hold it{within}{_snaps(verdict)}", values)
            found = True
    if tried and not found and not kinds:
        text = f"nothing that was tried would hold it{within}, not even {words.either(tried)}"
        yield Reason("advice", "advice", text, {"tried": tried})


def _snaps(verdict: Verdict) -> str:
    """Where an object that is held has snapped to another place on the way, by how far."""
    events = () if verdict.loading is None else verdict.loading.events
    return next((f", where {event.sentence}" for event in events if event.kind == "snaps"), "")


def _followed(trials: list[Trial], section: Section, order: Any) -> Iterator[Trial]:
    """Those that hold to the end of the loading."""
    promising = [t for t in trials if _bears(t.spec, section)]
    few = promising if len(promising) <= _FOLLOWED else [promising[k] for k in _spread(len(promising))]
    for trial in few:
        tick(f"trying {trial.text}")
        if _holds(trial.spec, section, order):
            yield trial


def _spread(count: int) -> list[int]:
    """As many of them as are followed, the first and the last included."""
    return [round(k * (count - 1) / (_FOLLOWED - 1)) for k in range(_FOLLOWED)]


def _bears(spec: GraspSpec, section: Section) -> bool:
    """Whether one solve finds an equilibrium within the torque limits."""
    found = solve_spec(spec, section, Auto(search_seconds=0.0), proof=False)
    check = getattr(found, "torque_check", None)
    return found.held and (check is None or not check.over)


def _holds(spec: GraspSpec, section: Section, order: Any) -> bool:
    """Whether the end of the loading is reached within the torque limits."""
    try:
        path = follow(spec, section, None, order, None, _STEPS, None)
    except Unsupported:
        return False
    if not path.held or spec.mechanism is None:
        return path.held
    return not over(limits_of(spec), path.last.efforts)


def _moved_out(spec: GraspSpec) -> Iterator[Trial]:
    """The object out of the links that it begins inside."""
    if spec.mechanism is not None and (found := spec.mechanism.moved_out(spec)) is not None:
        text, far, other = found
        yield Trial("out", far, text, other)


def _moved(spec: GraspSpec) -> Iterator[Trial]:
    """The object gripped elsewhere along the load."""
    mechanism, load = spec.mechanism, spec.wrench[:3]
    strength = float(np.linalg.norm(load))
    if mechanism is None or strength == 0.0:
        return
    for share in _SHIFTS:
        for way, name in ((1.0, "along"), (-1.0, "against")):
            far = two_digits(share * build(spec).units.length)
            other = mechanism.elsewhere(spec, way * far * load / strength)
            if other is not None:
                yield Trial(
                    "grip", way * far, f"the object {words.length(far)} farther {name} the load in the hand", other
                )
