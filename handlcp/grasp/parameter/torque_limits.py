"""The torque limits of the joints. Only those of joints that yield (`TorqueSaturation`) move anything."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, read_only
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import OfJoints, larger
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, no_change


class TorqueLimit(OfJoints):
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
        return with_limits(spec, larger(spec.mechanism.limits, k, step))

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        if not self.values(spec).any():
            return None
        assert spec.mechanism is not None
        return with_limits(spec, factor * spec.mechanism.limits)

    def change(self, answer: Answer) -> Change:
        nv = answer.rows.shape[1]
        change = no_change(answer, nv)
        change.torque_limits[:] = np.eye(nv)
        return change

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        yield f"{words.percent(share)} more torque", self.scaled(spec, 1.0 + share)


def with_limits(spec: GraspSpec, limits: Array) -> GraspSpec:
    """The grasp by a hand whose motors have these limits (nv,) [N·m], inf for none; all of them count as known."""
    assert spec.mechanism is not None
    made: GraspSpec = spec.mechanism.limited(spec, read_only(limits))
    return made
