"""The grasps of samples: the nominal grasp with other values of what varies.

What was commanded stays, in metres and radians of the joints: softer springs press less. Contacts stay where they are
on the object unless their positions vary. A joint that stands off by δq carries its fingertip along, by J δq, and its
command with it: the object lies -J δq off the tip, as a gap or as more squeeze, and J is that of the posture q + δq.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, read_only
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.friction import FrictionLaw
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.asked.load import weight_of
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.stiffness import JointStiffness, Pads
from handlcp.hand.mechanism import HandMechanism, finger_flexibility, mechanism_of
from handlcp.hand.robot.posture import Posture
from handlcp.study.reliability.outcome import Values, slid
from handlcp.study.reliability.spread import Dimension

_HAND = {"stiffness", "pads", "posture", "positions"}  # what changes the Jacobian or the flexibility of a hand


class Placed(NamedTuple):
    """The grasp of a sample. why_not : why it is none that could be judged, in words; None: it is one."""

    grasp: Grasp
    why_not: str | None


class Placer:
    """Makes the grasps of samples.

    own : whether the flexibility is the hand's own. Where it was given, or there is no hand, a factor on the stiffness
    is one on all of it.
    """

    def __init__(self, grasp: Grasp, dimensions: Sequence[Dimension]) -> None:
        self.grasp, self.spec, self.dimensions = grasp, grasp.spec, tuple(dimensions)
        self._varies = {d.parameter for d in dimensions}
        mechanism, self._k = self.spec.mechanism, self.spec.of_fingers
        self._hand = mechanism if isinstance(mechanism, HandMechanism) else None
        self.own = self._hand is not None and self._is_own(self._hand)
        self._weight = np.zeros(6)
        if self._hand is not None:
            self._weight = weight_of(self._hand.target, self._hand.gravity, self.spec.reference)

    def _is_own(self, hand: HandMechanism) -> bool:
        c = 3 * self._k
        made = finger_flexibility(replace(hand, jacobian=hand.jacobian[:c]))
        return bool(np.allclose(self.spec.flexibility[:c, :c], made, rtol=1e-12, atol=0.0))

    def placed(self, rows: Array) -> list[Placed]:
        """One for each row of values (m, d) of the dimensions."""
        spec, values, m = self.spec, Values(self.dimensions, rows), len(rows)
        laws = values.each("friction", spec.n, np.array([c.mu for c in spec.contacts]))
        places, past = self._places(values.shifts(self._k), m)
        masses, loads, squeezes = (values.one(name) for name in ("mass", "load", "squeeze"))
        hands: list[Any] = [self._hand] * m
        if self._hand is not None and self._varies & (_HAND | {"mass"}):
            hands = self._hands(self._hand, values, masses, places)
        deltas = None if self._hand is None else values.each("posture", len(self._hand.names), 0.0)
        factors = [None] * m if self.own else values.one("stiffness")
        out = []
        for k in range(m):
            changes = self._loaded(masses[k], loads[k])
            if places is not None:
                changes |= {"positions": places[0][k], "frames": places[1][k]}
            if laws is not None or places is not None:
                changes["contacts"] = self._contacts(None if laws is None else laws[k].tolist(), places, k)
            if hands[k] is not self._hand:
                changes |= self._of_hand(hands[k], None if deltas is None else deltas[k])
            if (factor := factors[k]) is not None:
                changes["flexibility"] = self._softened(factor)
            made = spec.replace(**changes)
            share = squeezes[k]
            why = self._why_not(past[k])
            out.append(Placed(type(self.grasp)(made if share is None else _eased(made, share)), why))
        return out

    def _why_not(self, past: Bools) -> str | None:
        """What is wrong with a sample, some of whose fingers (k,) are past an edge."""
        if not past.any():
            return None
        names = [self.spec.names[i] for i in np.flatnonzero(past)]
        return f"{words.listed(names)} would be past an edge of the object, where a contact has no normal"

    def _places(self, shifts: Array | None, m: int) -> tuple[tuple[Array, Array] | None, Bools]:
        """(m, n, 3) positions and (m, n, 3, 3) frames, read-only, the fingers' contacts slid, None: they stay; and
        which fingers (m, k) are past an edge.
        """
        if shifts is None:
            return None, np.zeros((m, self._k), bool)
        spec, k = self.spec, self._k
        target = None if self._hand is None or spec.planar else self._hand.target
        positions, frames = np.tile(spec.positions, (m, 1, 1)), np.tile(spec.frames, (m, 1, 1, 1))
        positions[:, :k], frames[:, :k], past = slid(spec.positions[:k], spec.frames[:k], shifts, target)
        return (read_only(positions), read_only(frames)), past

    def _contacts(self, mu: list[float] | None, places: tuple[Array, Array] | None, k: int) -> tuple[Contact, ...]:
        made: dict[tuple[int, float], FrictionLaw] = {}
        out = []
        for i, c in enumerate(self.spec.contacts):
            law = c.friction
            if mu is not None and mu[i] != c.mu:
                key = id(law), mu[i]  # one law for all contacts that share it
                law = made[key] if key in made else made.setdefault(key, law.with_mu(mu[i]))
            p, R = (c.position, c.rotation) if places is None else (places[0][k, i], places[1][k, i])
            out.append(Contact.placed(p, R, law, c.planar, c.name))
        return tuple(out)

    def _loaded(self, mass: float | None, load: float | None) -> dict[str, Any]:
        """The wrench, where mass or load vary."""
        if mass is None and load is None:
            return {}
        weight, share = self._weight, 1.0
        if mass is not None and self._hand is not None and self._hand.target is not None:
            share = mass / self._hand.target.mass
        return {"wrench": read_only(share * weight + (1.0 if load is None else load) * (self.spec.wrench - weight))}

    def _hands(
        self, old: HandMechanism, values: Values, masses: list[float | None], places: tuple[Array, Array] | None
    ) -> list[HandMechanism]:
        """The mechanism of each sample."""
        m, hand, k = len(values.rows), old.posture.hand, self._k
        springs = values.each("stiffness", hand.nv, 1.0) if self.own else None
        pads, deltas = values.each("pads", k, 1.0), values.each("posture", hand.nv, 0.0)
        still, target = self.spec.n - k, old.target
        out = []
        for i in range(m):
            mass = masses[i]
            here = target if mass is None or target is None else target.weighing(mass)
            if not self._varies & _HAND:
                out.append(replace(old, target=here))
                continue
            posture = old.posture
            if springs is not None or pads is not None or deltas is not None:
                parts: dict[str, Any] = {}
                if springs is not None:
                    parts["stiffness"] = _stiffer(hand.stiffness, springs[i])
                if pads is not None:
                    blocks = hand.pads.blocks.copy()
                    blocks[list(old.tips)] *= pads[i][:, None, None]
                    parts["pads"] = Pads(blocks)
                posture = _standing(posture, hand.with_parts(**parts), None if deltas is None else deltas[i])
            p, R = (old.positions, old.frames) if places is None else (places[0][i, :k], places[1][i, :k])
            out.append(mechanism_of(posture, old.tips, p, R, here, old.gravity, old.stand_off).beside(still))
        return out

    def _of_hand(self, hand: HandMechanism, delta: Array | None) -> dict[str, Any]:
        """What a mechanism of `_hands` changes in the specification. delta : (nv,) how far its joints are off."""
        spec, k = self.spec, self._k
        changes: dict[str, Any] = {"mechanism": hand}
        if delta is not None:
            away = (hand.jacobian[: 3 * k] @ delta).reshape(-1, 3)
            if spec.planar:
                away[:, 1] = 0.0
            offset = spec.offset.copy()
            offset[:k] -= away
            weight = read_only(hand.posture.gravity_torque(hand.gravity))
            effects = [replace(e, torque=weight) if isinstance(e, FingerWeight) else e for e in spec.effects]
            changes = {
                "mechanism": replace(hand, stand_off=read_only(hand.stand_off - away)), "offset": read_only(offset),
                "effects": tuple(effects),
            }  # fmt: skip
        if self.own and self._varies & _HAND:
            E = finger_flexibility(replace(hand, jacobian=hand.jacobian[: 3 * k]) if spec.n > k else hand)
            if spec.n > k:
                whole = spec.flexibility.copy()
                whole[: 3 * k, : 3 * k] = E
                E = read_only(whole)
            changes["flexibility"] = E
        return changes

    def _softened(self, factor: float) -> Array:
        """The flexibility that was given, of fingers so many times as stiff."""
        c, out = 3 * self._k, self.spec.flexibility.copy()
        out[:c, :c] /= factor
        return read_only(out)


def _stiffer(springs: Elasticity, factors: Array) -> Elasticity:
    """By factors (nv,), which are all alike for tendons and synergies."""
    return springs.by_joint(factors) if type(springs) is JointStiffness else springs.stiffer(float(factors[0]))


def _standing(old: Posture, hand: Any, delta: Array | None) -> Posture:
    """The posture of a hand that differs in springs and pads alone, its joints off by delta (nv,)."""
    if delta is not None:
        return type(old)(hand, old.q + delta)
    made = object.__new__(type(old))
    made.__dict__.update(old.__dict__, hand=hand)
    made.__dict__.pop("flexibility", None)  # of the other springs
    return made


def _eased(spec: GraspSpec, share: float) -> GraspSpec:
    """With this share of the squeeze: preloads, and commands of the joints."""
    if spec.mechanism is not None:
        eased: GraspSpec = spec.mechanism.eased(spec, share)
        return eased
    offset, k = spec.offset.copy(), spec.of_fingers
    offset[:k] *= np.where(offset[:k, 2:] < 0.0, share, 1.0)
    return spec.replace(offset=read_only(offset))
