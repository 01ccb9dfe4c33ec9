"""Mistakes of the first hour: what is said of them, and that what is nearly right is taken."""

from math import pi

import numpy as np
import pinocchio as pin
import pytest
import trimesh

import handlcp as hl
from tests.support.texts import same, says

BOX = hl.Box(0.05, (0, 0, 0.08), 0.2)


@pytest.fixture(scope="module")
def state(three):
    return three.at(three.close_on(BOX))


@pytest.fixture(scope="module")
def cube():
    mesh = trimesh.creation.box((0.05, 0.05, 0.05))
    mesh.apply_translation((0, 0, 0.08))
    return mesh


def refused(call):
    with pytest.raises(hl.InputError) as error:
        call()
    return str(error.value)


def test_a_mesh_that_is_no_object_yet_is_sent_to_mesh_from_everywhere(three, state, cube):
    grasp = state.grasp(BOX, 0.8)
    for call in (
        lambda: three.close_on(cube), lambda: state.grasp(cube), lambda: state.grasp(cube, friction=0.8),
        lambda: grasp.replace(object=cube), lambda: hl.find_grasp(three, cube),
        lambda: three.close_on(trimesh.Scene(cube)),
    ):  # fmt: skip
        assert "hl.Mesh(mesh, mass=...)" in refused(call)


@pytest.mark.parametrize("squeeze", [4, {"finger_1_tip": 4}])
def test_a_squeeze_in_millimetres_is_asked_about(three, state, squeeze):
    assert "millimetres" in refused(lambda: state.grasp(BOX, squeeze=squeeze))
    assert "millimetres" in refused(lambda: three.close_on(BOX, squeeze=squeeze))
    assert state.grasp(BOX, grip_force=4).spec.effects  # newtons


def test_a_load_of_the_wrong_length_is_told_what_the_numbers_are(state):
    says(refused(lambda: state.grasp(BOX, wrench=(0, 5, 0))), "[N·m]")
    for gravity in (9.81, 0):
        said = refused(lambda g=gravity: state.grasp(BOX, gravity=g))
    says(said, "(0, 0, -9.81)")


def test_a_rotation_that_was_printed_is_made_exact():
    R = pin.exp3(np.array([0.3, -0.7, 0.4]))
    given = np.eye(4)
    given[:3, :3] = np.round(R, 5)
    taken = hl.Box(0.05, given).frame[0]
    np.testing.assert_allclose(taken.T @ taken, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(taken, R, atol=2e-5)
    given[:3, :3] = 1.001 * R
    assert "rotation" in refused(lambda: hl.Box(0.05, given))


def test_a_hand_without_stiffness_is_asked_for_it():
    for read in (hl.Hand.from_urdf, hl.Hand.from_mjcf, hl.Hand.from_model):
        said = refused(lambda r=read: r("hand.urdf"))
    same("hand/test_first_mistakes: no stiffness", said, "N·m/rad", "1 to 10")


def test_a_grasp_that_nothing_loads_says_so(state):
    light = state.grasp(hl.Box(0.05, (0, 0, 0.08)), 0.8, squeeze=0.004)
    for verdict in (light.solve().verdict, light.check()):
        (reason,) = verdict.about("no_load")
        assert verdict.ok
        assert reason.severity == "note"
    same("hand/test_first_mistakes: no load", reason.sentence)
    for loaded in (light.replace(mass=0.2), light.replace(load=(0, 0, -1, 0, 0, 0))):
        assert not loaded.solve().verdict.about("no_load")


# ---------------------------------------------------------------- a hand that was told nothing that squeezes: said
BALL = hl.Sphere(0.03, placement=(0, 0, 0.07), mass=0.2)
SAID = "no squeeze was given: pass grip_force="


@pytest.fixture(scope="module")
def touching():
    """Three fingers that have closed until they touch, which leaves overlaps of nanometres, and a solve of that."""
    hand = hl.example_hand("three_finger")
    grasp = hand.at(hand.close_on(BALL)).grasp(BALL)
    assert 0.0 < -grasp.offset[:, 2].min() < 1e-6
    return grasp


def test_a_forgotten_squeeze_is_the_first_reason(touching):
    verdict = touching.check()
    assert verdict.word == "NOT HELD"
    assert verdict.reasons[0].code == "no_squeeze"
    assert verdict.text.startswith(SAID)
    assert "although" not in verdict.text  # overlaps of rounding squeeze nothing
    assert "nothing that was tried" not in str(verdict)


@pytest.mark.parametrize("geometry", ["followed", "fixed"])
def test_a_load_limit_of_nothing_says_it_first(touching, geometry):
    found = touching.load_limit((1, 0, 0, 0, 0, 0), geometry=geometry)
    assert found.factor == 0.0
    assert found.why.startswith(SAID)


def test_a_payload_of_nothing_says_it_too(touching):
    found = touching.payload(geometry="fixed")
    assert found.mass < 1e-6
    assert found.says.startswith(SAID)


@pytest.mark.parametrize("squeeze", [{"grip_force": 1e-3}, {"preload": 1e-5}])
def test_a_squeeze_that_is_too_small_is_another_reason(touching, squeeze):
    verdict = touching.state.grasp(BALL, **squeeze).check()
    assert not verdict.ok
    assert not verdict.about("no_squeeze")


def test_what_is_held_without_a_squeeze_says_first_that_nothing_loads_it():
    hand = hl.example_hand("three_finger")
    weightless = hand.at(hand.close_on(BALL)).grasp(BALL, gravity=(0, 0, 0))
    verdict = weightless.check()
    assert verdict.ok
    assert not verdict.about("no_squeeze")
    notes = [reason.code for reason in verdict.reasons if reason.severity == "note"]
    assert notes[0] == "no_load"  # before all that is so because of it
    assert verdict.text.startswith("no load: no weight acts on the object")


# ---------------------------------------------------------------- numbers in other units than they are asked for
SMALL_BALL = hl.Sphere(0.03, (0, 0, 0.08), mass=0.1)


@pytest.fixture(scope="module")
def jaws():
    return hl.example_hand("two_finger", joint_stiffness=6.0)


@pytest.mark.parametrize("q", [(20, 30, 40, 50), {"finger_1_proximal": 45, "finger_1_distal": 0,
                                                  "finger_2_proximal": 45, "finger_2_distal": 0}])  # fmt: skip
def test_a_posture_in_degrees_is_asked_about(jaws, q):
    with pytest.raises(hl.InputError, match=r"q\['finger_._\w+'\]: expected a position in its range, .* \(degrees\? "):
        jaws.at(q)


def test_a_posture_a_little_past_its_range_is_taken_and_a_quarter_turn_past_it_is_not(jaws):
    """Ranges in files are narrower than hands are: Allegro's thumb is at zero 0.26 rad past its own."""
    jaws.at(jaws.upper + 0.3)
    jaws.at(jaws.lower - pi / 2)
    with pytest.raises(hl.InputError, match="a position in its range"):
        jaws.at(jaws.lower - 1.01 * pi / 2)


def test_a_coefficient_in_per_cent_is_asked_about(jaws):
    state = jaws.at(jaws.close_on(SMALL_BALL))
    with pytest.raises(hl.InputError, match=r"friction: .* got 60 \(per cent\? 0.6\)"):
        state.grasp(SMALL_BALL, friction=60, grip_force=2.0)
    with pytest.raises(hl.InputError, match=r"friction: .*per cent"):
        hl.Contact((0.02, 0, 0), (-1, 0, 0), 60)
    assert state.grasp(SMALL_BALL, hl.Coulomb(60.0), grip_force=2.0).contacts[0].friction.mu == 60.0


def test_a_mass_in_grams_is_asked_about(jaws):
    state = jaws.at(jaws.close_on(SMALL_BALL))
    with pytest.raises(hl.InputError, match=r"mass in kilograms, got 200 kg for a hand of 0.342 kg \(grams\? 0.2\)"):
        state.grasp(SMALL_BALL.weighing(200.0), friction=0.6, grip_force=2.0)
    with pytest.raises(hl.InputError, match="grams"):
        hl.find_grasp(jaws, hl.Sphere(0.03, mass=200), friction=0.6, grip_force=2.0, tries=2)
    state.grasp(SMALL_BALL.weighing(20.0), friction=0.6, grip_force=2.0)


def test_a_brief_without_a_mass_says_first_that_its_verdict_is_about_payload_only(jaws):
    without, heavy = hl.Brief(hl.Sphere(0.03), grip_force=2.0, tries=4), hl.Brief(SMALL_BALL, grip_force=2.0, tries=4)
    said = " ".join(str(hl.evaluate(jaws, without)).split())
    assert said.startswith("no mass was given of object: the verdict is about payload only. ")
    assert "no mass" not in str(hl.evaluate(jaws, heavy))
