"""Squeeze given in joint space: its sign, its size, that it is data alone, and that streams and changes keep it."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from handlcp import Contact, GraspStream
from handlcp.errors import InputError, UnknownName
from handlcp.geometry import Sphere
from handlcp.hand import example_hand
from handlcp.scene import read
from tests.support import patches, texts
from tests.support.grasp import arrays
from tests.support.hand import deflection
from tests.support.scene_texts import BOX_IN_TWO_FINGERS

from .levers import PAD, C, K, L, lever_hand, lever_pinch

Writer = Callable[[str], Path]
BALL = Sphere(0.03, (0.001, -0.002, 0.09), mass=0.03)
EXACT = {"rtol": 1e-9, "atol": 1e-15}


@pytest.mark.parametrize("faces", [4, 8, "cone"])
def test_flexing_a_pinch_inwards_preloads_it(write, faces):
    """Either tip would go L δq inwards; the springs K behind lever L and the pads take that up: N = L δq / C."""
    s = lever_pinch(lever_hand(write), joint_offset=[0.1, 0.1]).solve(faces)
    np.testing.assert_allclose(s.normal_force, L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.torques, L * L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.joint_deflection, L * L * 0.1 / C / K, **EXACT)
    np.testing.assert_allclose(s.object_displacement, [0, 0, -0.5 * PAD, 0, 0, 0], atol=1e-15)


def test_outwards_it_opens_the_contacts(write):
    """The tips go away by L δq, and nothing holds the object."""
    grasp = lever_pinch(lever_hand(write), joint_offset=[-0.1, -0.1])
    np.testing.assert_allclose(grasp.offset, [[0, 0, 0.1 * L]] * 2, **EXACT)
    assert not grasp.solve(throw=False).held


def test_one_joint_squeezes_both_and_moves_the_object(write):
    """N = L δq / (2 C) on both sides, and the object gives way to the finger that pushes, by C N."""
    s = lever_pinch(lever_hand(write), joint_offset={"left_joint": 0.1}).solve()
    np.testing.assert_allclose(s.normal_force, 0.5 * L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.object_displacement[0], 0.5 * L * 0.1, **EXACT)


def test_sideways_it_drags_the_object_along():
    """It has tangential parts, too: -J δq along all three axes, and the tips' own offset does the same."""
    five = example_hand("five_finger")
    state = five.at(five.close_on(BALL, squeeze=4e-3))
    command = np.random.default_rng(0).normal(size=five.nv) * 0.02
    given = state.grasp(BALL, joint_offset=command)
    plain = state.grasp(BALL)
    tips = state.grasp(BALL, offset=-(plain.jacobian @ command).reshape(-1, 3))
    assert abs(tips.offset[:, :2]).max() > 1e-4
    np.testing.assert_allclose(given.offset, tips.offset, atol=1e-18)
    np.testing.assert_allclose(given.solve().forces, tips.solve().forces, atol=1e-12)
    np.testing.assert_allclose(given.tip_offset, plain.offset, atol=1e-18)


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


def test_it_is_data_not_unknowns_and_explain_says_so(write):
    hand = lever_hand(write)
    absent, given = lever_pinch(hand, preload=1e-3), lever_pinch(hand, preload=1e-3, joint_offset=[0.0, 0.1])
    assert given.effects == ()
    a, b = absent.problem(), given.problem()
    assert a.groups == b.groups
    np.testing.assert_allclose(a.M, b.M, atol=1e-12 * abs(a.M).max())
    on = {line.title: line for line in given.explain().effects}["commanded joint offset"]
    assert (on.on, on.cost) == (True, 0)
    texts.says(on.why, "right_joint +0.1 rad")
    off = {line.title: line for line in absent.explain("cone").effects}["commanded joint offset"]
    assert not off.on
    texts.says(off.why, "given")
    assert "commanded joint offset: right_joint +0.1 rad" in str(given.explain("cone"))


@pytest.mark.parametrize("nothing", [None, {}, [0.0, 0.0], {"left_joint": 0.0}])
def test_none_changes_no_bit(write, nothing):
    hand = lever_hand(write)
    a, b = lever_pinch(hand, preload=1e-3).problem(), lever_pinch(hand, preload=1e-3, joint_offset=nothing).problem()
    np.testing.assert_array_equal(a.scaled.M, b.scaled.M)
    np.testing.assert_array_equal(a.scaled.q, b.scaled.q)


def test_virtual_work_of_what_the_motors_put_in(write):
    """Nothing slides: w·u = r·E r - τ·δq. What the command puts in is the torque's work on it."""
    command = np.array([0.12, 0.05])
    g = lever_pinch(lever_hand(write), joint_offset=command, force=(0.4, 0, -1.0))
    s = g.solve()
    r = s.forces.ravel()
    load = np.array([0.4, 0, -1.0]) @ s.object_displacement[:3]
    assert load == pytest.approx(r @ arrays(g).flexibility @ r - s.torques @ command, rel=1e-9)


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


def test_a_stream_follows_it(five):
    q = five.close_on(BALL, squeeze=3e-3)
    contacts = five.at(q).grasp(BALL).contacts
    rng = np.random.default_rng(0)
    fixed = {"wrench": (0, 0, -0.3, 0, 0, 0), "preload": 2e-3}
    command = rng.uniform(0.0, 0.02, five.nv)
    stream = GraspStream(five.at(q).grasp(contacts, joint_offset=command, **fixed))

    def same(update, command, posture, **fixed):
        made = five.at(posture).grasp(contacts, joint_offset=command, **fixed)
        np.testing.assert_allclose(stream.grasp.offset, made.offset, atol=1e-17)
        np.testing.assert_allclose(update.forces, made.solve().forces, atol=1e-8)
        np.testing.assert_array_equal(stream.grasp.joint_offset, command)

    same(stream.update(), command, q, **fixed)
    for _ in range(5):  # the offset follows the posture
        q = q + rng.normal(size=five.nv) * 3e-3
        same(stream.update(q), command, q, **fixed)
    command = command + 0.01
    same(stream.update(joint_offset=command), command, q, **fixed)
    offset = np.tile([0.0, 0.0, -1e-3], (5, 1))
    fixed["preload"] = 1e-3
    same(stream.update(offset=offset), command, q, **fixed)
    same(stream.update(q, joint_offset=np.zeros(five.nv)), np.zeros(five.nv), q, **fixed)


def test_fingers_that_sag_are_commanded_too(five, monkeypatch):
    """-J δq and J K⁻¹ g(q) both come on top of what is given; changes and streams keep both."""
    q = five.close_on(BALL, squeeze=3e-3)
    contacts = five.at(q).grasp(BALL).contacts
    fixed = {"wrench": (0, 0, -0.3, 0, 0, 0), "finger_weight": True}
    one, other = np.full((2, five.nv), 0.01) * [[1.0], [1.5]]

    def made(posture, command, preload):
        return five.at(posture).grasp(contacts, joint_offset=command, preload=preload, **fixed)

    def same(grasp, other):
        np.testing.assert_allclose(grasp.offset, other.offset, atol=1e-17)
        np.testing.assert_allclose(grasp.tip_offset, other.tip_offset, atol=1e-17)

    grasp, sagging = made(q, one, 2e-3), made(q, None, 2e-3)
    np.testing.assert_allclose(grasp.tip_offset, [[0, 0, -2e-3]] * 5, atol=1e-17)
    shift = sagging.offset - (grasp.jacobian @ one).reshape(-1, 3)
    np.testing.assert_allclose(grasp.offset, shift, atol=1e-17)
    a, b = grasp.solve(), sagging.solve()
    expected = deflection(five, a.forces.reshape(-1) @ grasp.jacobian) + grasp.sag
    np.testing.assert_allclose(a.joint_deflection, expected, atol=1e-15)
    assert abs(a.forces - b.forces).max() > 1e-2
    same(grasp.replace(preload=1e-3), made(q, one, 1e-3))
    same(grasp.replace(joint_offset=other), made(q, other, 2e-3))
    same(grasp.replace(joint_offset=other, preload=1e-3), made(q, other, 1e-3))
    patches.shares_of_a_quarter(monkeypatch)
    on = {line.title for line in grasp.explain(measure=True).effects if line.share is not None}
    assert {"commanded joint offset", "finger weight"} <= on
    stream = GraspStream(grasp)
    q = q + 2e-3
    update = stream.update(q)
    same(stream.grasp, made(q, one, 2e-3))
    np.testing.assert_allclose(update.forces, made(q, one, 2e-3).solve().forces, atol=1e-8)
    stream = pickle.loads(pickle.dumps(stream))
    stream.update(joint_offset=other, offset=[[0, 0, -1e-3]] * 5)
    same(stream.grasp, made(q, other, 1e-3))
    stream.update(joint_offset={})
    same(stream.grasp, made(q, None, 1e-3))


@pytest.mark.parametrize(
    ("bad", "kind", "argument"),
    [
        ([0.1], InputError, "joint_offset"),
        ([0.1, np.nan], InputError, "joint_offset"),
        (0.1, InputError, "joint_offset"),
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


def test_in_a_plane_only_what_lies_in_it_counts():
    """A joint that moves the tips out of the plane squeezes nothing."""
    hand = example_hand("five_finger", joint_stiffness=5.0)
    state = hand.at(np.full(hand.nv, 0.4))
    p = state.tip_positions[:2] * (1, 1, 0)
    normal = (p[1] - p[0]) / np.linalg.norm(p[1] - p[0])
    contacts = [Contact(p[0], normal), Contact(p[1], -normal)]
    fingers = hand.fingertips[:2]
    g = state.grasp(contacts, fingers=fingers, plane=(0, 0, 1), joint_offset=np.full(hand.nv, 0.02))
    across = (g.jacobian @ g.joint_offset).reshape(-1, 3)
    assert abs(across[:, 1]).max() > 1e-5
    np.testing.assert_array_equal(g.offset[:, 1], 0.0)
    np.testing.assert_allclose(g.offset[:, [0, 2]], -across[:, [0, 2]], atol=1e-18)
    np.testing.assert_allclose(g.tip_offset, 0.0, atol=1e-18)
