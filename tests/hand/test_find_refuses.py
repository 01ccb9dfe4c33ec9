"""What a search passes on is checked before it begins: a typo is bad input, and never "no grasp"."""

from __future__ import annotations

import re

import numpy as np
import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.errors import InputError

BALL = hl.Sphere(0.03, mass=0.2)
NO_SIZES = ["abc", True, float("nan"), -1, [1.0, 2.0], {"finger_9": 0.01}, {"finger_1_tip": "much"}, np.array(["a"])]
CALLS = {
    "squeeze": ("pinch", [*NO_SIZES, 3.0]),  # 3 m
    "grip_force": ("pinch", NO_SIZES),
    "closing_torque": ("power", NO_SIZES),
    "friction": ("any", ["abc", True, float("nan"), -1]),
}
CASES = [(argument, kind, value) for argument, (kind, values) in CALLS.items() for value in values]


@pytest.fixture(scope="module")
def hand():
    return hl.example_hand("three_finger", joint_stiffness=5.0)


@pytest.mark.parametrize(("argument", "kind", "value"), CASES)
def test_what_says_no_size_is_refused_by_find_grasp_and_evaluate(hand, argument, kind, value):
    with pytest.raises(InputError, match=f"^{argument}"):
        hl.find_grasp(hand, BALL, kind=kind, tries=2, throw=False, **{argument: value})
    with pytest.raises(InputError, match=f"^{argument}"):
        hl.evaluate(hand, hl.Brief(BALL, kind=kind, tries=2, **{argument: value}))


@pytest.mark.parametrize(
    ("argument", "value"), [*((a, v) for a, _, v in CASES if not isinstance(v, (list, dict)))], ids=str
)
def test_a_brief_refuses_what_is_no_size_for_any_hand(argument, value):
    with pytest.raises(InputError, match=f"^{argument}"):
        hl.Brief(BALL, kind=CALLS[argument][0], **{argument: value})


def test_a_neighbour_does_not_hide_a_typo(hand):
    """A grasp that is brought along is made with what the brief says, too."""
    near = hl.evaluate(hand, hl.Brief(BALL, tries=2))
    with pytest.raises(InputError, match="did you mean 'finger_1_tip'"):
        hl.evaluate(hand, hl.Brief(BALL, tries=2, grip_force={"finger_1_tipp": 3.0}), near)


@pytest.mark.parametrize("call", [hl.find_grasp, lambda hand, obj: hl.evaluate(hand, hl.Brief(obj))])
def test_an_object_in_millimetres_is_refused_before_anything_is_tried(hand, call):
    with pytest.raises(InputError, match="are these millimetres"):
        call(hand, hl.Sphere(30.0, mass=0.2))


def test_a_wrench_that_is_none_is_refused(hand):
    with pytest.raises(InputError, match=r"^wrench"):
        hl.find_grasp(hand, BALL, wrench=(0, 0, -1), tries=2, throw=False)


@pytest.mark.parametrize(
    "ask",
    [
        lambda hand: hl.find_grasp(hand, BALL, gravity=9.81),
        lambda hand: hand.at(hand.neutral).gravity_torque(9.81),
        lambda hand: hand.at(hand.neutral).grasp(BALL, gravity=9.81, max_gap=1.0),
    ],
)
def test_a_size_of_gravity_offers_a_vector(hand, ask):
    with pytest.raises(InputError, match=re.escape("got 9.81 (is (0, 0, -9.81) meant?)")):
        ask(hand)


def test_a_gravity_beyond_all_floating_point_numbers_is_refused(hand):
    with pytest.raises(InputError, match=r"^gravity: expected an acceleration"):
        hand.at(hand.neutral).gravity_torque(10**400)


@pytest.mark.parametrize(
    "line", ['grip_force_N = { finger_9 = 3.0 }', "grip_force_N = -1.0", "squeeze_m = 3.0", "squeeze_m = nan",
             'kind = "power"\nclosing_torque_Nm = { thumb = 1.0 }', "grip_force_N = true"],
)  # fmt: skip
def test_on_the_command_line_it_is_bad_input_and_not_a_hand_that_fails(tmp_path, line):
    file = tmp_path / "brief.toml"
    file.write_text(f'{line}\ntries = 2\n[object]\nshape = "sphere"\nradius_m = 0.03\nmass_kg = 0.2\n')
    done = CliRunner().invoke(app, ["evaluate", "three_finger", str(file)])
    assert done.exit_code == 2
    assert "NOT FOUND" not in done.output
