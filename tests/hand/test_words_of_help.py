"""Mistakes of the first hour: what is said of them, and that what is nearly right is taken."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
import trimesh

import handlcp as hl
from tests.support.texts import same, says

BOX = hl.Box(0.05, (0, 0, 0.08), 0.2)


@pytest.fixture(scope="module")
def hand():
    return hl.example_hand("three_finger", joint_stiffness=6.0)


@pytest.fixture(scope="module")
def state(hand):
    return hand.at(hand.close_on(BOX))


@pytest.fixture(scope="module")
def cube():
    mesh = trimesh.creation.box((0.05, 0.05, 0.05))
    mesh.apply_translation((0, 0, 0.08))
    return mesh


def refused(call):
    with pytest.raises(hl.InputError) as error:
        call()
    return str(error.value)


def test_a_mesh_that_is_no_object_yet_is_sent_to_mesh_from_everywhere(hand, state, cube):
    grasp = state.grasp(BOX, 0.8)
    for call in (
        lambda: hand.close_on(cube), lambda: state.grasp(cube), lambda: state.grasp(cube, friction=0.8),
        lambda: grasp.replace(object=cube), lambda: hl.find_grasp(hand, cube),
        lambda: hand.close_on(trimesh.Scene(cube)),
    ):  # fmt: skip
        assert "hl.Mesh(mesh, mass=...)" in refused(call)


@pytest.mark.parametrize("squeeze", [4, {"finger_1_tip": 4}])
def test_a_squeeze_in_millimetres_is_asked_about(hand, state, squeeze):
    assert "millimetres" in refused(lambda: state.grasp(BOX, squeeze=squeeze))
    assert "millimetres" in refused(lambda: hand.close_on(BOX, squeeze=squeeze))
    assert state.grasp(BOX, grip_force=4).spec.effects  # newtons


def test_a_load_of_the_wrong_length_is_told_what_the_numbers_are(state):
    says(refused(lambda: state.grasp(BOX, wrench=(0, 5, 0))), "[N·m]")
    for gravity in (9.81, 0):
        said = refused(lambda g=gravity: state.grasp(BOX, gravity=g))
    says(said, "(0, 0, -9.81)")


@pytest.mark.parametrize("digits", [5])
def test_a_rotation_that_was_printed_is_made_exact(digits):
    R = pin.exp3(np.array([0.3, -0.7, 0.4]))
    given = np.eye(4)
    given[:3, :3] = np.round(R, digits)
    taken = hl.Box(0.05, given).frame[0]
    np.testing.assert_allclose(taken.T @ taken, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(taken, R, atol=2 * 10.0**-digits)
    given[:3, :3] = 1.001 * R
    assert "rotation" in refused(lambda: hl.Box(0.05, given))


def test_a_hand_without_stiffness_is_asked_for_it():
    for read in (hl.Hand.from_urdf, hl.Hand.from_mjcf, hl.Hand.from_model):
        said = refused(lambda r=read: r("hand.urdf"))
    same("hand/test_words_of_help: no stiffness", said, "N·m/rad", "1 to 10")


def test_a_grasp_that_nothing_loads_says_so(state):
    light = state.grasp(hl.Box(0.05, (0, 0, 0.08)), 0.8, squeeze=0.004)
    for verdict in (light.solve().verdict, light.check()):
        (reason,) = verdict.about("no_load")
        assert verdict.ok
        assert reason.severity == "note"
    same("hand/test_words_of_help: no load", reason.sentence)
    for loaded in (light.replace(mass=0.2), light.replace(load=(0, 0, -1, 0, 0, 0))):
        assert not loaded.solve().verdict.about("no_load")
