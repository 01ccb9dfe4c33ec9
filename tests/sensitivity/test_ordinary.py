"""The compiled derivatives of ordinary answers are those that serve every other answer."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import ring
from tests.hand.composition import made
from tests.support.sensitivity import in_general

ORDINARY = ("wrench", "squeeze", "pads", "friction", "positions", "joint_offset", "stiffness")
CASES = [(name, effects) for name in ("five", "allegro", "ring", "mimic") for effects in (
    (), ("soft fingers",), ("anisotropic friction", "commanded joints"), ("finger weight", "contact compliance"),
    ("environment", "a frictionless finger"),
)]  # fmt: skip


@pytest.mark.parametrize(("name", "effects"), CASES)
def test_both_give_the_same(name, effects):
    s = made(name, effects).grasp.solve("cone", throw=False)
    if not s.held:
        pytest.skip("no answer")
    one, other = s.sensitivity(), in_general(s)
    for parameter in ORDINARY:
        for quantity in one.quantities:
            a, b = one.of(quantity, parameter), other.of(quantity, parameter)
            assert a.shape == b.shape
            kind = (
                "displacement"
                if quantity in ("gap", "slip")
                else "forces"
                if quantity == "friction_margin"
                else quantity
            )
            size = np.nanmax(abs(other.of(kind, parameter)), initial=0.0)
            assert np.isnan(a).tolist() == np.isnan(b).tolist()
            assert np.nanmax(abs(a - b), initial=0.0) <= 1e-9 * size + 1e-12, (quantity, parameter)


def test_both_give_the_same_without_a_hand():
    contacts, args = ring(np.random.default_rng(0), preload=0.003)
    s = hl.Grasp(contacts, **args).solve()
    one, other = s.sensitivity(), in_general(s)
    for parameter in ORDINARY[:5]:
        a, b = one.of("forces", parameter), other.of("forces", parameter)
        assert a == pytest.approx(b, rel=1e-9, abs=1e-9 * abs(b).max())
