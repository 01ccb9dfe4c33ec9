"""Complementarity problems that come from no grasp: standard and mixed, cited hard ones and whole classes.

Sources: K. G. Murty, Linear Complementarity, Linear and Nonlinear Programming (1988), examples 2.8, 2.9 and 2.11, and
his P-matrices that cost Lemke's method 2ⁿ pivots; Y. Fathi's symmetric variant (Math. Program. 17, 1979); M. M.
Kostreva's two cycling examples (Math. Program. 16, 1979).
"""

import numpy as np
import pytest

import handlcp as hl
from tests.hard_cases.scenes import count
from tests.lcp.problems import semidefinite
from tests.oracle import every_solution

ENOUGH = 1e-7


def missed(M, q, free, z):
    """Worst |min(z, w)| (|w| where free) with each row and unknown measured by the terms that it is made of.

    A row whose terms all vanish has no size but that of the rounding in z, so no row counts as smaller than 1e-8.
    """
    w = M @ z + q
    row = np.maximum(abs(M) @ abs(z), abs(q))
    row = np.maximum(row, row.max(initial=0.0) * 1e-8) + 1e-300
    column = np.maximum(abs(z).max(initial=0.0), 1e-300)
    r, s = w / row, z / column
    pairs = np.maximum(np.maximum(-r, -s), np.minimum(abs(r), abs(s)))
    return float(np.where(free, abs(r), pairs).max(initial=0.0))


def proves(M, q, free, y):
    """Farkas: y ≥ 0, Mᵀy ≤ 0, qᵀy < 0 (free: any sign of y, Mᵀy = 0), by signs alone."""
    size = abs(M).T @ abs(y)
    slack = M.T @ y
    bad = np.where(free, abs(slack), slack)
    return bool((y[~free] >= 0).all() and (bad <= 1e-9 * size).all() and q @ y < -1e-9 * (abs(q) @ abs(y)))


def judged(M, q, free=None, start=None):
    """What came out: "solved", "infeasible" or "undecided"; anything claimed is checked here."""
    M, q = np.asarray(M, float), np.asarray(q, float)
    mask = np.zeros(len(q), bool) if free is None else free
    s = hl.solve_lcp(hl.LCP(M, q, free), throw=False, start=start)
    if s.status is hl.Status.SOLVED:
        assert missed(M, q, mask, s.z) < ENOUGH
        return "solved"
    if s.status is hl.Status.INFEASIBLE:
        assert proves(M, q, mask, s.certificate)
        return "infeasible"
    assert s.status in (hl.Status.UNDECIDED, hl.Status.NO_EQUILIBRIUM)
    return "undecided"


def nearest_known(M, q, s):
    """Distance from s.z to the nearest solution that enumeration finds, relative."""
    return min(abs(s.z - z).max() / max(1.0, abs(z).max()) for z in every_solution(M, q))


MURTY_2_8 = ([[1, -1, -1, -1], [-1, 1, -1, -1], [1, 1, 2, 0], [1, 1, 0, 2]], [3, 5, -9, -5])
MURTY_2_9 = ([[-1, 0, -3], [1, -2, -5], [-2, -1, -2]], [-3, -2, -1])
MURTY_2_11 = ([[-1.5, 2], [-4, 4]], [-5, 17])
KOSTREVA_1 = ([[1, 2, 0], [0, 1, 2], [2, 0, 1]], [-1, -1, -1])
KOSTREVA_2 = ([[1, -1, 3], [2, -1, 3], [-1, -2, 0]], [-1, -1, -1])


@pytest.mark.parametrize("solver", [None, hl.Lemke()])
@pytest.mark.parametrize("problem", [MURTY_2_8, MURTY_2_11, KOSTREVA_1], ids=["Murty 2.8", "Murty 2.11", "Kostreva 1"])
def test_cited_problems_with_a_solution_give_one_of_the_enumeration(problem, solver):
    M, q = (np.array(a, float) for a in problem)
    assert nearest_known(M, q, hl.solve_lcp(hl.LCP(M, q), solver)) < 1e-9


@pytest.mark.parametrize("problem", [MURTY_2_9, KOSTREVA_2], ids=["Murty 2.9", "Kostreva 2"])
def test_cited_problems_that_end_in_a_ray_are_infeasible_and_proven_so(problem):
    assert every_solution(*problem) == []
    assert judged(*problem) == "infeasible"


@pytest.mark.parametrize("n", [2, 10, 20])
def test_exponential_p_matrices_of_murty_and_positive_definite_ones_of_fathi_are_solved(n):
    L = 2 * np.tril(np.ones((n, n)), -1) + np.eye(n)
    for M in (L, L @ L.T):
        np.testing.assert_allclose(hl.solve_lcp(hl.LCP(M, -np.ones(n))).z, np.eye(n)[0], atol=1e-7)


# ---------------------------------------------------------------- whole classes, each with a solution by construction
def built(rng, M, degenerate=0.3):
    """Q that gives M a solution with about a third of z, of w, and of both zero."""
    n = len(M)
    kind = rng.random(n)
    z = np.where(kind < 0.5, rng.uniform(0.5, 2, n), 0.0)
    w = np.where(kind > 0.5 + degenerate / 2, rng.uniform(0.5, 2, n), 0.0)
    w[z > 0] = 0.0
    return w - M @ z


def definite(rng, n):
    A, B = rng.normal(size=(2, n, n))
    return A @ A.T / n + 0.1 * np.eye(n) + B - B.T


def skew(rng, n):
    B = rng.normal(size=(n, n))
    return B - B.T


def copositive(rng, n):
    return semidefinite(rng, n) + rng.uniform(0, 2, (n, n)) * (rng.random((n, n)) < 0.5) + 0.1 * np.eye(n)


def nonnegative(rng, n):
    return rng.uniform(0, 1, (n, n)) + np.eye(n)


def dominant(rng, n):
    M = rng.normal(size=(n, n))
    return M + np.diag(abs(M).sum(1))


CLASSES = {f.__name__: f for f in (definite, semidefinite, skew, copositive, nonnegative, dominant)}


@pytest.mark.parametrize("degenerate", [0.0, 0.8])
@pytest.mark.parametrize("kind", CLASSES)
def test_classes_that_a_theorem_covers_are_solved(kind, degenerate):
    lost = []
    for i in range(count(8)):
        rng = np.random.default_rng([list(CLASSES).index(kind), i])
        n = int(rng.integers(2, 25))
        M = CLASSES[kind](rng, n)
        if judged(M, built(rng, M, degenerate)) != "solved":
            lost.append(i)
    assert not lost, f"{len(lost)} undecided though solvable: {lost}"


@pytest.mark.parametrize("kind", CLASSES)
def test_bad_scaling_changes_nothing(kind):
    for i in range(count(4)):
        rng = np.random.default_rng([50, list(CLASSES).index(kind), i])
        n = int(rng.integers(2, 16))
        M = CLASSES[kind](rng, n)
        q = built(rng, M)
        rows, columns = 10.0 ** rng.uniform(-8, 8, (2, n))
        s = hl.solve_lcp(hl.LCP(rows[:, None] * M * columns, rows * q), throw=False)
        assert s.status is hl.Status.SOLVED, i
        assert missed(M, q, np.zeros(n, bool), s.z * columns) < ENOUGH, i


@pytest.mark.parametrize("kind", ["definite", "semidefinite", "dominant"])
def test_mixed_problems_are_solved(kind):
    for i in range(count(8)):
        rng = np.random.default_rng([60, list(CLASSES).index(kind), i])
        n = int(rng.integers(3, 20))
        M = CLASSES[kind](rng, n)
        free = rng.permutation(n) < rng.integers(1, n)
        z = np.where(free, rng.normal(size=n), np.where(rng.random(n) < 0.5, rng.uniform(0.5, 2, n), 0.0))
        w = np.where(free | (z > 0), 0.0, rng.uniform(0.5, 2, n) * (rng.random(n) < 0.7))
        assert judged(M, w - M @ z, free) == "solved", i


def test_quadratic_programs_with_redundant_equations_are_solved():
    """Mixed, with a singular free block: multipliers of equations that repeat each other."""
    for i in range(count(8)):
        rng = np.random.default_rng([61, i])
        n, k = int(rng.integers(3, 12)), 3
        A = rng.normal(size=(k, n))
        A[2] = A[0] + A[1]
        H = rng.normal(size=(n, n // 2 + 1))
        M = np.block([[H @ H.T, -A.T], [A, np.zeros((k, k))]])
        free = np.arange(n + k) >= n
        z = np.where(free, rng.normal(size=n + k), np.where(rng.random(n + k) < 0.6, rng.uniform(0.5, 2, n + k), 0))
        w = np.where(free | (z > 0), 0.0, rng.uniform(0.5, 2, n + k))
        assert judged(M, w - M @ z, free) == "solved", i


def test_bimatrix_games_have_equilibria():
    """Lemke & Howson's problem: costs A, B > 0, M = [0 A; Bᵀ 0], q = -1: every game has an equilibrium."""
    lost = []
    for i in range(count(8)):
        rng = np.random.default_rng([62, i])
        m, n = rng.integers(2, 9, 2)
        A, B = rng.uniform(1, 9, (2, m, n))
        M = np.block([[np.zeros((m, m)), A], [B.T, np.zeros((n, n))]])
        if judged(M, -np.ones(m + n)) != "solved":
            lost.append(i)
    assert not lost, f"{len(lost)} undecided though solvable: {lost}"


def test_infeasible_problems_are_proven_infeasible():
    """A Farkas vector is built in: y ≥ 0 with Mᵀy ≤ 0 and qᵀy < 0."""
    for i in range(count(10)):
        rng = np.random.default_rng([63, i])
        n = int(rng.integers(2, 15))
        M, q = rng.normal(size=(n, n)), rng.normal(size=n)
        y = rng.uniform(0.5, 2, n) * (rng.random(n) < 0.7)
        y[0] = 1.0
        M[0] -= (M.T @ y) + rng.uniform(0, 1, n)  # Mᵀy ≤ 0
        q[0] -= q @ y + 1.0
        assert judged(M, q) == "infeasible", i


@pytest.mark.parametrize("mixed", [False, True])
def test_any_small_matrix_gets_the_answer_of_the_enumeration(mixed):
    """No structure at all, without and with free rows: solved when enumeration finds a solution, and only then."""
    lost = []
    for i in range(count(40)):
        rng = np.random.default_rng([64 + mixed, i])
        n = int(rng.integers(1 + mixed, 7 + mixed))
        whole = not mixed and i % 2 == 0
        M = rng.integers(-2, 3, (n, n)).astype(float) if whole else rng.normal(size=(n, n))
        q = rng.integers(-2, 3, n).astype(float) if whole else rng.normal(size=n)
        free = rng.permutation(n) < rng.integers(1, n) if mixed else None
        exists, result = bool(every_solution(M, q, free)), judged(M, q, free)
        assert not (result == "solved" and not exists), i
        assert not (result == "infeasible" and exists), i
        if exists and result != "solved":
            lost.append(i)
    assert not lost, f"{len(lost)} undecided though solvable: {lost}"


@pytest.mark.parametrize("n", [30, 60])
def test_larger_problems_of_every_class(n):
    for kind, make in CLASSES.items():
        rng = np.random.default_rng([66, n])
        M = make(rng, n)
        assert judged(M, built(rng, M)) == "solved", kind


# ---------------------------------------------------------------- degenerate shapes
@pytest.mark.parametrize(
    ("M", "q", "free", "expected"),
    [
        (np.zeros((3, 3)), np.zeros(3), None, "solved"),
        (np.zeros((3, 3)), -np.ones(3), None, "infeasible"),
        (np.zeros((2, 2)), np.ones(2), np.ones(2, bool), "infeasible"),
        ([[1.0, 1], [1, 1]], [-1.0, -2], np.ones(2, bool), "infeasible"),
        ([[1.0, 1], [1, 1]], [-1.0, -1], np.ones(2, bool), "solved"),
        ([[0.0]], [-1e-140], None, "infeasible"),
        ([[1e-140]], [-1e-140], None, "solved"),
        ([[-1.0]], [1.0], None, "solved"),
        ([[0.0, 1], [1, 0]], [-1.0, -1], None, "solved"),
        ([[0.0, 1], [0, 0]], [0.0, 0], np.array([True, False]), "solved"),
    ],
)
def test_problems_of_zeros_ones_and_extremes(M, q, free, expected):
    assert judged(np.asarray(M, float), np.asarray(q, float), free) == expected
