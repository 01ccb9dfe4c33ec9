"""Where the joints stand, and where the ends of the links are: the grasp is made again as it was asked for, contacts on
an object are detected anew, a squeeze is commanded anew. What that changes in the laws is differenced.

A fingertip that just touches has two sides. Deeper, it counts as squeezed: its joints take it sideways along the
surface while they take it deeper. A gap has no such part. How far a fingertip is inside is therefore kept in these
differences, and what its own change does is added, on the side where it grows (`DepthChange`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.check import Array, check_keys
from handlcp.grasp.derivatives.linearisation_point import DepthChange, LawChange, LinearisationPoint, zero_change
from handlcp.grasp.derivatives.parameter.parameter import (
    JointParameter,
    Parameter,
    ParameterEntry,
    Samples,
    difference_laws,
)
from handlcp.grasp.derivatives.parameter.stiffness import require_hand
from handlcp.grasp.model.request import GraspSpec

_DEPTH_STEP = 1e-6  # [m]: what is differenced is linear in the depth
_SIDEWAYS_TOLERANCE = 1e-6  # of a depth: a sideways motion that is rounding


class _RebuiltParameter(Parameter):
    """What a mechanism can vary (`GraspVariation.vary_parameter`)."""

    def values(self, spec: GraspSpec) -> Array:
        return np.zeros(self.shape(spec))

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        assert spec.mechanism is not None
        made: GraspSpec = spec.mechanism.variation.vary_parameter(spec, self.name, k, step)
        return made

    def change(self, answer: LinearisationPoint) -> LawChange:
        return _rebuild_change(answer, self.name, int(np.prod(self.shape(answer.spec))), self.step)


class JointPosture(JointParameter, _RebuiltParameter):
    """The posture of the joints, (nv,) [rad, m]; derivatives by it are in [1/rad, 1/m].

    In samples, how far the joints stand from where they are said to be; the fingertips go along.
    """

    name = "posture"
    order, effort, spread = 110, 0, "posture"
    uncertain = "Of each joint, in radians or metres."

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Each joint, or those that a mapping names."""
        joints = require_hand(spec, argument, given).names
        named = (
            check_keys(argument, given, joints, "a joint")
            if isinstance(given, Mapping)
            else dict.fromkeys(joints, given)
        )
        return [
            ParameterEntry(f"posture {name}", (joints.index(name),), None, -np.inf, "rad", own, f"{argument}[{name!r}]")
            for name, own in named.items()
        ]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        assert samples.spec.mechanism is not None
        samples.put("joints", 0.0, len(samples.spec.mechanism.names), at, values)


class LinkLengths(_RebuiltParameter):
    """(m, 3) [m] of `GraspVariation.lengths`; derivatives [1/m]."""

    name = "lengths"
    order, step = 120, 1e-7

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (0 if spec.mechanism is None else len(spec.mechanism.variation.lengths), 3)


# ---------------------------------------------------------------- made again, with fingertips that just touch
def depth_change_at(answer: LinearisationPoint) -> DepthChange | None:
    """Of fingertips that count as inside the object, or just touch it and may be inside soon [1/m]; only those that
    are squeezed sideways by that. Its rates are (t, 0). None: there are none.
    """
    spec, mechanism = answer.spec, answer.spec.mechanism
    found = None if mechanism is None else mechanism.variation.inside_depths(spec)
    if mechanism is None or found is None:
        return None
    made, (inside, touches) = mechanism.variation.vary_parameter, found
    some = np.flatnonzero(touches | (inside > 0.0))

    def deeper(j: int, h: float) -> GraspSpec:
        more = inside.copy()
        more[some[j]] += h
        one: GraspSpec = made(spec, "posture", 0, 0.0, more)
        return one

    change = difference_laws(answer, len(some), _DEPTH_STEP, deeper)
    sideways = abs(change.motion).max(axis=0, initial=0.0) > _SIDEWAYS_TOLERANCE
    none = np.zeros((int(sideways.sum()), 0))
    return DepthChange(some[sideways], none, change.columns(sideways)) if sideways.any() else None


def _rebuild_change(answer: LinearisationPoint, what: str, count: int, h: float) -> LawChange:
    """By the entries of what a mechanism can vary; by a step h."""
    spec, mechanism = answer.spec, answer.spec.mechanism
    if mechanism is None:
        return zero_change(answer, 0)
    found, made, deeper = (
        mechanism.variation.inside_depths(spec),
        mechanism.variation.vary_parameter,
        depth_change_at(answer),
    )
    if found is None or deeper is None:
        return difference_laws(
            answer, count, h, lambda k, h: made(spec, what, k, h, None if found is None else found[0])
        )
    gaps: dict[tuple[int, bool], Array] = {}

    def vary_and_measure(k: int, step: float) -> GraspSpec:
        one: GraspSpec = made(spec, what, k, step, found[0])
        assert one.mechanism is not None  # a hand's
        gaps[k, step > 0.0] = one.mechanism.variation.gaps()[deeper.contacts]
        return one

    change = difference_laws(answer, count, h, vary_and_measure)
    none = np.full(len(deeper.contacts), np.nan)
    rates = [(gaps.get((k, False), none) - gaps.get((k, True), none)) / (2.0 * h) for k in range(count)]
    every = replace(change, depth_change=deeper.with_rates(np.column_stack([np.zeros((len(none), 0)), *rates])))
    return every.with_touching(found[1][deeper.contacts])
