"""NSNGRK is the paper's Algorithm 2: subgradients, threshold, index set, sampling and step, checked one by one."""

import numpy as np
import pytest

import handlcp as hl
from tests.lcp.problems import random_p
from tests.support.kernels import compiled
from tests.support.lcp import Kaczmarz, uniform_numbers


def phi(M, q, free, z):
    w = M @ z + q
    return np.where(free, w, np.hypot(z, w) - z - w)


def jacobian(M, q, free, z):
    """The paper's generalized Jacobian, equation (19), by central differences."""
    h = 1e-6
    return np.column_stack(
        [(phi(M, q, free, z + h * e) - phi(M, q, free, z - h * e)) / (2 * h) for e in np.eye(len(q))]
    )


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
    f, J = phi(M, q, free, z), jacobian(M, q, free, z)
    g2 = (J * J).sum(1)
    # thresholds (21) and set (22)
    epsilon = 0.5 * ((f**2 / g2).max() / (f @ f)) + 0.5 / (J * J).sum()
    U = np.flatnonzero(f**2 >= epsilon * (f @ f) * g2 * (1 - 1e-6))
    z1, w1, _ = one_step(M, q, free, z, seed)
    targets = [z - f[i] / g2[i] * J[i] for i in U]  # equation (20)
    assert min(abs(z1 - t).max() for t in targets) < 1e-6
    np.testing.assert_allclose(w1, M @ z1 + q, atol=1e-12)


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
