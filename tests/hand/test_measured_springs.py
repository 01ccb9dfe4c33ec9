"""Springs from readings: the line, its spread, where it is none, and readings that tell nothing."""

from __future__ import annotations

import json

import numpy as np
import pytest

import handlcp as hl

LOADS = np.array([0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.8, 1.0])  # N·m


def scattered(seed, size=1e-3):
    return 0.4 + LOADS / 6.0 + np.random.default_rng(seed).normal(0.0, size, len(LOADS))


def test_a_spring_without_scatter_has_its_stiffness_and_its_rest():
    found = hl.stiffness_from(0.4 + LOADS / 6.0, LOADS)
    assert found.stiffness == pytest.approx(6.0, rel=1e-12)
    assert found.flexibility == pytest.approx(1 / 6.0, rel=1e-12)
    assert found.rest == pytest.approx(0.4, rel=1e-12)
    assert found.spread < 1e-9
    assert found.range is None


def test_the_order_of_readings_and_where_angles_are_counted_from_do_not_matter():
    angle = scattered(1)
    one, other = hl.stiffness_from(angle, LOADS), hl.stiffness_from(angle[::-1] - 2.0, LOADS[::-1])
    assert other.stiffness == pytest.approx(one.stiffness, rel=1e-12)
    assert other.spread == pytest.approx(one.spread, rel=1e-12)
    assert other.rest == pytest.approx(one.rest - 2.0, rel=1e-12)


def test_the_spread_is_that_of_many_measurements():
    found = [hl.stiffness_from(scattered(seed), LOADS) for seed in range(400)]
    K = np.array([f.stiffness for f in found])
    assert K.mean() == pytest.approx(6.0, rel=2e-3)
    assert np.sqrt(np.mean([f.spread**2 for f in found])) == pytest.approx(K.std() / 6.0, rel=0.1)


def test_readings_on_a_line_look_bent_once_in_a_hundred_times_at_most():
    # with 10 % of scatter, where a curve that fits by chance can differ by more than a fifth
    bent = [hl.stiffness_from(scattered(seed, 0.015), LOADS).range is not None for seed in range(400)]
    assert np.mean(bent) < 0.03


def test_a_spring_that_stiffens_is_called_none_with_its_softest_and_stiffest_part():
    depth = np.linspace(0.2e-3, 1.4e-3, 9)
    found = hl.stiffness_from(depth, 1.6e5 * depth**1.5)
    low, high = found.range
    assert low == pytest.approx(1.5 * 1.6e5 * depth[0] ** 0.5, rel=0.25)  # Hertz: dF/dx = 1.5 F/x
    assert high == pytest.approx(1.5 * 1.6e5 * depth[-1] ** 0.5, rel=0.1)
    assert "on no line" in str(found)
    assert "agree with a line" in str(hl.stiffness_from(scattered(2), LOADS))


def test_three_readings_are_enough_and_tell_no_curve():
    found = hl.stiffness_from([0.0, 0.11, 0.2], [0.0, 0.5, 1.0])
    assert found.points == 3
    assert found.range is None


def test_reliability_takes_its_spread():
    found = hl.stiffness_from(scattered(3), LOADS)
    hand = hl.example_hand("three_finger", joint_stiffness=found.stiffness)
    cube = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)
    sure = hl.reliability(grasp, {"stiffness": found.spread, "pads": found.spread}, 64)
    assert float(sure.chance_held) == 1.0


def test_it_goes_into_json_and_prints_in_eighty_columns():
    found = hl.stiffness_from(scattered(4), LOADS)
    assert json.loads(found.to_json())["stiffness"] == found.stiffness
    assert max(map(len, str(found).splitlines())) <= 80


@pytest.mark.parametrize(
    ("angle", "torque", "argument"),
    [
        ([0.1, 0.2], [1.0, 2.0], "angle"),
        ([0.1, 0.2, 0.3], [1.0, 2.0], "torque"),
        ([0.1, 0.1, 0.1], [1.0, 2.0, 3.0], "angle"),
        ([0.1, 0.2, 0.3], [1.0, 1.0, 1.0], "torque"),
        ([0.3, 0.2, 0.1], [1.0, 2.0, 3.0], "torque"),
        ([0.1, float("nan"), 0.3], [1.0, 2.0, 3.0], "angle"),
        ([0.1, 0.2, 0.3], ["a", "b", "c"], "torque"),
        ("angles", [1.0, 2.0, 3.0], "angle"),
        (None, [1.0, 2.0, 3.0], "angle"),
        (0.1, 0.2, "angle"),
        ([], [], "angle"),
        ([[0.1, 0.2, 0.3]], [1.0, 2.0, 3.0], "angle"),
    ],
    ids=["two", "lengths", "one angle", "one torque", "negative", "nan", "letters", "text", "none", "numbers", "empty",
         "table"],
)  # fmt: skip
def test_readings_that_tell_no_spring_are_refused_by_name(angle, torque, argument):
    with pytest.raises(hl.InputError) as error:
        hl.stiffness_from(angle, torque)
    assert error.value.argument == argument
