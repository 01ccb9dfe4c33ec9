"""The mass of the object, whose weight is part of the load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import SHARE, Entry, Parameter
from handlcp.grasp.parameter.samples import Samples
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, no_change


class Mass(Parameter):
    """(1,) [kg] of a grasp of an object with a mass, under gravity; else (0,). δb is the weight of a kilogram."""

    name = "mass"
    order, step, spread = 40, 1e-5, "mass"
    uncertain = f"Of the object: {SHARE}."

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return self.values(spec).shape

    def values(self, spec: GraspSpec) -> Array:
        mechanism = spec.mechanism
        weighs = mechanism is not None and mechanism.weight_of_object(spec.reference).any()
        return np.array([mechanism.object_mass]) if mechanism is not None and weighs else np.zeros(0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        """With the weight in the load."""
        mechanism = spec.mechanism
        assert mechanism is not None
        before = mechanism.weight_of_object(spec.reference)
        made = mechanism.weighing(mechanism.object_mass + step)
        return spec.replace(
            mechanism=made, wrench=read_only(spec.wrench + made.weight_of_object(spec.reference) - before)
        )

    def change(self, answer: Answer) -> Change:
        mass, mechanism = self.values(answer.spec), answer.spec.mechanism
        change = no_change(answer, len(mass))
        if len(mass) and mechanism is not None:
            change.balance[:, 0] = mechanism.weight_of_object(answer.spec.reference) / mass
        return change

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[Entry]:
        values = self.values(spec)
        if not values.any():
            raise InputError(argument, "a grasp of an object with a mass, under gravity; vary 'load' otherwise", "none")
        return (Entry("mass", (), float(values[0]), 0.0, "kg", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("mass", 1, (), values / self.values(samples.spec)[0])
