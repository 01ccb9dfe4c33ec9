"""NSNGRK as printed, step by step against the paper and beside the package's; seeds disagree in metres and newtons."""

import io

import numpy as np
import pytest
from rich.console import Console

import handlcp as hl
from handlcp.studies.accuracy import AsPrinted
from tests.lcp.problems import random_p
from tests.oracle import every_solution
from tests.support.scripts import script

printed = script("paper/nsngrk_as_printed")
SEEDS = range(5)


def problem(seed, n, free=None):
    M, q = random_p(np.random.default_rng(seed), n)
    return hl.LCP(M, q, np.zeros(n, bool) if free is None else free, units=hl.lcp.Units.ones(n)).scaled


def phi(p, z):
    w = p.M @ z + p.q
    return np.where(p.free, w, np.sqrt(z * z + w * w) - z - w)


def test_the_matrix_is_that_of_forward_differences():
    p, h = problem(0, 7, np.arange(7) < 2), 1e-6
    z = np.random.default_rng(1).normal(size=7)
    columns = np.column_stack([(phi(p, z + h * e) - phi(p, z)) / h for e in np.eye(7)])
    np.testing.assert_allclose(printed.subgradients(p.M, z, p.M @ z + p.q, p.free), columns, atol=1e-8)


def test_rows_are_drawn_from_the_greedy_set_in_proportion_to_their_squares():
    rng = np.random.default_rng(3)
    for _ in range(50):
        f, J = rng.normal(size=6), rng.normal(size=(6, 6))
        g2, chances = (J * J).sum(axis=1), printed.greedy_rows(f, J)
        mean = (f @ f) / g2.sum()
        greedy = f * f / g2 >= 0.5 * ((f * f / g2).max() + mean) * (1 - 1e-12)  # equation (20)
        assert ((chances > 0) == greedy).all()
        np.testing.assert_allclose(chances[greedy], (f * f)[greedy] / (f * f)[greedy].sum())


@pytest.mark.parametrize("seed", range(4))
def test_a_step_is_one_that_the_compiled_algorithm_takes_too(seed):
    """Two programs of the same page: over many seeds both go to the same few places."""
    p = problem(seed, 9)
    z = np.random.default_rng(seed).normal(size=9)
    ours = {tuple(printed.step(p, z, np.random.default_rng(k)).round(8)) for k in range(60)}
    theirs = {tuple(AsPrinted(1e-30, 1, k).propose(p, z).z.round(8)) for k in range(60)}
    assert len(ours & theirs) == len(ours) == len(theirs)


@pytest.mark.parametrize("seed", range(3))
def test_it_finds_the_one_solution_of_a_p_matrix(seed):
    p = problem(seed, 6)
    (z,) = every_solution(p.M, p.q, p.free)
    run = printed.algorithm_2(p, 0, res=1e-8, steps=100_000)
    assert run.residual < 1e-8
    np.testing.assert_allclose(run.z, z, atol=1e-6)


@pytest.mark.parametrize(("number", "faces"), [(3, 8), (5, 6)])
def test_seeds_disagree_unscaled_and_agree_in_natural_units(number, faces):
    case = printed.run_case(number, faces, SEEDS)
    assert all(r < printed.RES for r in case.residuals), "each run met the paper's stop rule"
    assert all(steps < printed.STEPS for steps in case.steps)
    assert case.spread > 0.02
    assert case.off > 0.05
    assert case.natural_spread < 1e-6
    np.testing.assert_allclose(case.natural, np.tile(case.ours, (len(SEEDS), 1)), rtol=1e-6)


@pytest.mark.parametrize(("number", "faces"), [(1, 8), (2, 4)])
def test_where_compliance_does_not_matter_the_printed_rule_is_good_enough(number, faces):
    assert printed.run_case(number, faces, range(2)).off < 1e-5


@pytest.mark.long
def test_all_cases_are_as_the_script_asserts():
    printed.main(Console(file=io.StringIO()))
