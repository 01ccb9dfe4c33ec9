"""Motors that draw tendons in, against closed forms of levers: what closes, what holds for good, and for how long."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp import Motor
from handlcp.errors import InputError, UnknownName
from handlcp.hand import HandGrasp, example_hand
from handlcp.scene import read
from tests.support.hand import tendons_of

from .levers import L, lever_hand, lever_pinch
from .test_slack_tendons import ARM, ARMS, ASIDE, BOTH, KT, ONE, OWN, PRESSED, PULL, SHUT, along, pinch

Writer = Callable[[str], Path]
ROOT = Path(__file__).parents[2]
CLOSED = (PRESSED * L + OWN * (SHUT - PRESSED * L / BOTH)) / ARM  # N of a flexor once the hand has closed
THERMAL = 20.0  # s
GEAR, SPOOL = 20.0, 0.005  # –, m
FLEXORS = ["left_flexor", "right_flexor"]


def motor(continuous: float, peak: float, **more: float) -> Motor:
    """Of so many newtons at its tendon, behind a gear and a spool."""
    N, share = GEAR / SPOOL, 0.8
    return Motor(continuous / (N * share), peak / (N * share), reduction=N, efficiency=share, **more)


# ---------------------------------------------------------------- what a tendon holds
@pytest.mark.parametrize(("bears", "limit"), [(np.inf, 12.0), (15.0, 12.0), (9.0, 9.0)])
def test_the_limit_of_a_tendon_is_the_smaller_of_what_it_bears_and_what_its_motor_holds(
    write: Writer, bears: float, limit: float
) -> None:
    tendons = hl.Tendons(ARMS, KT, OWN, limits=bears, motors={"left_flexor": motor(10.0, 30.0, friction=2.0)})
    hand = lever_hand(write, joint_stiffness=tendons)
    for made in (hand, hand.scale_stiffness(2.0), pickle.loads(pickle.dumps(hand))):
        np.testing.assert_allclose(tendons_of(made).cables.limits, [limit, bears, bears, bears], rtol=1e-14)
        np.testing.assert_allclose(tendons_of(made).closing_tensions, [28.0, *[np.inf] * 3], rtol=1e-14)


@pytest.mark.parametrize("more", [{}, {"friction": 3.0}, {"holding": CLOSED + 15.0}])
def test_a_load_limit_is_where_the_tension_passes_what_the_motor_holds_for_good(
    write: Writer, more: dict[str, float]
) -> None:
    """The flexor behind the load takes F along(ONE) / (along(ONE) + along(BOTH)) at its tip, its own spring a share."""
    drive = motor(CLOSED + 10.0, 2.0 * CLOSED, **more)
    spare = drive.holds - CLOSED
    np.testing.assert_allclose(spare, {"friction": 13.0, "holding": 15.0}.get(next(iter(more), ""), 10.0))
    load = spare * ARM * ONE / (KT * ARM**2) / L * (along(ONE) + along(BOTH)) / along(ONE)
    limit = pinch(write, motors={"right_flexor": drive}).load_limit(ASIDE, geometry="fixed")
    assert [(c.kind, c.who) for c in limit.binds] == [("tension", "right_flexor")]
    np.testing.assert_allclose(limit.factor * PULL, load, rtol=1e-6)


# ---------------------------------------------------------------- what closing takes
@pytest.mark.parametrize("friction", [0.0, 0.05 * CLOSED])
def test_closing_takes_the_tension_of_the_closed_hand_and_no_more_than_the_peak_less_friction(
    write: Writer, friction: float
) -> None:
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
def test_a_tendon_that_is_let_out_or_holds_takes_no_peak(write: Writer) -> None:
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
def test_a_held_tension_beyond_continuous_lasts_as_long_as_a_joints_torque_does(write: Writer, friction: float) -> None:
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


def test_a_tendon_that_breaks_lasts_no_longer_for_its_motor(write: Writer) -> None:
    drive = motor(0.5 * CLOSED, 2.0 * CLOSED, thermal_time=THERMAL)
    assert pinch(write, motors=drive, limits=1.01 * CLOSED).check().about("overheats")
    verdict = pinch(write, motors=drive, limits=0.9 * CLOSED).check()
    (reason,) = verdict.about("tension_over_limit")
    np.testing.assert_allclose([row["limit_N"] for row in reason.values["tendons"]], 0.9 * CLOSED)
    assert not verdict.about("overheats")


def test_a_verdict_says_which_tension_is_the_limit(write: Writer) -> None:
    for more, word in (({}, "continuous"), ({"holding": 3.0 * CLOSED}, "holding")):
        (note,) = pinch(write, motors=motor(1.5 * CLOSED, 2.0 * CLOSED, **more)).check().about("tension")
        assert note.sentence.endswith(f"N {word}")


# ---------------------------------------------------------------- what is said of it
def test_a_hand_says_what_its_tendons_hold_and_close_with(write: Writer) -> None:
    tendons = hl.Tendons(ARMS, KT, OWN, limits={"right_flexor": 9.0}, motors={"left_flexor": motor(10.0, 30.0)})
    said = lever_hand(write, joint_stiffness=tendons).describe()
    assert [(row.name, row.arms) for row in said.tendons] == list(ARMS.items())
    found = {row["name"]: (row["tension_limit_N"], row["closes_N"]) for row in said.to_dict()["tendons"]}
    assert found["right_flexor"] == (9.0, None)
    assert found["left_extensor"] == (None, None)
    np.testing.assert_allclose(found["left_flexor"], (10.0, 30.0))
    assert "left_flexor: left_joint by 10 mm; at most 10 N for good; closes with 30 N" in str(said)
    assert "tension limit of left_flexor: its motor, continuous torque" in str(said)
    assert not lever_hand(write).describe().tendons


@pytest.mark.long
def test_a_brief_says_which_spool_a_motor_needs(write: Writer) -> None:
    flexors = {name: arms for name, arms in ARMS.items() if "flexor" in name}
    drive = motor(100.0, 200.0, friction=2.0)
    hand = lever_hand(write, joint_stiffness=hl.Tendons(flexors, KT, OWN, motors=drive))
    found = lever_pinch(hand).required_torque(safety=1.0).tensions
    assert found is not None
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


def scene(motors: str) -> str:
    return CUBE.replace("joint_stiffness_Nm_per_rad = 6.0\n", f"{TENDONS}{motors}", 1)


def test_a_scene_file_says_motors_of_tendons() -> None:
    expected = Motor(0.01, 0.05, reduction=4000.0, efficiency=0.7, thermal_time=20.0, friction=1.0, holding=40.0)
    keys = f"{MOTOR}friction_N = 1\nholding_N = 40\n"
    for table, of in ((f"[hand.tendons.motor]\n{keys}", (expected,) * 2),
                      (f"[hand.tendons.motors.lift]\n{keys}", (None, expected))):  # fmt: skip
        built = read(scene(table)).build()
        assert isinstance(built, HandGrasp)
        drives = tendons_of(built.state.hand).drives
        assert drives is not None
        assert drives.motors == of
        (reason,) = built.check().about("overheats")
        driven = [name for name, motor in zip(("pull", "lift"), of, strict=True) if motor is not None]
        assert [row["tendon"] for row in reason.values["tendons"]] == driven


@pytest.mark.parametrize(
    ("table", "key"),
    [
        (f"[hand.tendons.motor]\n{MOTOR}".replace("0.05", "0.001"), "hand.tendons.motor.peak_Nm"),
        (f"[hand.tendons.motors.lift]\n{MOTOR}holding_N = 1\n", "hand.tendons.motors.lift.holding_N"),
        (f"[hand.tendons.motors.push]\n{MOTOR}", "hand.tendons.motors"),
        (f"[hand.tendons.motor]\n{MOTOR}\n[hand.tendons.motors.lift]\n{MOTOR}", "hand.tendons.motors"),
        (f"[hand.tendons.motor]\n{MOTOR}stiffness_Nm_per_rad = 3\n", "hand.tendons.motor.stiffness_Nm_per_rad"),
        (f"[hand.tendons.motor]\n{MOTOR}".replace("reduction_N_per_Nm", "reduction"),
         "hand.tendons.motor.reduction_N_per_Nm"),
        ("[hand.tendons.motor]\nreduction_N_per_Nm = 4\n", "hand.tendons.motor.continuous_Nm"),
        (f"[hand.tendons.motor]\n{MOTOR}[hand.motor]\ncontinuous_Nm = 1\n", "hand.motors"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_scene_file_is_named_by_its_key(table: str, key: str) -> None:
    with pytest.raises(InputError) as refused:
        read(scene(table)).build()
    assert refused.value.argument == key


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (f"{MOTOR}friction_Nm = 3\n", r"the keys \[continuous_Nm, .*, friction_N\].*did you mean 'friction_N'"),
        ("reduction_N_per_Nm = 4\n", "continuous_Nm: expected a finite number > 0"),
    ],
)
def test_a_table_of_one_tendon_s_motor_has_the_keys_of_that_of_all(more: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(scene(f"[hand.tendons.motors.lift]\n{more}"))


# ---------------------------------------------------------------- bad input
@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({"motors": {"thumb": motor(1.0, 2.0)}}, UnknownName, r"Tendons.motors.*thumb"),
        ({"motors": 3.0}, InputError, "Tendons.motors: expected a Motor for every tendon, or a mapping of tendon"),
        ({"motors": {"left_flexor": 3.0}}, InputError, r"Tendons.motors\['left_flexor'\]: expected a Motor"),
        ({"motors": motor(1.0, 2.0, stiffness=5.0)}, InputError, "a Motor without stiffness: Tendons.stiffness says"),
        ({"motors": motor(1.0, 5.0), "pretension": 3.0}, InputError, "makes and holds the pretension, 3 N.*holds 1 N"),
        ({"motors": motor(3.0, 4.0, friction=2.0), "pretension": 3.0}, InputError, "closes with 2 N"),
    ],
)
def test_motors_that_cannot_draw_their_tendons_are_refused(
    more: dict[str, object], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        hl.Tendons(ARMS, KT, OWN, **more)


def test_a_joint_has_one_drive() -> None:
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


def test_one_motor_for_all_of_a_hand_with_tendons_is_asked_for_by_name() -> None:
    tendons = hl.Tendons({"pull": {"finger_1_distal": 0.01}}, 2e4, 4.0)
    words = r"motors: .*motors=\{'pull': Motor\(...\)\}, or Tendons\(motors=...\)"
    with pytest.raises(InputError, match=words):
        example_hand("three_finger", joint_stiffness=tendons, motors=Motor(0.3))
    hand = example_hand("three_finger", joint_stiffness=tendons)
    with pytest.raises(InputError, match=words):
        hand.replace(motors=Motor(0.3))
    assert hand.replace(motors=Motor(0.3), joint_stiffness=6.0).torque_limits.tolist() == [0.3] * 6


def test_motors_of_a_hand_are_by_joint_and_by_tendon(write: Writer) -> None:
    """`motors=` of the hand says the same as `motors=` of its tendons, from the start and in `replace`."""
    motor = hl.Motor(continuous=0.05, peak=0.15, reduction=100.0)
    plain = hl.Tendons(ARMS, KT, OWN)
    named = {"right_flexor": motor}
    hands = [
        lever_hand(write, joint_stiffness=hl.Tendons(ARMS, KT, OWN, motors=named)),
        lever_hand(write, joint_stiffness=plain, motors=named),
        lever_hand(write, joint_stiffness=plain).replace(motors=named),
    ]
    limits = [lever_pinch(hand).mechanism.cables.limits for hand in hands]
    np.testing.assert_array_equal(limits[1], limits[0])
    np.testing.assert_array_equal(limits[2], limits[0])
    assert np.isfinite(limits[0]).sum() == 1


def test_motors_by_tendon_take_the_place_of_those_of_tendons_and_motors_by_joint_of_those_of_joints() -> None:
    tendons = hl.Tendons({"pull": {"finger_1_distal": 0.01}, "lift": {"finger_2_distal": 0.01}}, 2e4, 4.0,
                         motors={"lift": motor(5.0, 9.0)})  # fmt: skip
    hand = example_hand("three_finger", joint_stiffness=tendons, motors={"finger_3_distal": Motor(0.2)})

    def found(**motors: object) -> tuple[list[bool], list[bool]]:
        made = hand.replace(**motors)
        of_joints, of_tendons = made.torques.drives, tendons_of(made).drives
        assert of_tendons is not None
        joints = [] if of_joints is None else [m is not None for m in of_joints.motors]
        return joints[4:], [m is not None for m in of_tendons.motors]

    assert hand.joint_names[4:] == ("finger_3_proximal", "finger_3_distal")
    first, other, both = {"pull": motor(50.0, 90.0)}, {"finger_3_proximal": Motor(0.3)}, [True, False]
    assert found(motors=first) == ([False, True], both)
    assert found(motors=other) == (both, [False, True])
    assert found(motors=first | other) == (both, both)


@pytest.mark.parametrize("routed", [False, True])
def test_without_motors_is_without_those_of_joints_and_of_tendons(routed: bool) -> None:
    links = ("finger_1_proximal_link", "finger_1_distal_link")
    route = hl.Route([hl.Site(link, (0.01, 0.0, 0.01)) for link in links])
    arms = {"pull": route if routed else {"finger_1_distal": 0.01}, "lift": {"finger_2_distal": 0.01}}
    bare = example_hand("three_finger", joint_stiffness=hl.Tendons(arms, 2e4, 4.0, limits=70.0))
    driven = bare.replace(motors={"pull": motor(5.0, 9.0), "finger_3_distal": Motor(0.2)})
    assert tendons_of(driven).cables.limits.min() < 70.0
    made = driven.replace(motors=None)
    assert (made.torques.drives, tendons_of(made).drives) == (None, None)
    np.testing.assert_array_equal(made.torque_limits, bare.torque_limits)
    np.testing.assert_array_equal(tendons_of(made).cables.limits, [70.0, 70.0])
    kept = driven.vary({"finger_3_distal.motor": None})
    assert kept.torques.drives is None
    assert tendons_of(kept).drives is not None


# ---------------------------------------------------------------- closing with a torque
def test_dry_friction_of_a_tendons_motor_takes_its_part_of_a_closing_torque() -> None:
    """As that of a joint's motor does: an arm r takes r τ_f of the torque; the tension is τ / r."""
    arm, rubs, ball = 0.01, 10.0, hl.Sphere(0.03, (0.0, 0.0, 0.09))
    joints = example_hand("three_finger").joint_names
    tendons = hl.Tendons({f"to {joint}": {joint: arm} for joint in joints}, 2e4, 4.0)
    hand = example_hand("three_finger", joint_stiffness=tendons)
    q = hand.close_on(ball)
    plain = hand.at(q).grasp(ball, closing_torque=0.3 - arm * rubs)
    driven = hand.replace(motors={f"to {joint}": motor(20.0, 40.0, friction=rubs) for joint in joints})
    np.testing.assert_allclose(
        driven.at(q).grasp(ball, closing_torque=0.3).joint_offset, plain.joint_offset, rtol=1e-12
    )
    for torque, words in ((arm * rubs, "dry friction of its drive, 10, and at most"), (0.41, "peak.* 40 N in")):
        with pytest.raises(InputError, match=f"closing_torque: .*{words}.*to finger_1_"):
            driven.at(q).grasp(ball, closing_torque=torque)
