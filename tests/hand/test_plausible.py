"""Numbers in other units than they are asked for: degrees, per cent, grams; what is merely unusual is taken."""

from __future__ import annotations

from math import pi

import pytest

import handlcp as hl

BALL = hl.Sphere(0.03, (0, 0, 0.08), mass=0.1)


@pytest.fixture(scope="module")
def hand():
    return hl.example_hand("two_finger", joint_stiffness=6.0)


@pytest.mark.parametrize("q", [(20, 30, 40, 50), {"finger_1_proximal": 45, "finger_1_distal": 0,
                                                  "finger_2_proximal": 45, "finger_2_distal": 0}])  # fmt: skip
def test_a_posture_in_degrees_is_asked_about(hand, q):
    with pytest.raises(hl.InputError, match=r"q\['finger_._\w+'\]: expected a position in its range, .* \(degrees\? "):
        hand.at(q)


def test_a_posture_a_little_past_its_range_is_taken_and_a_quarter_turn_past_it_is_not(hand):
    """Ranges in files are narrower than hands are: Allegro's thumb is at zero 0.26 rad past its own."""
    hand.at(hand.upper + 0.3)
    hand.at(hand.lower - pi / 2)
    with pytest.raises(hl.InputError, match="a position in its range"):
        hand.at(hand.lower - 1.01 * pi / 2)


def test_a_coefficient_in_per_cent_is_asked_about(hand):
    state = hand.at(hand.close_on(BALL))
    with pytest.raises(hl.InputError, match=r"friction: .* got 60 \(per cent\? 0.6\)"):
        state.grasp(BALL, friction=60, grip_force=2.0)
    with pytest.raises(hl.InputError, match=r"friction: .*per cent"):
        hl.Contact((0.02, 0, 0), (-1, 0, 0), 60)
    assert state.grasp(BALL, hl.Coulomb(60.0), grip_force=2.0).contacts[0].friction.mu == 60.0


def test_a_mass_in_grams_is_asked_about(hand):
    state = hand.at(hand.close_on(BALL))
    with pytest.raises(hl.InputError, match=r"mass in kilograms, got 200 kg for a hand of 0.342 kg \(grams\? 0.2\)"):
        state.grasp(BALL.weighing(200.0), friction=0.6, grip_force=2.0)
    with pytest.raises(hl.InputError, match="grams"):
        hl.find_grasp(hand, hl.Sphere(0.03, mass=200), friction=0.6, grip_force=2.0, tries=2)
    state.grasp(BALL.weighing(20.0), friction=0.6, grip_force=2.0)


def test_a_brief_without_a_mass_says_first_that_its_verdict_is_about_payload_only(hand):
    without, heavy = hl.Brief(hl.Sphere(0.03), grip_force=2.0, tries=4), hl.Brief(BALL, grip_force=2.0, tries=4)
    said = " ".join(str(hl.evaluate(hand, without)).split())
    assert said.startswith("no mass was given of object: the verdict is about payload only. ")
    assert "no mass" not in str(hl.evaluate(hand, heavy))
