"""The springs of the joints. A spring more at a joint pulls it to where it is commanded:

    δv = -J C δK C τ = -J C e_j δ_j,    C = (K + K_g)⁻¹, δ_j how far joint j gives way

In samples and as a share, a factor on them; without a hand, on the stiffness of the fingers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import (
    FORCES,
    SHARE,
    TENTH,
    Entry,
    OfJoints,
    Shown,
    Trial,
    factors,
    more_and_less,
)
from handlcp.grasp.parameter.samples import Samples
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, in_plane, no_change
from handlcp.tolerances import SEMIDEFINITE

_TRIED = (2.0, 5.0, 10.0)  # times as stiff


class Stiffness(OfJoints):
    """(nv,) [N·m/rad]; derivatives [rad/(N·m)] raise Unsupported where the flexibility was given."""

    name = "stiffness"
    order, effort, step, together, spread = 20, 2, 1e-4, True, "stiffness"
    common, uncertain = "stiffness of the joints", f"Of the joints: {SHARE}."

    def values(self, spec: GraspSpec) -> Array:
        """1 / C_jj; 0 for a rigid joint, and where the flexibility was given."""
        if spec.mechanism is None or not spec.mechanism.gives(spec):
            return np.zeros(self.shape(spec))
        C = (spec.mechanism.root**2).sum(axis=1)
        return np.where(C > 0.0, 1.0 / np.where(C > 0.0, C, 1.0), 0.0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        """Made again as it was asked for."""
        assert spec.mechanism is not None
        made: GraspSpec = spec.mechanism.varied(spec, "stiffness", k, step)
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
            E -= less * mechanism.compliance(mechanism.jacobian)
            made = mechanism.stiffer(factor)
        if not E.any() or float(np.linalg.eigvalsh(E)[0]) < -SEMIDEFINITE * float(abs(E).max()):
            return None
        stiff = spec.replace(mechanism=made, flexibility=read_only(E))
        return stiff if made is None else made.gripping_again(stiff)

    def change(self, answer: Answer) -> Change:
        if not answer.elastic_joints:
            raise Unsupported("a grasp whose flexibility was given has no derivative by the stiffness of joints")
        J, give = answer.rows, answer.compliance * answer.joints.deflection
        change = no_change(answer, J.shape[1])
        change.motion[:] = -answer.scale[:, None] * (J @ give)
        if answer.bent is not None:
            change.torque[:] = answer.bent @ give
        return in_plane(answer, change)

    def shown(self, answer: Answer) -> Shown | None:
        if answer.spec.mechanism is None or not answer.elastic_joints:
            return None
        C = np.diagonal(answer.compliance)
        return Shown("stiffness +10 %", [("all joints", TENTH / np.where(C > 0.0, C, np.inf))])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[Entry]:
        if not spec.flexibility[: 3 * spec.of_hand].any():
            raise InputError(argument, "nothing: the fingers of this grasp are rigid", repr(given)[:80])
        if not isinstance(given, Mapping):
            return factors("stiffness", argument, given, (), "")
        mechanism = hand(spec, argument, given)
        if not mechanism.springs_by_joint:
            raise InputError(argument, "one number or distribution for a hand with tendons or synergies", "a mapping")
        return factors("stiffness", argument, given, mechanism.names, "a joint")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        count = 1 if samples.spec.mechanism is None else len(samples.spec.mechanism.names)
        samples.times("springs", count, at, values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        who = "fingers" if spec.mechanism is None else "joints"
        yield from more_and_less(lambda f: self.scaled(spec, f), share, (who + " {} stiffer", who + " {} softer"))

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """Stiffer ones, where nothing creates the forces."""
        who = "fingers" if spec.mechanism is None else "joints"
        for factor in _TRIED if why == FORCES else ():
            if (made := self.scaled(spec, factor)) is not None:
                yield Trial("stiffness", factor, f"{who} {factor:g} × as stiff", made)


def hand(spec: GraspSpec, argument: str, given: Any) -> Any:
    """The hand of a grasp. Raises InputError for a grasp without one."""
    if spec.mechanism is None or spec.mechanism.nominal is None:
        expected = "the grasp of a hand, made by hand.at(q).grasp(...)"
        raise InputError(argument, expected, "a grasp without one")
    return spec.mechanism
