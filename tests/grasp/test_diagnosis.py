"""One sentence with names, and never more than is known."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch
from tests.support.grasp import Within, describe_motion, diagnose, diagnosed

PAIR = np.array([[-0.01, 0, 0], [0.01, 0, 0]])
NAMES = ("finger 1", "finger 2")
ZERO = np.zeros(3)


def way(twist, p=PAIR, c=ZERO, names=NAMES):
    return describe_motion(np.array(twist, float), p, np.array(c, float), names, "slides out", "turns out")


def test_a_translation_names_its_direction_whatever_the_reference():
    assert way((0, 0, -3, 0, 0, 0)) == "slides out along (0, 0, -1)"
    assert way((0, 0, -3, 0, 0, 0), c=(5, 6, 7)) == "slides out along (0, 0, -1)"
    assert way((0, 0, -1, 0, 0.001, 0)) == "slides out along (0, 0, -1)", "a thousandth of a turn over 1 cm is nothing"


@pytest.mark.parametrize("c", [(0, 0, 0), (0.3, -0.2, 0.5)])
def test_a_rotation_names_its_axis_and_a_point_whatever_the_reference(c):
    axis, foot = np.array([0, 0, 1.0]), np.array([0.02, 0.03, 0])
    twist = np.r_[np.cross(axis, np.array(c) - foot), axis]
    assert way(twist, c=c) == "turns out about (0, 0, 1) through (0.02, 0.03, 0) m"
    through = np.r_[np.cross(axis, np.array(c) - PAIR[1]), axis]
    assert way(through, c=c) == "turns out about (0, 0, 1) through finger 2"
    line = np.r_[np.cross((1, 0, 0), np.array(c)), 1, 0, 0]
    assert way(line, c=c) == "turns out about the line through fingers 1 and 2"


def test_a_screw_names_both():
    assert (
        way((0, 0, -0.01, 0, 0, 1)) == "turns out about (0, 0, 1) through (0, 0, 0) m and slides out along (0, 0, -1)"
    )


def test_not_holdable_says_where_the_object_goes():
    contacts = [hl.Contact(p, (-np.sign(p[0]), 0, 0), hl.Frictionless()) for p in PAIR]
    g = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    text = diagnosed(g, g.solve(throw=False))
    assert text == "no finger forces within friction balance the load: the object slides out along (0, 0, -1)"


def test_a_held_pinch_still_spins_about_its_line():
    g = pinch()
    assert (
        diagnosed(g, g.solve())
        == "held; all fingers stick; the object can still spin about the line through left and right"
    )


def test_states_are_told_by_name():
    g = pinch(load=(25.0, 0, 0))
    assert diagnosed(g, g.solve()).startswith("held; left does not push")
    text = diagnose(
        hl.Status.SOLVED,
        ("finger 1", "finger 2", "finger 3"),
        np.vstack([PAIR, [0, 0.01, 0]]),
        reference=ZERO,
        forces=np.ones((3, 3)),
        states=("sticking", "sticking", "sliding"),
        loose=np.zeros((0, 6)),
    )
    assert text == "held; finger 3 slides"


def test_several_loose_directions_are_counted():
    loose = np.array([[1.0, 0, 0, 0, 0, 0], [0, 1.0, 0, 0, 0, 0]])
    text = diagnose(
        hl.Status.SOLVED, NAMES, PAIR, reference=ZERO, states=("sliding",) * 2, loose=loose, forces_determined=False
    )
    assert "can still slide in 2 directions" in text
    assert "all fingers slide" in text
    assert "other forces" in text
    untouched = pinch(squeeze=-1e-3, load=(0, 0, 0))
    assert diagnosed(untouched, untouched.solve()) == (
        "in balance without any contact force; no finger pushes; the object is loose in every direction"
    )


def no_equilibrium(squeeze, **more):
    offset = np.zeros((2, 3))
    offset[:, 2] = -np.array(squeeze)
    return diagnose(hl.Status.NO_EQUILIBRIUM, NAMES, PAIR, reference=ZERO, offset=offset, **more)


def test_no_equilibrium_names_who_is_without_preload_and_what_would_hold():
    assert no_equilibrium((0, 0), required_preload=4.3e-6).endswith(
        "no finger carries preload; 4.3e-6 m on each finger would hold it"
    )
    assert "finger 2 carries no preload; 4.3e-6 m more on each finger" in no_equilibrium(
        (1e-6, 0), required_preload=4.3e-6
    )
    assert "the preload is too small; 4.3e-6 m more" in no_equilibrium((1e-6, 1e-6), required_preload=4.3e-6)
    assert "none up to 1e3 N and motions of 0.02 m" in no_equilibrium((0, 0), bounds=(1e3, 0.02))


def test_what_is_called_enough_is_rounded_up():
    assert "4.4e-6 m on each" in no_equilibrium((0, 0), required_preload=4.301e-6)
    assert "0.0013 m on each" in no_equilibrium((0, 0), required_preload=1.21e-3)


def test_what_is_not_known_is_not_said():
    assert "would hold" not in no_equilibrium((0, 0))
    assert "too small" not in no_equilibrium((1e-6, 1e-6))
    text = diagnose(hl.Status.UNDECIDED, NAMES, PAIR, reference=ZERO, offset=np.zeros((2, 3)), required_preload=1e-3)
    assert text == "the solver spent its budget without an answer, which says nothing about the grasp"


def test_many_names_are_cut_short():
    names = [f"finger {k}" for k in range(1, 8)]
    text = diagnose(
        hl.Status.SOLVED,
        [*names, "thumb"],
        np.random.default_rng(0).normal(size=(8, 3)),
        reference=ZERO,
        states=[*["sliding"] * 7, "sticking"],
    )
    assert text == "held; fingers 1, 2, 3, 4 and 3 more slide"


def test_fingers_without_friction_are_not_said_to_slide():
    contacts = [hl.Contact(p, (-np.sign(p[0]), 0, 0), hl.Frictionless()) for p in PAIR]
    text = hl.Grasp(contacts, flexibility=1e-4, preload=1e-3).solve().diagnosis
    assert text == "held; all fingers push without friction; the object can still move in 5 directions"
    one = diagnose(
        hl.Status.SOLVED,
        ("finger 1", "finger 2", "finger 3"),
        np.vstack([PAIR, [0, 0.01, 0]]),
        reference=ZERO,
        forces=np.array([[0, 0, 2.0], [1.0, 0, 2.0], [0, 0, 0]]),
        states=("sliding", "sliding", "separated"),
    )
    assert one == "held; finger 2 slides; finger 1 pushes without friction; finger 3 does not push"


def test_no_contact_force_is_measured_against_the_scene():
    """A contact is separated when its force is nothing beside the scene's; rounding does not make it one."""
    noise = {"forces": np.full((2, 3), 1e-16), "states": ("separated",) * 2}
    assert diagnose(hl.Status.SOLVED, NAMES, PAIR, reference=ZERO, **noise).startswith("in balance without any")
    held = {"forces": np.full((2, 3), 1e-16), "states": ("sticking",) * 2}
    assert diagnose(hl.Status.SOLVED, NAMES, PAIR, reference=ZERO, **held) == "held; all fingers stick"


def test_fingers_of_one_name_are_told_apart():
    contacts = [hl.Contact(p, (-np.sign(p[0]), 0, 0), hl.Coulomb(0.5), name="a") for p in PAIR]
    text = hl.Grasp(contacts, flexibility=1e-4, preload=1e-3).solve().diagnosis
    assert text.endswith("the object can still spin about the line through finger 1 (a) and finger 2 (a)")


def test_where_no_cause_is_known_the_preload_is_ruled_out():
    assert no_equilibrium((1e-6, 1e-6)).endswith("do not create them, although every finger carries preload")
    assert no_equilibrium((1e-6, 1e-6), bounds=Within((1.0, 2.0), "so it is")).endswith("motions of 2 m): so it is")
    assert no_equilibrium((1e-6, 0), bounds=Within((1.0, 2.0), "so it is")).endswith(
        "finger 2 carries no preload; so it is"
    )
