"""Parameters of the hand: the springs and torque limits of its joints, where they stand, and the ends of the links."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.derivatives.linearisation import LawChange, LinearisationPoint, difference_laws
from handlcp.grasp.derivatives.parameter.parameter import (
    MISSING_FORCES,
    SHARE_WORDS,
    TABLE_SHARE,
    JointParameter,
    Parameter,
    ParameterEntry,
    Samples,
    Shown,
    Trial,
    factor_entries,
    given_by_name,
    require_hand,
    with_larger_entry,
)
from handlcp.grasp.model.request import GraspSpec
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

_TRIED_FACTORS = (2.0, 5.0, 10.0)  # times as stiff


class Stiffness(JointParameter):
    """(nv,) [N·m/rad]; derivatives [rad/(N·m)] raise Unsupported where the flexibility was given. In samples and as a
    share, a factor on all; without a hand, on the stiffness of the fingers. A spring more at a joint pulls it to where
    it is commanded:

        δv = -J C δK C τ = -J C e_j δ_j,    C = (K + K_g)⁻¹, δ_j how far joint j gives way
    """

    name = "stiffness"
    order, effort, step, together, spread = 20, 2, 1e-4, True, "stiffness"
    common, uncertain = "stiffness of the joints", f"Of the joints: {SHARE_WORDS}."

    def values(self, spec: GraspSpec) -> Array:
        """1 / C_jj; 0 for a rigid joint, and where the flexibility was given."""
        if spec.mechanism is None or not spec.mechanism.variation.has_joint_flexibility(spec):
            return np.zeros(self.shape(spec))
        C = (spec.mechanism.compliance_factor**2).sum(axis=1)
        return np.where(C > 0.0, 1.0 / np.where(C > 0.0, C, 1.0), 0.0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        """Made again as it was asked for."""
        assert spec.mechanism is not None
        made: GraspSpec = spec.mechanism.variation.vary_parameter(spec, "stiffness", k, step)
        return made

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        """All joints, or the fingers where none are known, so many times as stiff. A grip force stays the force that it
        is; a squeeze stays as deep, and a joint offset as large. None: the flexibility is not that of the joints.
        """
        mechanism, k = spec.mechanism, 3 * spec.of_hand
        less, E, made = 1.0 - 1.0 / factor, spec.flexibility.copy(), mechanism
        if mechanism is None:
            E[:k, :k] *= 1.0 / factor
        else:
            E -= less * mechanism.contact_compliance(mechanism.jacobian)
            made = mechanism.variation.with_stiffness_factor(factor)
        if not E.any() or float(np.linalg.eigvalsh(E)[0]) < -SEMIDEFINITE_TOLERANCE * float(abs(E).max()):
            return None
        stiff = spec.replace(mechanism=made, flexibility=read_only(E))
        return stiff if made is None else made.variation.regrip(stiff)

    def change(self, answer: LinearisationPoint) -> LawChange:
        if not answer.elastic_joints:
            raise Unsupported("a grasp whose flexibility was given has no derivative by the stiffness of joints")
        give, loaded = answer.compliance * answer.joints.deflection, answer.loaded_joints
        torque = np.zeros(give.shape) if loaded is None else loaded.stiffness @ give
        motion = -answer.scale[:, None] * (answer.jacobian_rows @ give)
        return answer.law_change(len(give), contact_motion=motion, torque=torque)

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        if answer.spec.mechanism is None or not answer.elastic_joints:
            return None
        C = np.diagonal(answer.compliance)
        return Shown("stiffness +10 %", [("all joints", TABLE_SHARE / np.where(C > 0.0, C, np.inf))])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        if not spec.flexibility[: 3 * spec.of_hand].any():
            raise InputError(argument, "nothing: the fingers of this grasp are rigid", repr(given)[:80])
        if not isinstance(given, Mapping):
            return factor_entries("stiffness", argument, given, (), "")
        mechanism = require_hand(spec, argument)
        if not mechanism.variation.has_joint_springs:
            raise InputError(argument, "one number or distribution for a hand with tendons or synergies", "a mapping")
        return factor_entries("stiffness", argument, given, mechanism.names, "a joint")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        count = 1 if samples.spec.mechanism is None else len(samples.spec.mechanism.names)
        samples.times("springs", count, at, values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        who = "fingers" if spec.mechanism is None else "joints"
        return self.both_shares(spec, share, who + " {} stiffer", who + " {} softer")

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """Stiffer ones, where nothing creates the forces."""
        who = "fingers" if spec.mechanism is None else "joints"
        for factor in _TRIED_FACTORS if why == MISSING_FORCES else ():
            if (made := self.scaled(spec, factor)) is not None:
                yield Trial("stiffness", factor, f"{who} {factor:g} × as stiff", made)


# ----------------------------------------------------------------
# The torque limits of the joints. Only those of joints that yield (`TorqueSaturation`) move anything.


class TorqueLimit(JointParameter):
    """(nv,) [N·m]; 0 where a joint has none."""

    name = "torque_limits"
    order, effort, step, together = 80, 3, 1e-5, True
    common = "torque limits"

    def values(self, spec: GraspSpec) -> Array:
        return np.zeros(0) if spec.mechanism is None else np.where(self.without(spec), 0.0, spec.mechanism.limits)

    def without(self, spec: GraspSpec) -> Bools:
        return np.zeros(0, bool) if spec.mechanism is None else np.asarray(~np.isfinite(spec.mechanism.limits))

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        assert spec.mechanism is not None
        return with_torque_limits(spec, with_larger_entry(spec.mechanism.limits, k, step))

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        if not self.values(spec).any():
            return None
        assert spec.mechanism is not None
        return with_torque_limits(spec, factor * spec.mechanism.limits)

    def change(self, answer: LinearisationPoint) -> LawChange:
        nv = answer.jacobian_rows.shape[1]
        return answer.law_change(nv, torque_limits=np.eye(nv))

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        yield f"{words.format_percent(share)} more torque", self.scaled(spec, 1.0 + share)


def with_torque_limits(spec: GraspSpec, limits: Array) -> GraspSpec:
    """The grasp by a hand whose motors have these limits (nv,) [N·m], inf for none; all of them count as known."""
    assert spec.mechanism is not None
    made: GraspSpec = spec.mechanism.variation.with_torque_limits(spec, read_only(limits))
    return made


# ----------------------------------------------------------------
# Where the joints stand, and where the ends of the links are: the grasp is made again as it was asked for, contacts on
# an object are detected anew, a squeeze is commanded anew. What that changes in the laws is differenced.
#
# How far a fingertip is inside the object is kept in these differences, and what its own change does is added on the
# side where it grows: a fingertip that just touches has two sides (`LawChange.by_depth`).


class _RebuiltParameter(Parameter):
    """What a mechanism can vary (`GraspVariation.vary_parameter`)."""

    def values(self, spec: GraspSpec) -> Array:
        return np.zeros(self.shape(spec))

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        assert spec.mechanism is not None
        made: GraspSpec = spec.mechanism.variation.vary_parameter(spec, self.name, k, step)
        return made

    def change(self, answer: LinearisationPoint) -> LawChange:
        spec, tips, count = answer.spec, answer.tip_depths, int(np.prod(self.shape(answer.spec)))
        gaps = np.full((2, len(tips.contacts), count), np.nan)

        def vary_and_measure(k: int, step: float) -> GraspSpec:
            made: GraspSpec = answer.mechanism.variation.vary_parameter(spec, self.name, k, step, tips.inside)
            if len(tips.contacts):
                assert made.mechanism is not None
                gaps[int(step > 0.0), :, k] = made.mechanism.variation.gaps()[tips.contacts]
            return made

        change = difference_laws(answer, count, self.step, vary_and_measure)
        rates, by_depth, touch = (gaps[0] - gaps[1]) / (2.0 * self.step), tips.change.values, tips.touch
        inside = by_depth[:, ~touch] @ rates[~touch]  # what takes these deeper counts on both sides
        return LawChange(answer, change.values + inside, by_depth[:, touch], rates[touch])


class JointPosture(JointParameter, _RebuiltParameter):
    """The posture of the joints, (nv,) [rad, m]; derivatives by it are in [1/rad, 1/m].

    In samples, how far the joints stand from where they are said to be; the fingertips go along.
    """

    name = "posture"
    order, effort, spread = 110, 0, "posture"
    uncertain = "Of each joint, in radians or metres."

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Each joint, or those that a mapping names."""
        joints = require_hand(spec, argument).names
        return [
            ParameterEntry(f"posture {name}", (joints.index(name),), None, -np.inf, "rad", own, f"{argument}[{name!r}]")
            for name, own in given_by_name(argument, given, joints, "a joint").items()
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
