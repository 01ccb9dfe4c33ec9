"""Derivatives by posture and lengths of fingertips that just touch: both sides, against differences of whole solves."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl

HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
TOUCHING = HAND.close_on(CUBE)
COMMANDS = {
    "squeeze": {"squeeze": 0.005}, "grip force": {"grip_force": 5.0},
    "joint offset": {"joint_offset": HAND.at(TOUCHING).grasp(CUBE, friction=0.8, squeeze=0.005).joint_offset},
}  # fmt: skip
WAYS = {"a joint": np.eye(6)[3], "all joints": np.array([1.0, -3.0, 2.0, 1.0, -1.0, -2.0]) / 3.0}
STEP = 4e-4  # [rad]: overlaps of some micrometres, of which one counts as touching


def solved(q, command, start=None):
    return HAND.at(q).grasp(CUBE, friction=0.8, **COMMANDS[command]).solve(start=start)


def one_sided(here, q, way, command):
    """Of forces, from two steps, the error of the first order taken out."""
    half, whole = (
        (solved(q + h * way, command, here).forces - here.forces) / h for h in (STEP / 2, STEP)
    )  # fmt: skip
    return 2 * half - whole


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("command", COMMANDS)
def test_the_two_sides_of_touching_are_those_of_whole_solves(command, way):
    here = solved(TOUCHING, command)
    both = here.sensitivity().along("posture", way)
    truths = one_sided(here, TOUCHING, way, command), -one_sided(here, TOUCHING, -way, command)
    apart = abs(truths[0] - truths[1]).max()
    assert apart > 1e-3 * abs(truths[0]).max()
    for found, truth in zip((both.ahead, both.behind), truths, strict=True):
        assert abs(found["forces"] - truth).max() < 0.02 * apart


def test_fingers_that_just_touch_are_kinks_of_posture_and_lengths_alone():
    found = solved(TOUCHING, "squeeze").sensitivity()
    assert [(k.contact, k.by) for k in found.kinks] == [(i, ("posture", "lengths")) for i in range(3)]
    assert str(found.kinks[0]) == "finger_1_tip just touches where it was detected (by posture and lengths)"
    assert "Two sides" not in str(found)  # the table has no row of these
    for parameter, shape in (("wrench", (6,)), ("stiffness", (6,)), ("positions", (3, 3))):
        both = found.along(parameter, np.ones(shape))
        np.testing.assert_allclose(both.ahead["forces"], both.behind["forces"], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("parameter", ["posture", "lengths"])
def test_entries_are_those_of_a_parameter_that_grows(parameter):
    found = solved(TOUCHING, "squeeze").sensitivity()
    whole = found.of("forces", parameter)
    flat = whole.reshape(3, 3, -1)
    for k in range(flat.shape[-1]):
        way = np.zeros(flat.shape[-1])
        way[k] = 1.0
        ahead = found.along(parameter, way.reshape(whole.shape[2:])).ahead["forces"]
        np.testing.assert_allclose(flat[..., k], ahead, rtol=1e-9, atol=1e-9)


def test_fingertips_that_are_inside_or_that_leave_a_gap_have_no_kink():
    for deeper in (2e-3, -2e-3):  # rad
        q = TOUCHING + deeper
        here = solved(q, "squeeze")
        found = here.sensitivity()
        assert found.kinks == ()
        way = WAYS["a joint"]
        step = 1e-5  # too small to touch
        truth = (solved(q + step * way, "squeeze", here).forces - solved(q - step * way, "squeeze", here).forces) / 2e-5
        assert abs(found.forces_by_posture @ way - truth).max() < 1e-5 * abs(truth).max()
