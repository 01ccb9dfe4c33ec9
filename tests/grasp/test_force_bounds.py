"""Least and largest forces: closed forms, the solution itself where it is the only one, an oracle and other solvers."""

from dataclasses import replace

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, Unsupported
from tests.grasp.force_bounds_oracle import NEAR, examine, grasps, outside
from tests.grasp.scenes import pinch
from tests.grasp.test_equilibria import effect_with
from tests.support.texts import says

KEY = "grasp/test_force_bounds"
EXACT = {"rtol": 1e-9, "atol": 1e-9}
W = 10.0
FREE = hl.Frictionless()


def props(places, law=FREE, load=(0.0, -W, 0.0), **more):
    """Planar: supports from below at these places along x."""
    return hl.Grasp([hl.Contact((x, 0.0), (0.0, 1.0), law) for x in places], load, **more)


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("at", [0.1, 0.3, 0.4, 0.7])
def test_a_beam_on_three_rigid_supports(at):
    """The extreme members rest on two supports on either side of the weight: the lever rule of each such pair."""
    places = (0.0, 0.4, 1.0)
    b = props(places, load=(0, -W, -W * at)).solve().force_bounds()
    pairs = [(i, j) for i in range(3) for j in range(i + 1, 3) if places[i] <= at <= places[j]]
    every = np.zeros((len(pairs), 3))
    for row, (i, j) in zip(every, pairs, strict=True):
        row[j] = W * (at - places[i]) / (places[j] - places[i])
        row[i] = W - row[j]
    np.testing.assert_allclose(b.normal, np.column_stack([every.min(axis=0), every.max(axis=0)]), **EXACT)
    assert b.gap < 1e-12
    assert b.wider == ()


@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize("mu", [0.3, 0.9, 1.2])
def test_a_ball_in_a_rigid_groove_is_wedged_within_friction(mu, faces):
    """N (1 + t) = W / √2 with the friction t N upwards or downwards, |t| ≤ μ; from μ = 1 on nothing bounds it. In
    space, on the exact cone, what two points leave open is the force along the line between them.
    """
    q, plane = np.sqrt(0.5), [0, 2] if faces == 8 else [0, 1, 2]
    contacts = [hl.Contact(np.array((x, 0, -q))[plane], np.array((-x, 0, q))[plane], hl.Coulomb(mu)) for x in (-q, q)]
    b = hl.Grasp(contacts, (0, -W, 0) if faces == 8 else (0, 0, -W, 0, 0, 0)).solve(faces).force_bounds()
    most = W * q / (1.0 - mu) if mu < 1.0 else np.inf
    np.testing.assert_allclose(b.normal, [[W * q / (1.0 + mu), most]] * 2, **EXACT)
    assert b.gap < 1e-9
    assert b.open == ("finger 1", "finger 2")
    if (mu, faces) == (0.9, 8):
        says(str(b), "3.72")


def test_a_box_that_is_wedged_between_two_walls_may_press_with_any_force():
    contacts = [hl.Contact((x, 0), (-x, 0), hl.Coulomb(0.5)) for x in (-1.0, 1.0)]
    b = hl.Grasp(contacts, (0, -W, 0)).solve().force_bounds()
    np.testing.assert_allclose(b.normal[:, 0], W, **EXACT)  # W / 2μ
    np.testing.assert_array_equal(b.normal[:, 1], np.inf)
    np.testing.assert_allclose(abs(b.forces[:, 0]), 0.5 * W, **EXACT)
    assert b.to_dict()["normal_N"][0][1] is None
    says(str(b), "∞")


@pytest.mark.parametrize("faces", ["cone", 8])
def test_the_corners_of_a_rigid_table_bear_half_the_weight_at_most(faces):
    corners = [hl.Contact((x, y, 0), (0, 0, 1), hl.Coulomb(0.5)) for x in (-1, 1) for y in (-1, 1)]
    b = hl.Grasp(corners, (0, 0, -W, 0, 0, 0)).solve(faces).force_bounds()
    np.testing.assert_allclose(b.normal, [[0.0, 0.5 * W]] * 4, rtol=1e-9, atol=1e-8)


def test_a_limit_that_an_effect_sets_bounds_a_wedge():
    contacts = [hl.Contact((x, 0), (-x, 0), hl.Coulomb(0.5)) for x in (-1.0, 1.0)]
    s = hl.Grasp(contacts, (0, -W, 0), effects=[hl.FingerForceBound(15.0)]).solve()
    np.testing.assert_allclose(s.force_bounds().normal, [[W, 15.0]] * 2, **EXACT)


# ---------------------------------------------------------------- what is determined
@pytest.mark.parametrize("faces", ["cone", 8])
def test_where_forces_are_determined_both_are_the_solutions(faces):
    s = pinch().solve(faces)
    assert s.uniqueness.forces_determined
    for b in (s.force_bounds(), s.force_bounds(friction=(0.9, 1.5))):  # friction alone changes nothing that sticks
        np.testing.assert_array_equal(b.forces, np.repeat(s.forces[:, :, None], 2, axis=2))
        assert b.open == ()
    says(str(s.force_bounds()), "All forces are determined")


def test_what_of_it_is_determined_is_the_solutions_to_the_last_bit():
    """Two rigid supports under one end, and one soft finger that presses with what its squeeze gives."""
    contacts = [hl.Contact((x, 0), (0, 1), FREE) for x in (-1.0, 1.0, 0.0)] + [hl.Contact((0, 1), (0, -1), FREE)]
    E = np.zeros((12, 12))
    E[11, 11] = 1e-4
    offset = np.zeros((4, 3))
    offset[3, 2] = -1e-3
    s = hl.Grasp(contacts, (0, -W, 0), flexibility=E, offset=offset).solve()
    b = s.force_bounds()
    np.testing.assert_allclose(s.normal_force[3], 10.0, rtol=1e-9)
    assert b.normal[3, 0] == b.normal[3, 1] == s.normal_force[3]
    np.testing.assert_allclose(b.normal[:3], [[0, 10.0], [0, 10.0], [0, 20.0]], **EXACT)
    assert b.open == ("finger 1", "finger 2", "finger 3")


# ---------------------------------------------------------------- ranges
def test_two_pads_under_one_weight_share_it_as_they_are_soft():
    """N₁ p₁ = N₂ p₂, N₁ + N₂ = W: with factors from a to b each bears from W a / (a + b) to W b / (a + b)."""
    s = props((0.0, 0.0), flexibility=1e-4).solve()
    b = s.force_bounds(pads=(0.5, 2.0))
    np.testing.assert_allclose(b.normal, [[0.2 * W, 0.8 * W]] * 2, **EXACT)
    says(str(b), "8.000")


def test_friction_within_a_range_shares_a_weight_between_what_slides_and_what_supports():
    """Two walls pressed with 10 N each slide, and the support below bears what their friction leaves."""
    contacts = [hl.Contact((0.1 * x, 0), (-x, 0), hl.Coulomb(0.2)) for x in (-1, 1)] + [
        hl.Contact((0, -0.1), (0, 1), FREE)
    ]
    squeeze = [[0, 0, -1e-3], [0, 0, -1e-3], [0, 0, 0]]
    s = hl.Grasp(contacts, (0, -W, 0), flexibility=1e-4, offset=squeeze).solve()
    assert s.contact_state[:2] == ("sliding", "sliding")
    b = s.force_bounds(friction=(0.4, 1.0))
    np.testing.assert_allclose(abs(b.forces[:2, 0]), [[0.8, 2.0], [2.0, 0.8]], **EXACT)
    np.testing.assert_allclose(b.normal, [[10, 10], [10, 10], [6.0, 8.4]], **EXACT)


def _same_ways(a, b):
    """Whether contacts that slide do so in the same directions: against the same faces."""
    products = (a.slip * b.slip).sum(axis=1)
    sizes = np.linalg.norm(a.slip, axis=1) * np.linalg.norm(b.slip, axis=1)
    return all(p > (1.0 - 1e-9) * size for p, size, state in zip(products, sizes, a.contact_state, strict=True)
               if state == "sliding")  # fmt: skip


@pytest.mark.parametrize("faces", ["cone", 8])
@pytest.mark.parametrize("mu", [0.25, 0.8])
def test_grasps_with_pads_and_friction_in_the_ranges_lie_inside(faces, mu):
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(5, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)

    def made(friction, flexibility):
        contacts = [hl.Contact(-0.03 * n, n, hl.Coulomb(m)) for n, m in zip(normals, friction, strict=True)]
        return hl.Grasp(contacts, (0, 0, -5.0, 0, 0.01, 0), flexibility=flexibility, preload=2e-3)

    s, seen = made(np.full(5, mu), 1e-4 * np.eye(15)).solve(faces), 0
    wide = s.force_bounds(pads=(0.5, 2.0), friction=(0.6, 1.2))
    for _ in range(40):
        near = rng.uniform() ** 3
        E = 1e-4 * np.diag(2.0 ** (near * rng.uniform(-1, 1, 15)))
        other = made(mu * (1.0 + near * rng.uniform(-0.4, 0.2, 5)), E).solve(faces, throw=False)
        if other.held and other.contact_state == s.contact_state and (faces == "cone" or _same_ways(s, other)):
            seen += 1
            assert outside(wide, other.forces, W) < NEAR
    assert seen > 3
    assert outside(wide, s.forces, W) <= 0.0


# ---------------------------------------------------------------- what other solvers find
@pytest.mark.parametrize("faces", ["cone", 8])
@pytest.mark.parametrize("seed", range(5))
def test_an_oracle_and_other_solvers_find_nothing_outside(seed, faces):
    count = examine(grasps(seed), faces, seed, readings=3)
    assert count["not held"] or count["open"] + count["determined"] == 1


# ---------------------------------------------------------------- refusals
@pytest.mark.parametrize("wrong", [(2.0, 3.0), (0.0, 1.0), (0.5, 0.9), 2.0, (0.5, np.inf), (1.5, 0.5)])
def test_factors_have_one_between_them(wrong):
    for argument in ("pads", "friction"):
        with pytest.raises(InputError, match=argument):
            pinch().solve().force_bounds(**{argument: wrong})


def test_what_is_not_held_has_no_forces_to_bound():
    s = pinch(load=(0, 0, -100.0)).solve(throw=False)
    with pytest.raises(InputError, match="held"):
        s.force_bounds()


def test_beside_an_effect_that_moves_contacts_nobody_knows_what_is_open():
    s = pinch().solve()
    moved = replace(s, spec=s.spec.replace(effects=(effect_with("opening"),)))
    with pytest.raises(Unsupported, match="force_bounds"):
        moved.force_bounds()
