"""Doubts about tendons: arms and places that are hardly in metres, and tendons that move nothing."""

from __future__ import annotations

import pytest

import handlcp as hl
from handlcp.robot.audit import doubt_reasons

JOINT, LINKS = "finger_1_distal", ("finger_1_proximal_link", "finger_1_distal_link")


def route(*points):
    return hl.Route([hl.Site(link, (x, 0.0, 0.01)) for link, x in points])


def doubts(row):
    tendons = hl.Tendons({"pull": row, "good": {JOINT: 0.01}}, 2e4, 4.0)
    return [d for d in hl.example_hand("three_finger", joint_stiffness=tendons).audit() if d.about == "tendon arms"]


@pytest.mark.parametrize(
    ("row", "severity", "words"),
    [
        ({JOINT: -12.0}, "serious", "a moment arm of 12 m"),
        (route((LINKS[0], 20.0), (LINKS[1], 20.0)), "serious", "a place 20 m from the frame of its link"),
        (route((LINKS[0], 0.01), (LINKS[0], 0.02)), "minor", "moves no joint"),
    ],
)
def test_tendons_that_cannot_be_meant_are_doubted(row, severity, words):
    found = doubts(row)
    assert {(d.joint, d.severity) for d in found} == {("pull", severity)}
    assert any(words in d.what for d in found)


@pytest.mark.parametrize("row", [{JOINT: -0.15}, route((LINKS[0], 0.01), (LINKS[1], 0.01))])
def test_tendons_of_hands_are_not(row):
    assert not doubts(row)


def test_such_arms_are_a_warning_beside_a_verdict():
    hand = hl.example_hand("three_finger", joint_stiffness=hl.Tendons({"pull": {JOINT: 10.0}}, 2e4, 4.0))
    (reason,) = doubt_reasons(hand.doubts)
    assert (reason.code, reason.severity) == ("hand_doubtful", "warning")
    assert "pull: a moment arm of 10 m, as if millimetres were taken for metres" in reason.sentence
