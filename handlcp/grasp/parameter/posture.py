"""Where the joints stand, and where the ends of the links are: the grasp is made again as it was asked for, contacts on
an object are detected anew, a squeeze is commanded anew. What that changes in the laws is differenced.

A fingertip that just touches has two sides. Deeper, it counts as squeezed: its joints take it sideways along the
surface while they take it deeper. A gap has no such part. How far a fingertip is inside is therefore kept in these
differences, and what its own change does is added, on the side where it grows (`Deeper`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.check import Array, per_name
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.differences import differences
from handlcp.grasp.parameter.parameter import Entry, OfJoints, Parameter
from handlcp.grasp.parameter.samples import Samples
from handlcp.grasp.parameter.stiffness import hand
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, Deeper, no_change

_DEPTH = 1e-6  # [m]: what is differenced is linear in the depth
_NOTHING = 1e-6  # of a depth: a sideways motion that is rounding


class _MadeAgain(Parameter):
    """What a mechanism can vary (`Mechanism.varied`)."""

    def values(self, spec: GraspSpec) -> Array:
        return np.zeros(self.shape(spec))

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        assert spec.mechanism is not None
        made: GraspSpec = spec.mechanism.varied(spec, self.name, k, step)
        return made

    def change(self, answer: Answer) -> Change:
        return _made_again(answer, self.name, int(np.prod(self.shape(answer.spec))), self.step)


class Posture(OfJoints, _MadeAgain):
    """(nv,) [rad, m]; derivatives [1/rad, 1/m]. In samples, how far the joints stand from where they are said to be;
    the fingertips go along.
    """

    name = "posture"
    order, effort, spread = 110, 0, "posture"
    uncertain = "Of each joint, in radians or metres."

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[Entry]:
        """Each joint, or those that a mapping names."""
        joints = hand(spec, argument, given).names
        named = (
            per_name(argument, given, joints, "a joint") if isinstance(given, Mapping) else dict.fromkeys(joints, given)
        )
        return [
            Entry(f"posture {name}", (joints.index(name),), None, -np.inf, "rad", own, f"{argument}[{name!r}]")
            for name, own in named.items()
        ]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        assert samples.spec.mechanism is not None
        samples.put("joints", 0.0, len(samples.spec.mechanism.names), at, values)


class Lengths(_MadeAgain):
    """(m, 3) [m] of `Mechanism.lengths`; derivatives [1/m]."""

    name = "lengths"
    order, step = 120, 1e-7

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (0 if spec.mechanism is None else len(spec.mechanism.lengths), 3)


# ---------------------------------------------------------------- made again, with fingertips that just touch
def by_depth(answer: Answer) -> Deeper | None:
    """Of fingertips that count as inside the object, or just touch it and may be inside soon [1/m]; only those that
    are squeezed sideways by that. rates : (t, 0). None: there are none.
    """
    spec, mechanism = answer.spec, answer.spec.mechanism
    found = None if mechanism is None else mechanism.inside(spec)
    if mechanism is None or found is None:
        return None
    made, (inside, touches) = mechanism.varied, found
    some = np.flatnonzero(touches | (inside > 0.0))

    def deeper(j: int, h: float) -> GraspSpec:
        more = inside.copy()
        more[some[j]] += h
        one: GraspSpec = made(spec, "posture", 0, 0.0, more)
        return one

    change = differences(answer, len(some), _DEPTH, deeper)
    sideways = abs(change.motion).max(axis=0, initial=0.0) > _NOTHING
    none = np.zeros((int(sideways.sum()), 0))
    return Deeper(some[sideways], none, change.some(sideways)) if sideways.any() else None


def _made_again(answer: Answer, what: str, count: int, h: float) -> Change:
    """By the entries of what a mechanism can vary; by a step h."""
    spec, mechanism = answer.spec, answer.spec.mechanism
    if mechanism is None:
        return no_change(answer, 0)
    found, made, deeper = mechanism.inside(spec), mechanism.varied, by_depth(answer)
    if found is None or deeper is None:
        return differences(answer, count, h, lambda k, h: made(spec, what, k, h, None if found is None else found[0]))
    gaps: dict[tuple[int, bool], Array] = {}

    def kept(k: int, step: float) -> GraspSpec:
        one: GraspSpec = made(spec, what, k, step, found[0])
        assert one.mechanism is not None  # a hand's
        gaps[k, step > 0.0] = one.mechanism.gaps()[deeper.contacts]
        return one

    change = differences(answer, count, h, kept)
    none = np.full(len(deeper.contacts), np.nan)
    rates = [(gaps.get((k, False), none) - gaps.get((k, True), none)) / (2.0 * h) for k in range(count)]
    every = replace(change, deeper=deeper.by(np.column_stack([np.zeros((len(none), 0)), *rates])))
    return every.bent_at(found[1][deeper.contacts])
