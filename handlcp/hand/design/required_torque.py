"""Which motors does a brief take? The torque of each joint, with the grip that needs least, checked before it is said.

Every load of the brief times the safety factor is followed from the first touch: the hand closes without torque limits,
then the load comes. The grip is searched for with which all of them hold and the largest torque is least. What the
joints then need, at any time, becomes their torque limits, and `check` has to call every load HELD.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.analysis.required import tolerance_of
from handlcp.grasp.answer.verdict import HELD, Verdict
from handlcp.grasp.design.least import ORDER, verdict_on
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verdict.check import followed_to
from handlcp.hand.design.brief import Case, cases
from handlcp.hand.design.changed import gripped, hand_of, with_limits
from handlcp.hand.design.least_grip import least_grip
from handlcp.hand.design.motors import RequiredTorque
from handlcp.hand.design.search import least
from handlcp.hand.design.sticking import sticking
from handlcp.hand.design.trials import Trial, Trials

_ROUNDED_UP = 1e-6  # of a torque, so that rounding puts none over its limit


def required_torque(
    spec: GraspSpec, section: Section, loads: Any, safety: Any, tolerance: Any,
    progress: Callable[[int], object] | None = None,
) -> RequiredTorque:  # fmt: skip
    """See `HandGrasp.required_torque`."""
    near = tolerance_of(tolerance)
    brief, hand = cases(spec, loads, safety), hand_of(spec)
    known = bool(np.isfinite(hand.limits).all())
    share = hand.limits if known else np.ones(len(hand.names))
    trials = Trials(brief, section, share, progress)
    best, fails = least(trials, starts(brief, section, share), near)
    torque = np.full(len(hand.names), np.nan)
    verdicts = dict[str, Verdict]()
    if best.holds:
        # What `check` follows has more steps where fewer would end elsewhere, and may see a little more
        paths = [followed_to(gripped(case.spec, best.force), section, ORDER)[0] for case in brief]
        seen = [abs(path.steps.torques).max(axis=0) for path in paths]
        torque = np.max([best.largest, *seen], axis=0) * (1.0 + _ROUNDED_UP)
        torque = np.maximum(torque, _ROUNDED_UP * torque.max(initial=_ROUNDED_UP))
        verdicts = {case.name: _judged(case, best, torque, section) for case in brief}
    names = tuple([case.name for case in brief])
    grip = dict(zip(hand.fingertips, best.force.tolist(), strict=True))
    limits = hand.posture.hand.torques
    less = None if fails is None else float(fails.force.max() / best.force.max())
    lost = best.lost or (None if fails is None else fails.lost)
    return RequiredTorque(
        hand.names, read_only(torque), grip, tuple(["squeeze" if k < 0 else names[k] for k in best.worst.tolist()]),
        names, read_only(best.torque), float(safety), limits.limits, limits.known,
        {name: v.word for name, v in verdicts.items()}, less, lost,
        {name: _why(v) for name, v in verdicts.items() if v.word != HELD},
    )  # fmt: skip


def starts(brief: tuple[Case, ...], section: Section, share: Array) -> list[Array]:
    """Grips (k,) [N] to search from: those with which nothing slips, by finger and common to all; and in any case one
    of the size of the loads.
    """
    states = [sticking(case.spec, gripped) for case in brief]
    k = brief[0].spec.of_fingers
    found = [least_grip(states, section, share, pattern) for pattern in (np.eye(k), np.ones((k, 1)))]
    some = [force for force in found if force is not None and force.any()]
    size = max([float(np.linalg.norm(case.spec.wrench[:3])) for case in brief])
    return some or [np.full(k, (size or 1.0) / k)]


def _why(verdict: Verdict) -> str:
    """What keeps it from being HELD."""
    return "; ".join([r.sentence for r in verdict.reasons if r.severity == "decides"])


def _judged(case: Case, best: Trial, torque: Array, section: Section) -> Verdict:
    """The grasp with this grip and these motors under one load."""
    return verdict_on(with_limits(gripped(case.spec, best.force), torque), section)
