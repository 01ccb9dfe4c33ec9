"""Squeeze given in joint space: its sign, its size, that it is data alone, and that streams and changes keep it."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from handlcp import GraspStream
from handlcp.errors import InputError, UnknownName
from handlcp.geometry import Sphere
from handlcp.hand import example_hand
from handlcp.scene import read
from tests.support.scene_texts import BOX_IN_TWO_FINGERS

from .levers import PAD, C, K, L, lever_hand, lever_pinch

BALL = Sphere(0.03, (0.001, -0.002, 0.09), mass=0.03)
EXACT = {"rtol": 1e-9, "atol": 1e-15}


@pytest.mark.parametrize("faces", [8, "cone"])
def test_flexing_a_pinch_inwards_preloads_it(write, faces):
    """Either tip would go L δq inwards; the springs K behind lever L and the pads take that up: N = L δq / C."""
    s = lever_pinch(lever_hand(write), joint_offset=[0.1, 0.1]).solve(faces)
    np.testing.assert_allclose(s.normal_force, L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.torques, L * L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.joint_deflection, L * L * 0.1 / C / K, **EXACT)
    np.testing.assert_allclose(s.object_displacement, [0, 0, -0.5 * PAD, 0, 0, 0], atol=1e-15)


def test_one_joint_squeezes_both_and_moves_the_object(write):
    """N = L δq / (2 C) on both sides, and the object gives way to the finger that pushes, by C N."""
    s = lever_pinch(lever_hand(write), joint_offset={"left_joint": 0.1}).solve()
    np.testing.assert_allclose(s.normal_force, 0.5 * L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.object_displacement[0], 0.5 * L * 0.1, **EXACT)


def test_to_first_order_it_is_the_overlap_of_the_posture_commanded():
    """Tips flexed further into a ball overlap it by more: by J δq along the normals, up to δq²."""
    five = example_hand("five_finger")
    state = five.at(five.close_on(BALL, squeeze=2e-3))
    errors = []
    for step in (1e-3, 5e-4):
        command = np.tile([step, 2 * step], 5)
        there = five.at(state.q + command).grasp(BALL).offset[:, 2]
        errors.append(abs(state.grasp(BALL, joint_offset=command).offset[:, 2] - there).max())
    assert errors[0] < 1e-5
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("nothing", [{}, [0.0, 0.0]])
def test_none_changes_no_bit(write, nothing):
    hand = lever_hand(write)
    a, b = lever_pinch(hand, preload=1e-3).problem(), lever_pinch(hand, preload=1e-3, joint_offset=nothing).problem()
    np.testing.assert_array_equal(a.scaled.M, b.scaled.M)
    np.testing.assert_array_equal(a.scaled.q, b.scaled.q)


def test_replacing_keeps_it_or_changes_it(write):
    hand = lever_hand(write)
    g = lever_pinch(hand, joint_offset=[0.1, 0.1])
    lifted = pickle.loads(pickle.dumps(g)).replace(wrench=(0, 0, -2, 0, 0, 0))
    np.testing.assert_allclose(lifted.solve().normal_force, L * 0.1 / C, **EXACT)
    more = g.replace(preload=1e-3)  # comes beside it, as in state.grasp
    np.testing.assert_allclose(more.offset, lever_pinch(hand, joint_offset=[0.1, 0.1], preload=1e-3).offset)
    half = more.replace(joint_offset={"left_joint": 0.05, "right_joint": 0.05})
    np.testing.assert_allclose(half.offset[:, 2], -1e-3 - 0.05 * L, **EXACT)
    np.testing.assert_allclose(half.tip_offset[:, 2], -1e-3, **EXACT)
    none = half.replace(joint_offset=[0, 0])
    np.testing.assert_allclose(none.offset[:, 2], -1e-3, **EXACT)
    extra = lever_pinch(hand, joint_offset=[0.01, 0.01], force=(0, 0, -8.0)).required_preload()
    # Followed, the levers turn a little; by hand they do not
    np.testing.assert_allclose(extra.value, 8 / (2 * 0.5) * C - 0.01 * L, rtol=1e-2)


@pytest.mark.parametrize(
    ("bad", "kind", "argument"),
    [
        ([0.1, np.nan], InputError, "joint_offset"),
        ({"left_joint": "a"}, InputError, "joint_offset['left_joint']"),
        ({"thumb": 0.1}, UnknownName, "joint_offset"),
    ],
)
def test_bad_commands_are_named(write, bad, kind, argument):
    hand = lever_hand(write)
    with pytest.raises(kind) as e:
        lever_pinch(hand, joint_offset=bad)
    assert e.value.argument == argument
    g = lever_pinch(hand, preload=1e-3)
    for change in (g.replace, lambda **more: GraspStream(g).update(**more)):
        with pytest.raises(kind):
            change(joint_offset=bad)


SCENE = f"""
{BOX_IN_TWO_FINGERS}
[grasp]
joint_offset_rad = {{finger_1_distal = 0.1, finger_2_distal = 0.1}}
"""


def test_a_scene_file_says_it_by_joint():
    grasp = read(SCENE).build()
    hand = grasp.state.hand
    assert dict(zip(hand.joint_names, grasp.joint_offset.tolist(), strict=True))["finger_2_distal"] == 0.1
    assert read(SCENE).solve().held
    with pytest.raises(UnknownName) as e:
        read(SCENE.replace("finger_2_distal", "thumb")).build()
    assert e.value.argument == "grasp.joint_offset_rad"
    contact = "[[contact]]\nposition_m = [0, 0, 0]\nnormal = [0, 0, 1]\n[grasp]\njoint_offset_rad = [0.1]"
    with pytest.raises(InputError, match=r"grasp\.joint_offset_rad: .*\[hand\]"):
        read(contact)
