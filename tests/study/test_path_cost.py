"""What accuracy costs on a path: errors fall with the accuracy that is asked of its steps."""

from functools import cache

import numpy as np
import pytest

import handlcp as hl
from tests.support.squeezed import cube

ASIDE = (0.3, 0.9, 0.3, 0, 0, 0)


@cache
def cost():
    return hl.path_cost(cube(), ASIDE, accuracies=(1e-2, 1e-3, 1e-4), repeats=1)


def test_errors_fall_with_the_accuracy_that_is_asked_and_are_no_larger():
    for question in ("follow", "load_limit"):
        rows = cost().of(question)
        assert [r.accuracy for r in rows] == [1e-2, 1e-3, 1e-4]
        assert rows[-1].error <= rows[0].error
        assert all(r.estimate <= r.accuracy for r in rows)
        assert all(r.error <= 3.0 * r.accuracy for r in rows)
        assert all(r.seconds > 0.0 for r in rows)


def test_the_error_that_follow_was_asked_for_is_kept():
    load = 0.95 * cost().factor * np.array(ASIDE)
    asked = cube().follow(load, accuracy=5e-3)
    finest = cube().follow(load, steps=320)
    last = finest.steps.forces[-1]
    assert abs(asked.steps.forces[-1] - last).max() <= 5e-3 * abs(last).max()
    assert asked.accuracy <= 5e-3


def test_in_one_posture_steps_come_near_the_limit_that_is_found_from_event_to_event():
    fixed = hl.path_cost(cube(), ASIDE, geometry="fixed", accuracies=(1e-2, 1e-4), repeats=1)
    exact = cube().load_limit(ASIDE, geometry="fixed").factor
    assert fixed.geometry == "fixed"
    assert fixed.factor == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize(
    ("asked", "named"),
    [
        ({"accuracies": (1e-3,)}, "accuracies"), ({"accuracies": (1e-4, 1e-3)}, "accuracies"),
        ({"repeats": 0}, "repeats"),
        ({"wrench": (0,) * 6}, "wrench"),
    ],
)  # fmt: skip
def test_bad_input_is_named(asked, named):
    with pytest.raises(hl.InputError, match=named):
        hl.path_cost(cube(), **({"wrench": ASIDE} | asked))
    with pytest.raises(hl.InputError, match="grasp"):
        hl.path_cost("cube", ASIDE)
