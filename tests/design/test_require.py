"""What is required of an evaluation: limits of its numbers, and what is said of one that is not met."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import handlcp as hl
from handlcp.design.evaluation import NOT_FOUND, REQUIREMENT_UNITS, ObjectCase, parse_requirement
from tests.support.texts import says

FACTORS = {"weight": 4.0, "pull": 9.0}
BOX = ObjectCase("HELD", dict.fromkeys(FACTORS, "HELD"), FACTORS, 0.8, "the thumb slips", "pinch", False,
                 8.5, 0.31, 0.78, 0.0017)  # fmt: skip
BALL = ObjectCase("HELD", dict.fromkeys(FACTORS, "HELD"), {"weight": 3.0, "pull": 2.0}, 0.5, "the index slips", "pinch",
                  False, 3.3, 0.1, 0.25, 0.0021)  # fmt: skip
NONE = "no grasp of it found"
LOST = ObjectCase(NOT_FOUND, dict.fromkeys(FACTORS, NOT_FOUND), dict.fromkeys(FACTORS, 0.0), 0.0, NONE)
DONE = hl.Evaluation({"box": BOX, "ball": BALL})


def unmet(done, *texts):
    with pytest.raises(hl.RequirementNotMet) as caught:
        done.require(*texts)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    return str(caught.value)


def test_what_is_met_gives_the_evaluation_back():
    met = ("payload>=0.5", " factor > 1.9", "force<=8.5", "torque<0.32", "torque_used <= 0.78", "motion<2.2e-3")
    assert DONE.require(*met) is DONE
    assert DONE.require() is DONE, "every object is held"


@pytest.mark.parametrize(
    ("text", "worst"),
    [
        ("payload>0.5", "ball"),
        ("payload>=1.5", "ball"),
        ("factor>=2.5", "ball"),
        ("force<=3", "box"),
        ("torque<0.3", "box"),
        ("torque_used<=0.5", "box"),
        ("motion<=0.002", "ball"),
    ],
)
def test_what_is_not_met_is_said_of_the_worst_object_with_how_much_and_what_gives_out(text, worst):
    said, one = unmet(DONE, text), parse_requirement(text)
    apart = abs(getattr(DONE.cases[worst], one.name) - one.limit)
    says(said, worst, f"{apart:.4g}", REQUIREMENT_UNITS[one.name], DONE.cases[worst].gives_out)


def test_an_object_without_a_grasp_meets_no_limit_from_above():
    done = hl.Evaluation({"box": BOX, "ball": LOST})
    assert done.motion == BOX.motion, "which is all that is known"
    says(unmet(done, "motion<=0.002", "payload>0.1"), "ball", LOST.gives_out)
    assert LOST.gives_out in unmet(done)


def test_an_object_that_is_pressed_harder_than_it_bears_meets_nothing():
    pressed = replace(BOX, word="NOT HELD", gives_out="the object bears 3 N, and is pressed with 8.5 N")
    done = hl.Evaluation({"ball": BALL, "box": pressed})
    says(unmet(done, "payload>=0.1"), "box is NOT HELD", "pressed with 8.5 N")
    assert done.worst_object == "box", "although the ball is held fewer times"
    assert (done.factor, done.gives_out) == (2.0, pressed.gives_out)


def test_what_nothing_ends_is_infinite_in_a_row_and_nothing_in_json():
    free = replace(BALL, factors=dict.fromkeys(FACTORS, np.inf), gives_out="")
    done = hl.Evaluation({"ball": free})
    row = done.to_row()
    assert row["factor"] == row["objects.ball.factor"] == row["objects.ball.factors.pull"] == np.inf
    assert row["objects.ball.at_least"] is True
    assert done.to_dict()["factor"] is None
    assert "any" in str(done)


@pytest.mark.parametrize("text", ["payload", "payload=1", "payload=>1", "payload>=", "payload>=1 kg", "1<payload", 3])
def test_what_is_no_requirement_is_told_with_the_numbers_that_there_are(text):
    with pytest.raises(hl.InputError, match="payload, factor, force, torque, torque_used, motion"):
        DONE.require(text)


def test_an_unknown_number_and_a_limit_that_is_none_are_told():
    with pytest.raises(hl.UnknownName, match="did you mean 'payload'"):
        DONE.require("paylaod>=1")
    for limit in ("nan", "one", "inf"):
        with pytest.raises(hl.InputError, match="a finite number after >="):
            DONE.require(f"payload>={limit}")
