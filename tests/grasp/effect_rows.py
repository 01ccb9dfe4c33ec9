"""Every effect in one table: how a scene is without it, with it, and with it at the value that says nothing.

A new effect joins with a row; `test_absent_effects` fails for one that has none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import handlcp as hl
from tests.grasp.scenes import ring
from tests.support.effects import KINDS

FACES = 8
N = 4  # fingers of the ring
# Faces of the limit surface: m on each parallel, and two poles
SURFACE = FACES * (2 * max(1, round(FACES / 4)) - 1) + 2


@dataclass(frozen=True)
class Row:
    """name : its title in the catalogue. absent, on, neutral : grasps. added : unknowns by group that it adds to those
    of the grasp without it, below 0: takes away. exact : whether the neutral grasp is the absent one bit by bit; else
    its answer is, to 1e-9. faces : what it is solved with.
    """

    name: str
    absent: Callable[[], hl.Grasp]
    on: Callable[[], hl.Grasp]
    neutral: Callable[[], hl.Grasp]
    added: dict[str, int] = field(default_factory=dict)
    exact: bool = True
    faces: int | str = FACES

    @property
    def kind(self) -> type | None:
        """The effect's class; None where there is none, but data alone."""
        return KINDS.get(self.name)


@cache
def waist():
    return ring(np.random.default_rng(5), n=N, preload=0.02)


def rings(law=None, **more):
    """Four fingers with a law each, or all with one; None: Coulomb."""
    contacts, data = waist()
    laws = list(law) if isinstance(law, (list, tuple)) else [law or hl.Coulomb(0.6)] * N
    return hl.Grasp([c.with_friction(f) for c, f in zip(contacts, laws, strict=True)], **(data | more))


def planar(law):
    """Four fingers around a disc in the xy plane."""
    t = np.array([0.1, 1.7, 3.0, 4.6])
    contacts = [hl.Contact((0.03 * np.cos(a), 0.03 * np.sin(a)), (-np.cos(a), -np.sin(a)), law) for a in t]
    return hl.Grasp(contacts, (0.5, -0.2, 0.002), flexibility=(4e-4, 4e-4, 2e-4), preload=1e-3)


BALL = hl.Sphere(0.035, (0, 0, 0.07))
SPRINGS = 6.0


@cache
def posture():
    return hl.example_hand("five_finger").close_on(BALL)


def hands(target=BALL, joint_stiffness=SPRINGS, torque_limits=None, **more):
    """Five fingers of two joints; they hang, so that +z is down."""
    limits = {} if torque_limits is None else {"torque_limits": torque_limits}
    hand = hl.example_hand("five_finger", joint_stiffness=joint_stiffness, pad_flexibility=2e-4, **limits)
    pull = {"wrench": (0.3, 0.2, 0.5, 0.01, 0.005, 0.01), "gravity": (0, 0, 9.81), "preload": 0.004}
    return hand.at(posture()).grasp(target, **(pull | more))


def asked(*effects: Any) -> Callable[[], hl.Grasp]:
    return lambda: rings(effects=effects)


@cache
def own_force():
    return rings().solve(FACES).forces[0]


def floor(gap):
    wall = hl.Contact((0.0, 0.0, 0.0), (0, 0, 1), hl.Coulomb(0.3))
    return hl.Environment([wall], 5e-4, gap)


NV = 10  # joints of the hand
ARMS = np.random.default_rng(6).uniform(-0.01, 0.02, (3, NV))
POSTURES = np.random.default_rng(7).uniform(-0.5, 1.0, (NV, 2))

ROWS = (
    Row("object balance", rings, rings, rings),
    Row("unilateral contact", rings, rings, lambda: rings(offset=np.zeros((N, 3)))),
    Row("Coulomb friction", lambda: rings(hl.Frictionless()), rings, lambda: rings(hl.Coulomb(0.0)),
        {"r_T": 2 * N, "λ": FACES * N}),
    Row("Coulomb friction", lambda: rings(hl.Frictionless()), rings, lambda: rings(hl.Coulomb(0.0)),
        {"r_T": 2 * N}, faces="cone"),
    Row("Coulomb friction",
        lambda: planar(hl.Frictionless()), lambda: planar(hl.Coulomb(0.4)), lambda: planar(hl.Coulomb(0.0)),
        {"r_T": N, "λ": 2 * N}),
    Row("soft finger", rings, lambda: rings(hl.SoftFinger(0.6, 0.006)), lambda: rings(hl.SoftFinger(0.6, 0.0)),
        {"r_T": -2 * N, "λ": -FACES * N, "r_S": 3 * N, "λ_S": SURFACE * N}),
    Row("soft finger", rings, lambda: rings(hl.SoftFinger(0.6, 0.006)), lambda: rings(hl.SoftFinger(0.6, 0.0)),
        {"r_T": -2 * N, "r_S": 3 * N}, faces="cone"),
    Row("anisotropic friction", rings, lambda: rings(hl.AnisotropicCoulomb(0.6, 0.4)),
        lambda: rings(hl.AnisotropicCoulomb(0.6, 0.6))),
    Row("finger flexibility", lambda: rings(flexibility=0.0), rings,
        lambda: rings(flexibility=np.zeros((3 * N, 3 * N)))),
    Row("transmission: tendons", hands, lambda: hands(joint_stiffness=hl.Tendons(ARMS, 4e3, SPRINGS)),
        lambda: hands(joint_stiffness=hl.Tendons(ARMS, 1e-9, SPRINGS)), exact=False),
    Row("transmission: synergies", hands, lambda: hands(joint_stiffness=hl.Synergies(POSTURES, 20.0, SPRINGS)),
        lambda: hands(joint_stiffness=hl.Synergies(POSTURES, np.inf, SPRINGS)), exact=False),
    Row("finger weight", lambda: hands(gravity=(0, 0, 0)), lambda: hands(finger_weight=True),
        lambda: hands(gravity=(0, 0, 0), finger_weight=True)),
    Row("commanded joint offset", hands,
        lambda: hands(joint_offset=np.full(NV, 0.01)), lambda: hands(joint_offset=np.zeros(NV))),
    Row("object weight", hands, lambda: hands(hl.Sphere(0.035, (0, 0, 0.07), mass=0.1)),
        lambda: hands(hl.Sphere(0.035, (0, 0, 0.07), mass=0.0))),
    Row("total normal-force bound", rings, asked(hl.TotalForceBound(60.0)),
        asked(hl.TotalForceBound(np.inf)), {"z̄": 1}),
    Row("per-finger force bound", rings, asked(hl.FingerForceBound([20.0, np.inf, 20.0, 20.0])),
        asked(hl.FingerForceBound(np.inf)), {"z̄_i": 3}),
    Row("torque saturation", hands, lambda: hands(effects=[hl.TorqueSaturation()]),
        lambda: hands(effects=[hl.TorqueSaturation()], torque_limits=np.inf), {"s⁺": NV, "s⁻": NV}),
    Row("geometric stiffness",
        lambda: hands(joint_stiffness=None, preload=3e-3), lambda: hands(effects=[hl.GeometricStiffness()]),
        lambda: hands(joint_stiffness=None, preload=3e-3, effects=[hl.GeometricStiffness()]), exact=False),
    Row("contact compliance", rings, asked(hl.ContactCompliance(1e-4)), asked(hl.ContactCompliance(0.0))),
    Row("soft wrist", rings, asked(hl.SoftWrist(np.full(6, 1e-3))), asked(hl.SoftWrist(np.zeros(6)))),
    Row("prescribed contact force", rings, asked(hl.PrescribedForce(0, (0.1, 0.0, 6.0))),
        lambda: rings(effects=[hl.PrescribedForce(0, own_force())]), {"r_N": -1, "r_T": -2, "λ": -FACES}, exact=False),
    Row("known force components", rings, asked(hl.KnownForce(0, (None, None, 6.0))),
        lambda: rings(effects=[hl.KnownForce(0, (None, None, own_force()[2]))]), {"κ0⁺": 1, "κ0⁻": 1}, exact=False),
    Row("environment contacts", rings, lambda: rings(environment=floor(0.0)), lambda: rings(environment=floor(10.0)),
        {"r_N": 1, "r_T": 2, "λ": FACES}, exact=False),
)  # fmt: skip
