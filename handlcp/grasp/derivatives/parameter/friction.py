"""The coefficient of friction of each contact, the whole law growing with it: δμ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, check_keys
from handlcp.errors import InputError
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint, zero_change
from handlcp.grasp.derivatives.parameter.parameter import (
    SHARE_WORDS,
    TABLE_SHARE,
    ContactParameter,
    ParameterEntry,
    Samples,
    Shown,
    Trial,
    indices_named,
)
from handlcp.grasp.model.request import GraspSpec

_TRIED_COEFFICIENTS = (0.3, 0.5, 0.8, 1.0, 1.2)  # hardly anything grips better


class FrictionCoefficient(ContactParameter):
    """(n,) [-]; derivatives are NaN for contacts without friction."""

    name = "friction"
    order, effort, step, together, spread = 10, 1, 1e-5, True, "friction"
    common, uncertain = "friction", f"Of the fingers' coefficient: {SHARE_WORDS}."

    def values(self, spec: GraspSpec) -> Array:
        return np.array([c.mu for c in spec.contacts])

    def without(self, spec: GraspSpec) -> Bools:
        return self.values(spec) <= 0.0

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        laws = [c.friction for c in spec.contacts]
        laws[k] = laws[k].with_mu(laws[k].mu + step)
        return spec.with_laws(tuple(laws))

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        if not any(c.mu > 0.0 for c in spec.contacts):
            return None
        return spec.with_laws(
            tuple([c.friction.with_mu(factor * c.mu) if c.mu > 0.0 else c.friction for c in spec.contacts])
        )

    def change(self, answer: LinearisationPoint) -> LawChange:
        scene, change = answer.scene, zero_change(answer, answer.scene.n)
        change.friction[np.arange(scene.n), np.arange(scene.n)] = answer.friction_shares
        return change

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        mu = self.values(answer.spec)
        rough = (mu > 0.0) & (np.array(answer.scene.kind.tangent_count) > 0)
        return (
            Shown("friction -10 %", [("all fingers", np.where(rough, -TABLE_SHARE * mu, 0.0))]) if rough.any() else None
        )

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Of the fingers' contacts together, all with one coefficient; or of the contacts that a mapping names."""
        mu = [c.mu for c in spec.contacts]
        if isinstance(given, Mapping):
            return [
                ParameterEntry(
                    f"friction {name}",
                    indices_named(spec.names, name),
                    mu[spec.names.index(name)],
                    0.0,
                    "",
                    own,
                    f"{argument}[{name!r}]",
                )
                for name, own in check_keys(argument, given, spec.names, "a contact").items()
            ]
        fingers = tuple(range(spec.of_hand))
        coefficients = {mu[i] for i in fingers}
        if len(coefficients) > 1:
            expected = "a mapping by contact name, of contacts with different friction"
            raise InputError(argument, expected, repr(given)[:80])
        return (ParameterEntry("friction", fingers, coefficients.pop(), 0.0, "", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.put("friction", self.values(samples.spec), samples.spec.n, at, values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        yield f"{words.format_percent(share)} more friction", self.scaled(spec, 1.0 + share)

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """Rougher surfaces, whatever is missing."""
        now = self.values(spec).max(initial=0.0)
        for mu in _TRIED_COEFFICIENTS:
            if now > 0.0 and mu > 1.05 * now:
                yield Trial("friction", mu, f"a friction coefficient of {mu:g}", with_friction(spec, mu))


def with_friction(spec: GraspSpec, mu: float) -> GraspSpec:
    """The grasp with the coefficient `mu` at every contact that has friction; a law with several keeps their ratios,
    and `mu` is the one it calls so.
    """
    return spec.with_laws(tuple([c.friction.with_mu(mu) if c.mu > 0 else c.friction for c in spec.contacts]))
