"""Parameters of the contacts: their friction, the pads of the fingertips, where they are and how their axes lie."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError
from handlcp.grasp.derivatives.linearisation import LawChange, LinearisationPoint
from handlcp.grasp.derivatives.parameter.parameter import (
    SHARE_WORDS,
    TABLE_SHARE,
    ContactParameter,
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

_TRIED_COEFFICIENTS = (0.3, 0.5, 0.8, 1.0, 1.2)  # hardly anything grips better


class FrictionCoefficient(ContactParameter):
    """(n,) [-], the whole law growing with it: δμ; derivatives are NaN for contacts without friction."""

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
        laws = [c.friction.with_mu(factor * c.mu) if c.mu > 0.0 else c.friction for c in spec.contacts]
        return spec.with_laws(tuple(laws))

    def change(self, answer: LinearisationPoint) -> LawChange:
        """Of each coefficient, as much as its section bears."""
        mu = self.values(answer.spec)
        bears = np.where(mu > 0.0, answer.friction.coefficients / np.where(mu > 0.0, mu, 1.0), np.nan)
        change = answer.law_change(len(mu))
        np.fill_diagonal(change.friction, bears)
        return change

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        mu = self.values(answer.spec)
        less = np.where(np.array(answer.scene.kind.tangent_count) > 0, -TABLE_SHARE * mu, 0.0)
        return Shown("friction -10 %", [("all fingers", less)]) if less.any() else None

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Of the fingers' contacts together, all with one coefficient; or of the contacts that a mapping names."""
        mu, fingers = [c.mu for c in spec.contacts], tuple(range(spec.of_hand))
        found = factor_entries("friction", argument, given, spec.names, "a contact")
        if isinstance(given, Mapping):
            return [e._replace(mean=mu[e.at[0]], unit="") for e in found]
        if len({mu[i] for i in fingers}) > 1:
            expected = "a mapping by contact name, of contacts with different friction"
            raise InputError(argument, expected, repr(given)[:80])
        return [found[0]._replace(at=fingers, mean=mu[0], unit="")]

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


# ----------------------------------------------------------------

_MIN_PAD_SHARE = 1e-9  # of the flexibility: a pad softer by less is rounding


class PadFlexibility(ContactParameter):
    """(n,) [m/N] of the pad at each contact, the same more along all three axes S: δv = S r."""

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
        n, each = answer.scene.n, np.arange(3 * answer.scene.n)
        change = answer.law_change(n)
        change.contact_motion[each, each // 3] = answer.scale[: 3 * n] * answer.forces.reshape(-1)
        return change

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        pads, what = self.values(answer.spec), "flexibility" if answer.spec.mechanism is None else "pads"
        return Shown(f"{what} 10 % softer", [("all fingers", TABLE_SHARE * pads)]) if pads.any() else None

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Factors on the pads of a hand's fingertips."""
        require_hand(spec, argument)
        if not self.values(spec)[: spec.of_hand].any():
            raise InputError(argument, "nothing: the fingertips of this hand are rigid", repr(given)[:80])
        return factor_entries("pads", argument, given, spec.names[: spec.of_hand], "a fingertip of this grasp")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("pads", samples.spec.of_hand, at, values)


# ----------------------------------------------------------------
# Contacts that move or turn, the rest of the grasp following: the object stays, and so do the joints, their commands,
# and offsets and pads in the axes of fingertip and contact.


class _ContactVectors(Parameter):
    """(n, 3)."""

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (spec.n, 3)

    def values(self, spec: GraspSpec) -> Array:
        return np.zeros((spec.n, 3))

    def each_finger_alone(self, spec: GraspSpec, text: str, ways: Array) -> Shown:
        """The row of changes (k, a, 3) of each of k fingers alone."""
        one = np.eye(spec.n)
        return Shown(text, [(spec.names[i], np.outer(one[i], way)) for i, own in enumerate(ways) for way in own])


class ContactPositions(_ContactVectors):
    """[m], world axes; derivatives [1/m], in a planar scene those in its plane. In samples, slides along the object's
    surface.
    """

    name = "positions"
    order, step, spread = 90, 1e-7, "positions"
    uncertain = "Of each contact along both tangents, in metres."

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return _place_contacts(spec, with_larger_entry(spec.positions, k, step), spec.frames)

    def shown(self, answer: LinearisationPoint) -> Shown:
        axes = answer.spec.frames[: answer.spec.of_hand].swapaxes(1, 2)
        return self.each_finger_alone(answer.spec, "1 mm aside", 1e-3 * axes[:, :2])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Along both tangents of each finger, or of those that a mapping names; a contact of a plane stays in it."""
        named = given_by_name(argument, given, spec.names[: spec.of_hand], "a finger")
        axes = "x" if spec.planar else "xy"
        return [
            ParameterEntry(f"position {name} {x}", (i, a), None, -np.inf, "m", named[name], f"{argument}[{name!r}]")
            for i, name in enumerate(spec.names[: spec.of_hand])
            if name in named
            for a, x in enumerate(axes)
        ]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.array("slides", 0.0, samples.spec.of_hand, 2)[:, at[0], at[1]] = values


class ContactNormals(_ContactVectors):
    """Turns [rad] of the contact axes about themselves; derivatives [1/rad]: x and y tilt the normal, z turns the
    tangents.
    """

    name = "normals"
    order, step = 100, 1e-6

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        i, a = divmod(k, 3)
        x, y = (a + 1) % 3, (a + 2) % 3
        frames = spec.frames.copy()
        frames[i, :, x] = np.cos(step) * spec.frames[i, :, x] + np.sin(step) * spec.frames[i, :, y]
        frames[i, :, y] = np.cos(step) * spec.frames[i, :, y] - np.sin(step) * spec.frames[i, :, x]
        return _place_contacts(spec, spec.positions, read_only(frames))

    def shown(self, answer: LinearisationPoint) -> Shown:
        tilts = np.tile(np.radians(1.0) * np.eye(3)[:2], (answer.spec.of_hand, 1, 1))
        return self.each_finger_alone(answer.spec, "normal by 1°", tilts)


def _place_contacts(spec: GraspSpec, positions: Array, frames: Array) -> GraspSpec:
    """The grasp with its contacts at positions (n, 3) with frames (n, 3, 3)."""
    if spec.mechanism is not None:
        made: GraspSpec = spec.mechanism.variation.replace_contacts(spec, positions, frames)
        return made
    contacts = []
    for c, p, R, before in zip(spec.contacts, positions, frames, spec.frames, strict=True):
        rotation = read_only(R @ before.T @ c.rotation)  # its own axes turn along
        contacts.append(c.from_arrays(p, rotation, c.friction, c.planar, c.name))
    return spec.replace(contacts=tuple(contacts), positions=positions, frames=frames)
