"""Which motors does a brief take: against a pinch by hand, and as promises that the answer keeps."""

import dataclasses
import itertools

import numpy as np
import pytest

import handlcp as hl
from handlcp.actuation.motor import Drives
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.verdict.check import STEPS_PER_STAGE
from tests.design.hands import G, cube_grasp, pinch
from tests.hand.levers import MU, L

BRIEF = {"lift": {}, "push": (0, 3, 0, 0, 0, 0), "heavy, upside down": {"gravity": (0, 0, G), "mass": 0.8}}
SAFETY = 1.5


@pytest.fixture(scope="module")
def cube():
    """Grasp and answer."""
    grasp = cube_grasp()
    return grasp, grasp.required_torque(BRIEF, SAFETY, tolerance=0.05)


def under(grasp, name, grip, limits, safety=SAFETY):
    """The grasp under a load of BRIEF times safety, made by public names alone."""
    said = BRIEF[name]
    load = np.array(said, dtype=float) if isinstance(said, tuple) else np.zeros(6)
    parts = said if isinstance(said, dict) else {}
    hand = grasp.state.hand.replace(torque_limits=limits)
    mass = safety * parts.get("mass", grasp.target.mass)
    made = hand.at(grasp.state.q).grasp(grasp.target, friction=0.8, wrench=safety * load, grip_force=grip)
    return made.replace(mass=mass, gravity=parts.get("gravity", (0, 0, -G)))


# ---------------------------------------------------------------- by hand
@pytest.mark.parametrize(
    ("load", "safety"), [*(pytest.param(1.0, s, marks=pytest.mark.long) for s in (1.0, 1.5)), (3.0, 2.0)]
)
def test_a_pinch_needs_load_over_twice_its_friction_at_the_length_of_its_levers(tmp_path, load, safety):
    r = pinch(tmp_path, (0, 0, -load)).required_torque(safety=safety)
    exact = safety * load / (2 * MU)  # normal force; its lever is the finger's length, that of the friction is 0
    for grip in r.grip.values():
        assert exact * (1 - 1e-5) <= grip <= 1.01 * exact
    np.testing.assert_allclose(r.torque, L * np.mean(list(r.grip.values())), rtol=1e-5)
    assert r.verdicts == {"the load": "HELD"}
    assert r.fails * np.mean(list(r.grip.values())) < exact
    assert r.sized_by == ("squeeze", "squeeze")


def test_a_push_along_the_normals_adds_half_of_itself_to_one_finger(tmp_path):
    brief = {"down": (0, 0, -1.0, 0, 0, 0), "sideways": (0.6, 0, 0, 0, 0, 0)}
    r = pinch(tmp_path).required_torque(brief, safety=1.0)
    grip = np.mean(list(r.grip.values()))
    np.testing.assert_allclose(grip, 1.0 / (2 * MU), rtol=0.011)
    # both fingers are as stiff as each other: the push takes half of itself off the left one
    np.testing.assert_allclose(r.torque, (L * grip, L * (grip + 0.3)), rtol=1e-5)
    assert r.sized_by == ("squeeze", "sideways")


def test_without_slip_the_linear_program_begins_at_the_answer(tmp_path):
    """Faces inside the cones ask for a little more than the cones do."""
    r = pinch(tmp_path).required_torque(safety=1.0, tolerance=1e-4)
    assert 1.0 - 1e-5 <= next(iter(r.grip.values())) <= 1.0002


# ---------------------------------------------------------------- promises
def test_with_the_answer_as_limits_every_load_is_held(cube):
    grasp, r = cube
    assert set(r.verdicts.values()) == {"HELD"}
    for name in BRIEF:
        verdict = under(grasp, name, r.grip, r.torque).check()
        assert verdict.word == "HELD", f"{name}: {verdict}"


def test_with_a_little_less_grip_a_load_is_lost_and_the_answer_says_which(cube):
    grasp, r = cube
    less = {name: r.fails * force for name, force in r.grip.items()}
    assert 0.8 < r.fails < 1.0
    assert under(grasp, r.lost[0], less, np.inf).check().word == "NOT HELD"


def test_each_joint_is_sized_by_the_load_that_needs_most_of_it_on_its_whole_way(cube):
    grasp, r = cube
    paths = {name: under(grasp, name, r.grip, np.inf).follow(steps=STEPS_PER_STAGE) for name in BRIEF}
    most = np.array([abs(path.steps.torques).max(axis=0) for path in paths.values()])
    np.testing.assert_allclose(r.torques, most, rtol=1e-6)
    np.testing.assert_allclose(r.torque, most.max(axis=0), rtol=1e-5)
    path = paths["lift"].steps
    closing = abs(path.torques[path.stage == 0]).max(axis=0)
    for joint, name in enumerate(r.sized_by):
        own = closing if name == "squeeze" else most[list(BRIEF).index(name)]
        assert own[joint] == pytest.approx(r.torque[joint], rel=1e-5)


def test_finer_steps_need_no_more_than_a_thousandth_more(cube):
    grasp, r = cube
    for name in BRIEF:
        fine = under(grasp, name, r.grip, np.inf).follow(steps=30).steps.torques
        assert (abs(fine).max(axis=0) <= 1.001 * r.torque).all()


@pytest.mark.long
def test_a_grip_for_each_finger_needs_no_more_than_a_common_one(cube):
    grasp, r = cube
    most = 0.0
    for name in BRIEF:
        one = under(grasp, name, 1.0, np.inf)
        common = one.required_grip(tolerance=1e-2).value
        most = max(most, common)
    common = max(abs(under(grasp, n, most, np.inf).follow(steps=8).steps.torques).max() for n in BRIEF)
    assert r.torque.max() < common


@pytest.mark.long
def test_more_safety_needs_more_of_every_motor():
    grasp = cube_grasp()
    found = [grasp.required_torque(safety=s, tolerance=1e-3) for s in (1.0, 1.5, 2.0)]
    for less, more in itertools.pairwise(found):
        assert (more.torque > less.torque).all()
    # Small motions are linear: twice the load takes about twice the torque of the joint that needs most
    assert found[2].torque.max() == pytest.approx(2 * found[0].torque.max(), rel=0.1)


@pytest.mark.long
def test_what_counts_are_shares_of_the_limits_where_all_joints_have_one():
    """A weak thumb is spared: it needs a smaller share of the largest torque than where all motors are alike."""
    grasp = cube_grasp()
    hand = grasp.state.hand
    weak = {name: 0.2 if name.startswith("finger_2") else 2.0 for name in hand.joint_names}
    other = hand.replace(torque_limits=weak).at(grasp.state.q).grasp(grasp.target, friction=0.8)
    push = {"push": (0, 3, 0, 0, 0, 0)}
    alike, spared = grasp.required_torque(push), other.required_torque(push)
    assert spared.torque[2:4].max() <= alike.torque[2:4].max() * (1 + 1e-3)
    shares = [(r.torque / other.state.hand.torque_limits).max() for r in (alike, spared)]
    assert shares[1] <= shares[0] * (1 + 1e-3)


def test_the_hands_own_limits_are_enough_or_the_weak_joints_are_named(tmp_path):
    strong, weak = (pinch(tmp_path, limits=limit).required_torque(tolerance=0.1) for limit in (0.2, 0.1))
    assert strong.enough
    assert strong.weak == ()
    assert not weak.enough
    assert weak.weak == ("left_joint", "right_joint")
    assert not pinch(tmp_path, limits={"left_joint": 0.2, "right_joint": 0.05}).required_torque(tolerance=0.1).enough


@pytest.mark.long
def test_the_fingers_weight_counts_and_is_not_multiplied():
    grasp = cube_grasp()
    heavy = grasp.replace(finger_weight="torques")
    light, more = grasp.required_torque(safety=2.0), heavy.required_torque(safety=2.0)
    held = abs(heavy.gravity_torque)
    assert (abs(more.torque - light.torque) <= 1.05 * held.max() + 0.02 * light.torque).all()
    assert abs(more.torque - light.torque).max() > 0.2 * held.max()


# ---------------------------------------------------------------- dry friction
RUBS = 0.05  # N·m at each joint


def test_the_peak_is_what_drives_pull_with_against_dry_friction_at_the_joints(tmp_path):
    """The tips press as without friction, the springs pull with that and what friction takes of it."""
    plain = pinch(tmp_path).required_torque(safety=1.0, tolerance=0.05)
    rubbing = pinch(tmp_path, hand={"joint_friction": RUBS}).required_torque(safety=1.0, tolerance=0.05)
    np.testing.assert_allclose(rubbing.torque, plain.torque, rtol=0.06)
    np.testing.assert_allclose(rubbing.peak, rubbing.torque + RUBS, rtol=1e-5)
    np.testing.assert_allclose(rubbing.to_dict()["joints"][0]["closing_Nm"], rubbing.peak[0])
    np.testing.assert_allclose(plain.peak, plain.torque)
    assert rubbing.sized_by == ("squeeze", "squeeze")
    assert rubbing.enough
    short = dataclasses.replace(rubbing, limits=rubbing.torque + RUBS / 2)  # above what is held, below what closes
    assert short.weak == ("left_joint", "right_joint")
    assert not short.enough
    motor = hl.Motor(rubbing.torque[0] + RUBS / 2, holding=1.0)
    carried = dataclasses.replace(rubbing, limits=np.ones(2), drives=Drives((motor, motor)))
    assert carried.weak == ("left_joint", "right_joint")


@pytest.mark.parametrize(
    ("at_joints", "of_drive", "peak"),
    [pytest.param(0.0, 0.03, 0.04, marks=pytest.mark.long), (RUBS, 0.03, 0.012)],
)
def test_a_motor_with_the_reduction_that_is_said_closes_and_holds_and_with_less_does_not(
    tmp_path, at_joints, of_drive, peak
):
    """They take the place of the hand's own, with as much dry friction, on which the grip depends."""
    others = hl.Motor(1.0, friction=of_drive)
    r = pinch(tmp_path, hand={"joint_friction": at_joints, "motors": others}).required_torque(
        safety=1.0, tolerance=0.05
    )

    def built(times):
        some = hl.Motor(0.012, peak, friction=of_drive, reduction=10.0, efficiency=0.7)
        each = dict(zip(r.joints, (times * r.reductions(some)).tolist(), strict=True))
        motors = {name: dataclasses.replace(some, reduction=N) for name, N in each.items()}
        hand = {"joint_friction": at_joints, "motors": motors}
        return pinch(tmp_path, hand=hand, grip_force=r.grip).check().word

    assert [built(1.01), built(0.99)] == ["HELD", "OVER LIMIT"]


# ---------------------------------------------------------------- what does not hold, and what is refused
@pytest.mark.long
def test_where_no_grip_holds_it_is_said_how_far_the_best_gets():
    grasp = cube_grasp()
    slippery = grasp.replace(friction=0.01)
    r = slippery.required_torque({"lift": {}})
    assert not r.holds
    assert not r.enough
    assert np.isnan(r.torque).all()
    assert r.lost[0] == "lift"
    assert "No grip" in str(r)


@pytest.mark.parametrize(
    ("loads", "error"),
    [({}, InputError), ((1.0, 2.0), InputError), ({"a": {"weight": 1.0}}, UnknownName), ({"a": (1, 2)}, InputError),
     ({"a": {"mass": -1.0}}, InputError), (np.zeros((0, 6)), InputError), ({"a": {"mass": None}}, InputError)],
)  # fmt: skip
def test_what_is_no_brief_is_refused(loads, error):
    with pytest.raises(error):
        cube_grasp().required_torque(loads)


@pytest.mark.long
def test_where_check_does_not_say_held_the_answer_is_not_confirmed_and_says_why():
    hand = hl.example_hand("three_finger", joint_stiffness=60.0)
    box = hl.Box((0.05, 0.05, 0.13), (0.0, 0.0, 0.05), mass=0.1)  # down through the palm
    r = hand.at(hand.close_on(box)).grasp(box, friction=0.8).required_torque({"lift": {}}, tolerance=0.1)
    assert r.holds
    assert not r.confirmed
    assert not r.enough
    assert r.verdicts == {"lift": "UNDECIDED"}
    assert "palm" in r.reasons["lift"]
    said = " ".join(str(r).split())
    assert said.startswith("NOT CONFIRMED: ")
    assert f"lift is UNDECIDED: {r.reasons['lift']}." in said
    assert "held" not in said
