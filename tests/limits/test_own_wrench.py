"""Contacts without a hand keep their own wrench while another load grows: closed forms of Coulomb's law."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.limits import limits_of_grasp

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
def test_a_pinch_holds_across_what_its_own_wrench_leaves_of_the_cone(own):
    grasp = pinch(own * DOWN)
    assert grasp.load_limit(ACROSS).factor == pytest.approx(np.sqrt(MOST**2 - own**2), rel=1e-9)
    assert grasp.load_limit(DOWN).factor == pytest.approx(MOST - own, rel=1e-7)
    assert grasp.load_limit(-DOWN).factor == pytest.approx(MOST + own, rel=1e-9)


@pytest.mark.parametrize("way", [DOWN, -DOWN, ACROSS, -ACROSS])
def test_what_presses_on_a_wall_stays_on(wall, way):
    found = wall.load_limit(way)
    assert found.factor == pytest.approx(20.0, rel=1e-6)
    assert found.bound == pytest.approx(20.0, rel=1e-6), "bounds of friction alone know the own wrench, too"


@pytest.mark.parametrize("way", [ACROSS, DOWN, -DOWN])
@pytest.mark.parametrize("case", ["pinch", "wall"])
def test_check_holds_a_little_less_and_does_not_hold_a_little_more(wall, case, way):
    grasp = wall if case == "wall" else pinch(10.0 * DOWN)
    own, most = grasp.spec.wrench, grasp.load_limit(way).factor
    assert grasp.replace(wrench=own + 0.95 * most * way).check().word == "HELD"
    assert grasp.replace(wrench=own + 1.05 * most * way).check().word == "NOT HELD"


@pytest.mark.parametrize("accuracy", [None, 1e-3])
def test_all_that_a_limit_says_is_beside_the_own_wrench(accuracy):
    """What the contacts bear at the limit is both: √(6.63² + 10²) = 12 N, and 6 N each."""
    found = pinch(10.0 * DOWN).load_limit(ACROSS, accuracy=accuracy)
    both = found.load + 10.0 * DOWN
    assert np.linalg.norm(both) == pytest.approx(MOST, rel=1e-6)
    assert found.at_limit.held
    np.testing.assert_allclose(found.at_limit.spec.wrench, both, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(found.path.forces[-1][:, :2], axis=1), MOST / 2, rtol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(found.path.forces[0][:, :2], axis=1), 5.0, rtol=1e-6)
    assert found.some_equilibrium == pytest.approx(found.factor, rel=1e-5), "beyond the cone nothing balances both"
    assert found.bound == np.inf, "fingers that may press as hard as they like hold anything"
    assert found.why.startswith("at 6.633 times the load, 6.63 N along +y beside the grasp's own 10 N along -z: ")
    assert "own" not in pinch(10.0 * DOWN).load_limit().why, "the own wrench itself grows: there is nothing beside it"


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3])
def test_a_load_may_help_a_wrench_that_is_not_held_alone(unit):
    """13 N down on 12 N of friction: from 1 N upwards to 25 N there is an equilibrium, whatever the load's unit."""
    found = pinch(13.0 * DOWN).load_limit(-unit * DOWN)
    assert found.factor == 0.0, "a load that grows slowly comes too late"
    assert found.some_equilibrium == pytest.approx((MOST + 13.0) / unit, rel=1e-4)


def test_envelope_and_payload_name_the_wrench_that_stays_on():
    grasp, told = pinch(10.0 * DOWN), "beside the grasp's own 10 N along -z"
    assert told in " ".join(str(hl.envelope(grasp, "yz", adaptive=0)).split())
    assert told in " ".join(str(grasp.payload()).split())
    assert "own" not in str(hl.envelope(grasp.replace(wrench=np.zeros(6)), "yz", adaptive=0))


@pytest.fixture(scope="module")
def planar():
    """The same two pads in a plane, under 10 N down."""
    ends = [hl.Contact((-0.02, 0), (1, 0), MU), hl.Contact((0.02, 0), (-1, 0), MU)]
    return hl.Grasp(ends, wrench=(0, -10, 0), flexibility=PAD, preload=SQUEEZE)


@pytest.mark.parametrize("load", [(0, -1, 0), (0, 1, 0), (1, 0, 0), (0, 0, 1)])
def test_three_numbers_grow_beside_the_own_wrench_in_a_plane(planar, load):
    """Balance of moments keeps both tangential forces at 5 N under a force f along x: a finger slips where its normal
    force 10 - f / 2 has fallen to 5 / μ. A moment m adds m / 40 mm to one of them.
    """
    most = {(0, -1, 0): MOST - 10.0, (0, 1, 0): MOST + 10.0, (1, 0, 0): 2 * (10.0 - 5.0 / MU), (0, 0, 1): 0.04}
    found = planar.load_limit(load)
    assert found.factor == pytest.approx(most[load], rel=1e-6)
    assert planar.best_change(load).before.factor == pytest.approx(most[load], rel=1e-6)


def test_an_envelope_in_a_plane_is_beside_the_own_wrench(planar):
    found = hl.envelope(planar, [(1, 0, 0), (0, 1, 0), (0, -1, 0)], adaptive=0)
    np.testing.assert_allclose(found.factors, [2 * (10.0 - 5.0 / MU), MOST + 10.0, MOST - 10.0], rtol=1e-6)


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


def test_a_grasp_without_any_wrench_says_which_load_is_missing():
    none = pinch(np.zeros(6))
    for ask in (none.load_limit, none.best_change):
        with pytest.raises(hl.InputError, match=r"^wrench: expected the load that is to grow"):
            ask()


def test_sensitivities_are_those_of_the_closed_form():
    """∂/∂μ of √((2 μ N)² - w²), per contact together."""
    limit = pinch(10.0 * DOWN).load_limit(ACROSS)
    push = SQUEEZE / PAD
    assert limit.sensitivity().factor_by_all_friction == pytest.approx(4 * MU * push**2 / limit.factor, rel=1e-5)
