"""How hard the hand of a scene file closes: one of three keys of [grasp], or [posture]; by number or by finger."""

import numpy as np
import pytest

from handlcp.errors import InputError, SceneFileError, UnknownName
from handlcp.geometry import Box
from handlcp.hand import example_hand
from handlcp.scene import read
from tests.support.scene_texts import BOX_IN_TWO_FINGERS

BOX = Box((0.03, 0.04, 0.06), (0, 0, 0.08))


def touching():
    hand = example_hand("two_finger")
    return hand.at(hand.close_on(BOX))


@pytest.mark.parametrize(
    ("line", "argument", "value"),
    [
        ("squeeze_m = 0.002", "squeeze", 0.002),
        ("squeeze_m = [0.002, 0.001]", "squeeze", [0.002, 0.001]),
        ("squeeze_m = { finger_2_tip = 0.002 }", "squeeze", [0.0, 0.002]),
        ("grip_force_N = 2", "grip_force", 2.0),
        ("grip_force_N = { finger_1_tip = 2.0, finger_2_tip = 1.5 }", "grip_force", [2.0, 1.5]),
        ("joint_offset_rad = { finger_1_distal = 0.1 }", "joint_offset", {"finger_1_distal": 0.1}),
    ],
)
def test_each_key_is_the_argument_of_its_name(line, argument, value):
    grasp = read(f"{BOX_IN_TWO_FINGERS}[grasp]\n{line}").build()
    expected = touching().grasp(BOX, **{argument: value})
    assert expected.joint_offset.any()
    np.testing.assert_array_equal(grasp.joint_offset, expected.joint_offset)
    np.testing.assert_array_equal(grasp.offset, expected.offset)


def test_closing_deeper_by_finger_and_squeezing_by_finger_have_the_same_forces_to_first_order():
    by_finger = "squeeze_m = {{ finger_1_tip = {0}, finger_2_tip = {1} }}"
    for size, within in ((1e-3, 0.02), (1e-4, 0.002)):
        line = by_finger.format(2 * size, size)
        closed = read(f"{BOX_IN_TWO_FINGERS}[posture]\n{line}").solve()
        told = read(f"{BOX_IN_TWO_FINGERS}[grasp]\n{line}").solve()
        np.testing.assert_allclose(closed.normal_force, told.normal_force, rtol=within)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("[grasp]\nsqueeze_m = 0.001\ngrip_force_N = 1.0", "grasp.grip_force_N"),
        ("[grasp]\ngrip_force_N = 1.0\njoint_offset_rad = { finger_1_distal = 0.1 }", "grasp.joint_offset_rad"),
        ("[posture]\nsqueeze_m = 0.001\n[grasp]\nsqueeze_m = 0.002", "posture.squeeze_m"),
        ("[posture]\nsqueeze_m = 0.001\n[grasp]\ngrip_force_N = 2", "posture.squeeze_m"),
        ("[grasp]\nsqueeze_m = -0.001", "grasp.squeeze_m"),
        ("[grasp]\ngrip_force_N = 'hard'", "grasp.grip_force_N"),
        ("[posture]\nsqueeze_m = [0.001, -0.001]", "posture.squeeze_m"),
    ],
)
def test_what_contradicts_itself_or_makes_no_sense_is_refused_by_its_key(text, key):
    with pytest.raises(SceneFileError) as e:
        read(BOX_IN_TWO_FINGERS + text)
    assert e.value.argument == key


@pytest.mark.parametrize(
    ("text", "key", "kind"),
    [
        ("[grasp.squeeze_m]\nthumb = 0.001", "grasp.squeeze_m", UnknownName),
        ("[grasp.grip_force_N]\nthumb = 1.0", "grasp.grip_force_N", UnknownName),
        ("[posture.squeeze_m]\nthumb = 0.001", "posture.squeeze_m", UnknownName),
        ("[grasp]\nsqueeze_m = [0.001]", "grasp.squeeze_m", InputError),
        ("[posture]\nsqueeze_m = [0.001]", "posture.squeeze_m", InputError),
    ],
)
def test_refusals_of_the_package_name_the_key(text, key, kind):
    with pytest.raises(kind) as e:
        read(BOX_IN_TWO_FINGERS + text).build()
    assert e.value.argument == key
    assert str(e.value).startswith(f"{key}: ")
