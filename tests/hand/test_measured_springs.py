"""Springs from readings: the line, its spread, where it is none, and readings that tell nothing."""

import numpy as np
import pytest

import handlcp as hl

LOADS = np.array([0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.8, 1.0])  # N·m
ANGLES = 0.4 + LOADS / 6.0  # rad
UP_AND_DOWN = np.arcsin(np.array([1, 2, 4, 6, 8, 10, 7, 5, 3, 1.5]) / 85.0)  # rad, as the page of the tour has it
WAY = np.array([1.0] * 6 + [-1.0] * 4)


def scattered(seed, size=6e-3):
    return LOADS + np.random.default_rng(seed).normal(0.0, size, len(LOADS))


def test_a_spring_without_scatter_has_its_stiffness_and_its_rest():
    found = hl.stiffness_from(ANGLES, LOADS)
    assert found.stiffness == pytest.approx(6.0, rel=1e-12)
    assert found.flexibility == pytest.approx(1 / 6.0, rel=1e-12)
    assert found.rest == pytest.approx(0.4, rel=1e-12)
    assert found.spread < 1e-9
    assert found.friction is None
    assert found.range is None


def test_readings_all_upwards_or_all_downwards_and_any_origin_of_the_angle_tell_the_same():
    load = scattered(1)
    one, other = hl.stiffness_from(ANGLES, load), hl.stiffness_from(ANGLES[::-1] - 2.0, load[::-1])
    assert other.stiffness == pytest.approx(one.stiffness, rel=1e-12)
    assert other.spread == pytest.approx(one.spread, rel=1e-9)
    assert other.rest == pytest.approx(one.rest - 2.0, rel=1e-12)
    assert one.friction is other.friction is None


def test_the_spread_is_that_of_many_measurements():
    found = [hl.stiffness_from(ANGLES, scattered(seed)) for seed in range(400)]
    K = np.array([f.stiffness for f in found])
    assert K.mean() == pytest.approx(6.0, rel=2e-3)
    assert np.sqrt(np.mean([f.spread**2 for f in found])) == pytest.approx(K.std() / 6.0, rel=0.1)
    rest = np.array([f.rest for f in found])
    assert np.sqrt(np.mean([f.rest_error**2 for f in found])) == pytest.approx(rest.std(), rel=0.1)


def test_noise_of_the_scale_does_not_pull_the_stiffness_to_one_side():
    angle = np.linspace(0.0, 0.1, 50)
    noise = [0.1 * np.random.default_rng(seed).standard_normal(50) for seed in range(50)]  # a fifth of the largest load
    found = [hl.stiffness_from(angle, 5.0 * angle + n) for n in noise]
    K, spread = (np.array([getattr(f, name) for f in found]) for name in ("stiffness", "spread"))
    assert abs(K.mean() - 5.0) < 3.0 * K.std() / np.sqrt(50)
    assert np.mean(abs(K - 5.0) < 2.0 * spread * K) > 0.9


@pytest.mark.parametrize("friction", [0.03, 0.1])
def test_dry_friction_on_the_way_up_and_down_neither_turns_the_line_nor_is_left_out_of_the_spread(friction):
    found = hl.stiffness_from(UP_AND_DOWN, 5.0 * UP_AND_DOWN + friction * WAY)
    assert found.stiffness == pytest.approx(5.0, rel=1e-12)
    assert found.friction == pytest.approx(friction, rel=1e-9)
    assert found.spread == pytest.approx(friction / (5.0 * np.ptp(UP_AND_DOWN)), rel=1e-6)
    assert found.rest == pytest.approx(0.0, abs=1e-12)
    assert found.range is None
    assert f"friction {friction:g}, counted in the spread" in str(found)


@pytest.mark.parametrize("share", [0.03, 0.06, 0.1])
def test_friction_that_grows_with_the_load_is_within_the_spread(share):
    found = hl.stiffness_from(UP_AND_DOWN, 5.0 * UP_AND_DOWN * (1.0 + share * WAY))
    assert abs(found.stiffness - 5.0) < found.spread * found.stiffness
    assert found.spread > share


def test_a_reading_taken_twice_at_the_top_belongs_to_the_way_down():
    angle = np.array([1, 2, 3, 4, 4, 3, 2, 1]) / 100.0
    way = np.repeat([1.0, -1.0], 4)
    assert hl.stiffness_from(angle, 5.0 * angle + 0.02 * way).friction == pytest.approx(0.02, rel=1e-9)


def test_loads_that_are_larger_on_the_way_down_are_scatter_and_no_friction():
    found = hl.stiffness_from(UP_AND_DOWN, 5.0 * UP_AND_DOWN - 0.02 * WAY)
    assert found.friction == 0.0
    assert found.spread == pytest.approx(0.02 / (5.0 * np.ptp(UP_AND_DOWN)), rel=1e-6)


def test_readings_on_a_line_look_bent_once_in_a_hundred_times_at_most():
    # with 10 % of scatter, where a curve that fits by chance can differ by more than a fifth
    bent = [hl.stiffness_from(ANGLES, scattered(seed, 0.09)).range is not None for seed in range(400)]
    assert np.mean(bent) < 0.03


def test_a_spring_that_stiffens_is_called_none_with_its_softest_and_stiffest_part():
    depth = np.linspace(0.2e-3, 1.4e-3, 9)
    found = hl.stiffness_from(depth, 1.6e5 * depth**1.5)
    low, high = found.range
    assert low == pytest.approx(1.5 * 1.6e5 * depth[0] ** 0.5, rel=0.25)  # Hertz: dF/dx = 1.5 F/x
    assert high == pytest.approx(1.5 * 1.6e5 * depth[-1] ** 0.5, rel=0.1)
    assert "on no line" in str(found)
    assert "agree with a line" in str(hl.stiffness_from(ANGLES, scattered(2)))


@pytest.mark.parametrize(
    ("angle", "torque", "argument"),
    [
        ([0.1, 0.2], [1.0, 2.0], "angle"),
        ([0.1, 0.2, 0.3], [1.0, 2.0], "torque"),
        ([0.1, 0.1, 0.1], [1.0, 2.0, 3.0], "angle"),
        ([0.1, 0.2, 0.3], [1.0, 1.0, 1.0], "torque"),
        ([0.1, float("nan"), 0.3], [1.0, 2.0, 3.0], "angle"),
        ([0.1, 0.2, 0.3], ["a", "b", "c"], "torque"),
        ([], [], "angle"),
    ],
)  # fmt: skip
def test_readings_that_tell_no_spring_are_refused_by_name(angle, torque, argument):
    with pytest.raises(hl.InputError) as error:
        hl.stiffness_from(angle, torque)
    assert error.value.argument == argument
