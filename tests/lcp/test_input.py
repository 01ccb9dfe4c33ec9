"""Bad input gives one typed error that names the argument."""

import math

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import Units

GOOD = {"M": np.eye(3), "q": [-1.0, 0.0, 1.0], "free": None}


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"M": np.eye(2)}, "M"),
        ({"M": np.ones((3, 2))}, "M"),
        ({"M": "abc"}, "M"),
        ({"M": np.full((3, 3), np.nan)}, "M"),
        ({"M": np.full((3, 3), np.inf)}, "M"),
        ({"M": [[1, 2], [3]]}, "M"),
        ({"q": [[1.0]]}, "q"),
        ({"q": [1, np.nan, 1]}, "q"),
        ({"q": None}, "q"),
        ({"free": [0, 1, 0]}, "free"),
        ({"free": [True, False]}, "free"),
    ],
)
def test_one_wrong_dimension_or_number(change, name):
    with pytest.raises(hl.InputError) as e:
        hl.LCP(**(GOOD | change))
    assert e.value.argument == name
    assert isinstance(e.value, ValueError)
    assert isinstance(e.value, hl.HandLCPError)


def solved(solver=None, start=None):
    return hl.solve_lcp(hl.LCP(np.eye(2), [1, 1]), solver, start=start)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: hl.LCP(np.eye(2), [1, 1], units=Units(np.array([1.0, 0.0]), np.ones(2))), r"units\.z"),
        (lambda: hl.LCP([[1e150]], [1.0], units=Units(np.full(1, 1e150), np.full(1, 1e-150))), "units"),  # overflows
        *((lambda solver=solver: solved(solver), "solver") for solver in ("lemke", 3, object())),
        (lambda: solved(start=[1.0]), "start"),
        (lambda: hl.solve_lcp((np.eye(2), [1, 1])), "problem"),
    ],
)
def test_what_is_no_unit_solver_start_or_problem_is_refused_by_name(call, words):
    with pytest.raises(hl.InputError, match=words):
        call()


@pytest.mark.parametrize(
    "make",
    [lambda: hl.Lemke(max_iterations=0), lambda: hl.Lemke(coverings=0), lambda: hl.Lemke(pivot_tolerance=-1),
     lambda: hl.SemismoothNewton(tol=0), lambda: hl.SemismoothNewton(max_iterations=0), lambda: hl.Auto(seed=-1),
     lambda: hl.Auto(restarts=1.5), lambda: hl.Auto(np.zeros(3)), lambda: hl.Auto(search_seconds=np.zeros(3)),
     lambda: hl.Auto(search_seconds=-math.inf)],
)  # fmt: skip
def test_solvers_check_their_settings(make):
    with pytest.raises(hl.InputError):
        make()


def test_problems_are_read_only():
    p = hl.LCP(np.eye(2), [1, 1])
    for a in (p.M, p.q, p.free, p.scaled.M, p.scaled.q):
        with pytest.raises(ValueError, match="read-only"):
            a[0] = 0


def test_an_empty_problem_is_solved():
    assert hl.solve_lcp(hl.LCP(np.zeros((0, 0)), [])).status is hl.Status.SOLVED
