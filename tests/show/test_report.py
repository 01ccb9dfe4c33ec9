"""The page of hands beside each other: what stands on it, and that nothing is loaded from anywhere."""

import re

import numpy as np
import pytest

import handlcp as hl
from handlcp.design.evaluation import ObjectCase
from handlcp.hand.vary.vary import hand_number, hand_numbers, number_unit
from handlcp.viz.picture.figure import draw_comparable_pictures
from handlcp.viz.report.report import compare_hands, describe_better_hands, mark_best
from tests.support.design import reported_by

BRIEF = hl.Brief({"a <b> ball": hl.Sphere(0.03, mass=0.1)}, loads={"pull": (1.0, 0, 0, 0, 0, 0)}, tries=3)
LONG = {f"finger_{k}_distal.length": 0.042 for k in (1, 2, 3)}


@pytest.fixture(scope="module")
def hands():
    one = hl.example_hand("three_finger")
    return {"short": one, "long & stiff": one.vary(LONG | {"joint_stiffness": 2.0})}


@pytest.fixture(scope="module")
def found(hands):
    return hl.evaluate(hands["short"], BRIEF)


@pytest.fixture(scope="module")
def page(hands, found, tmp_path_factory):
    """Neighbouring hands: the grasp of one is brought along, which takes less than a search."""
    with pytest.MonkeyPatch.context() as patch:
        reported_by(patch, lambda hand, brief: hl.evaluate(hand, brief, near=found))
        file = hl.report(hands, BRIEF, tmp_path_factory.mktemp("report") / "report.html")
    return file.read_text(encoding="utf-8")


def test_the_page_needs_nothing_else_and_escapes_names(page):
    assert not re.search(r"""(src|href)=["'](?!data:)|url\(|@import|<script""", page)
    assert "a &lt;b&gt; ball" in page
    assert "long &amp; stiff" in page
    assert "<b> ball" not in page
    assert "{{" not in page


def test_each_grasp_has_its_picture_and_each_object_and_load_its_row(page):
    assert page.count('src="data:image/png;base64,') == 2
    for row in ("weight", "pull", "payload", "largest force", "torque used", "moves"):
        assert page.count(f"<td>a &lt;b&gt; ball: {row}</td>") == 1
    assert "0.04 m" in page
    assert "0.042 m" in page


def test_what_differs_has_names_of_vary_with_the_values_of_each_hand(hands):
    rows = dict((row[0], row[1:]) for row in compare_hands(hands))
    (lengths,) = [values for what, values in rows.items() if what.startswith("length of finger_1_distal")]
    (springs,) = [values for what, values in rows.items() if what.startswith("stiffness of")]
    assert (lengths, springs) == (("0.04 m", "0.042 m"), ("1 N·m/rad", "2 N·m/rad"))
    assert "size" in rows
    assert compare_hands({"one": hands["short"], "other": hands["short"]}) == []


def test_what_was_not_followed_to_its_end_is_told_as_at_least(page):
    held = ObjectCase("HELD", {"weight": "HELD", "pull": "HELD"}, {"weight": 2.0, "pull": 2.5}, 0.4, "it slips")
    assert (held.times("weight"), held.times("pull"), held.mass) == ("2", "≥ 2.5", "0.4 kg")
    assert re.search(r"ball: (weight|pull)</td><td[^>]*>(≥ )?\d", page)


def test_the_numbers_of_a_hand_are_those_that_vary_gives_it(hands):
    numbers = hand_numbers(hands["short"])
    for name, value in numbers.items():
        assert hand_number(hands["short"].vary({name: 1.25 * value}), name) == pytest.approx(1.25 * value, rel=1e-12)
        assert number_unit(name)
    assert hand_number(hands["long & stiff"], "joint_stiffness") == 2.0
    with pytest.raises(hl.InputError, match="finger_1_proximal"):
        hand_number(hands["short"], "finger_9.length")


def test_only_numbers_that_differ_have_a_best():
    assert mark_best([1.0, 1.5, np.nan], True) == [False, True, False]
    assert mark_best([1.0, 1.5], False) == [True, False]
    assert mark_best([1.0, 1.005], True) == [False, False]
    assert describe_better_hands({}) == []


def test_a_hand_that_drops_its_object_sooner_is_not_called_gentler():
    def made(word, force):
        return hl.Evaluation({"box": ObjectCase(word, {}, {"weight": 2.0}, 0.4, "it slips", force=force, motion=0.0)})

    assert not any(
        "presses" in text for text in describe_better_hands({"a": made("HELD", 5.0), "b": made("NOT HELD", 2.0)})
    )
    told = describe_better_hands({"a": made("HELD", 5.0), "b": made("HELD", 2.0), "c": made("NOT HELD", 1.0)})
    assert "b presses less hard: a 5 N, b 2 N" in told


def test_a_grasp_that_there_is_none_of_has_no_picture_and_equal_ones_the_same(found):
    grasp = found.cases["a <b> ball"].candidate
    one, none, other = draw_comparable_pictures([grasp, None, grasp])
    assert none == b""
    assert one == other
    assert one.startswith(b"\x89PNG")


def test_what_is_no_hand_among_hands_is_named(hands, tmp_path):
    with pytest.raises(hl.InputError, match=r"hands\[1\]: expected a Hand, got 'x'"):
        hl.report([hands["short"], "x"], BRIEF, tmp_path / "report.html")
