"""Paths of many contacts, which are eliminated one by one, beside the same paths with all of them in one matrix."""

import json
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from tests.mujoco.find_power_grasps import made
from tests.support.paths import in_one_matrix
from tests.support.power import STRONG, WEAK, power_grasp

GRASPS = Path(__file__).parents[1] / "mujoco" / "power_grasps.json"


@pytest.mark.parametrize(("n", "seed", "friction"), [(10, 0, STRONG), (12, 1, WEAK), (20, 2, STRONG), (20, 4, WEAK)])
def test_contacts_that_stay_give_the_path_of_one_matrix(n, seed, friction):
    grasp = power_grasp(n, seed, friction, loaded=False)
    whole, single = grasp.dense().follow(), grasp.factored().follow()
    assert whole.reached
    assert single.reached
    most = abs(whole.steps.forces[-1]).max()
    np.testing.assert_allclose(single.steps.forces[-1], whole.steps.forces[-1], atol=1e-8 * most)
    np.testing.assert_allclose(single.displacement, whole.displacement, atol=1e-8 * abs(whole.displacement).max())


def test_a_contact_that_creeps_slides_in_short_steps_as_in_long_ones():
    """Slips of a nanometre in a step: contacts of which some change their state only once, whatever the steps are."""
    grasp = power_grasp(60, 0, STRONG, loaded=False).factored()
    coarse, fine = grasp.follow(steps=20), grasp.follow(steps=80)
    assert [(e.kind, e.who, e.stage) for e in coarse.events] == [(e.kind, e.who, e.stage) for e in fine.events]
    assert len(fine.steps) < 170  # a change ends a step


def test_loads_at_which_contacts_slip_are_located_in_long_steps_as_in_short_ones():
    grasp = power_grasp(40, 1, STRONG, loaded=False).factored()
    long, short = (
        {e.who: e.share for e in grasp.follow(steps=steps).events if e.kind == "slips" and e.stage == "load"}
        for steps in (10, 40)
    )
    assert len(long) >= 4
    assert long == pytest.approx(short, abs=1e-4)


def test_a_grasp_that_is_lost_is_lost_at_the_same_load():
    grasp = power_grasp(12, 5, WEAK)
    whole, single = grasp.dense().follow(), grasp.factored().follow()
    assert not whole.reached
    assert whole.lost_stage == single.lost_stage
    assert single.lost_at == pytest.approx(whole.lost_at, rel=1e-5)


def test_joints_without_names_have_no_limits_and_the_load_limit_is_that_of_one_matrix():
    grasp = power_grasp(12, 5, WEAK, loaded=False)
    load = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    whole, single = grasp.dense(), grasp.factored()
    assert single.follow(1e-3 * load).word == whole.follow(1e-3 * load).word
    assert single.load_limit(load).factor == pytest.approx(whole.load_limit(load).factor, rel=1e-5)


def test_contacts_that_move_with_a_hand_give_the_path_of_one_matrix(monkeypatch):
    """Turning and moving contacts, pads and joints: all terms of the tangent, eliminated and in one matrix."""
    row = json.loads(GRASPS.read_text())["five_finger, ball 1"]
    found = []
    for one_matrix in (False, True):
        if one_matrix:
            in_one_matrix(monkeypatch)
        grasp = made(row)
        assert grasp.spec.n >= 10
        found.append(grasp.follow(load=(0.5, 0.0, 1.0, 0.0, 0.01, 0.0), steps=5))
    single, whole = found
    assert single.reached
    assert whole.reached
    most = abs(whole.steps.forces[-1]).max()
    np.testing.assert_allclose(single.steps.forces[-1], whole.steps.forces[-1], atol=1e-6 * most)
    np.testing.assert_allclose(single.steps.torques[-1], whole.steps.torques[-1], atol=1e-6 * most)
    met, other = (m / np.linalg.norm(m) for m in (single.last.met, whole.last.met))  # natural units differ a little
    np.testing.assert_allclose(met, other, atol=1e-5)


def test_many_contacts_that_have_no_equilibrium_are_proven_to_have_none():
    """The compliance creates too little force at friction 0.15, though forces that balance the load exist."""
    for n, seed in ((14, 1106), (24, 1170)):
        found = power_grasp(n, seed, WEAK).factored().solve(throw=False)
        assert found.status is hl.Status.NO_EQUILIBRIUM
