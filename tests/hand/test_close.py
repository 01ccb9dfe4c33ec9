"""Closing the hand: touching to tolerance, inside the ranges, the same every time, honest about what never reaches."""

from __future__ import annotations

import re

import numpy as np
import pytest

from handlcp.errors import InputError, NotReached, UnknownName
from handlcp.geometry import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.hand import example_hand
from tests.support.grasp import arrays
from tests.support.hand import gaps
from tests.support.texts import says

from .test_objects import box_file


@pytest.mark.parametrize("name", ["two_finger", "three_finger", "five_finger"])
@pytest.mark.parametrize("shape", ["sphere", "cylinder", "ellipsoid", "box", "mesh"])
def test_upright_hands_touch(name, shape, tmp_path):
    """Every upright hand closes on every kind of object to the tolerance, inside its joint ranges."""
    at = (0.002, -0.001, 0.085)
    obj = {
        "sphere": lambda: Sphere(0.03, at),
        "cylinder": lambda: Cylinder(0.025, 0.08, at),
        "ellipsoid": lambda: Ellipsoid((0.025, 0.02, 0.03), at),
        "box": lambda: Box((0.03, 0.035, 0.06), at),
        "mesh": lambda: Mesh(box_file(tmp_path, np.array([0.03, 0.035, 0.06])), 1.0, at),
    }[shape]()
    hand = example_hand(name)
    q = hand.close_on(obj)
    assert abs(gaps(hand, q, obj)).max() <= 1e-6
    assert (q >= hand.lower).all()
    assert (q <= hand.upper).all()
    np.testing.assert_array_equal(hand.close_on(obj), q)  # deterministic, bit by bit
    assert arrays(hand.at(q).grasp(obj)).n == len(hand.fingertips)


def test_the_ring_closes_on_a_disc():
    """Six fingers in a plane, from straight (a dead point: no joint moves the tip inward) and from bent."""
    hand = example_hand("planar_ring")
    disc = Cylinder(0.03, 0.02)
    for q0 in (hand.neutral, np.tile([0.5, -0.9], 6)):
        q = hand.close_on(disc, q0)
        assert abs(gaps(hand, q, disc)).max() <= 1e-6
        assert abs(hand.at(q).tip_positions[:, 2]).max() < 1e-12


def test_allegro_and_psyonic_close():
    """Four joints a finger with a posture outside the ranges to start from; and coupled fingers on a bar."""
    allegro = example_hand("allegro")
    ball = Sphere(0.035, (0.06, 0.0, 0.07))
    q = allegro.close_on(ball, np.zeros(16), fingers=["link_3.0_tip", "link_7.0_tip", "link_11.0_tip"])
    assert abs(gaps(allegro, q, ball)[:3]).max() <= 1e-6
    assert (q[allegro.joint_names.index("joint_12.0")]) == pytest.approx(0.263)  # zero is outside its range
    psyonic = example_hand("psyonic")
    tips = psyonic.at(psyonic.neutral + 0.4 * (psyonic.upper > 1)).tip_positions
    bar = Sphere(0.01, tips[1])
    q = psyonic.close_on(bar, fingers=["Left_index_anchor"])
    assert abs(gaps(psyonic, q, bar)[1]) <= 1e-6


def test_squeeze_is_overlap(five):
    """Squeezing by 3 mm leaves each tip 3 mm inside."""
    ball = Sphere(0.03, (0, 0, 0.09))
    np.testing.assert_allclose(gaps(five, five.close_on(ball, squeeze=3e-3), ball), -3e-3, atol=1e-6)


def test_other_fingers_stay(five):
    """Only the named fingers move."""
    q0 = np.full(10, 0.1)
    q = five.close_on(Sphere(0.03, (0, 0, 0.09)), q0, fingers=["finger_2_tip"])
    moved = {name for name, a, b in zip(five.joint_names, q, q0, strict=True) if a != b}
    assert moved == {"finger_2_proximal", "finger_2_distal"}


def test_unreachable_fingers_are_named_with_what_is_left(five):
    """An object on one side: the near fingers touch, the far ones are reported with gaps and posture."""
    ball = Sphere(0.01, (0.045, 0.0, 0.1))
    with pytest.raises(NotReached) as caught:
        five.close_on(ball)
    error = caught.value
    assert "finger_1_tip" not in error.gaps
    assert {"finger_3_tip", "finger_4_tip"} <= set(error.gaps)
    q = error.q
    left = gaps(five, q, ball)
    for name, gap in error.gaps.items():
        assert left[five.fingertips.index(name)] == pytest.approx(gap, abs=1e-12)
    assert (q >= five.lower).all()
    assert (q <= five.upper).all()
    with pytest.raises(NotReached):
        five.close_on(Sphere(0.01, (1.0, 0.0, 0.0)))


def test_two_points_on_one_finger_are_said_to_share_its_joints():
    """The link in the middle has no joint of its own: with it the whole finger would move."""
    hand = example_hand(
        "three_finger", joint_stiffness=6.0, fingertips=["finger_1_tip", "finger_1_proximal_link", "finger_2_tip"]
    )
    with pytest.raises(NotReached) as caught:
        hand.close_on(Sphere(0.02, (0.0, 0.0, 0.09)))
    assert "finger_1_proximal_link" in caught.value.gaps
    without = re.sub(r", got .*", "", str(caught.value))
    says(without, "no joint moves finger_1_proximal_link without finger_1_tip")
    with pytest.raises(NotReached) as alone:  # fingers with joints of their own are out of reach, and nothing else
        hand.close_on(Sphere(0.01, (1.0, 0.0, 0.0)), fingers=["finger_2_tip"])
    assert "without" not in str(alone.value)


@pytest.mark.parametrize(
    ("arguments", "argument", "kind"),
    [
        ({"obj": "ball"}, "obj", InputError),
        ({"q0": [0.0]}, "q0", InputError),
        ({"q0": np.full(10, np.nan)}, "q0", InputError),
        ({"squeeze": -1.0}, "squeeze", InputError),
        ({"tolerance": 0.0}, "tolerance", InputError),
        ({"fingers": ["thumb"]}, "fingers", UnknownName),
        ({"fingers": "finger_1_tip"}, "fingers", InputError),
        ({"fingers": []}, "fingers", InputError),
    ],
)
def test_bad_arguments_are_named(five, arguments, argument, kind):
    """One broken argument a time."""
    obj = arguments.pop("obj", Sphere(0.03, (0, 0, 0.09)))
    with pytest.raises(kind) as caught:
        five.close_on(obj, **arguments)
    assert caught.value.argument == argument
