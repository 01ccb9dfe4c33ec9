"""What a random grasp is made of, as plain values: it can be made again with one of them changed.

Three kinds, with the same methods: `HandRecipe`, a hand whose fingertips close on an object, `WrapRecipe`, one whose
links do, and `FreeRecipe`, bare contacts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pinocchio as pin

import handlcp as hl
from tests.mujoco.case import read_rows
from tests.mujoco.find_power_grasps import FILE, a_hand, thing
from tests.paths.hands import made_hand


def turn(rng: np.random.Generator) -> np.ndarray:
    """(3, 3) random rotation."""
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Q * np.sign(np.linalg.det(Q))


def spun(Q: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """(6,) a wrench turned with the world."""
    return np.append(Q @ wrench[:3], Q @ wrench[3:])


@dataclass(frozen=True)
class Law:
    """kind : "coulomb", "soft" or "anisotropic". mu : coefficient. second : of a soft finger its torsion [m], of an
    anisotropic one the smaller coefficient over the larger. along (3,) : where that has the larger one.
    """

    kind: str
    mu: float
    second: float
    along: tuple[float, ...]

    def made(self) -> Any:
        """The friction law."""
        if self.kind == "soft":
            return hl.SoftFinger(self.mu, self.second)
        if self.kind == "anisotropic":
            return hl.AnisotropicCoulomb(self.mu, self.second * self.mu, along=self.along)
        return hl.Coulomb(self.mu)

    def times(self, share: float) -> Law:
        """With all friction larger by a factor, a soft finger's torsion too."""
        return replace(self, mu=share * self.mu, second=self.second * (share if self.kind == "soft" else 1.0))

    def turned(self, Q: np.ndarray) -> Law:
        """In a world that is turned."""
        return replace(self, along=tuple((Q @ self.along).tolist()))


@dataclass(frozen=True)
class Thing:
    """An object. kind : "box", "ball", "cylinder" or "ellipsoid". sizes : as its class takes them [m].
    position (3,) [m], rotation (3, 3), mass [kg].
    """

    kind: str
    sizes: tuple[float, ...]
    position: np.ndarray
    rotation: np.ndarray
    mass: float

    def made(self) -> Any:
        """The object where it is."""
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = self.rotation, self.position
        if self.kind == "box":
            return hl.Box(self.sizes, place, mass=self.mass)
        if self.kind == "ellipsoid":
            return hl.Ellipsoid(self.sizes, place, mass=self.mass)
        return (hl.Sphere if self.kind == "ball" else hl.Cylinder)(*self.sizes, place, mass=self.mass)


@dataclass(frozen=True)
class HandRecipe:
    """A hand that closes on an object from the posture `start`. torque : factor on the hand's torque limits, 0: none.
    squeeze [m], gravity (3,) [m/s²]. fingers : those that take part, in this order. world (3, 3) : how the whole world
    is turned. force : the unit of force in newtons.
    """

    hand: str
    stiffness: float
    pads: float
    torque: float
    thing: Thing
    start: tuple[float, ...] | None
    law: Law
    squeeze: float
    gravity: np.ndarray
    fingers: tuple[str, ...]
    world: np.ndarray | None = None
    force: float = 1.0

    def grasp(self) -> hl.HandGrasp:
        """Made anew. Raises what the hand raises where it does not reach."""
        s = self.force
        hand = made_hand(self.hand, self.stiffness / s, self.pads * s, self.torque / s, self.world)
        q = self._posture()
        thing, gravity, law = self.thing, self.gravity, self.law
        if self.world is not None:
            Q = self.world
            thing = replace(thing, position=Q @ thing.position, rotation=Q @ thing.rotation)
            gravity, law = Q @ gravity, law.turned(Q)
        thing = replace(thing, mass=thing.mass / s)
        return hand.at(q).grasp(
            thing.made(), law.made(), gravity=gravity, squeeze=self.squeeze, fingers=list(self.fingers)
        )

    def _posture(self) -> np.ndarray:
        """In the world as it was, so that a turned hand has the same posture to the last bit."""
        hand = made_hand(self.hand, 1.0, 0.0, 1.0, None)
        return hand.close_on(self.thing.made(), self.start, fingers=sorted(self.fingers, key=hand.fingertips.index))

    def rubbed(self, share: float) -> Self:
        """With more friction, or less."""
        return replace(self, law=self.law.times(share))

    def stronger(self, share: float) -> Self | None:
        """With other torque limits; None: it has none."""
        return replace(self, torque=share * self.torque) if self.torque else None

    def squeezed(self, share: float) -> Self:
        """Closed harder, or less hard."""
        return replace(self, squeeze=share * self.squeeze)

    def stiffer(self, share: float) -> Self:
        """With other joint stiffness."""
        return replace(self, stiffness=share * self.stiffness)

    def permuted(self, rng: np.random.Generator) -> Self | None:
        """With the fingers in another order; None: it has no order."""
        order = _other_order(rng, len(self.fingers))
        return replace(self, fingers=tuple(self.fingers[i] for i in order))

    def turned(self, Q: np.ndarray) -> Self | None:
        """In a turned world; None for a hand whose file cannot be turned."""
        return replace(self, world=Q) if self.hand in ("three_finger", "five_finger") else None

    def in_units(self, force: float, length: float) -> Self | None:
        """With forces counted in other units. The unit of length stays: files of hands are in metres. None: the whole
        recipe is in SI units.
        """
        return replace(self, force=force)


@dataclass(frozen=True)
class WrapRecipe:
    """A hand whose joints close by torque until links and palm press: the placement `key` of the power grasps that are
    found for MuJoCo. stiffness of all joints [N·m/rad], torque of all [N·m]. The methods are those of `HandRecipe`.
    """

    key: str
    stiffness: float
    torque: float
    law: Law

    def grasp(self) -> hl.HandGrasp:
        row = read_rows(FILE)[self.key]
        hand = a_hand(row["hand"]).replace(joint_stiffness=self.stiffness)
        place = pin.SE3(np.array(row["rotation"]), np.array(row["position"]))
        obj = thing(row["thing"], row["hand"], place)
        return hand.at(row["q"]).grasp(obj, self.law.made(), links="all", closing_torque=self.torque)

    def rubbed(self, share: float) -> Self:
        return replace(self, law=self.law.times(share))

    def stronger(self, share: float) -> None:
        """Its torque limits are out of the way."""

    def squeezed(self, share: float) -> Self:
        return replace(self, torque=share * self.torque)

    def stiffer(self, share: float) -> Self:
        return replace(self, stiffness=share * self.stiffness)

    def permuted(self, rng: np.random.Generator) -> None:
        """Links are in the order of the hand's file."""

    def turned(self, Q: np.ndarray) -> None:
        """Files of hands cannot be turned."""

    def in_units(self, force: float, length: float) -> None:
        """Its objects have masses in kilograms."""


@dataclass(frozen=True)
class FreeRecipe:
    """Bare contacts at p (n, 3) with frames R (n, 3, 3), E (3n, 3n) [m/N] and preloads (n,) [m], or as commands move
    them along all their axes (n, 3) [m]. force, length : the units, in newtons and metres. The methods are those of
    `HandRecipe`.
    """

    p: np.ndarray
    R: np.ndarray
    laws: tuple[Law, ...]
    E: np.ndarray
    preload: np.ndarray
    force: float = 1.0
    length: float = 1.0

    def grasp(self) -> hl.Grasp:
        f, m = self.force, self.length
        laws = [replace(law, second=law.second / m) if law.kind == "soft" else law for law in self.laws]
        contacts = [
            hl.Contact(p / m, R[:, 2], law.made(), R[:, 0]) for p, R, law in zip(self.p, self.R, laws, strict=True)
        ]
        closing = {"preload": self.preload / m} if self.preload.ndim == 1 else {"offset": -self.preload / m}
        return hl.Grasp(contacts, flexibility=self.E * f / m, **closing)

    def rubbed(self, share: float) -> Self:
        return replace(self, laws=tuple(law.times(share) for law in self.laws))

    def stronger(self, share: float) -> None:
        """There are no torques."""

    def squeezed(self, share: float) -> Self:
        return replace(self, preload=share * self.preload)

    def stiffer(self, share: float) -> Self:
        return replace(self, E=self.E / share)

    def permuted(self, rng: np.random.Generator) -> Self:
        order = _other_order(rng, len(self.p))
        rows = (3 * order[:, None] + np.arange(3)).ravel()
        return replace(
            self, p=self.p[order], R=self.R[order], laws=tuple(self.laws[i] for i in order),
            E=self.E[np.ix_(rows, rows)], preload=self.preload[order],
        )  # fmt: skip

    def turned(self, Q: np.ndarray) -> Self:
        return replace(self, p=self.p @ Q.T, R=Q @ self.R, laws=tuple(law.turned(Q) for law in self.laws))

    def in_units(self, force: float, length: float) -> Self:
        return replace(self, force=force, length=length)


Recipe = HandRecipe | WrapRecipe | FreeRecipe


def _other_order(rng: np.random.Generator, n: int) -> np.ndarray:
    """(n,) a permutation that is not the one there is."""
    while True:
        order = rng.permutation(n)
        if (order != np.arange(n)).any():
            return order
