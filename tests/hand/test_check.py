"""`grasp.check()`: squeezed, then loaded, held or lost, and why; what it advises holds when it is done."""

import numpy as np
import pytest

import handlcp as hl
from tests.hand.levers import MU, C, L, lever_hand, lever_pinch
from tests.support.texts import same, says

SQUEEZE = 5.0 * C  # [m] of each lever finger: 5 N
BALL = hl.Sphere(0.035, (0.0, 0.0, 0.07), mass=0.3)
CUBE = hl.Box(0.05, (0.0, 0.0, 0.08), mass=0.2)


def lever(write, pull, torque_limit=5.0, mu=MU, effects=(), **more):
    """Two lever fingers that squeeze with 5 N, under a pull along their tips; friction holds up to 2 μ 5 N."""
    hand = lever_hand(write, torque_limits=torque_limit, **more)
    return lever_pinch(hand, (0, 0, -pull), mu, preload=SQUEEZE, effects=effects)


def five(stiffness, pull=0.0, **more):
    """The five-finger hand on a ball that is pulled out of it by its weight, closed by 1 mm."""
    hand = hl.example_hand("five_finger", joint_stiffness=stiffness)
    settings = {"gravity": (0, 0, 9.81), "wrench": (0, 0, pull, 0, 0, 0), "preload": 1e-3} | more
    return hand.at(hand.close_on(BALL)).grasp(BALL, hl.Coulomb(0.6), **settings)


# ---------------------------------------------------------------- held or not
def test_friction_of_a_pinch_holds_up_to_twice_mu_times_the_squeeze_and_is_lost_at_that_share(write):
    held, lost = lever(write, 0.98 * 2 * MU * 5.0).check(), lever(write, 1.25 * 2 * MU * 5.0).check()
    assert (held.word, held.ok) == ("HELD", True)
    assert lost.word == "NOT HELD"
    (why,) = lost.about("lost")
    assert why.values["stage"] == "load"
    assert why.values["share"] == pytest.approx(1 / 1.25, abs=0.02), "the geometry moves a little"


def test_a_torque_over_its_limit_is_over_limit_with_the_torque_at_the_end(write):
    """Each joint holds 5 N at the length of its finger, 0.4 N·m."""
    v = lever(write, 2.0, torque_limit=0.3).check()
    assert v.word == "OVER LIMIT"
    (over,) = v.about("torque_over_limit")
    assert {j["joint"] for j in over.values["joints"]} == {"left_joint", "right_joint"}
    assert over.values["joints"][0]["torque_Nm"] == pytest.approx(5.0 * L, rel=0.02)
    (gentler,) = [r for r in v.about("advice") if r.values["change"] == "less squeeze"]
    same("hand/test_check: less squeeze", gentler.sentence)
    eased = lever(write, 2.0, torque_limit=0.3).replace(preload=gentler.values["value"] * SQUEEZE)
    assert eased.check().word == "HELD"


@pytest.mark.parametrize(("stiffness", "pull"), [(1.0, 0.0), (6.0, 20.0)], ids=["soft", "pulled"])
def test_a_soft_hand_that_one_solve_calls_held_drops_the_ball(stiffness, pull):
    """A simulation in MuJoCo, springs in the joints, drops both; one solve proves an equilibrium of small motions."""
    grasp = five(stiffness, pull)
    one = grasp.solve("cone")
    assert one.held
    v = grasp.check(solution=one)
    assert v.word == "NOT HELD"
    (lost,) = v.about("lost")
    assert lost.values["share"] == pytest.approx(grasp.follow(steps=20).lost_at, rel=1e-5)
    assert any(why in lost.sentence for why in ("runs away", "do not create the forces"))  # at a fold both are so
    (note,) = v.about("followed_forces")
    says(note.sentence, "equilibrium")


@pytest.mark.parametrize(("stiffness", "pull"), [(1.0, 0.0), (6.0, 12.0)])
def test_the_estimate_of_what_small_motions_miss_is_of_the_size_of_what_the_loading_finds(stiffness, pull):
    """Between a third of it and three times; one solve is 3 to 8 % away here, from motions of 1.5 to 2.3 mm."""
    grasp = five(stiffness, pull, preload=0.0, squeeze=3e-3)
    one, path = grasp.solve("cone"), grasp.follow(order="together", steps=10)
    off = np.linalg.norm(path.steps.forces[-1] - one.forces, axis=1).max()
    off /= np.linalg.norm(path.steps.forces[-1], axis=1).max()
    said = one.verdict.about("large_motion")
    estimate = said[0].values["force_error"] if said else 0.05
    assert off > 0.02
    assert off / 3 < estimate < 3 * off


def test_a_loading_that_cannot_be_followed_is_said(write):
    effects = (hl.PrescribedForce(0, (0.5, 0.0, 5.0)),)
    grasp = lever_pinch(lever_hand(write), preload=SQUEEZE, effects=effects)
    v = grasp.check()
    (told,) = v.about("not_followed")
    assert told.severity == "warning"
    assert v.word == grasp.solve("cone").verdict.word


def test_a_joint_that_the_squeeze_drives_past_its_range_is_named(three):
    grasp = three.at(three.close_on(CUBE)).grasp(CUBE, hl.Coulomb(0.8), preload=20e-3)
    assert not grasp.solve("cone").verdict.about("joint_range"), "not in this posture"
    end = grasp.follow().state.q
    names, inside = np.array(three.joint_names), (three.lower <= end) & (end <= three.upper)
    past = set(names[~inside].tolist())
    assert past
    assert {r.values["joint"] for r in grasp.check().about("joint_range")} == past


def test_a_joint_that_yields_at_its_limit_is_not_over_it(write):
    """Joints of 0.3 N·m give way where a squeeze of 5 N would take 0.4, and hold 2 N, pulled away from the hinges."""
    grasp = lever(write, -2.0, torque_limit=0.3, effects=(hl.TorqueSaturation(),))
    v = grasp.check()
    assert v.word == "HELD"
    (yields,) = (r for r in v.about("torque") if "yielding" in r.values)
    assert set(yields.values["yielding"]) == {"left_joint", "right_joint"}


@pytest.mark.long
def test_levers_whose_joints_both_yield_tip_over_under_a_push_towards_their_hinges(write):
    """They go sideways until one joint yields no more: half of what both yielded, (5 - 3.75) N of its share of C."""
    grasp = lever(write, 2.0, torque_limit=0.3, effects=(hl.TorqueSaturation(),))
    path = grasp.follow()
    assert path.reached
    (snap,) = (e for e in path.events if e.kind == "snaps")
    assert snap.share < 0.1, "nothing but their leaning outwards by 1.2° steadies them"
    assert snap.moved == pytest.approx((5.0 - 3.75) * C, rel=0.02)
    assert grasp.check().word == "NOT HELD", "a jerk may take it further"


# ---------------------------------------------------------------- advice
@pytest.mark.parametrize("pull", [1.1, 1.5])
def test_what_is_advised_holds_when_it_is_done(write, pull):
    grasp = lever(write, pull * 2 * MU * 5.0)
    v = grasp.check()
    advice = {r.values["change"]: r.values["value"] for r in v.about("advice")}
    assert "friction" in advice
    assert advice["friction"] >= pull * MU * 0.97, "2 μ 5 N have to bear the pull"
    assert lever(write, pull * 2 * MU * 5.0, mu=advice["friction"]).check().ok
    if "squeeze" in advice:
        assert grasp.replace(preload=SQUEEZE + advice["squeeze"]).check().ok
    if "stiffness" in advice:
        assert lever(write, pull * 2 * MU * 5.0, joint_stiffness=20.0 * advice["stiffness"]).check().ok


def test_advice_keeps_within_torque_limits(write):
    """8 N of pull need 8 N of each finger at μ = 0.5, 0.64 N·m: with 0.45 N·m more squeeze is no advice."""
    v = lever(write, 8.0, torque_limit=0.45).check()
    assert v.word == "NOT HELD"
    assert {r.values["change"] for r in v.about("advice")} == {"friction"}


def test_advice_has_a_sensible_size(write):
    """Twenty times what friction bears: nothing tried holds it, and that is what is said."""
    v = lever(write, 20 * 2 * MU * 5.0).check()
    (said,) = v.about("advice")
    same("hand/test_check: nothing that was tried holds it", said.sentence)
    assert "74 mm" not in str(v)
    assert max(map(len, str(v).splitlines())) <= 80


def test_a_soft_hand_is_told_how_much_stiffer_it_has_to_be():
    v = five(1.0).check()
    advice = {r.values["change"]: r.values["value"] for r in v.about("advice")}
    assert five(1.0 * advice["stiffness"]).check().ok


# ---------------------------------------------------------------- what is tried
@pytest.mark.parametrize(
    "more",
    [
        {"effects": (hl.TorqueSaturation(),)},
        {"effects": (hl.GeometricStiffness(),)},
        {"finger_weight": True},
        {"friction": hl.SoftFinger(0.8, 0.005)},
        {"environment": hl.Table((0, 0, 0.055), flexibility=1e-4)},
        {"fingers": ["finger_1_tip", "finger_2_tip", "finger_3_tip"], "max_gap": 2e-3},
    ],
    ids=lambda more: next(iter(more)),
)
def test_every_kind_of_grasp_can_be_checked(three, more):
    grasp = three.at(three.close_on(CUBE)).grasp(CUBE, **({"friction": hl.Coulomb(0.8), "squeeze": 4e-3} | more))
    v = grasp.check()
    assert v.word == "HELD"
    path = grasp.follow(steps=10)
    (motion,) = v.about("motion")
    assert motion.values["move_m"] == pytest.approx(np.linalg.norm(path.displacement[:3]), rel=1e-6)
    (torque,) = (r for r in v.about("torque") if "torque_Nm" in r.values)
    k = three.joint_names.index(torque.values["joint"])
    assert torque.values["torque_Nm"] == pytest.approx(path.steps.torques[-1, k], rel=1e-6)


def test_pads_that_are_pressed_in_farther_than_pads_are_thick_are_doubted():
    for pad, deep in ((1e-4, False), (3e-3, True)):
        hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=pad)
        grasp = hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=0.8, grip_force=4.0)
        limit = grasp.load_limit((1.0, 0, 0, 0, 0, 0))
        said = [reason.sentence for reason in grasp.check().about("pressed_in")]
        assert bool(said) == bool(limit.doubt) == deep
        assert limit.doubt in " ".join(str(limit).split())
        pressed = 1e3 * pad * grasp.check().loading.solution.normal_force.max()  # [mm]
        assert not deep or f"{pressed:.2g} mm" in said[0] or f"{pressed:.0f} mm" in said[0]
