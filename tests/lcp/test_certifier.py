"""The certifier trusts nobody: corrupted answers are refused, and NaN never passes."""

import ast

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import certify, is_farkas
from tests.lcp.problems import random_p
from tests.support.lcp import CERTIFIERS


@pytest.fixture
def solved():
    p = hl.LCP(*random_p(np.random.default_rng(2), 8))
    return p, hl.solve_lcp(p).z


def test_a_solution_passes(solved):
    assert certify(*solved)[0] is hl.Status.SOLVED


@pytest.mark.parametrize("k", range(8))
@pytest.mark.parametrize("change", [1e-6, -1e-6, 1.0, np.nan, np.inf, -np.inf])
def test_any_corrupted_entry_is_refused(solved, k, change):
    p, z = solved
    z = z.copy()
    z[k] += change
    status, _, residual = certify(p, z)
    assert status is hl.Status.UNDECIDED
    assert not residual <= 1e-8


def test_huge_cancelling_numbers_excuse_nothing():
    # columns 0 and 1 cancel: w = z_0 - z_1 - 1 in every row; 1e14 of each leaves rounding of 1e-2
    p = hl.LCP([[1.0, -1.0], [-1.0, 1.0]], [-1.0, 1.0])
    assert certify(p, np.array([1.0, 0.0]))[0] is hl.Status.SOLVED
    assert certify(p, np.array([1e14 + 1.015625, 1e14]))[0] is hl.Status.UNDECIDED


@pytest.mark.parametrize("z", [3.0, np.nan])
def test_a_solver_that_lies_is_found_out(z):
    class Liar:
        def propose(self, problem, start=None):
            return hl.lcp.Proposal(np.full(len(problem.q), z), 1, "converged, of course")

    s = hl.solve_lcp(hl.LCP(np.eye(3), [-1, -1, -1]), Liar(), throw=False)
    assert s.status is hl.Status.UNDECIDED
    assert np.isinf(s.residual) == np.isnan(z)


def test_farkas_vectors_are_checked_by_their_signs():
    p = hl.LCP([[-1, 0], [0, 1]], [-1, -1])  # row 0: w = -z - 1 < 0
    s = hl.solve_lcp(p, throw=False)
    assert s.status is hl.Status.INFEASIBLE
    y = s.certificate
    assert (y >= 0).all()
    assert (p.M.T @ y <= 0).all()
    assert p.q @ y < 0
    assert not is_farkas(p, np.array([0.0, 1.0]))
    assert not is_farkas(p, np.array([-1.0, 0.0]))
    assert not is_farkas(p, np.array([np.nan, 0.0]))
    assert not is_farkas(p, np.zeros(2))


def test_a_mixed_problem_whose_equations_contradict_is_infeasible():
    p = hl.LCP([[0, 0, 1], [0, 0, 1], [0, 0, 1]], [0, 1, 0.0], [True, True, False])
    s = hl.solve_lcp(p, throw=False)
    assert s.status is hl.Status.INFEASIBLE
    assert is_farkas(p, s.certificate)


def test_unsolved_is_not_infeasible():
    # feasible (z = (2, 0) gives w ≥ 0) but without a complementary solution: a fact no solver may dress up
    p = hl.LCP([[0, 1], [0, 0]], [-1, 0.0])
    s = hl.solve_lcp(hl.LCP([[0, -1], [1, 0]], [1, -1.0]), throw=False)
    assert s.status is hl.Status.SOLVED
    s = hl.solve_lcp(p, throw=False)
    assert s.status in (hl.Status.SOLVED, hl.Status.UNDECIDED)


@pytest.mark.parametrize("file", CERTIFIERS, ids=lambda file: f"{file.parent.name}/{file.name}")
def test_certifiers_import_no_solver(file):
    names = [n.module or "" for n in ast.walk(ast.parse(file.read_text())) if isinstance(n, ast.ImportFrom)]
    assert not [n for n in names if "solver" in n or n.endswith(".solve")]
