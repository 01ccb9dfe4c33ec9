"""Every solver on every structure: what it calls an answer is one, and it is the oracle's."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import Units
from tests.lcp.problems import KNOWN, random_p, random_psd
from tests.oracle import every_solution

SOLVERS = {
    "auto": hl.Auto(),
    "nsngrk": hl.NSNGRK(),
    "lemke": hl.Lemke(),
    "newton": hl.SemismoothNewton(),
    "nsngrk_unpolished": hl.NSNGRK(polish=False, max_iterations=200_000),
}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", KNOWN)
def test_known_problems_give_a_solution_of_the_oracle(name, solver):
    M, q = KNOWN[name]
    s = hl.solve_lcp(hl.LCP(M, q), SOLVERS[solver], throw=False)
    if s.status is not hl.Status.SOLVED:
        # Newton may stall and plain Kaczmarz may need more steps where M is singular: they may fail, never lie
        assert solver in ("newton", "nsngrk_unpolished")
        assert s.status is hl.Status.UNDECIDED
        return
    assert (s.z >= -1e-7 * abs(s.z).max()).all()
    oracle = every_solution(M, q)
    scale = hl.LCP(M, q).scaled.units.z
    close = min(float(abs((s.z - z) / scale).max()) for z in oracle)
    singular = np.linalg.matrix_rank(np.asarray(M, float)) < len(q)
    assert close < 1e-6 or singular  # of a continuum the oracle knows one member only


@pytest.mark.parametrize("solver", ["auto", "nsngrk", "lemke"])
@pytest.mark.parametrize("n", [1, 4, 8])
@pytest.mark.parametrize("seed", range(4))
def test_p_matrices_have_one_solution_and_it_is_found(n, seed, solver):
    M, q = random_p(np.random.default_rng([n, seed]), n)
    (z,) = every_solution(M, q)
    s = hl.solve_lcp(hl.LCP(M, q), SOLVERS[solver])
    np.testing.assert_allclose(s.z, z, atol=1e-8 * max(1, abs(z).max()))


@pytest.mark.parametrize("solver", ["auto", "nsngrk", "lemke", "newton"])
@pytest.mark.parametrize("seed", range(6))
def test_positive_semidefinite_problems_are_solved(seed, solver):
    M, q = random_psd(np.random.default_rng(seed), 20)
    s = hl.solve_lcp(hl.LCP(M, q), SOLVERS[solver])
    assert s.residual < 1e-8
    np.testing.assert_allclose(s.w, M @ s.z + q, atol=1e-12)


@pytest.mark.parametrize("solver", ["auto", "nsngrk", "lemke"])
@pytest.mark.parametrize("seed", range(4))
def test_mixed_problems_agree_with_the_oracle(seed, solver):
    rng = np.random.default_rng(seed)
    M, q = random_p(rng, 8)
    free = rng.permutation(8) < 3
    (z,) = every_solution(M, q, free)
    s = hl.solve_lcp(hl.LCP(M, q, free), SOLVERS[solver])
    np.testing.assert_allclose(s.z, z, atol=1e-7)
    assert abs(s.w[free]).max() < 1e-8


@pytest.mark.parametrize("solver", ["auto", "nsngrk", "lemke"])
def test_units_change_neither_answer_nor_path(solver):
    M, q = random_psd(np.random.default_rng(3), 12)
    rng = np.random.default_rng(4)
    units = hl.LCP(M, q).scaled.units
    a = hl.solve_lcp(hl.LCP(M, q, units=units), SOLVERS[solver])
    # powers of two, so that not even rounding differs
    dz, dw = 2.0 ** rng.integers(-30, 30, 12), 2.0 ** rng.integers(-30, 30, 12)
    b = hl.solve_lcp(hl.LCP(dw[:, None] * M / dz, dw * q, units=Units(units.z * dz, units.w * dw)), SOLVERS[solver])
    assert a.iterations == b.iterations
    np.testing.assert_array_equal(a.z * dz, b.z)


def test_equilibration_makes_answers_independent_of_units_to_rounding():
    M, q = random_p(np.random.default_rng(8), 10)
    rng = np.random.default_rng(9)
    dz, dw = 10.0 ** rng.uniform(-8, 8, 10), 10.0 ** rng.uniform(-8, 8, 10)
    a, b = hl.solve_lcp(hl.LCP(M, q)), hl.solve_lcp(hl.LCP(dw[:, None] * M / dz, dw * q))
    np.testing.assert_allclose(a.z * dz, b.z, rtol=1e-9, atol=0)


def test_a_warm_start_at_the_solution_needs_no_step():
    M, q = random_p(np.random.default_rng(1), 10)
    s = hl.solve_lcp(hl.LCP(M, q))
    again = hl.solve_lcp(hl.LCP(M, q), hl.NSNGRK(polish=False, tol=1e-8), start=s.z)
    assert again.iterations == 0
