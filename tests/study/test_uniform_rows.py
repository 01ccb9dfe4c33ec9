"""What the greedy choice is compared with: rows that are all equally likely."""

from __future__ import annotations

import numpy as np

import handlcp as hl
from handlcp.lcp import Units
from handlcp.method.nsngrk import UniformRows
from tests.lcp.problems import random_p


def phi(M, q, free, z):
    w = M @ z + q
    return np.where(free, w, np.hypot(z, w) - z - w)


def test_every_row_with_a_residual_is_drawn_alike_and_no_other():
    M, q = np.eye(4), np.array([-3.0, -2.9, -0.1, 1.0])  # from zero the last has none
    free = np.array([False, False, True, False])
    problem = hl.LCP(M, q, free, units=Units.ones(4)).scaled
    hits, h = np.zeros(4), 1e-6
    for seed in range(6000):
        z = UniformRows(1e-30, 1, seed).propose(problem).z
        row = np.flatnonzero(z)[0]
        hits[row] += 1
        # equation (20)
        f = phi(M, q, free, np.zeros(4))[row]
        g = np.array([(phi(M, q, free, h * e) - phi(M, q, free, -h * e))[row] / (2 * h) for e in np.eye(4)])
        np.testing.assert_allclose(z, -f / (g @ g) * g, atol=1e-5)
    np.testing.assert_allclose(hits / 6000, [1 / 3, 1 / 3, 1 / 3, 0], atol=0.03)


def test_it_finds_the_same_answer_in_more_steps():
    p = hl.LCP(*random_p(np.random.default_rng(0), 12))
    greedy, alike = (
        hl.solve_lcp(p, solver)
        for solver in (hl.NSNGRK(polish=False, max_iterations=100_000), UniformRows(1e-10, 100_000))
    )
    np.testing.assert_allclose(greedy.z, alike.z, atol=1e-8)
    assert greedy.iterations < alike.iterations


def test_it_stops_at_an_answer_and_where_no_row_moves():
    solved = hl.LCP(np.eye(2), [1.0, 1.0]).scaled
    stuck = hl.LCP([[0.0]], [-1.0], [True]).scaled
    for p in (solved, stuck):
        assert UniformRows(1e-10, 100).propose(p).iterations == 0
