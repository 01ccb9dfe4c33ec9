"""Tendons pull and never push, and have motors: closed forms of levers, limits of tensions, MuJoCo, refusals."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp import Motor
from handlcp.errors import InputError, UnknownName
from handlcp.hand import HandGrasp, example_hand
from handlcp.scene import read
from tests.support.hand import agrees_with_mujoco, tendons_of

from .levers import PAD, L, along, lever_hand, lever_pinch

ARM, KT, OWN = 0.01, 6e4, 4.0  # m, N/m, N·m/rad
SHUT, PULL = 0.05, 8.0  # rad commanded; N on the object
BOTH = OWN + 2 * KT * ARM**2  # N·m/rad of a joint with both tendons
ONE = OWN + KT * ARM**2
PRESSED = SHUT * L / (L * L / BOTH + PAD)  # N of each finger once the hand has closed
CLOSED = (PRESSED * L + OWN * (SHUT - PRESSED * L / BOTH)) / ARM  # N of a flexor then
ASIDE = [PULL, 0.0, 0.0, 0.0, 0.0, 0.0]
WAYS = {"flexor": ARM, "extensor": -ARM}
ARMS = {f"{side}_{way}": {f"{side}_joint": arm} for side in ("left", "right") for way, arm in WAYS.items()}


def pinch(write, pretension=0.0, shut=SHUT, **tendons):
    """Levers with a flexor and an extensor each."""
    hand = lever_hand(write, joint_stiffness=hl.Tendons(ARMS, KT, OWN, pretension=pretension, **tendons))
    return lever_pinch(hand, (0.0, 0.0, 0.0), **({"joint_offset": [shut] * 2} if shut else {}))


@pytest.mark.parametrize("steps", [1, 40])
def test_a_finger_pushed_open_loses_its_extensor_and_the_other_keeps_both(write, steps):
    """Of the joint behind the flexor alone is left; the one that follows the object has both. In one step or many."""
    path = pinch(write).follow(ASIDE, steps=steps, geometry="fixed")
    load, moved = path.steps.load[:, 0], path.steps.displacement[:, 0]
    np.testing.assert_allclose(moved, load / (along(ONE) + along(BOTH)), atol=1e-8 * moved.max())
    assert [(e.kind, e.who) for e in path.events] == [("slackens", "right_extensor")]
    assert path.steps.tensions[-1, 3] == 0.0
    assert path.solution.held


@pytest.mark.parametrize("more", [1.0, 2.5])
def test_pretension_keeps_an_extensor_taut_until_the_joint_has_let_it_go(write, more):
    """T₀ = k r Δq, where the joint gives way by Δq = F L / K."""
    path = pinch(write, pretension=more).follow(ASIDE, steps=80, geometry="fixed")
    load, moved = path.steps.load[:, 0], path.steps.displacement[:, 0]
    first = 2.0 * more * BOTH / (KT * ARM * L)  # half of the load on each
    assert 0.0 < first < PULL
    before = load / (2.0 * along(BOTH))
    after = first / (2.0 * along(BOTH)) + (load - first) / (along(ONE) + along(BOTH))
    np.testing.assert_allclose(moved, np.where(load < first, before, after), atol=1e-7 * moved.max())


def test_a_rod_pushes_and_is_as_stiff_as_a_spring(write):
    path = pinch(write, pretension=np.inf).follow(ASIDE, geometry="fixed")
    np.testing.assert_allclose(path.steps.displacement[-1, 0], PULL / (2.0 * along(BOTH)), rtol=1e-8)
    assert not path.events


def test_drives_let_no_tendon_go_below_its_pretension_while_they_close(write):
    """The flexor makes the torque of the contact and turns the joint against its own spring; the extensor stays at
    T₀.
    """
    for pretension in (0.0, 3.0):
        end = pinch(write, pretension=pretension).follow(order="squeeze", geometry="fixed").last
        np.testing.assert_allclose(end.pull.tension, pretension + CLOSED * np.array([1.0, 0.0] * 2), atol=1e-6)


def test_a_flexor_that_works_against_a_spring_never_goes_slack(write):
    """Contacts push joints open alone, so that such a hand is what it was when tendons were springs."""
    arms = {name: row for name, row in ARMS.items() if "flexor" in name}
    moved = []
    for pretension in (0.0, np.inf):
        hand = lever_hand(write, joint_stiffness=hl.Tendons(arms, KT, OWN, pretension=pretension))
        path = lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=[0.01] * 2).follow(ASIDE, geometry="fixed")
        assert "opens" in {e.kind for e in path.events}
        assert path.steps.tensions[-1].min() > 0.0
        moved.append(path.steps.displacement)
    np.testing.assert_allclose(moved[0], moved[1], rtol=0.0, atol=1e-12)


def test_two_tendons_that_share_a_spring_go_slack_as_the_rest_allows(write):
    """Coupled tendons, k not diagonal: of a pair of which one is slack the other is as stiff as k₁₁ - k₁₂² / k₂₂."""
    k = np.kron(np.eye(2), KT * np.array([[1.0, 0.4], [0.4, 1.0]]))
    hand = lever_hand(write, joint_stiffness=hl.Tendons(ARMS, k, OWN))
    path = lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=[SHUT] * 2).follow(ASIDE, geometry="fixed")
    both, one = OWN + 1.2 * KT * ARM**2, OWN + (1.0 - 0.16) * KT * ARM**2
    np.testing.assert_allclose(path.steps.displacement[-1, 0], PULL / (along(one) + along(both)), rtol=1e-8)


def load_of(more):
    """[N] The load at which the flexor behind it pulls with so much more [N]: it takes F along(ONE) / (along(ONE) +
    along(BOTH)) of a load at its tip, all but the share of the joint's own spring.
    """
    return more * ARM * ONE / (KT * ARM**2) / L * (along(ONE) + along(BOTH)) / along(ONE)


def test_what_a_tendon_bears_ends_a_load_and_decides_a_verdict(write):
    limit = pinch(write, limits={"right_flexor": CLOSED + 10.0}).load_limit(ASIDE, geometry="fixed")
    assert [(c.kind, c.who) for c in limit.binds] == [("tension", "right_flexor")]
    np.testing.assert_allclose(limit.factor * PULL, load_of(10.0), rtol=1e-6)
    assert "right_flexor reaches the limit of its tension" in limit.why
    verdict = pinch(write, limits=0.5 * CLOSED).check()
    assert verdict.word == "OVER LIMIT"
    (reason,) = verdict.about("tension_over_limit")
    assert [r["tendon"] for r in reason.values["tendons"]] == ["left_flexor", "right_flexor"]
    for r in reason.values["tendons"]:
        np.testing.assert_allclose(r["tension_N"], CLOSED, rtol=1e-4)


LOAD = [2.0, 1.0, 0.0, 0.0, 0.02, 0.0]


def boxed(pretension, k=1e4):
    """A box in three fingers with a flexor and an extensor at each joint."""
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    joints = example_hand("three_finger").joint_names
    arms = {f"{j} {way}": {j: arm} for j in joints for way, arm in (("flexor", 0.01), ("extensor", -0.008))}
    tendons = hl.Tendons(arms, k, 1.0, pretension=pretension)
    hand = example_hand("three_finger", joint_stiffness=tendons, pad_flexibility=3e-5)
    return hand.at(hand.close_on(box)).grasp(box, friction=0.8, squeeze=0.008, wrench=LOAD)


def test_mujoco_has_the_same_forces_and_tensions():
    agrees_with_mujoco(boxed(1.0), 0.02)


def test_what_a_slack_tendon_falls_short_of_is_the_pretension_that_keeps_it_taut():
    """As `required_torque` advises. Tried: with as much none goes slack, with less some do."""
    missing = -min(float(s.pull.taut.min()) for s in boxed(0.0).follow().steps.states)
    assert missing > 0.0
    assert not [e for e in boxed(1.05 * missing).follow().events if e.kind == "slackens"]
    assert [e for e in boxed(0.8 * missing).follow().events if e.kind == "slackens"]


def test_a_command_against_the_way_of_every_tendon_is_not_called_held(write):
    arms = {f"{side}_extensor": {f"{side}_joint": -ARM} for side in ("left", "right")}
    grasp = lever_pinch(lever_hand(write, joint_stiffness=hl.Tendons(arms, KT, OWN)), joint_offset=[SHUT] * 2)
    assert grasp.solve().verdict.word == "UNDECIDED"
    verdict = grasp.check()
    (reason,) = verdict.about("command_not_made")
    assert verdict.word == "UNDECIDED"
    assert "it takes tendons that pull the other way to turn left_joint with 0." in reason.sentence
    assert reason.values["share"] == pytest.approx(1.0)
    assert grasp.load_limit(ASIDE).doubt == reason.sentence


@pytest.mark.long
def test_motors_sized_for_tendons_that_pull_the_other_way_are_not_confirmed():
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.3)
    arms = {f"cable_{k}": {f"finger_{k}_proximal": -0.012, f"finger_{k}_distal": -0.008} for k in (1, 2, 3)}
    hand = example_hand("three_finger", joint_stiffness=hl.Tendons(arms, 2e4, 4.0))
    grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, grip_force=5.0)
    sized = grasp.required_torque(tolerance=0.5)
    assert not sized.confirmed
    assert not sized.enough


@pytest.mark.parametrize(("share", "word"), [(0.005, "HELD"), (0.02, "UNDECIDED")])
def test_a_hundredth_of_a_command_that_no_tendon_makes_is_a_doubt_and_more_decides(write, share, word):
    arms = {"both": {"left_joint": ARM, "right_joint": ARM}}
    hand = lever_hand(write, joint_stiffness=hl.Tendons(arms, KT, OWN))
    told = np.linalg.solve(hand.joint_stiffness, [1.0 + share, 1.0 - share])  # N·m, of which the tendon makes 1 and 1
    verdict = lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=told).check()
    (reason,) = verdict.about("command_not_made")
    assert verdict.word == word
    assert reason.values["share"] == pytest.approx(share, rel=0.05)


# ---------------------------------------------------------------- motors that draw tendons in, against closed forms
ROOT = Path(__file__).parents[2]
THERMAL = 20.0  # s
GEAR, SPOOL = 20.0, 0.005  # –, m
FLEXORS = ["left_flexor", "right_flexor"]


def motor(continuous, peak, **more):
    """Of so many newtons at its tendon, behind a gear and a spool."""
    N, share = GEAR / SPOOL, 0.8
    return Motor(continuous / (N * share), peak / (N * share), reduction=N, efficiency=share, **more)


@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({"pretension": -1.0}, InputError, "Tendons.pretension: expected a number ≥ 0"),
        ({"pretension": {"thumb": 1.0}}, UnknownName, "thumb"),
        ({"limits": {"left_flexor": -2.0}}, InputError, r"Tendons.limits\['left_flexor'\]"),
        ({"limits": {"left_flexor": 2.0}, "pretension": 3.0}, InputError, "at least the pretension, 3 N"),
        ({"motors": {"thumb": motor(1.0, 2.0)}}, UnknownName, r"Tendons.motors.*thumb"),
        ({"motors": {"left_flexor": 3.0}}, InputError, r"Tendons.motors\['left_flexor'\]: expected a Motor"),
        ({"motors": motor(1.0, 2.0, stiffness=5.0)}, InputError, "a Motor without stiffness: Tendons.stiffness says"),
        ({"motors": motor(1.0, 5.0), "pretension": 3.0}, InputError, "makes and holds the pretension, 3 N.*holds 1 N"),
    ],
)
def test_tendons_and_motors_that_cannot_be_are_refused(more, error, words):
    with pytest.raises(error, match=words):
        hl.Tendons(ARMS, KT, OWN, **more)


# ---------------------------------------------------------------- what a tendon holds
@pytest.mark.parametrize(("bears", "limit"), [(np.inf, 12.0), (15.0, 12.0), (9.0, 9.0)])
def test_the_limit_of_a_tendon_is_the_smaller_of_what_it_bears_and_what_its_motor_holds(write, bears, limit):
    tendons = hl.Tendons(ARMS, KT, OWN, limits=bears, motors={"left_flexor": motor(10.0, 30.0, friction=2.0)})
    hand = lever_hand(write, joint_stiffness=tendons)
    for made in (hand, hand.scale_stiffness(2.0), pickle.loads(pickle.dumps(hand))):
        np.testing.assert_allclose(tendons_of(made).cables.limits, [limit, bears, bears, bears], rtol=1e-14)
        np.testing.assert_allclose(tendons_of(made).closing_tensions, [28.0, *[np.inf] * 3], rtol=1e-14)


@pytest.mark.parametrize("more", [{}, {"friction": 3.0}, {"holding": CLOSED + 15.0}])
def test_a_load_limit_is_where_the_tension_passes_what_the_motor_holds_for_good(write, more):
    drive = motor(CLOSED + 10.0, 2.0 * CLOSED, **more)
    spare = drive.holds - CLOSED
    np.testing.assert_allclose(spare, {"friction": 13.0, "holding": 15.0}.get(next(iter(more), ""), 10.0))
    limit = pinch(write, motors={"right_flexor": drive}).load_limit(ASIDE, geometry="fixed")
    assert [(c.kind, c.who) for c in limit.binds] == [("tension", "right_flexor")]
    np.testing.assert_allclose(limit.factor * PULL, load_of(spare), rtol=1e-6)


# ---------------------------------------------------------------- what closing takes
@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.long), 0.05 * CLOSED])
def test_closing_takes_the_tension_of_the_closed_hand_and_no_more_than_the_peak_less_friction(write, friction):
    grasps = [
        pinch(write, motors=motor(0.5 * CLOSED, share * CLOSED + friction, holding=2.0 * CLOSED, friction=friction))
        for share in (1.0 + 1e-4, 1.0 - 1e-4)
    ]
    assert [grasp.check().word for grasp in grasps] == ["HELD", "OVER LIMIT"]
    (reason,) = grasps[1].check().about("closing_over_peak")
    assert [row["tendon"] for row in reason.values["tendons"]] == FLEXORS
    np.testing.assert_allclose([row["tension_N"] for row in reason.values["tendons"]], CLOSED, rtol=1e-5)
    np.testing.assert_allclose([row["limit_N"] for row in reason.values["tendons"]], CLOSED * (1 - 1e-4), rtol=1e-9)
    assert ("less dry friction" in reason.sentence) is (friction > 0.0)
    assert "left_flexor needs 68 N of 68 N" in reason.sentence
    for geometry in ("fixed", "followed"):
        limit = grasps[1].load_limit(ASIDE, geometry=geometry)
        assert limit.factor == 0.0
        assert [(c.kind, c.who) for c in limit.binds] == [("tension", name) for name in FLEXORS]
        assert "cannot close so hard: left_flexor, right_flexor" in limit.why
        assert grasps[0].load_limit(ASIDE, geometry=geometry).factor > 0.0
    assert hl.envelope(grasps[1], [ASIDE], geometry="followed").factors.tolist() == [0.0]


@pytest.mark.long
def test_a_tendon_that_is_let_out_or_holds_takes_no_peak(write):
    """An extensor stays at its pretension while the hand closes, and a load pulls a flexor beyond what closes."""
    drives = {"left_extensor": motor(3.5, 3.5), "right_flexor": motor(CLOSED, CLOSED + 4.0, holding=3.0 * CLOSED)}
    grasp = pinch(write, pretension=3.0, motors=drives)
    flexor = grasp.follow(ASIDE).steps.tensions[:, 2]
    assert flexor.max() > drives["right_flexor"].closes
    verdict = grasp.replace(load=ASIDE).check()
    assert not verdict.about("lost")
    assert not verdict.about("closing_over_peak")


# ---------------------------------------------------------------- for how long
@pytest.mark.parametrize("friction", [0.0, 2.0])
def test_a_held_tension_beyond_continuous_lasts_as_long_as_a_joints_torque_does(write, friction):
    drive = motor((CLOSED - friction) / 1.2, 2.0 * CLOSED, friction=friction, thermal_time=THERMAL)
    verdict = pinch(write, motors=drive).check()
    (reason,) = verdict.about("overheats")
    assert (verdict.word, reason.severity) == ("OVER LIMIT", "decides")
    assert [row["tendon"] for row in reason.values["tendons"]] == FLEXORS
    np.testing.assert_allclose(reason.values["lasts_s"], THERMAL * np.log(1.44 / 0.44), rtol=1e-4)
    np.testing.assert_allclose(reason.values["lasts_s"], drive.lasts(CLOSED), rtol=1e-4)
    assert "left_flexor gives 120 % of continuous" in reason.sentence
    assert "overheats after 24 s" in reason.sentence
    unknown = pinch(write, motors=motor((CLOSED - friction) / 1.2, 2.0 * CLOSED, friction=friction)).check()
    assert "not for longer than the motor's thermal time" in unknown.about("overheats")[0].sentence


def test_a_tendon_that_breaks_lasts_no_longer_for_its_motor(write):
    drive = motor(0.5 * CLOSED, 2.0 * CLOSED, thermal_time=THERMAL)
    assert pinch(write, motors=drive, limits=1.01 * CLOSED).check().about("overheats")
    verdict = pinch(write, motors=drive, limits=0.9 * CLOSED).check()
    (reason,) = verdict.about("tension_over_limit")
    np.testing.assert_allclose([row["limit_N"] for row in reason.values["tendons"]], 0.9 * CLOSED)
    assert not verdict.about("overheats")


# ---------------------------------------------------------------- what is said of it
@pytest.mark.long
def test_a_brief_says_which_spool_a_motor_needs(write):
    flexors = {name: arms for name, arms in ARMS.items() if "flexor" in name}
    drive = motor(100.0, 200.0, friction=2.0)
    hand = lever_hand(write, joint_stiffness=hl.Tendons(flexors, KT, OWN, motors=drive))
    found = lever_pinch(hand).required_torque(safety=1.0).tensions
    np.testing.assert_allclose(found.peak, found.tension + 2.0)
    np.testing.assert_allclose(found.continuous, np.maximum(found.held - 2.0, 0.0))
    for rubs in (0.0, 3.0):  # of the motor that takes the place of the hand's own
        N = found.reductions(Motor(0.05, 0.15, efficiency=0.5, friction=rubs, reduction=100.0))
        continuous = np.maximum(found.held - rubs, 0.0)
        np.testing.assert_allclose(0.5 * N, np.maximum((found.tension + rubs) / 0.15, continuous / 0.05))


# ---------------------------------------------------------------- scene files
CUBE = (ROOT / "examples" / "cube_three_fingers.toml").read_text(encoding="utf-8")
TENDONS = """[hand.tendons]
stiffness_N_per_m = 6e4
passive_Nm_per_rad = 6.0
limits_N = 900
moment_arms_m = { pull = { finger_1_distal = 0.01 }, lift = { finger_2_distal = 0.01, finger_3_distal = 0.01 } }
"""
MOTOR = "continuous_Nm = 0.01\npeak_Nm = 0.05\nreduction_N_per_Nm = 4000\nefficiency = 0.7\nthermal_time_s = 20\n"


def scene(motors):
    return CUBE.replace("joint_stiffness_Nm_per_rad = 6.0\n", f"{TENDONS}{motors}", 1)


def test_a_scene_file_says_motors_of_tendons():
    expected = Motor(0.01, 0.05, reduction=4000.0, efficiency=0.7, thermal_time=20.0, friction=1.0, holding=40.0)
    keys = f"{MOTOR}friction_N = 1\nholding_N = 40\n"
    for table, of in ((f"[hand.tendons.motor]\n{keys}", (expected,) * 2),
                      (f"[hand.tendons.motors.lift]\n{keys}", (None, expected))):  # fmt: skip
        built = read(scene(table)).build()
        assert isinstance(built, HandGrasp)
        drives = tendons_of(built.state.hand).drives
        assert drives.motors == of
        (reason,) = built.check().about("overheats")
        driven = [name for name, motor in zip(("pull", "lift"), of, strict=True) if motor is not None]
        assert [row["tendon"] for row in reason.values["tendons"]] == driven


@pytest.mark.parametrize(
    ("table", "key"),
    [
        (f"[hand.tendons.motor]\n{MOTOR}".replace("0.05", "0.001"), "hand.tendons.motor.peak_Nm"),
        (f"[hand.tendons.motor]\n{MOTOR}\n[hand.tendons.motors.lift]\n{MOTOR}", "hand.tendons.motors"),
        (f"[hand.tendons.motor]\n{MOTOR}stiffness_Nm_per_rad = 3\n", "hand.tendons.motor.stiffness_Nm_per_rad"),
        (f"[hand.tendons.motor]\n{MOTOR}".replace("reduction_N_per_Nm", "reduction"),
         "hand.tendons.motor.reduction_N_per_Nm"),
        ("[hand.tendons.motor]\nreduction_N_per_Nm = 4\n", "hand.tendons.motor.continuous_Nm"),
        (f"[hand.tendons.motor]\n{MOTOR}[hand.motor]\ncontinuous_Nm = 1\n", "hand.motors"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_scene_file_is_named_by_its_key(table, key):
    with pytest.raises(InputError) as refused:
        read(scene(table)).build()
    assert refused.value.argument == key


def test_a_joint_has_one_drive():
    """Joints that no tendon with a motor moves may have their own."""
    tendons = hl.Tendons({"pull": {"finger_1_distal": 0.01}, "free": {"finger_2_distal": 0.01}}, 2e4, 4.0,
                         motors={"pull": motor(50.0, 90.0)})  # fmt: skip
    words = "motors: expected no motor of a joint that a tendon with a motor moves, got finger_1_distal"
    with pytest.raises(InputError, match=words):
        example_hand("three_finger", joint_stiffness=tendons, motors={"finger_1_distal": Motor(0.3)})
    others = {"finger_1_proximal": Motor(0.3), "finger_2_distal": Motor(0.2)}
    hand = example_hand("three_finger", joint_stiffness=tendons, motors=others)
    assert hand.torques.drives is not None
    with pytest.raises(InputError, match=words):
        hand.replace(motors={"finger_1_distal": Motor(0.3)})
    with pytest.raises(InputError, match=words):
        example_hand("three_finger", motors=Motor(0.3)).replace(joint_stiffness=tendons)


def test_motors_of_a_hand_are_by_joint_and_by_tendon(write):
    """`motors=` of the hand says the same as `motors=` of its tendons, from the start and in `replace`."""
    motor = hl.Motor(continuous=0.05, peak=0.15, reduction=100.0)
    plain = hl.Tendons(ARMS, KT, OWN)
    named = {"right_flexor": motor}
    hands = [
        lever_hand(write, joint_stiffness=hl.Tendons(ARMS, KT, OWN, motors=named)),
        lever_hand(write, joint_stiffness=plain, motors=named),
        lever_hand(write, joint_stiffness=plain).replace(motors=named),
    ]
    limits = [lever_pinch(hand).mechanism.joint_model.cables.limits for hand in hands]
    np.testing.assert_array_equal(limits[1], limits[0])
    np.testing.assert_array_equal(limits[2], limits[0])
    assert np.isfinite(limits[0]).sum() == 1


def test_motors_by_tendon_take_the_place_of_those_of_tendons_and_motors_by_joint_of_those_of_joints():
    tendons = hl.Tendons({"pull": {"finger_1_distal": 0.01}, "lift": {"finger_2_distal": 0.01}}, 2e4, 4.0,
                         motors={"lift": motor(5.0, 9.0)})  # fmt: skip
    hand = example_hand("three_finger", joint_stiffness=tendons, motors={"finger_3_distal": Motor(0.2)})

    def found(**motors):
        made = hand.replace(**motors)
        of_joints, of_tendons = made.torques.drives, tendons_of(made).drives
        joints = [] if of_joints is None else [m is not None for m in of_joints.motors]
        return joints[4:], [m is not None for m in of_tendons.motors]

    assert hand.joint_names[4:] == ("finger_3_proximal", "finger_3_distal")
    first, other, both = {"pull": motor(50.0, 90.0)}, {"finger_3_proximal": Motor(0.3)}, [True, False]
    assert found(motors=first) == ([False, True], both)
    assert found(motors=other) == (both, [False, True])
    assert found(motors=first | other) == (both, both)


# ---------------------------------------------------------------- closing with a torque
def test_dry_friction_of_a_tendons_motor_takes_its_part_of_a_closing_torque():
    """As that of a joint's motor does: an arm r takes r τ_f of the torque; the tension is τ / r."""
    arm, rubs, ball = 0.01, 10.0, hl.Sphere(0.03, (0.0, 0.0, 0.09))
    joints = example_hand("three_finger").joint_names
    tendons = hl.Tendons({f"to {joint}": {joint: arm} for joint in joints}, 2e4, 4.0)
    hand = example_hand("three_finger", joint_stiffness=tendons)
    q = hand.close_on(ball)
    plain = hand.at(q).grasp(ball, closing_torque=0.3 - arm * rubs)
    driven = hand.replace(motors={f"to {joint}": motor(20.0, 40.0, friction=rubs) for joint in joints})
    closed = driven.at(q).grasp(ball, closing_torque=0.3)
    np.testing.assert_allclose(closed.joint_offset, plain.joint_offset, rtol=1e-12)
    for torque, words in ((arm * rubs, "dry friction of its drive, 10, and at most"), (0.41, "peak.* 40 N in")):
        with pytest.raises(InputError, match=f"closing_torque: .*{words}.*to finger_1_"):
            driven.at(q).grasp(ball, closing_torque=torque)
