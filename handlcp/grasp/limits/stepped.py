"""The load limit by loading in steps (`follow`), for the rare path that is not followed from event to event."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.binds import why_of
from handlcp.grasp.limits.further import bound_beside, largest_held
from handlcp.grasp.limits.result import (
    EQUILIBRIUM,
    MOTION,
    OBJECT,
    SLIPS,
    TORQUE,
    Bind,
    Later,
    LimitEvent,
    LimitPath,
    LoadLimit,
)  # fmt: skip
from handlcp.grasp.loading.follow import Loading, follow
from handlcp.grasp.loading.stage import Stage
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["stepped_limit"]

_STEPS, _DOUBLED, _BEYOND = 60, 40, 1.02
_NAMED = ("slips", "sticks", "opens", "touches", "yields", "holds")


def stepped_limit(spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float]) -> LoadLimit:
    """As `fixed_limit`; the factor is one that was reached, short of the limit by a small part of a step."""
    reach, loading = 1.0, _loaded(spec, section, wrench, 1.0)
    for _ in range(_DOUBLED):
        if not loading.reached or _ends(loading, spec, most)[0] < len(loading.steps) - 1:
            break
        reach *= 2.0
        loading = _loaded(spec, section, wrench, reach)
    last, binds = _ends(loading, spec, most)
    if not loading.reached or last < len(loading.steps) - 1:
        near = _BEYOND * max(_factor(loading, wrench, last), 1e-9 * reach)
        loading = _loaded(spec, section, wrench, near)
        last, binds = _ends(loading, spec, most)
    factor = _factor(loading, wrench, last) if binds else np.inf
    steps = loading.steps
    factors = np.array([float(load @ wrench) / float(wrench @ wrench) for load in steps.load[: last + 1]])
    path = LimitPath(
        read_only(factors), steps.forces[: last + 1], steps.torques[: last + 1], steps.displacement[: last + 1]
    )  # fmt: skip
    goal = float(steps.load[-1] @ wrench) / float(wrench @ wrench) / (loading.lost_at or 1.0)
    happened = tuple([
        LimitEvent(e.kind, e.who, e.share * goal)
        for e in loading.events
        if e.kind in _NAMED and e.stage == "load" and e.share * goal <= factor
    ])  # fmt: skip
    weight = np.zeros(6) if spec.mechanism is None else spec.mechanism.weight_of_object(spec.reference)

    def bound() -> float:
        return bound_beside(spec, section, wrench)

    def furthest() -> float:
        return largest_held(spec, section, weight, wrench, factor, bound())

    later = Later(lambda: path, lambda: loading.solution, furthest, bound)
    return LoadLimit(factor, wrench, binds, why_of(factor, wrench, binds), happened, "fixed", later)


def _loaded(spec: GraspSpec, section: Section, wrench: Array, factor: float) -> Loading:
    order = ("squeeze", Stage("weight", weight=1.0), "load")
    return follow(spec, section, factor * wrench, order, "fixed", _STEPS, None)


def _factor(loading: Loading, wrench: Array, last: int) -> float:
    return float(loading.steps.load[last] @ wrench) / float(wrench @ wrench)


def _ends(loading: Loading, spec: GraspSpec, most: tuple[float, float]) -> tuple[int, tuple[Bind, ...]]:
    """The last step within every limit, and what binds there."""
    steps = loading.steps
    under = np.flatnonzero(steps.load.any(axis=1))
    first = int(under[0]) - 1 if len(under) else len(steps) - 1
    for k in range(max(first, 0), len(steps)):
        if spec.mechanism is not None:
            over = np.flatnonzero(abs(steps.torques[k]) > (1.0 + 1e-9) * spec.mechanism.limits)
            if len(over):
                return k - 1, tuple([Bind(TORQUE, spec.mechanism.names[j]) for j in over])
        moved = steps.displacement[k] - steps.displacement[max(first, 0)]
        if np.linalg.norm(moved[:3]) > most[0] or np.linalg.norm(moved[3:]) > most[1]:
            return k - 1, (Bind(MOTION, OBJECT),)
    end = len(steps) - 1
    if loading.reached:
        return end, ()
    kinds = steps.contact_state[-1]
    sliding = [name for name, kind in zip(spec.names, kinds, strict=True) if kind == "sliding"]
    if sliding and "sticking" not in kinds:
        return end, tuple([Bind(SLIPS, name) for name in sliding])
    return end, (Bind(EQUILIBRIUM, OBJECT),)
