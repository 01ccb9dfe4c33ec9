"""Loads that grow in MuJoCo and short loadings beside it: the same forces, torques, jumps and losses."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

import handlcp as hl
from handlcp.simulator import simulate, simulate_limit
from handlcp.simulator.load_limit import LimitTracker
from tests.mujoco import limits
from tests.mujoco.case import misses
from tests.mujoco.cases import CASES, three
from tests.mujoco.limit_cases import CASES as CASES_OF_LIMITS
from tests.mujoco.limit_truth import Truth, stored

REST, FORCES = np.zeros(6), np.zeros((2, 3))


def along_x(motion):
    return np.array([motion, 0, 0, 0, 0, 0])


def test_motion_while_the_load_grows_is_no_jump_and_motion_while_it_waits_is_one():
    tracking = LimitTracker(REST)
    for k in range(20):
        tracking.record_rest(0.1 * k, along_x(1e-3 * k), FORCES + k)
    assert tracking.jump == np.inf
    tracking.record_motion(2.0, along_x(19.9e-3))
    assert tracking.jump == np.inf
    tracking.record_motion(2.0, along_x(20.1e-3))
    tracking.record_rest(2.0, along_x(25e-3), FORCES + 25.0)
    tracking.record_motion(3.0, along_x(30e-3))
    assert tracking.jump == 2.0
    assert [hop[0] for hop in tracking.hops] == [2.0, 3.0]
    assert np.array(tracking.hops)[:, 1] == pytest.approx([1.1e-3, 5e-3])
    track = tracking.make_track()
    assert track.motion_at(0.55)[0] == pytest.approx(5.5e-3)
    assert track.motion_at(2.0)[0] == pytest.approx(25e-3)
    assert np.isnan(track.motion_at(2.1)).all()
    assert track.forces_at(0.55) == pytest.approx(FORCES + 5.0)
    assert np.isnan(track.forces_at(2.1)).all()


def test_a_turn_of_more_than_two_degrees_is_a_jump():
    start = np.array([0.0, 0, 0, 0.3, 0, 0])
    tracking = LimitTracker(start)
    tracking.record_motion(1.0, moved_by(start, 1.9))
    assert tracking.jump == np.inf
    tracking.record_motion(1.5, moved_by(start, 2.1))
    assert tracking.jump == 1.5


def moved_by(start, degrees):
    """The same, turned about the first axis."""
    return start + np.array([0, 0, 0, np.radians(degrees), 0, 0])


def test_an_object_weighs_what_it_weighs_whatever_mass_it_moves_with():
    heavy = three(hl.Box(0.05, [0, 0, 0.08], mass=0.3), offset=0.06)
    end = simulate(heavy, seconds=0.6)
    assert end.held
    assert end.forces_world.sum(axis=0) == pytest.approx([0, 0, 0.3 * 9.81], rel=1e-3, abs=3e-3)


def test_an_object_that_is_lost_before_the_load_grows_has_no_track():
    limit = simulate_limit(three(offset=0.0), [1.0, 0, 0, 0, 0, 0], 1.0, seconds=0.5)
    assert limit.factor == 0.0
    assert not len(limit.track.factors)
    assert np.isinf([limit.jump, limit.first_at]).all()


def test_every_case_is_stored_and_a_row_reads_as_it_was_written():
    rows = stored()
    assert sorted(rows) == sorted(case.title for case in CASES_OF_LIMITS)
    assert len(CASES_OF_LIMITS) == 80
    assert len({case.hand for case in CASES_OF_LIMITS}) == 6
    for truth in rows.values():
        assert Truth.read(truth.row()).row() == truth.row()


# ---------------------------------------------------------------- the short cases of the suite: grasps, loaded here
SHORT = [case for case in CASES if case.short]


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.name)
def test_both_end_with_the_same_forces_and_torques(case):
    found = case.run(seconds=1.0)
    assert not misses(case, found)
    if case.kind == "sticks":
        assert found.force_error < 3e-3
        assert found.torque_error < 3e-3


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(c, marks=pytest.mark.long) if c.title.startswith(("allegro", "three_finger")) else c
        for c in CASES_OF_LIMITS
        if c.short
    ],
    ids=lambda case: case.title,
)
def test_a_load_that_grows_is_lost_at_the_same_factor_as_the_stored_table_says(case):
    ours, expected = limits.ours(case), stored()[case.title]
    most = 1.2 * ours.end
    theirs = simulate_limit(case.make(), case.wrench, most, seconds=3.0)
    assert theirs.factor == pytest.approx(ours.end, rel=limits.NEAR)
    assert theirs.factor == pytest.approx(expected.factor, rel=0.02)
    assert theirs.jump == pytest.approx(expected.jump, rel=0.02)
    half = 0.5 * expected.factor
    near = abs(theirs.track.motion_at(half) - expected.at(half))
    assert near[:3].max() < 1e-5 + 0.03 * np.linalg.norm(expected.at(half)[:3])
