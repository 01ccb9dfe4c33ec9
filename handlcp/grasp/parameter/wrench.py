"""The load: δb = δw. In samples, a factor on what loads the object besides its weight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import SHARE, TENTH, Entry, Parameter, Shown, larger
from handlcp.grasp.parameter.samples import Samples
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, no_change


class Wrench(Parameter):
    """(6,) about the reference; derivatives [1/N, 1/(N·m)]."""

    name = "wrench"
    order, effort, step, spread = 50, 0, 1e-4, "load"
    uncertain = f"Of what loads it besides its weight: {SHARE}."

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (6,)

    def values(self, spec: GraspSpec) -> Array:
        return spec.wrench

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(wrench=larger(spec.wrench, k, step))

    def change(self, answer: Answer) -> Change:
        change = no_change(answer, 6)
        change.balance[:] = np.eye(6)
        return change

    def shown(self, answer: Answer) -> Shown:
        return Shown("load +10 %", [("", TENTH * answer.spec.wrench)])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[Entry]:
        return (Entry("load", (), 1.0, -np.inf, "×", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("load", 1, (), values)


def beside_weight(spec: GraspSpec) -> Array:
    """(6,) what loads the object besides its weight, about the reference; 0 where that is rounding."""
    if spec.mechanism is None:
        return spec.wrench
    own = spec.wrench - spec.mechanism.weight_of_object(spec.reference)
    own[abs(own) <= 1e-12 * abs(spec.wrench).max()] = 0.0
    return read_only(own)


def loaded(spec: GraspSpec, load: Array) -> GraspSpec:
    """The grasp under a load (6,) beside the object's weight, about the reference."""
    if spec.mechanism is None:
        return spec.replace(wrench=read_only(np.array(load)))
    made: GraspSpec = spec.mechanism.loaded(spec, load)
    return made
