"""Tests that others publish: closed forms of a parallel gripper, levers and pinches; finite differences of tips."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.studies.published.lift_and_shake import LIFT_ACCELERATION, SHAKE_ACCELERATION, shake_grasp
from tests.design.hands import pinch as levers
from tests.hand.levers import L
from tests.support.published import gripper
from tests.support.squeezed import MU, G, K, N, R, pinch as two_points

DOWN = np.array([0.0, 0.0, 1.0])
FORCE, WIDE, PAD = 10.0, 0.05, 1e-5  # of the jaws [N]; of the ball [m]; of the jaws' pads [m/N]


def three(**more):
    return hl.example_hand("three_finger", joint_stiffness=6.0, **more)


def ball(folder, mass, grip=FORCE, friction=MU):
    """A ball between two jaws, both contacts on its axis, under the largest weight of the shake."""
    hand = gripper(folder, FORCE)
    obj = hl.Sphere(0.5 * WIDE, placement=(0, 0, 0.1), mass=mass)
    state = hand.at(hand.close_on(obj))
    return state.grasp(obj, friction=friction, gravity=(G + SHAKE_ACCELERATION) * DOWN, grip_force=grip)


# ---------------------------------------------------------------- finger strength
@pytest.mark.parametrize("most", [0.1, 0.4])
def test_a_lever_presses_with_its_torque_over_its_length(tmp_path, most):
    hand = levers(tmp_path, limits=most).state.hand
    found = hl.finger_strength(hand, ["left_tip"], postures={"up": [0.0, 0.0]})
    (row,) = found.rows
    assert row.force == pytest.approx(most / L, rel=1e-9)
    assert (row.finger, row.posture, row.binds) == ("left_tip", "up", "left_joint")
    np.testing.assert_allclose(row.direction, (1, 0, 0), atol=1e-12)


def test_a_finger_presses_with_the_least_torque_over_lever_of_its_joints_in_every_posture():
    """Levers are how far the contact's point moves along the cell when one joint turns: a finite difference."""
    hand, rng, h = three(), np.random.default_rng(0), 1e-6
    postures = {f"{k}": rng.uniform(0.1, 1.2, hand.nv) for k in range(4)}
    for row in hl.finger_strength(hand, postures=postures).rows:
        tip = hand.fingertips.index(row.finger)

        def height(q, row=row, tip=tip):
            state = hand.at(q)
            own = hand.at(row.q)
            point = own.tip_rotations[tip].T @ (row.at - own.tip_positions[tip])
            return row.direction @ (state.tip_positions[tip] + state.tip_rotations[tip] @ point)

        steps = h * np.eye(hand.nv)
        levers_ = [abs(height(row.q + e) - height(row.q - e)) / (2 * h) for e in steps]
        known = [t / lever for t, lever in zip(hand.torque_limits, levers_, strict=True) if lever > 1e-9]
        assert row.force == pytest.approx(min(known), rel=1e-6)
        assert abs(row.torques / hand.torque_limits).max() == pytest.approx(1.0, abs=1e-8)


def test_the_cell_touches_the_tip_where_it_is_highest():
    row = hl.finger_strength(three(), ["finger_1_tip"], postures={"neutral": three().neutral}).rows[0]
    tip = three().at(three().neutral).tip_positions[0]
    radius = float(np.linalg.norm(row.at - tip))
    np.testing.assert_allclose(row.at, tip + radius * row.direction, atol=1e-12)
    assert radius == pytest.approx(float(three().tip_shapes(0)[0].radius))


def test_a_tendon_with_a_pretension_gives_out_at_what_is_left_of_its_limit():
    """Each tendon has an arm of 10 mm at one joint: a torque τ takes τ / 10 mm beside the pretension."""
    names, arm, begun, most = three().joint_names, 0.01, 5.0, 20.0
    cables = {f"tendon {name}": {name: arm} for name in names}
    tendons = hl.Tendons(cables, 1e6, 6.0, pretension=begun, limits=most)
    hand = three().replace(joint_stiffness=tendons, torque_limits=np.inf)
    plain = three().replace(torque_limits=arm * (most - begun))
    pulled, turned = (hl.finger_strength(h, postures={"a": np.full(h.nv, 0.5)}) for h in (hand, plain))
    shares = 1.0 / (1.0 + 6.0 / (1e6 * arm**2))  # of a torque that tendons bear beside springs of 6 N·m/rad
    assert {row.binds for row in pulled.rows} == {f"tendon finger_{k}_proximal" for k in (1, 2, 3)}
    assert pulled.weakest.force == pytest.approx(turned.weakest.force / shares, rel=1e-6)


# ---------------------------------------------------------------- slip resistance
def test_two_points_slip_at_twice_their_friction():
    found = hl.slip_resistance(two_points(), (0, 0, 3.0))
    assert found.force == pytest.approx(2 * MU * N, rel=1e-6)
    assert found.slips
    np.testing.assert_allclose(found.axis, DOWN)


@pytest.mark.parametrize("n", [3, 5])
def test_a_cylinder_in_n_fingers_slips_along_its_axis_at_n_times_their_friction(n):
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) for a in 2 * np.pi * np.arange(n) / n]
    contacts = [hl.Contact(R * d, -d, MU) for d in ways]
    found = hl.slip_resistance(hl.Grasp(contacts, flexibility=K, preload=K * N), DOWN)
    assert found.force == pytest.approx(n * MU * N, rel=1e-6)
    assert found.along.factor == pytest.approx(found.against.factor, rel=1e-9)


def test_the_axis_is_the_objects_own_and_its_weight_comes_beside_the_pull(tmp_path):
    """Along the weight the ball is held with less, against it with more, by as much."""
    mass = 0.3
    grasp = ball(tmp_path, mass).replace(gravity=G * DOWN)
    found = hl.slip_resistance(grasp)
    np.testing.assert_allclose(found.axis, DOWN)
    assert found.along.factor == pytest.approx(2 * MU * FORCE - mass * G, rel=1e-5)
    assert found.against.factor == pytest.approx(2 * MU * FORCE + mass * G, rel=1e-5)
    assert found.force == found.along.factor


@pytest.mark.long
def test_a_hand_pulls_on_with_all_its_torque_while_a_pinched_cylinder_is_pulled_out():
    hand = three()
    found = hl.slip_resistance(hand, diameter=0.05, kind="pinch")
    assert found.slips
    assert 0.0 < found.force < 0.6 * sum(hl.split_cylinder(hand, 0.05, grasps=["pinch"]).pinch.normal_force.values())


# ---------------------------------------------------------------- lift and shake
def test_the_accelerations_are_those_of_the_documents():
    assert pytest.approx(0.02 * (4 * np.pi) ** 2) == SHAKE_ACCELERATION
    assert pytest.approx(0.8) == LIFT_ACCELERATION  # 20 cm in 1 s, half of it speeding up: s = a t² / 2 twice
    assert LIFT_ACCELERATION < SHAKE_ACCELERATION


@pytest.mark.parametrize(("share", "holds"), [(0.98, True), (1.02, False)])
def test_jaws_hold_a_ball_through_the_shake_up_to_2_mu_n_over_g_plus_a(tmp_path, share, holds):
    most = 2 * MU * FORCE / (G + SHAKE_ACCELERATION)
    row = shake_grasp(ball(tmp_path, share * most), "sphere", WIDE, DOWN)
    assert row.held is holds, str(row)
    assert row.most == pytest.approx(most, rel=1e-5)
    if holds:
        mass, c = row.mass, 0.5 * PAD  # two pads that give way side by side
        assert row.moved == pytest.approx(mass * (G + SHAKE_ACCELERATION) * c, rel=1e-3)
        assert len(row.loading.stages) == 2 + 2 * 4 + 1


def test_a_ball_on_pads_swings_with_the_period_of_a_spring(tmp_path):
    """Soft fingertips, so that the ball does not turn about the line between them."""
    row = shake_grasp(ball(tmp_path, 0.4, friction=hl.SoftFinger(MU, 0.01)), "sphere", WIDE, DOWN)
    assert row.period == pytest.approx(2 * np.pi * np.sqrt(0.4 * 0.5 * PAD), rel=1e-3)


def test_a_ball_of_half_the_rated_payload_is_lifted_70_percent_as_wide_as_the_hand_opens(tmp_path):
    """Two points hold no cube, which turns about the line between them, unless its centre is on it."""
    hand = gripper(tmp_path, FORCE)
    found = hl.lift_and_shake(hand, 1.0, 0.08, friction=MU, tries=4)
    assert (found.sphere.mass, found.sphere.size) == pytest.approx((0.5, 0.056))
    assert found.sphere.held, str(found)
    assert found.sphere.most == pytest.approx(2 * MU * FORCE / (G + SHAKE_ACCELERATION), rel=1e-3)
    assert found.passed is (found.cube is not None and found.cube.held)
    assert set(found.missing) == ({"cube"} if found.cube is None else set())


@pytest.mark.long
def test_a_hand_lifts_and_shakes_both():
    found = hl.lift_and_shake(three(), 0.2, 0.07, friction=0.8, tries=16)
    assert found.passed, str(found)
    assert (found.sphere.mass, found.cube.mass) == pytest.approx((0.1, 0.17))
    for row in (found.sphere, found.cube):
        assert row.used <= 1.0 + 1e-6
        assert row.most > row.mass
        assert row.moved < 1e-3
    assert found.to_dict()["rated_payload_kg"] == 0.2


@pytest.mark.long
def test_a_payload_that_no_grip_holds_is_not_passed():
    found = hl.lift_and_shake(three(), 3.0, 0.07, friction=0.8, tries=16)
    assert not found.passed
    assert "not passed" in str(found)
    assert found.sphere is None or found.sphere.most < 1.5


# ---------------------------------------------------------------- what is asked, and what prints
def test_bad_questions_are_refused(tmp_path):
    hand, grasp = three(), two_points()
    for call, word in (
        (lambda: hl.finger_strength("hand"), "hand"),
        (lambda: hl.finger_strength(hand, direction=(0, 0, 2)), "direction"),
        (lambda: hl.finger_strength(hand, postures={}), "postures"),
        (lambda: hl.slip_resistance(grasp), "axis"),
        (lambda: hl.slip_resistance(grasp, (0, 0, 0)), "axis"),
        (lambda: hl.slip_resistance(grasp, (0, 0, 1), diameter=0.05), "diameter"),
        (lambda: hl.slip_resistance(hand), "diameter"),
        (lambda: hl.slip_resistance(7), "held"),
        (lambda: hl.lift_and_shake(hand, 0.0, 0.07), "rated_payload"),
        (lambda: hl.lift_and_shake(hand, 1.0, -1.0), "opening"),
        (lambda: hl.lift_and_shake(hand, 1.0, 0.07, forward=(0, 0, 0)), "forward"),
        (lambda: hl.lift_and_shake(three(torque_limits=np.inf), 1.0, 0.07), "torque limit"),
    ):
        with pytest.raises(hl.InputError, match=word):
            call()
    with pytest.raises(hl.UnknownName, match="fingertip"):
        hl.finger_strength(hand, ["thumb"])
