"""The least grip, squeeze, friction and joint stiffness with which a hand's grasp holds, against closed forms."""

import numpy as np
import pytest

import handlcp as hl
from tests.design.hands import PAD, STIFF, cube_grasp, pinch
from tests.hand.levers import MU, L
from tests.support.least import lost_above
from tests.support.texts import says

LOAD = 1.0
EXACT = LOAD / (2 * MU)  # normal force of a pinch that just carries it
C = L * L / STIFF + PAD  # m/N of a tip along its normal


# ---------------------------------------------------------------- commands
def test_the_least_grip_of_a_pinch_is_the_load_over_twice_its_friction(tmp_path):
    r = pinch(tmp_path).required_grip(tolerance=1e-4)
    assert r.unit == "N"
    assert r.value == pytest.approx(EXACT, rel=1.1e-4)
    assert r.value * (1 - 1.001e-4) <= r.fails < r.value
    assert r.verdict == "HELD"


def test_the_least_squeeze_of_a_pinch_is_that_force_times_the_flexibility(tmp_path):
    r = pinch(tmp_path).required_squeeze(tolerance=1e-4)
    assert r.unit == "m"
    assert r.value == pytest.approx(C * EXACT * (L * L / STIFF + PAD) / C, rel=1.1e-4)
    assert r.verdict == "HELD"


def test_a_grip_and_a_squeeze_that_are_enough_hold_and_a_little_less_does_not():
    grasp = cube_grasp()
    for r, name in ((grasp.required_grip(), "grip_force"), (grasp.required_squeeze(), "squeeze")):
        assert grasp.replace(**{name: r.value}).check().word == "HELD"
        assert grasp.replace(**{name: r.fails}).check().word == "NOT HELD"
        assert r.value - r.fails <= 1e-3 * r.value


def test_an_object_that_rests_on_the_fingers_needs_no_grip(tmp_path):
    r = pinch(tmp_path, (0.0, 0.0, 0.0)).required_grip()
    assert r.value == 0.0
    assert "nothing added" in str(r)


@pytest.mark.long
def test_where_no_grip_holds_the_loading_says_why():
    r = cube_grasp().replace(friction=0.01).required_grip()
    assert r.value is None
    assert r.hint


# ---------------------------------------------------------------- friction
def test_the_least_friction_of_a_followed_grasp_is_what_check_says():
    grasp = cube_grasp().replace(grip_force=8.0)
    r = grasp.required_friction()
    assert r.verdict == "HELD"
    assert grasp.replace(friction=r.value).check().word == "HELD"
    assert grasp.replace(friction=r.fails).check().word == "NOT HELD"
    assert r.value - r.fails <= 1.001e-3 * r.value


def test_without_a_hand_the_least_friction_is_what_solve_says_and_check_is_asked():
    contacts = [hl.Contact((s, 0, 0), (-s, 0, 0), hl.Coulomb(0.8), tangent=(0, 0, 1)) for s in (-1.0, 1.0)]
    grasp = hl.Grasp(contacts, (0, 0, -3.0, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    r = grasp.required_friction(tolerance=1e-4)
    assert r.value == pytest.approx(0.15, rel=1.1e-4)
    assert r.verdict == "HELD"


def test_a_joint_over_its_limit_is_said_beside_the_least_friction(tmp_path):
    grasp = pinch(tmp_path, limits=1e-3, grip_force=2.0)
    r = grasp.required_friction()
    assert r.value == pytest.approx(LOAD / (2 * 2.0), rel=2e-3)
    assert r.verdict == "OVER LIMIT"
    says(str(r), "OVER LIMIT")


def test_an_object_that_falls_on_the_palm_without_friction_is_not_called_held_where_it_was_gripped():
    """The ball is lost with its own friction of 0.6; without any it comes to rest on the palm, 5 mm below."""
    hand, ball = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Sphere(0.035, (0, 0, 0.04), mass=0.3)
    links = ["palm", *(f"finger_{k}_distal_link" for k in (1, 2, 3))]
    grasp = hand.at(hand.neutral).grasp(ball, links=links, closing_torque=0.4, hold_object=True)
    assert any(e.kind == "snaps" for e in grasp.replace(friction=0.0).check().loading.events)
    r = grasp.required_friction(tolerance=0.1)
    assert 0.6 < r.fails < r.value < 1.0
    assert r.verdict == "HELD"
    assert not any(e.kind == "snaps" for e in grasp.replace(friction=r.value).follow(steps=8).events)
    assert "with 0 it snaps to another place, and is held there" in " ".join(str(r).split())


def test_friction_that_holds_where_more_does_not_is_said(monkeypatch):
    lost_above(monkeypatch, 0.7)
    r = cube_grasp().replace(grip_force=8.0).required_friction()
    assert r.value < 0.7
    assert "with its own 0.8 the grasp does not hold: more is not always better" in " ".join(str(r).split())


# ---------------------------------------------------------------- stiffness
PUSH = 0.5  # N along the normals: u = P C / 2 with both fingers pressing


def pushed(tmp_path, **more):
    return pinch(tmp_path, (PUSH, 0, 0), grip_force=2.0, **more)


@pytest.mark.parametrize("times", [0.3, 1.0, 4.0])
def test_the_stiffness_of_a_pinch_that_is_pushed_along_its_normals(tmp_path, times):
    motion = PUSH * (L * L / (STIFF * times) + PAD) / 2
    r = pushed(tmp_path).required_stiffness(motion, tolerance=1e-4)
    assert r.factor == pytest.approx(times, rel=2e-4)
    assert r.fails < r.factor
    assert r.moved == pytest.approx(motion, rel=1e-3)
    assert r.moved <= motion
    assert r.pads == pytest.approx(PUSH * PAD / 2, rel=1e-6)
    assert r.pads_share == pytest.approx(PAD / (L * L / (STIFF * times) + PAD), rel=1e-6)
    assert r.verdict == "HELD"


def test_what_pads_alone_move_no_joints_take_away(tmp_path):
    r = pushed(tmp_path).required_stiffness(0.8 * PUSH * PAD / 2)
    assert r.factor is None
    assert r.pads_share == pytest.approx(1.25, rel=1e-6)
    assert "125 %" in " ".join(str(r).split())


def test_with_that_stiffness_and_the_same_grip_the_object_moves_no_further():
    grasp = cube_grasp().replace(grip_force=8.0, load=(0, 2, 0, 0, 0, 0))
    allowed = 2.2e-4
    r = grasp.required_stiffness(allowed)

    def moved(factor):
        hand = grasp.state.hand.replace(joint_stiffness=60.0 * factor)
        other = hand.at(grasp.state.q).grasp(grasp.target, friction=0.8, wrench=(0, 2, 0, 0, 0, 0), grip_force=8.0)
        steps = other.follow(steps=8).steps
        u = steps.displacement
        return np.linalg.norm(u[-1, :3] - u[steps.stage == 0][-1, :3])

    assert moved(r.factor) <= allowed * (1 + 1e-6)
    assert moved(r.fails) > allowed
    assert r.moved == pytest.approx(moved(r.factor), rel=1e-6)


def test_fingers_without_a_hand_are_made_stiffer_as_a_whole():
    contacts = [hl.Contact((s, 0, 0), (-s, 0, 0), hl.Coulomb(0.8), tangent=(0, 0, 1)) for s in (-1.0, 1.0)]
    grasp = hl.Grasp(contacts, (0, 0, -3.0, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    r = grasp.required_stiffness(0.75e-4, tolerance=1e-4)
    assert r.factor == pytest.approx(2.0, rel=2e-4)  # u = P E / 2
    assert r.pads < 1e-15


def test_torque_limits_bound_how_stiff_a_squeezed_hand_may_be(tmp_path):
    depth = 2.0 * C
    grasp = pinch(tmp_path, (PUSH, 0, 0), limits=2.5 * L, squeeze=depth)
    r = grasp.required_stiffness(PUSH * C / 8)  # four times as stiff presses four times as hard
    assert r.factor is None
    assert r.moved > PUSH * C / 8


def test_why_less_stiffness_is_not_enough_is_said(tmp_path):
    moves = pushed(tmp_path).required_stiffness(PUSH * C / 4)
    assert moves.why == "the object moves farther than allowed"
    lost = cube_grasp().replace(squeeze=1e-3).required_stiffness(0.01)  # softer joints press less
    assert lost.why == "the object is lost"
    assert f"with × {lost.fails:.4g} the object is lost" in " ".join(str(lost).split())
