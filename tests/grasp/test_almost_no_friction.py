"""Planar contacts with friction from 1e-12 to 1e-3: every question has an answer, none breaks the linear algebra."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import handlcp as hl

QUICK = hl.Auto(search_seconds=0.3)


def _planar(seed: int) -> hl.Grasp:
    """One to five contacts around an object, many opposite each other, with and without limits on the forces."""
    rng = np.random.default_rng(seed)
    n, first = int(rng.integers(1, 6)), rng.uniform(0, 2 * np.pi)
    contacts = []
    for i in range(n):
        a = first + (np.pi / 2 * rng.integers(4) if seed % 2 else 2 * np.pi * i / n)
        z = np.array([np.cos(a), np.sin(a)])
        mu = float(10 ** rng.uniform(-12, -3))
        contacts.append(hl.Contact(-0.03 * z + 0.01 * rng.normal(size=2) * (seed % 3 > 0), z, hl.Coulomb(mu)))
    J = rng.normal(size=(3 * n, int(rng.integers(1, 2 * n + 1)))) * 1e-2
    J[1::3] = 0.0
    E: Any = (0.0, 1e-4, J @ J.T)[int(rng.integers(3))]
    load = np.append(rng.normal(size=2), 0.01 * rng.normal()) * rng.integers(2, size=3)
    limits = ([], [hl.TotalForceBound(10.0)], [hl.FingerForceBound(5.0)])[int(rng.integers(3))]
    return hl.Grasp(contacts, load, flexibility=E, preload=float(10 ** rng.uniform(-5, -2)), effects=limits)


LONG = 0, 12, *range(20, 40)  # 0, 12, 22 and 32 take as long as all others


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=pytest.mark.long) if seed in LONG else seed for seed in range(40)]
)
def test_every_question_has_an_answer(seed: int) -> None:
    """A status, how much friction and squeeze it takes, and which equilibria there are."""
    g = _planar(seed)
    s = g.solve(solver=QUICK, throw=False)
    assert s.diagnosis
    assert s.held == (s.status is hl.Status.SOLVED)
    found = g.equilibria(seconds=0.05)
    assert all(one.held for one in found)
    assert str(g.required_friction(tolerance=0.1))
    assert str(g.required_preload(tolerance=0.1))


@pytest.mark.parametrize("mu", [1e-12, 1e-10, 1e-8])
def test_friction_that_would_take_forces_beyond_all_limits_holds_nothing(mu: float) -> None:
    """A moment of 5 mN·m on two opposite contacts, 60 mm apart, asks for 0.083 / μ newtons from each; 10 N are allowed
    in all. No limit is blamed where without it 1e7 times the load would be needed.
    """
    contacts = [hl.Contact((x, 0.0), (-np.sign(x), 0.0), hl.Coulomb(mu)) for x in (-0.03, 0.03)]
    for effects in ([hl.TotalForceBound(10.0)], [hl.FingerForceBound(5.0)]):
        g = hl.Grasp(contacts, (0.0, 0.0, 0.005), flexibility=1e-4, preload=1e-4, effects=effects)
        s = g.solve(throw=False)
        assert s.status in (hl.Status.NOT_HOLDABLE, hl.Status.NO_EQUILIBRIUM)
        assert s.diagnosis
