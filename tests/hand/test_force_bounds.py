"""Torques where forces are open: between what and what they lie, and what a verdict says of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import handlcp as hl
from tests.support.texts import says

from .levers import MU, L, lever_hand, lever_pinch

BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)


def wedged(write, limit, most=np.inf):
    """Rigid joints and tips: N from W / 2μ = 1 N to what bounds each finger, and the torque is L N."""
    hand = lever_hand(write, joint_stiffness=np.inf, pad_flexibility=0.0, torque_limits=limit)
    effects = [hl.FingerForceBound(most)] if np.isfinite(most) else []
    solution: Any = lever_pinch(hand, effects=effects).solve()
    return solution


def reason(s):
    (found,) = s.verdict.about("torques_open")
    return found


def test_no_statics_can_tell_whether_a_joint_is_within_its_limit(write):
    s = wedged(write, 0.2, 3.0)
    b = s.force_bounds()
    np.testing.assert_allclose(b.torques, [[L / (2 * MU), 3.0 * L]] * 2, rtol=1e-9)
    np.testing.assert_allclose(b.utilisation, [[0.4, 1.2]] * 2, rtol=1e-9)
    assert s.verdict.word == "HELD"
    assert reason(s).severity == "warning"
    says(reason(s).sentence, "left_joint", "40 to 120 %")
    says(str(b), "40 to 120 %")


def test_joints_within_their_limits_whatever_the_forces_are(write):
    s = wedged(write, 0.25, 3.0)
    assert s.verdict.word == "HELD"
    assert reason(s).severity == "note"
    says(reason(s).sentence, "left_joint", "96 %")
    np.testing.assert_allclose(reason(s).values["joints"][0]["torque_Nm"], [L / (2 * MU), 3.0 * L], rtol=1e-9)


@pytest.mark.parametrize("faces", ["cone", 8])
def test_where_forces_are_determined_a_verdict_says_what_it_said(three, faces):
    grasp = three.at(three.close_on(BOX)).grasp(BOX, hl.Coulomb(0.8), squeeze=5e-3)
    s: Any = grasp.solve(faces)
    assert not s.verdict.about("torques_open")
    b = s.force_bounds()
    np.testing.assert_array_equal(b.torques, np.repeat(s.torques[:, None], 2, axis=1))
    np.testing.assert_array_equal(b.utilisation[:, 0], s.utilisation)
    wide = s.force_bounds(pads=(0.5, 2.0))
    assert (wide.torques[:, 0] < s.torques).all()
    assert (wide.torques[:, 1] > s.torques).all()


def test_springs_that_bear_the_open_forces_know_the_torques(three):
    """Tips on a rigid table leave forces open; every joint has a spring, and its torque is that of its deflection."""
    can = hl.Cylinder(0.025, 0.05, (0, 0, 0.08), 0.3)
    floor = hl.Table((0, 0, 0.055))
    grasp = three.at(three.close_on(can)).grasp(can, hl.Frictionless(), preload=0.003, environment=floor)
    s: Any = grasp.solve()
    b = s.force_bounds()
    assert set(b.open) == {name for name in s.names if name.startswith("table")}
    np.testing.assert_array_equal(b.torques[:, 0], b.torques[:, 1])
    np.testing.assert_allclose(b.normal[:3].T, np.tile(s.normal_force[:3], (2, 1)), rtol=1e-12)
    np.testing.assert_allclose(b.normal[3:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(b.normal[3:, 1], 0.5 * 0.3 * 9.80665, rtol=1e-3)  # a weight between two opposite points
    says(reason(s).sentence, "joint's")


def test_pads_of_other_softness_lie_inside(three):
    q = three.close_on(BOX)

    def solved(pads):
        other = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=pads)
        return other.at(q).grasp(BOX, hl.Coulomb(0.8), joint_offset=0.05 * np.ones(three.nv)).solve()

    s = solved(1e-4)
    b, rng, seen = s.force_bounds(pads=(0.5, 2.0)), np.random.default_rng(0), 0
    for _ in range(10):
        other = solved(1e-4 * 2.0 ** rng.uniform(-1, 1, 3)[:, None, None] * np.eye(3))
        if other.contact_state == s.contact_state:
            seen += 1
            assert (other.forces >= b.forces[..., 0] - 1e-9).all()
            assert (other.forces <= b.forces[..., 1] + 1e-9).all()
            assert (other.torques >= b.torques[:, 0] - 1e-9).all()
            assert (other.torques <= b.torques[:, 1] + 1e-9).all()
    assert seen
