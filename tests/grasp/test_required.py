"""Required preload and friction against closed forms; what is returned holds, a tolerance less does not."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError
from handlcp.grasp.analysis.required_value import find_least
from handlcp.studies.paper import example
from tests.grasp.scenes import pinch
from tests.support.grasp import arrays, holds_with, required_friction, required_preload
from tests.support.texts import says

C = 1e-4  # m/N, the pinch's flexibility


def reach(faces):
    return 1.0 if faces == "cone" else np.cos(np.pi / faces)


@pytest.mark.parametrize("faces", [4, 8, 16, "cone"])
def test_a_pinch_needs_load_over_twice_its_friction_times_the_flexibility_and_friction_likewise(faces):
    r = required_preload(pinch(mu=0.5, squeeze=0.0, load=(0, 0, -3.0)), faces, tolerance=1e-4)
    exact = C * 3.0 / (2 * 0.5 * reach(faces))  # squeeze / C on each side carries 2 μ_m squeeze / C
    assert exact * (1 - 1e-9) <= r.value <= exact * (1 + 1e-4)
    assert r.value * (1 - 1.001e-4) <= r.fails < exact
    assert dict(r.checked)[r.value]
    assert not dict(r.checked)[r.fails]
    assert not r.proven
    r = required_friction(pinch(squeeze=1e-3, load=(0, 0, -3.0)), faces, tolerance=1e-4)
    exact = 3.0 / (2 * 10.0 * reach(faces))
    assert exact * (1 - 1e-9) <= r.value <= exact * (1 + 1e-4)
    assert r.fails < exact


def test_a_squeeze_already_there_counts():
    r = required_preload(pinch(mu=0.5, squeeze=1e-4, load=(0, 0, -3.0)), "cone", tolerance=1e-4)
    np.testing.assert_allclose(r.value, 2e-4, rtol=2e-4)
    gap = required_preload(pinch(mu=0.5, squeeze=-1e-3, load=(0, 0, -3.0)), "cone", tolerance=1e-4)
    np.testing.assert_allclose(gap.value, 1.3e-3, rtol=2e-4)


@pytest.mark.parametrize("faces", [4, 6, 8, "cone"])
def test_example_4_needs_a_few_micrometres_on_all_fingers(faces):
    grasp = example(4).grasp
    r = required_preload(grasp, faces)
    assert 3e-6 < r.value < 5e-6
    assert holds_with(grasp, faces, r.value)
    assert not holds_with(grasp, faces, r.value * (1 - r.tolerance))
    assert required_friction(grasp, faces).value is None, "no friction makes up for the missing squeeze"


def test_nothing_needed_nothing_enough_and_a_limit():
    enough = required_preload(pinch(squeeze=1e-3))
    assert (enough.value, enough.fails) == (0.0, None)
    says(str(enough), "check()")
    smooth = [hl.Contact((s, 0, 0), (-s, 0, 0), hl.Frictionless()) for s in (-1.0, 1.0)]
    never = hl.Grasp(smooth, (0, 0, -1, 0, 0, 0), flexibility=C)
    for r in (required_preload(never), required_friction(never)):
        assert r.value is None
        assert r.proven
        says(str(r), "balances")
    along = hl.Grasp(smooth, (1, 0, 0, 0, 0, 0), flexibility=C)
    assert required_friction(along).value == 0.0
    short = required_preload(pinch(squeeze=0.0), limit=1e-6)
    assert (short.value, short.fails, short.proven) == (None, 1e-6, False)


def test_three_props_under_a_push_need_the_friction_of_statics_and_that_is_proven():
    """Rigid props, statically determined: below μ = push / weight no force balances it at all."""
    p = np.array([[1.0, 0, 0], [-0.5, 0.8, 0], [-0.5, -0.8, 0]])
    contacts = [hl.Contact(a, (0, 0, 1), hl.Coulomb(0.9), tangent=(1, 0, 0)) for a in p]
    r = required_friction(hl.Grasp(contacts, (2.0, 0, -10.0, 0, 0, 0), flexibility=C), "cone")
    np.testing.assert_allclose(r.value, 0.2, rtol=2e-3)
    assert r.proven or r.fails < r.value


def test_holding_that_is_not_monotone_gives_a_value_that_holds_and_a_tolerance_less_that_does_not():
    windows = lambda x: 0.30 <= x <= 0.5 or x >= 2.0  # noqa: E731
    r = find_least(windows, 0.0, 10.0, 1e-3, step=0.01)
    np.testing.assert_allclose(r.value, 0.30, rtol=1e-3)
    assert windows(r.value)
    assert not windows(r.fails)
    assert r.value - r.fails <= 1e-3 * r.value
    assert find_least(lambda x: False, 0.0, 10.0, 1e-3, step=0.01).fails == 10.0


@pytest.mark.parametrize("start", [0.02, 0.3, 0.9, 40.0])
def test_the_least_value_of_a_window_is_found_from_below_from_inside_and_from_above(start):
    """What is too much is said apart from what is too little; both ends that come back were asked."""
    found = find_least(lambda x: 0.3 <= x <= 0.5, start, 100.0, 1e-3, too_much=lambda x: x > 0.5)
    assert found.value == pytest.approx(0.3, rel=1e-3)
    assert (found.value, True) in found.checked
    assert (found.fails, False) in found.checked
    assert 0.0 < found.value - found.fails <= 1e-3 * found.value


def test_a_slower_test_that_says_yes_lower_down_is_believed():
    found = find_least(lambda x: x >= 0.7, 0.0, 10.0, 1e-3, step=0.01, sure=lambda x: x >= 0.4)
    assert found.value == pytest.approx(0.4, rel=2e-3)
    assert find_least(lambda x: False, 0.0, 10.0, 1e-3, step=0.01, sure=lambda x: x >= 0.4).value == pytest.approx(
        0.4, rel=2e-3
    )


@pytest.mark.parametrize("tolerance", [1e-17, 1e-100])
def test_a_tolerance_finer_than_floats_ends_at_neighbouring_ones(tolerance):
    squeeze = required_preload(pinch(squeeze=0.0), 8, tolerance, check=lambda g: g.offset[0, 2] <= -1.23e-4)
    friction = required_friction(pinch(squeeze=1e-3), 8, tolerance, check=lambda g: arrays(g).mu[0] >= 0.123)
    for r, exact in ((squeeze, 1.23e-4), (friction, 0.123)):
        assert (r.value, r.fails) == (exact, np.nextafter(exact, 0.0))
        assert len(r.checked) < 200


def test_a_tolerance_has_to_be_one():
    for bad in (0.0, -1.0, 1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="tolerance"):
            required_preload(pinch(), tolerance=bad)
        with pytest.raises(InputError, match="tolerance"):
            required_friction(pinch(), tolerance=bad)
    with pytest.raises(InputError, match="limit"):
        required_friction(pinch(), limit=0.0)


def test_steps_double_from_where_the_search_begins():
    up, down = find_least(lambda x: x >= 30.0, 1.0, 100.0, 0.5, step=1.0), find_least(lambda x: True, 8.0, 9.0, 1.0)
    assert [x for x, _ in up.checked[:7]] == [1.0, 2.0, 3.0, 5.0, 9.0, 17.0, 33.0]
    assert [x for x, _ in down.checked] == [8.0, 0.0]
