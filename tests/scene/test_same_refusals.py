"""A bad value is refused alike wherever it comes in: a call in Python, a change of a grasp, a scene file, a brief."""

from __future__ import annotations

import inspect
import json
import re

import numpy as np
import pytest

import handlcp as hl
from handlcp.scene import keys, read

UNIT = re.compile(r"_(kg_per_m3|m_per_s2|m_per_N|N_per_Nm|N_per_m|Nm_per_rad|rad_per_Nm|kg|rad|Nm|N|m|s)$")

SCENE = """
[hand]
name = "three_finger"
joint_stiffness_Nm_per_rad = 6.0
[object]
shape = "box"
size_m = 0.05
position_m = [0.0, 0.0, 0.08]
[grasp]
"""
CUBE = hl.Box(0.05, placement=(0, 0, 0.08))
BAD_BY_TIP = [-1.0, np.inf, "deep", True, [-1.0, 1.0, 1.0], [[1.0]], {"finger_1_tip": -1.0}, {"finger_1_tip": "x"}]
BAD_ARGUMENTS = [
    *[(key, bad) for key in ("squeeze_m", "grip_force_N") for bad in BAD_BY_TIP],
    *[("closing_torque_Nm", bad) for bad in (-1.0, "x", [[1.0]], {"finger_1_distal": "x"})],
    *[("joint_offset_rad", bad) for bad in (0.1, "x", [[1.0]], {"finger_1_distal": "x"}, {"finger_1_distal": np.inf})],
    ("squeeze_m", 5.0),
]


@pytest.fixture(scope="module")
def touching():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    return hand.at(hand.close_on(CUBE)).grasp(CUBE)


def argument_of(key):
    return UNIT.sub("", key)


def toml(value):
    """The value as TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + " }"
    return str(value) if isinstance(value, float) and not np.isfinite(value) else json.dumps(value)


def refused(call):
    """The argument, what was expected, and what came: a grasp keeps lists as tuples."""
    with pytest.raises(hl.InputError) as caught:
        call()
    came = str(caught.value.got).replace("(", "[").replace(",)", "]").replace(")", "]")
    return caught.value.argument, caught.value.expected, came


@pytest.mark.parametrize(("key", "bad"), BAD_ARGUMENTS)
def test_a_bad_value_is_refused_alike_in_python_in_a_change_and_in_a_scene_file(touching, key, bad):
    argument = argument_of(key)
    called = refused(lambda: touching.state.grasp(CUBE, **{argument: bad}))
    changed = refused(lambda: touching.replace(**{argument: bad}))
    written = refused(lambda: read(f"{SCENE}{key} = {toml(bad)}"))
    assert changed == called
    assert written == (called[0].replace(argument, f"grasp.{key}", 1), *called[1:])


@pytest.mark.parametrize(
    ("key", "bad"),
    [
        ("acceleration_m_per_s2", -1.0), ("motion_m", 0.0), ("most_force_N", "x"), ("safety", True), ("tries", 0),
        ("seed", -1), ("tries", 1.5), ("squeeze_m", -1.0), ("grip_force_N", {"tip": -1.0}), ("grip_force_N", "x"),
    ],
)  # fmt: skip
def test_a_brief_refuses_alike_in_python_and_in_a_file(tmp_path, key, bad):
    argument, file = argument_of(key), tmp_path / "brief.toml"
    file.write_text(f"{key} = {toml(bad)}\n[object]\nshape = 'sphere'\nradius_m = 0.03\n")
    called = refused(lambda: hl.Brief(hl.Sphere(0.03), **{argument: bad}))
    written = refused(lambda: hl.Brief.from_toml(file))
    assert written == (called[0].replace(argument, key, 1), *called[1:])


@pytest.mark.parametrize(
    ("table", "call", "left_out"),
    [
        ("grasp", hl.HandState.grasp, {"flexibility"}),
        ("hand.motor", hl.Motor, set()),
        ("hand.tendons", hl.Tendons, set()),
        ("hand", hl.Hand.from_urdf, {"name", "urdf"}),
    ],
)
def test_every_key_is_an_argument_of_what_it_is_passed_to(table, call, left_out):
    """And so a key that is added needs no list besides."""
    taken = set(inspect.signature(call).parameters)
    assert {argument_of(key.key) for key in keys() if key.table == table} - taken == left_out


def test_no_two_keys_of_a_table_are_one_argument():
    for table in {key.table for key in keys()}:
        named = [argument_of(key.key) for key in keys() if key.table == table and key.shape in ("", "box")]
        assert len(set(named)) == len(named)
