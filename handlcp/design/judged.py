"""A grasp judged by a brief: the path of each loading, what gives out first, and the numbers on the way.

    weight    factor = payload / mass        the least over the orientations of gravity
    a load    factor                         of a load that grows beside the weight, the hand upright

Each factor is held if it is at least the safety that was asked for. What is compared between designs is what gives out
first. So the weakest are followed first, and others up to what these hold: a tenth of the time.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.contact.friction import as_section
from handlcp.design.brief import WEIGHT_NAME, Brief
from handlcp.design.evaluation import NOT_FOUND, ObjectCase
from handlcp.geometry.object import Object
from handlcp.grasp import LoadLimit
from handlcp.grasp.failure.failure_mode import TENSION, TORQUE, UNDECIDED as UNKNOWN, FailureMode, is_exceeded
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.followed import Before, anything_else, up_to_the_first
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.advance import Patience
from handlcp.grasp.solution.verdict import HELD, NOT_HELD, OVER_LIMIT, UNDECIDED
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.studies.payload.largest_mass import ANY, find_payload, unit_mass_loads

_MOTORS = {TORQUE, TENSION}
_WORST = (NOT_FOUND, NOT_HELD, UNDECIDED, OVER_LIMIT, HELD)
_NEWTON = 1e-6  # of a step, of the contacts' radii: factors are the same to 1e-7, to 1e-4 where contacts slide before

_PATIENCE = Patience(500)  # where that many steps lead to no end, more is undecided


@dataclass
class Known:
    """The least payload [kg] and factor of other objects: nothing is followed beyond both of them and the safety."""

    payload: float = np.inf
    factor: float = np.inf

    def add(self, case: ObjectCase) -> None:
        """One more object."""
        self.payload, self.factor = min(self.payload, case.payload), min(self.factor, case.factor)


def judged(brief: Brief, obj: Object, one: Candidate, known: Known, near: ObjectCase | None = None) -> ObjectCase:
    """Of a grasp that was found, or brought along from the one of `near`: what gave out first there is likely to be
    what does here.
    """
    grasp, spec, safety = one.grasp, one.grasp.spec, brief.safety
    likely: Sequence[float] = () if near is None else near.masses
    weights = _weights(grasp, brief, safety * obj.mass, max(known.payload, known.factor * obj.mass), likely)
    masses = tuple(min(limit.factor, until) for limit, until in weights)
    mass = min(masses)
    factors = {WEIGHT_NAME: mass / obj.mass if obj.mass else np.inf}
    before = unloaded(brief, spec)
    likely = () if near is None else [near.factors[name] for name in brief.loads if name in near.factors]
    asked = [(before, load) for load in brief.loads.values()]
    loads = up_to_the_first(asked, safety, min(factors[WEIGHT_NAME], known.factor), likely)
    limits = dict(zip(brief.loads, loads, strict=True))
    factors |= {name: min(limit.factor, until) for name, (limit, until) in limits.items()}
    causes = {WEIGHT_NAME: min([limit for limit, _ in weights], key=lambda limit: limit.factor).binds}
    causes |= {name: limit.binds for name, (limit, _) in limits.items()}
    ends = {WEIGHT_NAME: _most([_up_to(limit, safety * obj.mass) for limit, _ in weights])}
    ends |= {name: _up_to(limit, safety) for name, (limit, _) in limits.items()}
    verdicts = {name: _word(factors[name], safety, causes[name]) for name in factors}
    verdicts[WEIGHT_NAME] = _worst((verdicts[WEIGHT_NAME], one.verdict.word))
    worst = min(factors, key=lambda name: factors[name])
    gives_out = describe_failures(causes[worst], spec) if causes[worst] else ""
    bears = np.inf if brief.most_force is None else brief.most_force
    if pressed := [name for name, end in ends.items() if is_exceeded(end.force / bears)]:
        verdicts |= {name: _worst((verdicts[name], NOT_HELD)) for name in pressed}
        hardest = max(ends[name].force for name in pressed)
        gives_out = f"the object bears {bears:.3g} N, and is pressed with {hardest:.3g} N"
    end, torques = _most(ends.values()), grasp.state.hand.torques
    used = np.where(np.isfinite(torques.limits), abs(end.torque) / torques.limits, 0.0)
    return ObjectCase(
        _worst(verdicts.values()), verdicts, factors, mass, gives_out, one.kind, near is not None, end.force,
        float(end.torque.max(initial=0.0)), float(used.max(initial=0.0)), end.motion, one, masses,
    )  # fmt: skip


def _weights(
    grasp: HandGrasp, brief: Brief, least: float, most: float, likely: Sequence[float]
) -> list[tuple[LoadLimit, float]]:  # fmt: skip
    """Of 1 kg in each orientation, as `Grasp.payload` has them, with the mass [kg] up to which each was followed, as in
    `up_to_the_first`.
    """
    if brief.orientations == ANY:
        rows = find_payload(grasp, ANY, brief.acceleration, motion=brief.motion).by_orientation
        return [(row.limit, np.inf) for row in rows]
    pulls = unit_mass_loads(grasp, brief.acceleration)
    specs = {id(spec): spec for spec, _ in pulls}  # several where gravity pulls at fingers that weigh something
    befores = {key: unloaded(brief, spec) for key, spec in specs.items()}
    loads = [(befores[id(spec)], wrench) for spec, wrench in pulls]
    return up_to_the_first(loads, least, most, likely)


def unloaded(brief: Brief, spec: GraspSpec) -> Before:
    """What comes before the loads."""
    allowed = anything_else(spec)._replace(motion=brief.most_motion)
    return Before(spec, as_section("cone", planar=False), allowed, tolerance=_NEWTON, patience=_PATIENCE)


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


def _word(factor: float, safety: float, causes: Iterable[FailureMode]) -> str:
    """For a load that is held so many times."""
    if factor >= safety:
        return HELD
    kinds = {cause.kind for cause in causes}
    return UNDECIDED if UNKNOWN in kinds or np.isnan(factor) else OVER_LIMIT if kinds and kinds <= _MOTORS else NOT_HELD


def _worst(found: Iterable[str]) -> str:
    """The worst of these words."""
    return min(found, key=_WORST.index)
