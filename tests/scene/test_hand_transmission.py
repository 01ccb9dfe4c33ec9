"""Tendons and synergies from a scene file: the hand that the same calls in Python give, or the key that is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from handlcp import Synergies, Tendons
from handlcp.errors import HandLCPError
from handlcp.hand import HandGrasp, example_hand
from handlcp.scene import read
from tests.support.hand import is_one_spring_a_joint
from tests.support.scene_texts import BOX_IN_TWO_FINGERS

HEAD = f"""
[grasp]
preload_m = 5e-3
{BOX_IN_TWO_FINGERS}
"""
TENDONS = """
[hand.tendons]
stiffness_N_per_m = {left = 2e4, right = 3e4}
passive_Nm_per_rad = 0.5
[hand.tendons.moment_arms_m]
left = {finger_1_proximal = 0.01, finger_1_distal = 0.006}
right = {finger_2_proximal = 0.01, finger_2_distal = 0.006}
"""
SYNERGIES = """
[hand.synergies]
columns = {grip = {finger_1_proximal = 1.0, finger_1_distal = 0.5, finger_2_proximal = 1.0, finger_2_distal = 0.5}}
stiffness_Nm_per_rad = 3.0
joint_stiffness_Nm_per_rad = 8.0
"""


@pytest.mark.parametrize(
    ("text", "made"),
    [
        (TENDONS, Tendons([[0.01, 0.006, 0, 0], [0, 0, 0.01, 0.006]], [2e4, 3e4], 0.5)),
        ("[hand.tendons]\nmoment_arms_m = [[0.01, 0.0, 0.0, 0.02]]\nstiffness_N_per_m = 1e4\npassive_Nm_per_rad = 1",
         Tendons([[0.01, 0, 0, 0.02]], 1e4, 1.0)),
        (SYNERGIES, Synergies([[1.0], [0.5], [1.0], [0.5]], 3.0, 8.0)),
        ("[hand.synergies]\ncolumns = [[1, 0, 1, 0], [0, 1, 0, 1]]\nstiffness_Nm_per_rad = [2.0, inf]",
         Synergies([[1.0, 0], [0, 1], [1, 0], [0, 1]], [2.0, np.inf])),
    ],
)  # fmt: skip
def test_a_scene_file_makes_the_hand_that_the_calls_make(text: str, made: object) -> None:
    grasp = read(HEAD + text).build()
    assert isinstance(grasp, HandGrasp)
    expected = example_hand("two_finger", joint_stiffness=made)
    np.testing.assert_array_equal(grasp.state.hand.joint_compliance, expected.joint_compliance)
    assert not is_one_spring_a_joint(grasp.state.hand)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (TENDONS.replace("2e4", "-1"), "hand.tendons.stiffness_N_per_m['left']"),
        (TENDONS.replace("{left = 2e4, right = 3e4}", "{left = 2e4}"), "hand.tendons.stiffness_N_per_m"),
        (TENDONS.replace("left = {finger_1", "left = {thumb_1"), "hand.tendons.moment_arms_m['left']"),
        (TENDONS.replace("0.5", "0"), "hand.tendons.passive_Nm_per_rad"),
        (TENDONS.replace("stiffness_N_per_m", "stiffness"), "hand.tendons.stiffness"),
        ("[hand.tendons]\nstiffness_N_per_m = 1", "hand.tendons.moment_arms_m"),
        ("[hand.tendons]\nstiffness_N_per_m = 1\nmoment_arms_m = [[1], [1, 2]]", "hand.tendons.moment_arms_m"),
        ("[hand.synergies]\nstiffness_Nm_per_rad = 1\ncolumns = [[1], [1, 2]]", "hand.synergies.columns"),
        (SYNERGIES.replace("finger_1_distal", "elbow"), "hand.synergies.columns['grip']"),
        (SYNERGIES.replace("8.0", "[1.0]"), "hand.synergies.joint_stiffness_Nm_per_rad"),
        (SYNERGIES + TENDONS, "hand.tendons"),
        ("joint_stiffness_Nm_per_rad = 1.0" + SYNERGIES, "hand.synergies"),
    ],
)
def test_what_is_wrong_names_its_key(text: str, key: str) -> None:
    with pytest.raises(HandLCPError) as e:
        read(HEAD + text).build()
    errors = getattr(e.value, "each", (e.value,))
    assert key in [e.argument for e in errors]
