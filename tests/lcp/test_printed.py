"""AsPrinted is Algorithm 2 of the paper to the letter: forward differences with h = 1e-6, then (20) to (22)."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.studies.accuracy import AsPrinted
from handlcp.studies.paper import example
from tests.lcp.problems import random_p
from tests.support.texts import says

H = 1e-6


def phi(problem, z):
    w = problem.M @ z + problem.q
    return np.where(problem.free, w, np.sqrt(z * z + w * w) - z - w)


def differences(problem, z):
    """The subgradient matrix (19), column by column, each from a product with M of its own."""
    return np.column_stack([(phi(problem, z + H * e) - phi(problem, z)) / H for e in np.eye(len(z))])


@pytest.mark.parametrize("seed", range(20))
def test_a_step_projects_on_a_forward_difference_of_a_row_of_the_greedy_set(seed):
    rng = np.random.default_rng(seed)
    M, q = random_p(rng, 9)
    p = hl.LCP(M, q, rng.random(9) < 0.3, units=hl.LCP(M, q).scaled.units).scaled
    z = rng.normal(size=9)
    f, J = phi(p, z), differences(p, z)
    g2 = (J * J).sum(1)
    epsilon = 0.5 * ((f**2 / g2).max() / (f @ f)) + 0.5 / (J * J).sum()
    greedy = np.flatnonzero(f**2 >= epsilon * (f @ f) * g2 * (1 - 1e-6))
    moved = AsPrinted(max_iterations=1, tol=1e-30, seed=seed).propose(p, z).z
    # equation (20); two ways to round w differ by 1e-16 / h
    assert min(abs(moved - (z - f[i] / g2[i] * J[i])).max() for i in greedy) < 1e-8


def test_it_follows_the_analytic_method_until_the_differences_show():
    p = hl.LCP(*random_p(np.random.default_rng(2), 12)).scaled
    for steps, close in ((1, 1e-5), (10, 1e-4)):
        a = AsPrinted(max_iterations=steps, tol=1e-30, seed=3).propose(p).z
        b = hl.NSNGRK(max_iterations=steps, tol=1e-30, seed=3, polish=False).propose(p).z
        assert 0 < abs(a - b).max() < close


def test_where_both_of_a_pair_vanish_differences_stop_short_of_what_subgradients_reach():
    p = example(3).grasp.problem(8).scaled
    printed, ours = (s.propose(p) for s in (AsPrinted(1e-8, 60_000), hl.NSNGRK(1e-8, 60_000, polish=False)))
    assert ours.outcome == "converged"
    both = np.maximum(abs(ours.z), abs(p.M @ ours.z + p.q))
    assert (both < 1e-7).sum() == 1, "one pair of zeros: there a difference over 1e-6 is no subgradient"
    assert printed.iterations == 60_000
    says(printed.outcome, "60000")
    assert 1e-8 < np.linalg.norm(phi(p, printed.z)) < 10 * H
