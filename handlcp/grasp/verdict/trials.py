"""What would help a grasp that does not hold, or not within its torque limits: changes that were tried, and hold.

Each change is tried at a few values, the smallest first: by one solve, and where that holds by following the loading in
few steps. Only what then has the verdict HELD itself is advice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import read_only
from handlcp.errors import Unsupported
from handlcp.grasp.analysis.advice import MOST
from handlcp.grasp.analysis.required import with_friction
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.assembly.build import build
from handlcp.grasp.cause.judge import limits_of, over
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.follow import follow
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Auto
from handlcp.progress import tick
from handlcp.tolerances import SEMIDEFINITE

_STEPS = 5  # of a stage
_FRICTION = (0.3, 0.5, 0.8, 1.0, 1.2)  # coefficients; hardly anything grips better
_STIFFER = (2.0, 5.0, 10.0)  # times as stiff
_SQUEEZES = (0.125, 0.25, 0.375, 0.5, 0.75, 1.0)  # of the most that is tried
_SHIFTS = (0.1, 0.2)  # of the size, of the place where the object is gripped
_LESS = (0.75, 0.5, 0.25)  # of the squeeze
_FOLLOWED = 3  # loadings followed for one kind of change, at most


class _Trial(NamedTuple):
    """value : of what is changed. text : the change in words. spec : the changed grasp."""

    value: float
    text: str
    spec: GraspSpec


@dataclass(frozen=True, slots=True)
class _Change:
    """name : what is changed. trials : makes the grasps to try, the smallest change first."""

    name: str
    trials: Callable[[GraspSpec], Iterator[_Trial]]


def advice(
    spec: GraspSpec, section: Section, order: Any, over: bool, holdable: bool, held: Callable[[GraspSpec], bool]
) -> Iterator[Reason]:
    """What would hold, one sentence for each kind of change; or that nothing tried does. held : whether the verdict on
    a grasp is HELD.

    over : whether the grasp holds but for its torque limits. holdable : whether any force within friction balances the
    load; if not, friction alone can help.
    """
    changes: tuple[_Change, ...] = (_SQUEEZE, _ROUGHEN, _STIFFEN, _REGRIP) if holdable else (_ROUGHEN, _REGRIP)
    if over:
        changes = (_EASE, _ROUGHEN, _REGRIP)
    limited = spec.mechanism is not None and bool(np.isfinite(spec.mechanism.limits).any())
    within, found, tried = " within the torque limits" if limited else "", False, list[str]()
    for change in changes:
        trials = list(change.trials(spec))
        if trials:
            tried.append(trials[-1].text)
        if (trial := next((t for t in _followed(trials, section, order) if held(t.spec)), None)) is not None:
            values = {"change": change.name, "value": trial.value}
            yield Reason("advice", "advice", f"{trial.text} would hold it{within}", values)
            found = True
    if tried and not found:
        text = f"nothing that was tried would hold it{within}, not even {words.either(tried)}"
        yield Reason("advice", "advice", text, {"tried": tried})


def _followed(trials: list[_Trial], section: Section, order: Any) -> Iterator[_Trial]:
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
    return not over(limits_of(spec), path.steps.torques[-1])


def stiffened(spec: GraspSpec, factor: float) -> GraspSpec | None:
    """The grasp with joints that are so many times as stiff, or with fingers where no joints are known; what commands
    them stays. None: its flexibility is not that of the joints, or there is none.
    """
    mechanism, k = spec.mechanism, 3 * spec.of_fingers
    less, E, made = 1.0 - 1.0 / factor, spec.flexibility.copy(), mechanism
    if mechanism is None:
        E[:k, :k] *= 1.0 / factor
    else:
        E -= less * mechanism.compliance(mechanism.jacobian)
        made = mechanism.stiffer(factor)
    if not E.any() or float(np.linalg.eigvalsh(E)[0]) < -SEMIDEFINITE * float(abs(E).max()):
        return None
    return spec.replace(mechanism=made, flexibility=read_only(E))


# ---------------------------------------------------------------- the changes
def _squeezed(spec: GraspSpec) -> Iterator[_Trial]:
    most = MOST * build(spec).units.length
    for share in _SQUEEZES:
        depth = _round(share * most)
        other = spec.squeezed(depth) if spec.mechanism is None else spec.mechanism.squeezed(spec, depth)
        yield _Trial(depth, f"{words.length(depth)} more squeeze on each finger", other)


def _eased(spec: GraspSpec) -> Iterator[_Trial]:
    mechanism = spec.mechanism
    if mechanism is None:  # which limits torques
        return
    for share in _LESS:
        yield _Trial(share, f"{words.percent(share)} of the squeeze", mechanism.eased(spec, share))


def _rougher(spec: GraspSpec) -> Iterator[_Trial]:
    now = [c.mu for c in spec.contacts if c.mu > 0]
    for mu in _FRICTION:
        if now and mu > 1.05 * max(now):
            yield _Trial(mu, f"a friction coefficient of {mu:g}", with_friction(spec, mu))


def _stiffer(spec: GraspSpec) -> Iterator[_Trial]:
    who = "fingers" if spec.mechanism is None else "joints"
    for factor in _STIFFER:
        if (made := stiffened(spec, factor)) is not None:
            yield _Trial(factor, f"{who} {factor:g} × as stiff", made)


def _moved(spec: GraspSpec) -> Iterator[_Trial]:
    mechanism, load = spec.mechanism, spec.wrench[:3]
    strength = float(np.linalg.norm(load))
    if mechanism is None or strength == 0.0:
        return
    for share in _SHIFTS:
        for way, name in ((1.0, "along"), (-1.0, "against")):
            far = _round(share * build(spec).units.length)
            other = mechanism.elsewhere(spec, way * far * load / strength)
            if other is not None:
                yield _Trial(way * far, f"the object {words.length(far)} farther {name} the load in the hand", other)


def _round(x: float) -> float:
    """Two digits."""
    return float(f"{x:.2g}")


_SQUEEZE, _EASE = _Change("squeeze", _squeezed), _Change("less squeeze", _eased)
_ROUGHEN, _STIFFEN = _Change("friction", _rougher), _Change("stiffness", _stiffer)
_REGRIP = _Change("grip", _moved)
