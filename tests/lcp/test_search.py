"""The search over all active sets: finds what exists, and says "none" only where an exhaustive oracle finds none."""

import time

import numpy as np
import pytest

from handlcp.errors import InputError
from handlcp.lcp import LCP
from handlcp.lcp.certificate import search_active_sets
from tests.lcp.problems import KNOWN, random_psd
from tests.oracle import every_solution
from tests.support.lcp import certified


@pytest.mark.parametrize("seed", range(40))
def test_it_agrees_with_every_active_set_of_random_problems(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    M, q = rng.normal(size=(n, n)), rng.normal(size=n)
    free = rng.random(n) < 0.3 if seed % 2 else None
    problem, solutions = LCP(M, q, free), every_solution(M, q, free)
    r = search_active_sets(problem)
    assert r.outcome == ("solution" if solutions else "none")
    if solutions:
        assert certified(problem, r.z)
        assert any(np.allclose(r.z * problem.scaled.units.z, z, rtol=1e-6, atol=1e-8) for z in solutions)


@pytest.mark.parametrize("name", KNOWN)
def test_it_solves_the_known_problems(name):
    problem = LCP(*KNOWN[name])
    r = search_active_sets(problem)
    assert r.outcome == "solution"
    assert certified(problem, r.z)


@pytest.mark.parametrize("seed", range(5))
def test_it_solves_semidefinite_problems_whose_active_sets_are_singular(seed):
    problem = LCP(*random_psd(np.random.default_rng(seed), 8))
    assert certified(problem, search_active_sets(problem).z)


def test_a_solution_beyond_the_box_is_one_all_the_same():
    problem = LCP([[1.0]], [-20.0], units=LCP([[1.0]], [-1.0]).scaled.units)
    assert search_active_sets(problem, 10.0, 10.0).outcome == "solution"
    assert search_active_sets(LCP([[-1.0]], [-1.0])).outcome == "none"


def test_a_mixed_problem_and_one_without_pairs():
    mixed = LCP([[0.0, 1.0], [1.0, 1.0]], [-1.0, 2.0], free=np.array([True, False]))
    np.testing.assert_allclose(search_active_sets(mixed).z * mixed.scaled.units.z, [-3.0, 1.0])
    linear = LCP([[2.0, 0.0], [0.0, 4.0]], [2.0, -4.0], free=np.array([True, True]))
    np.testing.assert_allclose(search_active_sets(linear).z * linear.scaled.units.z, [-1.0, 1.0])
    assert search_active_sets(LCP([[0.0]], [1.0], free=np.array([True]))).outcome == "none"


def test_what_the_certifier_refuses_is_cut_off_and_none_is_no_longer_claimed():
    # two solutions, 0 and 1: w = 1 - z … refused one by one, what is left is "unknown"
    problem, seen = LCP([[-1.0]], [1.0]), []
    r = search_active_sets(problem, 10.0, 10.0, accept=lambda z: bool(seen.append(z.copy())))
    assert r.outcome == "unknown"
    assert r.z is None
    assert r.cuts == 2
    assert {round(float(z[0]), 9) for z in seen} == {0.0, round(1.0 / problem.scaled.units.z[0], 9)}


def test_no_work_and_no_time_are_no_claim():
    rng = np.random.default_rng(2)
    M, q = rng.normal(size=(20, 20)), rng.normal(size=20)
    assert search_active_sets(LCP(M, q), work=1.0).outcome == "unknown"
    assert search_active_sets(LCP(M, q), end=time.monotonic() - 1.0).outcome == "unknown"


def test_bounds_that_bound_nothing_are_refused():
    problem = LCP(np.eye(2), [-1.0, 1.0])
    with pytest.raises(InputError, match="bound_z"):
        search_active_sets(problem, 0.0, 1.0)
    with pytest.raises(InputError, match="bound_w"):
        search_active_sets(problem, 1.0, [1.0, -1.0])
    with pytest.raises(InputError, match="work"):
        search_active_sets(problem, work=0.0)
