"""The flexibility of the fingertips' pads, the same more along all three axes: δv = S r."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import SHARE, TENTH, Entry, OfContacts, Shown, factors, larger
from handlcp.grasp.parameter.samples import Samples
from handlcp.grasp.parameter.stiffness import hand
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, in_plane, no_change

_NO_PAD = 1e-9  # of the flexibility: a pad softer by less is rounding


class Pads(OfContacts):
    """(n,) [m/N] of each contact."""

    name = "pads"
    order, step, together, spread = 30, 1e-8, True, "pads"
    common, uncertain = "flexibility of the pads", f"Of the fingertips' flexibility: {SHARE}."

    def values(self, spec: GraspSpec) -> Array:
        """Of each contact without that of the joints, the mean over its axes."""
        mechanism, axes = spec.mechanism, (0, 2) if spec.planar else (0, 1, 2)
        own = np.diagonal(spec.flexibility)[: 3 * spec.n].reshape(spec.n, 3)
        if mechanism is not None and mechanism.gives(spec):
            through = mechanism.rows(())[: 3 * spec.n] @ mechanism.root
            own = own - (through**2).sum(axis=1).reshape(spec.n, 3)
        pads = own[:, axes].mean(axis=1)
        return np.asarray(np.where(pads > _NO_PAD * abs(spec.flexibility).max(initial=0.0), pads, 0.0))

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        E = spec.flexibility
        for a in (0, 2) if spec.planar else (0, 1, 2):
            E = larger(E, (3 * k + a) * (len(E) + 1), step)
        mechanism = None if spec.mechanism is None else spec.mechanism.padded(k, step)
        return spec.replace(flexibility=E, mechanism=mechanism)

    def change(self, answer: Answer) -> Change:
        n = answer.scene.n
        change, each = no_change(answer, n), np.arange(3 * n)
        change.motion[each, each // 3] = answer.scale[: 3 * n] * answer.forces.reshape(-1)
        return in_plane(answer, change)

    def shown(self, answer: Answer) -> Shown | None:
        pads, what = self.values(answer.spec), "flexibility" if answer.spec.mechanism is None else "pads"
        return Shown(f"{what} 10 % softer", [("all fingers", TENTH * pads)]) if pads.any() else None

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[Entry]:
        """Factors on the pads of a hand's fingertips."""
        hand(spec, argument, given)
        fingers = spec.names[: spec.of_hand]
        if not self.values(spec)[: spec.of_hand].any():
            raise InputError(argument, "nothing: the fingertips of this hand are rigid", repr(given)[:80])
        return factors("pads", argument, given, fingers, "a fingertip of this grasp")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("pads", samples.spec.of_hand, at, values)
