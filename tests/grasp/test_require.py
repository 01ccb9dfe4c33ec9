"""A verdict says in one line what decides it, and may be required: what pytest shows is the reason."""

import pickle
from functools import cache

import pytest

import handlcp as hl

CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
_SHOWN = 240  # characters of a value that pytest shows of a failed assertion


@cache
def verdict(limits):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=limits)
    return hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=0.8, squeeze=0.005).check()


def test_the_repr_is_the_sentence_and_what_decides_stands_where_pytest_cuts():
    v = verdict(0.2)
    (decides,) = [r for r in v.reasons if r.severity == "decides"]
    assert repr(v).startswith(f"OVER LIMIT: {decides.sentence}")
    assert "finger_1_proximal" in repr(v)[: _SHOWN // 2]
    assert "\n" not in repr(v)
    assert repr(verdict(0.8)).startswith("HELD: ")


def test_a_held_grasp_gives_its_verdict_back():
    assert verdict(0.8).require() is verdict(0.8)


def test_one_that_is_not_held_raises_with_its_sentence_and_advice():
    v = verdict(0.2)
    with pytest.raises(hl.RequirementNotMet, match=r"^OVER LIMIT: the contacts could hold the object") as caught:
        v.require()
    assert isinstance(caught.value, hl.HandLCPError)
    assert "Advice: " in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_of_an_evaluation_the_reason_stands_before_the_counts_of_the_search():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    found = hl.find_grasp(hand, hl.Sphere(0.2, mass=0.2), tries=2, throw=False)
    assert not len(found)
    reason, counts = found.why.index("found: "), found.why.index(" sampled, ")
    assert found.why[reason:counts].count("(") >= 1
    assert found.why[reason + len("found: ")].isalpha(), "no number"
    assert found.why.endswith(")")
