"""`Stiffness`: the springs of the joints. A spring more at a joint pulls it to where it is commanded:

    δv = -J C δK C τ = -J C e_j δ_j,    C = (K + K_g)⁻¹, δ_j how far joint j gives way

In samples and as a share, a factor on them; without a hand, on the stiffness of the fingers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint, restrict_to_plane, zero_change
from handlcp.grasp.derivatives.parameter.parameter import (
    MISSING_FORCES,
    SHARE_WORDS,
    TABLE_SHARE,
    ContactParameter,
    JointParameter,
    ParameterEntry,
    Samples,
    Shown,
    Trial,
    factor_entries,
    scale_both_ways,
    with_larger_entry,
)
from handlcp.grasp.model.request import GraspSpec
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

_TRIED_FACTORS = (2.0, 5.0, 10.0)  # times as stiff


class Stiffness(JointParameter):
    """(nv,) [N·m/rad]; derivatives [rad/(N·m)] raise Unsupported where the flexibility was given."""

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
        J, give = answer.jacobian_rows, answer.compliance * answer.joints.deflection
        change = zero_change(answer, J.shape[1])
        change.motion[:] = -answer.scale[:, None] * (J @ give)
        if answer.geometric_stiffness is not None:
            change.torque[:] = answer.geometric_stiffness @ give
        return restrict_to_plane(answer, change)

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
        mechanism = require_hand(spec, argument, given)
        if not mechanism.variation.has_joint_springs:
            raise InputError(argument, "one number or distribution for a hand with tendons or synergies", "a mapping")
        return factor_entries("stiffness", argument, given, mechanism.names, "a joint")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        count = 1 if samples.spec.mechanism is None else len(samples.spec.mechanism.names)
        samples.times("springs", count, at, values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        who = "fingers" if spec.mechanism is None else "joints"
        yield from scale_both_ways(lambda f: self.scaled(spec, f), share, (who + " {} stiffer", who + " {} softer"))

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """Stiffer ones, where nothing creates the forces."""
        who = "fingers" if spec.mechanism is None else "joints"
        for factor in _TRIED_FACTORS if why == MISSING_FORCES else ():
            if (made := self.scaled(spec, factor)) is not None:
                yield Trial("stiffness", factor, f"{who} {factor:g} × as stiff", made)


def require_hand(spec: GraspSpec, argument: str, given: Any) -> Any:
    """The hand of a grasp. Raises InputError for a grasp without one."""
    if spec.mechanism is None:
        expected = "the grasp of a hand, made by hand.at(q).grasp(...)"
        raise InputError(argument, expected, "a grasp without one")
    return spec.mechanism


# ----------------------------------------------------------------
# The flexibility of the fingertips' pads, the same more along all three axes: δv = S r.


_MIN_PAD_SHARE = 1e-9  # of the flexibility: a pad softer by less is rounding


class PadFlexibility(ContactParameter):
    """The flexibility of the pad at each contact, (n,) [m/N]."""

    name = "pads"
    order, step, together, spread = 30, 1e-8, True, "pads"
    common, uncertain = "flexibility of the pads", f"Of the fingertips' flexibility: {SHARE_WORDS}."

    def values(self, spec: GraspSpec) -> Array:
        """Of each contact without that of the joints, the mean over its axes."""
        mechanism, axes = spec.mechanism, (0, 2) if spec.planar else (0, 1, 2)
        own = np.diagonal(spec.flexibility)[: 3 * spec.n].reshape(spec.n, 3)
        if mechanism is not None and mechanism.variation.has_joint_flexibility(spec):
            through = mechanism.jacobian_rows(())[: 3 * spec.n] @ mechanism.compliance_factor
            own = own - (through**2).sum(axis=1).reshape(spec.n, 3)
        pads = own[:, axes].mean(axis=1)
        return np.asarray(np.where(pads > _MIN_PAD_SHARE * abs(spec.flexibility).max(initial=0.0), pads, 0.0))

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        E = spec.flexibility
        for a in (0, 2) if spec.planar else (0, 1, 2):
            E = with_larger_entry(E, (3 * k + a) * (len(E) + 1), step)
        mechanism = None if spec.mechanism is None else spec.mechanism.variation.with_softer_pad(k, step)
        return spec.replace(flexibility=E, mechanism=mechanism)

    def change(self, answer: LinearisationPoint) -> LawChange:
        n = answer.scene.n
        change, each = zero_change(answer, n), np.arange(3 * n)
        change.motion[each, each // 3] = answer.scale[: 3 * n] * answer.forces.reshape(-1)
        return restrict_to_plane(answer, change)

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        pads, what = self.values(answer.spec), "flexibility" if answer.spec.mechanism is None else "pads"
        return Shown(f"{what} 10 % softer", [("all fingers", TABLE_SHARE * pads)]) if pads.any() else None

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Factors on the pads of a hand's fingertips."""
        require_hand(spec, argument, given)
        fingers = spec.names[: spec.of_hand]
        if not self.values(spec)[: spec.of_hand].any():
            raise InputError(argument, "nothing: the fingertips of this hand are rigid", repr(given)[:80])
        return factor_entries("pads", argument, given, fingers, "a fingertip of this grasp")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("pads", samples.spec.of_hand, at, values)


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
        change = zero_change(answer, nv)
        change.torque_limits[:] = np.eye(nv)
        return change

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        yield f"{words.format_percent(share)} more torque", self.scaled(spec, 1.0 + share)


def with_torque_limits(spec: GraspSpec, limits: Array) -> GraspSpec:
    """The grasp by a hand whose motors have these limits (nv,) [N·m], inf for none; all of them count as known."""
    assert spec.mechanism is not None
    made: GraspSpec = spec.mechanism.variation.with_torque_limits(spec, read_only(limits))
    return made
