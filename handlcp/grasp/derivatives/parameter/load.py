"""The load: δb = δw. In samples, a factor on what loads the object besides its weight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint, zero_change
from handlcp.grasp.derivatives.parameter.parameter import (
    SHARE_WORDS,
    TABLE_SHARE,
    Parameter,
    ParameterEntry,
    Samples,
    Shown,
    with_larger_entry,
)
from handlcp.grasp.model.request import GraspSpec


class Wrench(Parameter):
    """(6,) about the reference; derivatives [1/N, 1/(N·m)]."""

    name = "wrench"
    order, effort, step, spread = 50, 0, 1e-4, "load"
    uncertain = f"Of what loads it besides its weight: {SHARE_WORDS}."

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (6,)

    def values(self, spec: GraspSpec) -> Array:
        return spec.wrench

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(wrench=with_larger_entry(spec.wrench, k, step))

    def change(self, answer: LinearisationPoint) -> LawChange:
        change = zero_change(answer, 6)
        change.balance[:] = np.eye(6)
        return change

    def shown(self, answer: LinearisationPoint) -> Shown:
        return Shown("load +10 %", [("", TABLE_SHARE * answer.spec.wrench)])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        return (ParameterEntry("load", (), 1.0, -np.inf, "×", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("load", 1, (), values)


def load_beside_weight(spec: GraspSpec) -> Array:
    """(6,) what loads the object besides its weight, about the reference; 0 where that is rounding."""
    if spec.mechanism is None:
        return spec.wrench
    own = spec.wrench - spec.mechanism.weight_of_object(spec.reference)
    own[abs(own) <= 1e-12 * abs(spec.wrench).max()] = 0.0
    return read_only(own)


def with_load(spec: GraspSpec, load: Array) -> GraspSpec:
    """The grasp under a load (6,) beside the object's weight, about the reference."""
    if spec.mechanism is None:
        return spec.replace(wrench=read_only(np.array(load)))
    made: GraspSpec = spec.mechanism.variation.with_load(spec, load)
    return made


# ----------------------------------------------------------------
# The mass of the object, whose weight is part of the load.


class Mass(Parameter):
    """(1,) [kg] of a grasp of an object with a mass, under gravity; else (0,). δb is the weight of a kilogram."""

    name = "mass"
    order, step, spread = 40, 1e-5, "mass"
    uncertain = f"Of the object: {SHARE_WORDS}."

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return self.values(spec).shape

    def values(self, spec: GraspSpec) -> Array:
        mechanism = spec.mechanism
        weighs = mechanism is not None and mechanism.weight_of_object(spec.reference).any()
        return np.array([mechanism.variation.object_mass]) if mechanism is not None and weighs else np.zeros(0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        """With the weight in the load."""
        mechanism = spec.mechanism
        assert mechanism is not None
        before = mechanism.weight_of_object(spec.reference)
        made = mechanism.variation.with_object_mass(mechanism.variation.object_mass + step)
        return spec.replace(
            mechanism=made, wrench=read_only(spec.wrench + made.weight_of_object(spec.reference) - before)
        )

    def change(self, answer: LinearisationPoint) -> LawChange:
        mass, mechanism = self.values(answer.spec), answer.spec.mechanism
        change = zero_change(answer, len(mass))
        if len(mass) and mechanism is not None:
            change.balance[:, 0] = mechanism.weight_of_object(answer.spec.reference) / mass
        return change

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        values = self.values(spec)
        if not values.any():
            raise InputError(argument, "a grasp of an object with a mass, under gravity; vary 'load' otherwise", "none")
        return (ParameterEntry("mass", (), float(values[0]), 0.0, "kg", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("mass", 1, (), values / self.values(samples.spec)[0])
