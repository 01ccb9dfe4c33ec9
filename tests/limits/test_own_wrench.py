"""Contacts without a hand keep their own wrench while another load grows: closed forms of Coulomb's law."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.limits import limit_in_steps, limits_of_grasp

MU, PAD, SQUEEZE = 0.6, 1e-4, 1e-3  # friction, m/N, m
MOST = 2 * MU * SQUEEZE / PAD  # what two pads bear across their line [N]
DOWN, ACROSS = np.array([0, 0, -1.0, 0, 0, 0]), np.array([0, 1.0, 0, 0, 0, 0])
G = 9.81


def pinch(own):
    """Two pads along x, 40 mm apart, under a wrench of their own."""
    ends = [hl.Contact((-0.02, 0, 0), (1, 0, 0), MU), hl.Contact((0.02, 0, 0), (-1, 0, 0), MU)]
    return hl.Grasp(ends, wrench=own, flexibility=PAD, preload=SQUEEZE)


@pytest.fixture(scope="module")
def wall():
    """A cube that a wrench of 20 N presses on a wall, friction 1."""
    corners = [(-0.05, y, z) for y in (-0.05, 0.05) for z in (-0.05, 0.05)]
    return hl.Grasp([hl.Contact(at, (1, 0, 0), 1.0) for at in corners], wrench=(-20, 0, 0, 0, 0, 0), flexibility=1e-6)


@pytest.mark.parametrize("own", [1.0, 6.0, 10.0, 11.9])
@pytest.mark.parametrize("limit", [lambda g, w: g.load_limit(w).factor, limit_in_steps], ids=["by events", "in steps"])
def test_a_pinch_holds_across_what_its_own_wrench_leaves_of_the_cone(own, limit):
    assert limit(pinch(own * DOWN), ACROSS) == pytest.approx(np.sqrt(MOST**2 - own**2), rel=1e-4)
    assert limit(pinch(own * DOWN), DOWN) == pytest.approx(MOST - own, rel=1e-4)
    assert limit(pinch(own * DOWN), -DOWN) == pytest.approx(MOST + own, rel=1e-4)


@pytest.mark.parametrize("way", [DOWN, -DOWN, ACROSS, -ACROSS])
def test_what_presses_on_a_wall_stays_on(wall, way):
    found = wall.load_limit(way)
    assert found.factor == pytest.approx(20.0, rel=1e-6)
    assert found.bound == pytest.approx(20.0, rel=1e-6), "bounds of friction alone know the own wrench, too"
    assert limit_in_steps(wall, way) == pytest.approx(20.0, rel=1e-3)


@pytest.mark.parametrize("way", [ACROSS, DOWN, -DOWN])
@pytest.mark.parametrize("case", ["pinch", "wall"])
def test_check_holds_a_little_less_and_does_not_hold_a_little_more(wall, case, way):
    grasp = wall if case == "wall" else pinch(10.0 * DOWN)
    own, most = grasp.spec.wrench, grasp.load_limit(way).factor
    assert grasp.replace(wrench=own + 0.95 * most * way).check().word == "HELD"
    assert grasp.replace(wrench=own + 1.05 * most * way).check().word == "NOT HELD"


def test_the_wrench_itself_grows_from_nothing():
    grasp = pinch(10.0 * DOWN)
    assert grasp.load_limit().factor == pytest.approx(MOST / 10.0, rel=1e-9)
    assert grasp.margins().safety == pytest.approx(MOST / 10.0, rel=1e-9)


def test_a_wrench_that_is_not_held_alone_leaves_nothing_and_says_so():
    found = pinch(1.1 * MOST * DOWN).load_limit(ACROSS)
    assert found.factor == 0.0
    assert "its own wrench alone is not held" in found.why
    assert pinch(1.1 * MOST * DOWN).load_limit().factor == pytest.approx(1.0 / 1.1, rel=1e-9)


def test_an_envelope_is_the_disc_of_friction_about_the_own_wrench():
    grasp, turns = pinch(10.0 * DOWN), np.linspace(0.0, 2 * np.pi, 9)[:-1] + 0.1
    ways = np.array([(0.0, np.cos(a), np.sin(a)) for a in turns])
    down = ways @ (0.0, 0.0, -1.0)  # |10 z + f d| = 12
    expected = -10.0 * down + np.sqrt((10.0 * down) ** 2 + MOST**2 - 100.0)
    np.testing.assert_allclose(hl.envelope(grasp, ways, adaptive=0).factors, expected, rtol=1e-6)
    many = limits_of_grasp(grasp, np.hstack([ways, np.zeros((8, 3))]))
    np.testing.assert_allclose(many.factors, expected, rtol=1e-6)


def test_a_payload_comes_beside_the_own_wrench(wall):
    """Pulled off the wall, or down it, as much as presses it there."""
    rows = {tuple(np.round(row.direction)): row.mass for row in wall.payload().by_orientation}
    assert rows[1.0, 0.0, 0.0] == pytest.approx(20.0 / G, rel=1e-6)
    assert rows[0.0, 0.0, -1.0] == pytest.approx(20.0 / G, rel=1e-6)
    assert rows[-1.0, 0.0, 0.0] == np.inf
    assert pinch(10.0 * DOWN).payload().mass == pytest.approx((MOST - 10.0) / G, rel=1e-6)


def test_the_best_change_is_judged_beside_the_own_wrench():
    found = pinch(10.0 * DOWN).best_change(ACROSS)
    assert found.before.factor == pytest.approx(np.sqrt(MOST**2 - 100.0), rel=1e-6)
    assert found.tried[0].factor == pytest.approx(np.sqrt((1.1 * MOST) ** 2 - 100.0), rel=1e-6)
    assert found.confirmed
    alone = pinch(10.0 * DOWN).best_change()
    assert alone.before.factor == pytest.approx(MOST / 10.0, rel=1e-6)
    assert alone.confirmed


def test_sensitivities_are_those_of_the_closed_form():
    """∂/∂μ of √((2 μ N)² - w²), per contact together."""
    limit = pinch(10.0 * DOWN).load_limit(ACROSS)
    push = SQUEEZE / PAD
    assert limit.sensitivity().factor_by_all_friction == pytest.approx(4 * MU * push**2 / limit.factor, rel=1e-5)
