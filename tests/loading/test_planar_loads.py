"""Loads of planar grasps: three numbers, two forces and the moment, wherever a load is taken; bad ones are named."""

import re

import numpy as np
import pytest

import handlcp as hl
from handlcp.simulator import simulate
from tests.loading.hands import cube

MU, PAD, SQUEEZE = 0.6, 1e-4, 1e-3  # friction, m/N, m
MOST = 2 * MU * SQUEEZE / PAD  # what two pads bear across their line [N]


def pinch(height=None):
    """Two pads along x, 40 mm apart; height : of the contacts' plane above the reference [m], None: in it."""
    if height is None:
        ends = [hl.Contact((-0.02, 0), (1, 0), MU), hl.Contact((0.02, 0), (-1, 0), MU)]
        return hl.Grasp(ends, flexibility=PAD, preload=SQUEEZE)
    ends = [hl.Contact((-0.02, 0, height), (1, 0, 0), MU), hl.Contact((0.02, 0, height), (-1, 0, 0), MU)]
    return hl.Grasp(ends, flexibility=PAD, preload=SQUEEZE, plane=(0, 0, 1))


@pytest.fixture(scope="module")
def ring():
    hand = hl.example_hand("planar_ring")
    disc = hl.Cylinder(0.03, 0.02)
    state = hand.at(hand.close_on(disc, np.tile([0.5, -0.9], 6)))
    return state.grasp(disc, friction=0.5, plane=(0, 0, 1), joint_offset=np.tile([0.02, 0.02], 6))


@pytest.mark.parametrize(("share", "held"), [(0.99, True), (1.01, False)])
def test_a_stage_takes_three_numbers(share, held):
    """What two pads hold across their line is 2 μ N."""
    load = (0, -share * MOST, 0)
    staged = pinch().follow(order=["squeeze", hl.Stage("pull", load=load)])
    assert staged.held is held
    assert pinch().follow(load).held is held
    assert pinch().follow([(0, -1, 0), load]).held is held


@pytest.mark.parametrize("height", [None, 0.03])
def test_three_numbers_are_the_six_of_the_grasp_itself(height):
    """Forces act in the plane of the contacts, however far that is above the reference."""
    grasp, load = pinch(height), (2.0, -3.0, 0.02)
    own = grasp.replace(wrench=load)
    assert (own.spec.wrench[3:5] == 0.0).all() is np.bool_(height is None)
    expected = own.follow().steps.forces[-1]
    for found in (
        grasp.follow(load),
        grasp.follow(own.spec.wrench),
        grasp.follow([load]),
        grasp.follow(order=["squeeze", hl.Stage("load", load=load)]),
        grasp.follow(order=["squeeze", hl.Stage("load", load=own.spec.wrench)]),
    ):
        np.testing.assert_allclose(found.steps.forces[-1], expected, rtol=1e-12)


def test_a_planar_hand_takes_three_numbers(ring):
    load = (0.2, -0.1, 0.001)
    same = ring.replace(load=load)
    staged = ring.follow(order=["squeeze", hl.Stage("push", load=load, weight=1.0)], steps=4)
    assert same.follow(steps=4).held
    np.testing.assert_allclose(staged.steps.forces[-1], same.follow(steps=4).steps.forces[-1], rtol=1e-9)


def test_the_simulator_takes_three_numbers(ring):
    pytest.importorskip("mujoco")
    load = (0.2, -0.1, 0.001)
    loads = load, ring.replace(load=load).spec.wrench, (0, 0, 0)
    three, six, none = (simulate(ring, w, seconds=0.02, settle=0.0).forces_world for w in loads)
    np.testing.assert_array_equal(three, six)
    assert abs(three - none).max() > 0.01, "the load is there"
    with pytest.raises(hl.InputError, match=r"^load:"):
        simulate(ring, (0, 0, 1.0, 0, 0, 0))


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ({"load": (0, -1.0, 0)}, "load"),
        ({"load": [(0, -1.0, 0)]}, "load"),
        ({"load": np.zeros((0, 6))}, "load"),
        ({"order": [hl.Stage("pull", load=(0, -1.0, 0))]}, "order[0].load"),
    ],
    ids=["three", "rows of three", "none", "stage"],
)
def test_in_space_a_load_has_six_numbers(words, named):
    with pytest.raises(hl.InputError, match=f"^{re.escape(named)}: expected"):
        cube().follow(**words)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ({"load": (0, 0, 5.0, 0, 0, 0)}, "load"),
        ({"load": [(0, 1.0, 0, 0, 0, 0), (0, 0, 0, 0.1, 0, 0)]}, "load[1]"),
        ({"order": ["squeeze", hl.Stage("pull", load=(0, 0, 5.0, 0, 0, 0))]}, "order[1].load"),
    ],
    ids=["out of the plane", "a moment across it", "stage"],
)
def test_what_does_not_act_in_the_plane_is_named(words, named):
    with pytest.raises(hl.InputError, match=f"^{re.escape(named)}: expected forces in the plane"):
        pinch().follow(**words)


@pytest.mark.parametrize("load", [(1.0, 2.0), (1.0, 2.0, 3.0, 4.0), "down", (np.nan, 0, 0)])
def test_a_stage_takes_no_other_load(load):
    with pytest.raises(hl.InputError, match=r"^Stage\.load: expected force"):
        hl.Stage("pull", load=load)


def test_three_numbers_need_the_plane_xy():
    upright = [hl.Contact((-0.02, 0, 0), (1, 0, 0), MU), hl.Contact((0.02, 0, 0), (-1, 0, 0), MU)]
    grasp = hl.Grasp(upright, flexibility=PAD, preload=SQUEEZE, plane=(0, 1, 0))
    with pytest.raises(hl.InputError, match=r"^load: expected shape \(6,\) unless the plane is xy"):
        grasp.follow((0, -1.0, 0))
