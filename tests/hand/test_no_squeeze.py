"""A hand that was told nothing that squeezes: said first, and only a squeeze is tried. No load is said first, too."""

from __future__ import annotations

import pytest

import handlcp as hl

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
