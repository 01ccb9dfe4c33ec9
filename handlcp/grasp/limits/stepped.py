"""The load limit by loading in steps (`follow`), for the rare path that is not followed from event to event."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.binds import why_of
from handlcp.grasp.limits.further import largest_held
from handlcp.grasp.limits.result import (
    EQUILIBRIUM,
    MOTION,
    OBJECT,
    RANGE,
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

__all__ = ["confirms", "stepped_limit"]

_STEPS, _MORE = 60, 1.5
_GROWN, _GROWS, _BEYOND = 9, 4.0, 1.25  # a load 300,000 times larger is as good as any
_SHORT, _PAST = 0.03, 1e-3  # of a factor: steps that end between these end where the path does
_RANGE = 1e-9  # of a joint's motion: it may be so far beyond the end of its range
_AT = 1e-3  # of its friction: a contact this close is about to slip
_NAMED = ("slips", "sticks", "opens", "touches", "yields", "holds")


def stepped_limit(
    spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float], near: float = 0.0
) -> LoadLimit:
    """As `fixed_limit`; the factor is one that was reached, short of the limit by a small part of a step. near : a
    factor that was reached otherwise; 0: none is known.
    """
    reach = _BEYOND * near if 0.0 < near < np.inf else _size(spec, section, wrench)
    loading = _loaded(spec, section, wrench, reach)
    last, binds = _ends(loading, spec, most)
    for _ in range(_GROWN):
        if binds:
            break
        reach *= _GROWS
        loading = _loaded(spec, section, wrench, reach)
        last, binds = _ends(loading, spec, most)
    held = _factor(loading, wrench, last)
    if binds and held < reach / _GROWS:
        closer = _loaded(spec, section, wrench, held + _MORE * reach / _STEPS)
        if _ends(closer, spec, most)[1]:
            loading, (last, binds) = closer, _ends(closer, spec, most)
    factor = max(_factor(loading, wrench, last), 0.0) if binds else np.inf
    steps, way = loading.steps, slice(_first(loading), last + 1)
    factors = steps.load[way] @ wrench / float(wrench @ wrench)
    path = LimitPath(read_only(factors), steps.forces[way], steps.torques[way], steps.displacement[way])
    goal = float(steps.load[-1] @ wrench) / float(wrench @ wrench) / (loading.lost_at or 1.0)
    happened = tuple([
        LimitEvent(e.kind, e.who, e.share * goal)
        for e in loading.events
        if e.kind in _NAMED and e.stage == "load" and e.share * goal <= factor
    ])  # fmt: skip
    weight = np.zeros(6) if spec.mechanism is None else spec.mechanism.weight_of_object(spec.reference)

    def beyond(bound: float) -> float:
        return largest_held(spec, section, weight, wrench, factor, bound)

    later = Later(lambda: path, lambda: loading.solution, beyond)
    return LoadLimit(factor, wrench, binds, why_of(factor, wrench, binds), happened, "fixed", later)


def _size(spec: GraspSpec, section: Section, wrench: Array) -> float:
    """The factor with which the load is as large as the forces before it; 1 where there are none."""
    order = ("squeeze", Stage("weight", weight=1.0))
    before = follow(spec, section, np.zeros(6), order, "fixed", _STEPS, None)
    length = float(np.linalg.norm(spec.positions - spec.reference, axis=1).mean()) or 1.0
    load = float(np.linalg.norm(np.append(wrench[:3], wrench[3:] / length)))
    return float(np.linalg.norm(before.steps.forces[-1], axis=1).sum()) / load or 1.0


def confirms(slower: LoadLimit, factor: float) -> bool:
    """Whether loading in steps ends where a path did that was not seen to end, but not followed any further."""
    return bool((1.0 - _SHORT) * factor <= slower.factor <= (1.0 + _PAST) * factor)


def _loaded(spec: GraspSpec, section: Section, wrench: Array, factor: float) -> Loading:
    order = ("squeeze", Stage("weight", weight=1.0), "load")
    return follow(spec, section, factor * wrench, order, "fixed", _STEPS, None)


def _factor(loading: Loading, wrench: Array, last: int) -> float:
    return float(loading.steps.load[last] @ wrench) / float(wrench @ wrench)


def _first(loading: Loading) -> int:
    """The last step without any load."""
    under = np.flatnonzero(loading.steps.load.any(axis=1))
    return max(int(under[0]) - 1, 0) if len(under) else len(loading.steps) - 1


def _ends(loading: Loading, spec: GraspSpec, most: tuple[float, float]) -> tuple[int, tuple[Bind, ...]]:
    """The last step within every limit, and what binds there."""
    steps, first = loading.steps, _first(loading)
    for k in range(first, len(steps)):
        if over := _over(spec, steps.torques[k], steps.states[k].where.q):
            return max(k - 1, first), over
        moved = steps.displacement[k] - steps.displacement[first]
        if np.linalg.norm(moved[:3]) > most[0] or np.linalg.norm(moved[3:]) > most[1]:
            return max(k - 1, first), (Bind(MOTION, OBJECT),)
    end = len(steps) - 1
    if loading.reached:
        return end, ()
    kinds = steps.contact_state[-1]
    sliding = [name for name, kind in zip(spec.names, kinds, strict=True) if kind == "sliding"]
    if not sliding:  # none slides yet where the last step ends just before it
        used = loading.solution.friction_used
        sliding = [spec.names[i] for i in np.flatnonzero(used >= 1.0 - _AT)]
    return end, tuple([Bind(SLIPS, name) for name in sliding]) or (Bind(EQUILIBRIUM, OBJECT),)


def _over(spec: GraspSpec, torque: Array, q: Array) -> tuple[Bind, ...]:
    """Joints beyond their torque limits or ranges; q (nv,) : from the posture [rad, m]."""
    joints = spec.mechanism
    if joints is None:
        return ()
    found = [Bind(TORQUE, joints.names[j]) for j in np.flatnonzero(abs(torque) > (1.0 + 1e-9) * joints.limits)]
    if joints.stands is None or joints.ranges is None:
        return tuple(found)
    (lower, upper), at = joints.ranges, joints.stands + q
    started = (joints.stands >= lower) & (joints.stands <= upper)
    near = _RANGE * abs(q).max(initial=0.0)
    beyond = np.flatnonzero(started & ((at > upper + near) | (at < lower - near)))
    return tuple(found + [Bind(RANGE, joints.names[j]) for j in beyond])
