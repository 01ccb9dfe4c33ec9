"""NSNGRK is the paper's Algorithm 2: subgradients, threshold, index set, sampling and step, checked one by one.

AsPrinted is that algorithm to the letter: forward differences with h = 1e-6, then (20) to (22).
"""

import numpy as np
import pytest

import handlcp as hl
from handlcp.studies.accuracy import AsPrinted
from handlcp.studies.paper import example
from tests.lcp.problems import random_p
from tests.support.kernels import compiled
from tests.support.lcp import Kaczmarz, uniform_numbers
from tests.support.texts import says

H = 1e-6


def phi(M, q, free, z):
    w = M @ z + q
    return np.where(free, w, np.hypot(z, w) - z - w)


def jacobian(M, q, free, z, back=H):
    """The paper's generalized Jacobian, equation (19), by differences from `back` before to H ahead."""
    ways = np.eye(len(q))
    return np.column_stack([(phi(M, q, free, z + H * e) - phi(M, q, free, z - back * e)) / (H + back) for e in ways])


def projections(f, J, z):
    """Where a step may lead from z: (20), on the rows of the set (22), with the thresholds (21)."""
    g2 = (J * J).sum(1)
    epsilon = 0.5 * ((f**2 / g2).max() / (f @ f)) + 0.5 / (J * J).sum()
    return [z - f[i] / g2[i] * J[i] for i in np.flatnonzero(f**2 >= epsilon * (f @ f) * g2 * (1 - 1e-6))]


def one_step(M, q, free, z, seed):
    steps, norm, z, w = Kaczmarz(M, q, free).run(z.copy(), M @ z + q, seed, 1)
    assert steps == 1
    return z, w, norm


@pytest.mark.parametrize("seed", range(20))
def test_a_step_projects_on_a_row_of_the_greedy_set(seed):
    rng = np.random.default_rng(seed)
    M, q = random_p(rng, 9)
    free = rng.random(9) < 0.3
    z = rng.normal(size=9)
    z1, w1, _ = one_step(M, q, free, z, seed)
    targets = projections(phi(M, q, free, z), jacobian(M, q, free, z), z)
    assert min(abs(z1 - t).max() for t in targets) < 1e-6
    np.testing.assert_allclose(w1, M @ z1 + q, atol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_a_step_as_printed_projects_on_a_forward_difference_of_a_row_of_the_greedy_set(seed):
    rng = np.random.default_rng(seed)
    M, q = random_p(rng, 9)
    p = hl.LCP(M, q, rng.random(9) < 0.3, units=hl.LCP(M, q).scaled.units).scaled
    z = rng.normal(size=9)
    targets = projections(phi(p.M, p.q, p.free, z), jacobian(p.M, p.q, p.free, z, back=0.0), z)
    moved = AsPrinted(max_iterations=1, tol=1e-30, seed=seed).propose(p, z).z
    assert min(abs(moved - t).max() for t in targets) < 1e-8  # two ways to round w differ by 1e-16 / h


def test_rows_of_the_set_are_drawn_in_proportion_to_their_squared_residual():
    M, q = np.eye(3), np.array([-3.0, -2.9, -0.1])  # from zero φ = (6, 5.8, 0.2), of which the last is not greedy
    free = np.zeros(3, bool)
    hits = np.zeros(3)
    for seed in range(4000):
        z, _, _ = one_step(M, q, free, np.zeros(3), seed)
        hits[np.flatnonzero(z)[0]] += 1
    f = phi(M, q, free, np.zeros(3))
    assert hits[2] == 0
    assert hits[0] / hits[:2].sum() == pytest.approx(f[0] ** 2 / (f[:2] @ f[:2]), abs=0.03)


def test_the_generator_is_uniform_and_repeats_with_its_seed():
    u = uniform_numbers(7, 20_000)
    assert (u >= 0).all()
    assert (u < 1).all()
    np.testing.assert_allclose(np.histogram(u, 10, (0, 1))[0] / len(u), 0.1, atol=0.01)
    assert uniform_numbers(7, 1) == u[0]


def test_equal_seeds_give_equal_runs_and_others_do_not():
    p = hl.LCP(*random_p(np.random.default_rng(0), 12))
    runs = [hl.solve_lcp(p, hl.NSNGRK(seed=s, polish=False), throw=False) for s in (1, 1, 2)]
    np.testing.assert_array_equal(runs[0].z, runs[1].z)
    assert (runs[0].z != runs[2].z).any()


def test_history_holds_the_residual_at_its_stride_and_falls_linearly():
    p = hl.LCP(*random_p(np.random.default_rng(0), 12))
    s = hl.solve_lcp(p, hl.NSNGRK(polish=False, stride=10, max_iterations=50_000))
    steps, norms = s.history.T
    np.testing.assert_array_equal(steps, 10 * np.arange(len(steps)))
    assert norms[-1] < 1e-8 < norms[0]
    half = len(norms) // 2  # two halves of the run gain about the same number of decades
    first, second = np.log10(norms[0] / norms[half]), np.log10(norms[half] / norms[-1])
    assert 0.3 < first / second < 3


def test_polish_turns_a_rough_iterate_into_an_exact_one():
    p = hl.LCP(*random_p(np.random.default_rng(5), 15))
    rough = hl.solve_lcp(p, hl.NSNGRK(polish=False, tol=1e-2), throw=False)
    exact = hl.solve_lcp(p, hl.NSNGRK(polish=True))
    assert rough.residual > 1e-6
    assert exact.residual < 1e-14
    assert exact.iterations < rough.iterations + 15 * 15


@pytest.mark.parametrize(
    ("settings", "name"),
    [({"tol": 0}, "tol"), ({"tol": np.nan}, "tol"), ({"seed": -1}, "seed"), ({"seed": 1.5}, "seed"),
     ({"max_iterations": -1}, "max_iterations"), ({"stride": -2}, "stride"), ({"seed": 2**64}, "seed")],
)  # fmt: skip
def test_bad_settings_are_refused_by_name(settings, name):
    with pytest.raises(hl.InputError, match=name):
        hl.NSNGRK(**settings)


@pytest.mark.parametrize("tol", [1, np.float32(1e-3), np.int8(1)])
def test_a_setting_of_another_number_type_compiles_nothing_anew(tol):
    p = hl.LCP(np.eye(2), [-1.0, 1.0])
    hl.solve_lcp(p, hl.NSNGRK(tol=1e-3), throw=False)
    before = compiled()
    hl.solve_lcp(p, hl.NSNGRK(tol=tol), throw=False)
    assert compiled() == before > 0


# ---------------------------------------------------------------- as printed
def test_as_printed_it_follows_the_analytic_method_until_the_differences_show():
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
    assert 1e-8 < np.linalg.norm(phi(p.M, p.q, p.free, printed.z)) < 10 * H
