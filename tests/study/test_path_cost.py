"""What accuracy costs on a path: errors fall with the steps, and the estimate beside an answer is not too small."""

from functools import cache

import numpy as np
import pytest

import handlcp as hl
from tests.support.squeezed import cube

ASIDE = (0.3, 0.9, 0.3, 0, 0, 0)


@cache
def cost():
    return hl.path_cost(cube(), ASIDE, times=(1, 4), repeats=1)


def test_with_twice_the_steps_errors_fall_by_about_two_and_are_no_larger_than_is_estimated():
    for question in ("follow", "load_limit"):
        rows = cost().of(question)
        assert len(rows) == 2
        errors = np.array([r.error for r in rows])
        assert (errors[1:] < 0.7 * errors[:-1]).all()
        assert all(r.error <= r.estimate for r in rows[1:])
        assert all(r.seconds > 0.0 for r in rows)


def test_the_error_that_follow_was_asked_for_is_kept_where_steps_are_short_for_other_reasons():
    """Twice the steps that are asked for are hardly more of those in which the cube slides, at first."""
    load = 0.7 * cost().factor * np.array(ASIDE)
    asked = cube().follow(load, accuracy=5e-3)
    finest = cube().follow(load, steps=320)
    last = finest.steps.forces[-1]
    assert abs(asked.steps.forces[-1] - last).max() <= 5e-3 * abs(last).max()
    assert asked.accuracy <= 5e-3


def test_in_one_posture_steps_come_near_the_limit_that_is_found_from_event_to_event():
    fixed = hl.path_cost(cube(), ASIDE, geometry="fixed", times=(1, 4), repeats=1)
    exact = cube().load_limit(ASIDE, geometry="fixed").factor
    assert fixed.geometry == "fixed"
    assert fixed.factor == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize(
    ("asked", "named"),
    [
        ({"times": (1,)}, "times"), ({"times": (2, 1)}, "times"), ({"repeats": 0}, "repeats"),
        ({"wrench": (0,) * 6}, "wrench"),
    ],
)  # fmt: skip
def test_bad_input_is_named(asked, named):
    with pytest.raises(hl.InputError, match=named):
        hl.path_cost(cube(), **({"wrench": ASIDE} | asked))
    with pytest.raises(hl.InputError, match="grasp"):
        hl.path_cost("cube", ASIDE)
