"""Numbers that makers state beside ours: where they come from, what is computed, and what is said where it is not."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import handlcp as hl
from tests.support.table import Stated, computed, stated

PRESS = Stated("mine", "fingertip", 10.0, 10.0, "N", "maker", "", "", "", fingers=("finger_1_tip",))


@cache
def fingertips():
    return hl.beside_hardware(tests=("fingertip",))


def test_every_stated_number_has_its_source_and_date():
    assert len(stated()) > 12
    assert all(one.source and one.date and one.posture and one.least > 0.0 for one in stated())
    assert all(one.example or one.file for one in stated())


def test_a_fingertip_presses_as_hard_as_its_torques_allow():
    """Two links of 50 + 40 mm: of all forces along the way it moves the one with which a joint is at its limit."""
    hand = hl.example_hand("three_finger", joint_stiffness=5.0)
    found = computed(hand, PRESS)
    assert found.low <= found.nominal <= found.high
    assert found.low > 0.4 / 0.09
    assert found.high < 0.8 / 0.03


def test_limits_that_are_doubted_widen_the_interval():
    """Every limit of the file is 1 N·m, which the audit doubts."""
    try:
        hand = hl.example_hand("inspire", joint_stiffness=5.0)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    surely = hand.vary({f"{joint}.torque_limit": 1.0 for joint in hand.joint_names})
    asked = next(one for one in stated() if one.hand.startswith("Inspire"))
    doubted, sure = computed(hand, asked), computed(surely, asked)
    np.testing.assert_allclose([doubted.low, doubted.high], [0.5 * sure.low, 2.0 * sure.high], rtol=1e-6)
    assert "torque limits" in doubted.over


def test_a_hand_without_torque_limits_says_so():
    hand = hl.example_hand("three_finger", joint_stiffness=5.0, torque_limits=np.inf)
    with pytest.raises(hl.InputError, match="torque limits in its file"):
        computed(hand, PRESS)


def test_a_file_that_is_not_installed_says_how_to_give_it():
    row = next(row for row in fingertips() if row.stated.hand == "Unitree Dex5-1")
    assert row.word == "not computed"
    assert 'beside_hardware({"Unitree Dex5-1": Hand.from_urdf(…)})' in row.why


def test_a_hand_that_is_given_is_computed():
    hand = hl.example_hand("three_finger", joint_stiffness=5.0)
    rows = hl.beside_hardware({"Yale Model T": hand}, tests=("fingertip",))
    row = next(row for row in rows if row.stated.hand == "Yale Model T")
    assert row.word in ("inside", "outside")
    assert row.low > 0.0


def test_what_is_outside_says_how_far():
    weak = hl.example_hand("three_finger", joint_stiffness=5.0, torque_limits=0.01)
    rows = hl.beside_hardware({"Yale Model T": weak}, tests=("fingertip",))
    row = next(row for row in rows if row.stated.hand == "Yale Model T")
    assert row.word == "outside"
    assert "times those of the file" in row.why


@pytest.mark.parametrize(
    ("given", "why"),
    [({"hands": {"nobody": 1}}, "nobody"), ({"hands": {"RUKA": 1}}, "a Hand"), ({"tests": ("jump",)}, "jump")],
)
def test_bad_arguments_are_refused(given, why):
    with pytest.raises(hl.HandLCPError, match=why):
        hl.beside_hardware(**given)
