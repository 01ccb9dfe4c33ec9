"""Lemke's method: ties do not cycle, tolerances are relative, a ray proves nothing."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import Units
from handlcp.lcp.lemke import eliminate_free
from tests.lcp.problems import KNOWN, random_p
from tests.oracle import every_solution
from tests.support.lcp import pivoted
from tests.support.texts import says


@pytest.mark.parametrize("scale", [1e-140, 1e-9, 1.0, 1e9, 1e140])
def test_scaling_m_or_q_changes_nothing_but_units(scale):
    M, q = random_p(np.random.default_rng(0), 8)
    (z,) = every_solution(M, q)
    for s, expected in (
        (hl.solve_lcp(hl.LCP(scale * M, q), hl.Lemke()), z / scale),
        (hl.solve_lcp(hl.LCP(M, scale * q), hl.Lemke()), z * scale),
    ):
        np.testing.assert_allclose(s.z, expected, rtol=1e-9, atol=1e-9 * abs(expected).max())


def test_ties_in_every_row_end():
    rng = np.random.default_rng(0)
    for _ in range(200):
        n = int(rng.integers(2, 7))
        M = rng.integers(-2, 3, (n, n)).astype(float)
        ending, pivots, _ = pivoted(M, -np.ones(n), np.ones(n), 10_000)
        assert ending in ("solved", "ray")
        assert pivots < 10_000


def test_kostreva_cycles_without_an_order_and_is_solved_with_it():
    s = hl.solve_lcp(hl.LCP(*KNOWN["Kostreva_1"]), hl.Lemke(coverings=1))
    np.testing.assert_allclose(s.z, 1 / 3)


def test_another_covering_vector_solves_what_ends_in_a_ray_with_ones():
    # the same lesson as Murty's example 2.11, on a problem found by search among small integers
    M, q = [[1, 3, 3], [-2, 0, -3], [-3, 1, -3]], [2, 2, -2]
    p = hl.LCP(M, q, units=Units.ones(3))
    (z,) = every_solution(M, q)
    one = hl.solve_lcp(p, hl.Lemke(coverings=1), throw=False)
    assert one.status is hl.Status.UNDECIDED  # a ray is no verdict
    says(one.outcome, "secondary")
    np.testing.assert_allclose(hl.solve_lcp(p, hl.Lemke(coverings=30)).z, z, atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_a_singular_free_block_is_made_regular_by_swapping_pairs(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(5, 3))
    # equilibrium-like: [E A; -Aᵀ 0] with the free block (last three) zero
    E = np.eye(5) + 0.1 * np.diag(rng.random(5))
    M = np.block([[E, A], [-A.T, np.zeros((3, 3))]])
    x = np.where(rng.random(5) < 0.6, rng.uniform(1, 2, 5), 0)
    q = np.concatenate([np.where(x > 0, 0, rng.uniform(1, 2, 5)) - E @ x, A.T @ x])
    free = np.arange(8) >= 5
    p = hl.LCP(M, q, free)
    reduced = eliminate_free(p.scaled)
    assert reduced.consistent
    assert len(reduced.q) == 5
    s = hl.solve_lcp(p, hl.Lemke())
    assert abs(s.w[free]).max() < 1e-9


def test_a_direction_that_touches_nothing_is_held_at_zero():
    M = np.diag([1.0, 2.0, 0.0])
    s = hl.solve_lcp(hl.LCP(M, [-1.0, -2.0, 0.0], [False, True, True]), hl.Lemke())
    np.testing.assert_allclose(s.z, [1, 1, 0], atol=1e-12)


def test_murty_2_11_ends_in_a_ray_with_his_covering_vector_and_is_solved_with_ones():
    M, q = np.array([[-1.5, 2], [-4, 4]]), np.array([-5.0, 17.0])
    assert pivoted(M, q, np.array([5.0, 16.0]), 100)[0] == "ray"
    ending, _, z = pivoted(M, q, np.ones(2), 100)
    assert ending == "solved"
    np.testing.assert_allclose(np.minimum(z, M @ z + q), 0, atol=1e-11)
