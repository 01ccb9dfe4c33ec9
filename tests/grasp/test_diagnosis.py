"""One sentence with names, and never more than is known."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import describe_motion, diagnose, diagnosed
from tests.support.texts import same, says

PAIR = np.array([[-0.01, 0, 0], [0.01, 0, 0]])
NAMES = ("finger 1", "finger 2")
ZERO = np.zeros(3)


KEY = "grasp/test_diagnosis"


def way(twist, p=PAIR, c=ZERO, names=NAMES):
    return describe_motion(np.array(twist, float), p, np.array(c, float), names, "slides out", "turns out")


def test_a_translation_names_its_direction_whatever_the_reference():
    down = way((0, 0, -3, 0, 0, 0))
    says(down, "(0, 0, -1)")
    assert way((0, 0, -3, 0, 0, 0), c=(5, 6, 7)) == down
    assert way((0, 0, -1, 0, 0.001, 0)) == down, "a thousandth of a turn over 1 cm is nothing"


@pytest.mark.parametrize("c", [(0, 0, 0), (0.3, -0.2, 0.5)])
def test_a_rotation_names_its_axis_and_a_point_whatever_the_reference(c):
    axis, foot = np.array([0, 0, 1.0]), np.array([0.02, 0.03, 0])
    twist = np.r_[np.cross(axis, np.array(c) - foot), axis]
    says(way(twist, c=c), "(0, 0, 1)", "(0.02, 0.03, 0) m")
    through = np.r_[np.cross(axis, np.array(c) - PAIR[1]), axis]
    says(way(through, c=c), "(0, 0, 1)", "finger 2")
    line = np.r_[np.cross((1, 0, 0), np.array(c)), 1, 0, 0]
    says(way(line, c=c), "fingers 1 and 2")


def test_a_screw_names_both():
    says(way((0, 0, -0.01, 0, 0, 1)), "(0, 0, 1)", "(0, 0, 0) m", "(0, 0, -1)")


def test_not_holdable_says_where_the_object_goes():
    contacts = [hl.Contact(p, (-np.sign(p[0]), 0, 0), hl.Frictionless()) for p in PAIR]
    g = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    same(f"{KEY}: not holdable", diagnosed(g, g.solve(throw=False)), way((0, 0, -1, 0, 0, 0)))


def no_equilibrium(squeeze, **more):
    offset = np.zeros((2, 3))
    offset[:, 2] = -np.array(squeeze)
    return diagnose(hl.Status.NO_EQUILIBRIUM, NAMES, PAIR, reference=ZERO, offset=offset, **more)


def test_no_equilibrium_names_who_is_without_preload_and_what_would_hold():
    none, one, both = (
        no_equilibrium(squeeze, required_preload=4.3e-6) for squeeze in ((0, 0), (1e-6, 0), (1e-6, 1e-6))
    )
    same(f"{KEY}: nobody squeezes", none, "4.3 µm")
    same(f"{KEY}: one does not squeeze", one, "finger 2", "4.3 µm")
    says(both, "4.3 µm")
    far = no_equilibrium((0, 0), bounds=(1.1e4, 6.9))
    says(far, "no finger squeezes")
    assert not any(c.isdigit() for c in far), "no newtons and metres that nobody asked for"


def test_what_is_called_enough_is_rounded_up():
    assert "4.4 µm" in no_equilibrium((0, 0), required_preload=4.301e-6)
    assert "1.3 mm" in no_equilibrium((0, 0), required_preload=1.21e-3)


def test_what_is_not_known_is_not_said():
    nobody, both = no_equilibrium((0, 0)), no_equilibrium((1e-6, 1e-6))
    says(nobody, "no finger squeezes")
    says(both, "although")
    assert not any(c.isdigit() for c in nobody + both), "no squeeze that would hold, no bounds"
    text = diagnose(hl.Status.UNDECIDED, NAMES, PAIR, reference=ZERO, offset=np.zeros((2, 3)), required_preload=1e-3)
    same(f"{KEY}: undecided", text)
    assert not any(c.isdigit() for c in text), "no finger and no squeeze"


def test_no_contact_force_is_measured_against_the_scene():
    """A contact is separated when its force is nothing beside the scene's; rounding does not make it one."""
    noise = {"forces": np.full((2, 3), 1e-16), "states": ("separated",) * 2}
    says(diagnose(hl.Status.SOLVED, NAMES, PAIR, reference=ZERO, **noise), "no finger pushes")
    held = {"forces": np.full((2, 3), 1e-16), "states": ("sticking",) * 2}
    same(f"{KEY}: all stick", diagnose(hl.Status.SOLVED, NAMES, PAIR, reference=ZERO, **held))
