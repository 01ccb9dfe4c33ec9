"""Motors behind joints, against answers written down: what closes, what holds for good, and for how long the rest."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp import Motor
from handlcp.errors import InputError, UnknownName
from handlcp.hand import Hand, example_hand

from .levers import PAD, C, L, lever_hand, lever_pinch

URDF = Path(__file__).parents[2] / "urdf" / "three_finger.urdf"
DEPTH = 5e-3  # m each tip is commanded deeper than touching
PRESSED = DEPTH / C  # N of each finger without a load
PUSH = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # towards the right finger
MOTOR = Motor(0.01, 0.04, friction=0.05, reduction=50.0, efficiency=0.8, thermal_time=20.0)  # 0.4 and 1.6 N·m


def pinch(write, motors, squeeze=DEPTH):
    hand = lever_hand(write, motors=motors)
    return lever_pinch(hand, (0.0, 0.0, 0.0), squeeze=squeeze)


# ---------------------------------------------------------------- what a joint holds
def test_reduction_and_efficiency_bring_the_motors_torque_to_the_joint():
    np.testing.assert_allclose([MOTOR.for_good, MOTOR.at_peak], [0.4, 1.6], rtol=1e-15)
    np.testing.assert_allclose([MOTOR.closes, MOTOR.holds, MOTOR.gives], [1.55, 0.45, 1.65], rtol=1e-15)
    geared = Motor(0.01, 0.04, 2.0, 0.05, 50.0, 0.8)
    assert (geared.closes, geared.holds, geared.gives, geared.held_by) == (MOTOR.closes, 2.0, 2.0, "holding")
    assert Motor(0.3).at_peak == 0.3


@pytest.mark.parametrize("share", [1.2, 2.0, 3.5])
def test_a_motor_overheats_when_its_winding_is_as_warm_as_with_continuous_torque_for_ever(share):
    """T' = (u² - T) / τ from T = 0 reaches 1, integrated in small steps."""
    torque = share * MOTOR.for_good + MOTOR.friction
    lasts = MOTOR.lasts(torque)
    count, warm, step = 20000, 0.0, lasts / 20000
    for _ in range(count):
        middle = warm + 0.5 * step * (share**2 - warm) / 20.0
        warm += step * (share**2 - middle) / 20.0
    np.testing.assert_allclose(warm, 1.0, rtol=1e-6)


def test_a_torque_within_the_limit_lasts_for_ever_and_one_beyond_the_peak_not_at_all():
    assert MOTOR.lasts(MOTOR.holds) == np.inf
    assert MOTOR.lasts(-1.0001 * MOTOR.gives) == 0.0
    assert Motor(0.1, 0.3).lasts(0.2) is None
    assert Motor(0.1, 0.3, holding=1.0).lasts(0.9) == np.inf


@pytest.mark.parametrize("holding", [1.2 * PRESSED * L, 1.6 * PRESSED * L])
def test_a_gear_that_cannot_be_driven_back_holds_its_torque_whatever_the_motor(write, holding):
    """While both fingers touch, N₂ + N₁ = 2 δ / C and N₂ - N₁ = P: the right joint carries L (δ / C + P / 2)."""
    for continuous in (0.001, 0.002):
        motor = Motor(continuous, 0.05, holding=holding, reduction=50.0)
        limit = pinch(write, motor).load_limit(PUSH, geometry="fixed")
        np.testing.assert_allclose(limit.factor, 2 * (holding / L - PRESSED), rtol=1e-9)
        assert [(c.kind, c.who) for c in limit.binds] == [("torque", "right_joint")]


def test_dry_friction_helps_to_hold(write):
    """What friction takes of the left finger's force it adds to the right one's, beside its continuous torque."""
    for rubs in (0.0, 0.1):
        limit = pinch(write, Motor(1.2 * PRESSED * L, 2.0, friction=rubs)).load_limit(PUSH, geometry="fixed")
        np.testing.assert_allclose(limit.factor, 2 * ((1.2 * PRESSED * L + rubs) / L - PRESSED), rtol=1e-7)


# ---------------------------------------------------------------- what a verdict says
def test_the_held_end_is_judged_by_continuous_torque_and_the_verdict_says_how_long_more_lasts(write):
    torque = PRESSED * L
    held = pinch(write, Motor(1.001 * torque, 2.0 * torque)).check()
    assert held.word == "HELD"
    assert "continuous" in str(held)
    hot = pinch(write, Motor(torque / 1.2, 2.0 * torque, thermal_time=20.0)).check()
    (reason,) = hot.about("overheats")
    assert (hot.word, reason.severity) == ("OVER LIMIT", "decides")
    np.testing.assert_allclose(reason.values["lasts_s"], 20.0 * np.log(1.44 / 0.44), rtol=1e-3)
    assert "120 % of continuous" in reason.sentence
    solved = pinch(write, Motor(torque / 1.2, 2.0 * torque, thermal_time=20.0)).solve().verdict  # in this very posture
    np.testing.assert_allclose(solved.about("overheats")[0].values["lasts_s"], 20.0 * np.log(1.44 / 0.44), rtol=1e-9)
    (unknown,) = pinch(write, Motor(torque / 1.2, 2.0 * torque)).solve().verdict.about("overheats")
    assert "not for longer than the motor's thermal time" in unknown.sentence


def test_closing_is_judged_by_the_peak_and_nothing_is_held_before_the_hand_has_closed(write):
    """N L + τ_f = K (θ - φ), with N = (θ - τ_f / K) L / C: dry friction takes its part of what the motor gives."""
    torque, rubs = PRESSED * L, 0.05
    gives = torque + rubs * PAD / C
    enough, short = (Motor(0.9 * torque, peak, 2 * torque, rubs) for peak in (1.001 * gives, 0.999 * gives))
    assert pinch(write, enough).check().word == "HELD"
    grasp = pinch(write, short)
    (reason,) = grasp.check().about("closing_over_peak")
    assert [joint["joint"] for joint in reason.values["joints"]] == ["left_joint", "right_joint"]
    assert grasp.check().word == "OVER LIMIT"
    limit = grasp.load_limit(PUSH)
    assert limit.factor == 0.0
    assert "cannot close so hard" in limit.why
    assert hl.envelope(grasp, [PUSH], geometry="followed").factors.tolist() == [0.0]


# ---------------------------------------------------------------- how hard a motor closes
def test_closing_torque_is_the_motors_and_dry_friction_takes_its_part():
    ball = hl.Sphere(0.03, (0.0, 0.0, 0.09))
    hand = example_hand("three_finger", motors=Motor(1.0, friction=0.1))
    q = hand.close_on(ball)
    through = hand.at(q).grasp(ball, closing_torque=0.3, gravity=(0, 0, 0), hold_object=True).follow(order="squeeze")
    end = np.flatnonzero(through.steps.stage == 0)[-1]
    pulled, torque = abs(through.steps.pulled[end]).reshape(3, 2), abs(through.steps.torques[end]).reshape(3, 2)
    np.testing.assert_allclose(pulled.max(axis=1), 0.3, rtol=1e-3)
    assert (abs(pulled - torque) <= 0.1 * (1 + 1e-6)).all()
    for torque, words in ((0.1, "dry friction"), (1.1, "peak")):
        with pytest.raises(InputError, match=f"closing_torque.*{words}"):
            hand.at(q).grasp(ball, closing_torque=torque)


# ---------------------------------------------------------------- what is passed
def test_motors_give_limits_and_stiffness_of_their_joints_and_others_keep_theirs():
    joints = example_hand("three_finger").joint_names
    hand = example_hand("three_finger", joint_stiffness=6.0, motors={joints[1]: Motor(0.1, stiffness=9.0)})
    np.testing.assert_allclose(hand.torque_limits, [0.8, 0.1, 0.8, 0.4, 0.8, 0.4])
    np.testing.assert_allclose(np.diagonal(hand.joint_stiffness), [6, 9, 6, 6, 6, 6])
    assert "its motor, continuous torque" in str(hand.describe())
    every = Hand.from_urdf(URDF, motors=Motor(0.1, stiffness=9.0))
    np.testing.assert_allclose(np.diagonal(every.joint_stiffness), 9.0)


def test_what_is_passed_last_counts():
    hand = example_hand("three_finger", motors=Motor(0.1, stiffness=9.0))
    joint = hand.joint_names[0]
    np.testing.assert_allclose(hand.replace(torque_limits={joint: 0.3}).torque_limits, [0.3, *[0.1] * 5])
    np.testing.assert_allclose(hand.replace(torque_limits=0.3).torque_limits, 0.3)
    np.testing.assert_allclose(hand.replace(motors=None).torque_limits, example_hand("three_finger").torque_limits)
    np.testing.assert_allclose(hand.replace(motors=Motor(0.2)).torque_limits, 0.2)
    np.testing.assert_allclose(np.diagonal(hand.replace(joint_stiffness=3.0).joint_stiffness), 3.0)
    assert pickle.loads(pickle.dumps(hand)).torques.drives is not None


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"continuous": 0.3, "peak": 0.2}, "Motor.peak: expected at least the continuous torque"),
        ({"continuous": 0.3, "efficiency": 1.1}, "Motor.efficiency: expected a number above 0 and at most 1"),
        ({"continuous": 0.3, "friction": 0.3}, "Motor.friction: expected less than the peak torque"),
        ({"continuous": 0.3, "holding": 0.2}, "Motor.holding: expected at least what the motor"),
        ({"continuous": 0.3, "reduction": 0.0}, "Motor.reduction"),
        ({"continuous": "much"}, "Motor.continuous"),
    ],
)
def test_a_motor_that_cannot_be_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        Motor(**given)


def test_motors_of_unknown_joints_and_what_is_no_motor_are_refused():
    with pytest.raises(UnknownName, match="finger_1_proximal"):
        example_hand("three_finger", motors={"finger_9_proximal": Motor(0.3)})
    with pytest.raises(InputError, match=r"motors.*a Motor"):
        example_hand("three_finger", motors={"finger_1_proximal": 0.3})
    with pytest.raises(InputError, match="a Motor for every joint"):
        example_hand("three_finger", motors=0.3)
    both = {"finger_1_proximal": 0.3}
    with pytest.raises(InputError, match=r"torque_limits.*no limit of a joint with a motor"):
        example_hand("three_finger", motors=Motor(0.3), torque_limits=both)
    with pytest.raises(InputError, match=r"joint_stiffness.*finger_1_distal"):
        Hand.from_urdf(URDF, motors={"finger_1_proximal": Motor(0.3, stiffness=5.0)})
    tendons = hl.Tendons({"pull": {"finger_1_distal": 0.01}}, 2e4, 4.0)
    with pytest.raises(InputError, match=r"Motor.stiffness.*shares springs"):
        example_hand("three_finger", joint_stiffness=tendons, motors={"finger_1_distal": Motor(0.3, stiffness=5.0)})


# ---------------------------------------------------------------- which to buy
@pytest.mark.long
def test_a_brief_sizes_motors_by_what_is_held_and_by_the_peak_and_says_the_gear_of_one(three):
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    rubs = 0.02
    plain = three.at(three.close_on(cube)).grasp(cube, friction=0.8).required_torque()
    assert (plain.held <= plain.torque).all()
    np.testing.assert_allclose(plain.peak, plain.torque)
    np.testing.assert_allclose(plain.continuous, plain.held)
    driven = three.replace(motors=Motor(0.3, 0.6, friction=rubs))
    found = driven.at(driven.close_on(cube)).grasp(cube, friction=0.8).required_torque()
    np.testing.assert_allclose(found.peak, np.maximum(found.closing + rubs, found.torque - rubs), rtol=1e-12)
    np.testing.assert_allclose(found.continuous, np.maximum(found.held - rubs, 0.0), rtol=1e-12)
    assert found.enough
    small = Motor(0.004, 0.005, friction=rubs, reduction=100.0, efficiency=0.5)
    gears = found.reductions(small)
    geared = [replace(small, reduction=N * (1 + 1e-9)) for N in gears.tolist()]
    bought = driven.replace(motors=dict(zip(driven.joint_names, geared, strict=True)))
    again = bought.at(bought.close_on(cube)).grasp(cube, friction=0.8, grip_force=found.grip)
    assert again.replace(mass=1.5 * 0.2).check().word == "HELD"
    carried = three.replace(motors=Motor(0.3, 0.6, holding=2.0))
    worm = carried.at(carried.close_on(cube)).grasp(cube, friction=0.8).required_torque()
    assert not worm.continuous.any()


# ---------------------------------------------------------------- tendons
def test_a_brief_says_what_tendons_pull_with_and_which_go_slack(write):
    """A flexor's tension is torque over arm; an extensor that goes slack needs the pretension that is said."""
    arm, stiffness = 0.01, 1e5
    flexors = {f"{side} flexor": {f"{side}_joint": arm} for side in ("left", "right")}
    extensors = {f"{side} extensor": {f"{side}_joint": -arm} for side in ("left", "right")}
    load = (2.0, 0.0, -1.0)

    def required(arms, k, pretension=0.0):
        hand = lever_hand(write, joint_stiffness=hl.Tendons(arms, k, pretension=pretension))
        return lever_pinch(hand, load).required_torque(safety=1.0, tolerance=0.5)

    found = [required(flexors, 2.0 * stiffness), required(flexors | extensors, stiffness)]
    tensions = [one.tensions for one in found]
    np.testing.assert_allclose(tensions[0].tension, found[0].torque / arm, rtol=1e-6)
    assert tensions[0].slack == ()
    np.testing.assert_allclose(tensions[1].tension[:2], found[1].torque / arm, rtol=1e-6)
    assert "right extensor" in tensions[1].slack
    assert "more of pretension at most keep it taut" in str(found[1])
    more = -float(tensions[1].least.min())
    assert not required(flexors | extensors, stiffness, more).tensions.slack
    assert [row["tendon"] for row in found[1].to_dict()["tendons"]] == [*flexors, *extensors]
