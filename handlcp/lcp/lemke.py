"""Lemke's complementary pivoting on a dictionary (paper, Algorithm 1), with lexicographic ties.

The dictionary writes the n basic variables as affine functions of the n + 1 others; it starts as w = q + M z + d z₀.
Lexicographic order perturbs q by (ε, ε², …). No column has to be kept for that: where w_c is nonbasic the
coefficient of ε_c in row i is minus its dictionary entry, and where it is basic it is one in its own row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from handlcp.check import Array, Bools, Ints, check_init_call, check_integer, check_number, read_only
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.kernels.newton import polish_active_set
from handlcp.lcp.problem import Proposal, ScaledLCP
from handlcp.tolerances import PIVOT_TOLERANCE, RANK_TOLERANCE, SOLVE_TOLERANCE

SOLVED, RAY, SPENT = 0, 1, 2


@kernel
def pivot_lemke(M: Array, q: Array, d: Array, most: int, pivot: float) -> tuple[int, int, Array]:
    """Pivot until z₀ leaves. d (n,) > 0 is the covering vector, `pivot` the relative tolerance of pivots and ties.

    Returns (SOLVED | RAY | SPENT, pivots, z (n,)); z is what the last basis says, whatever the outcome.
    Variables are numbered w: 0 … n-1, z: n … 2n-1, z₀: 2n.
    """
    n = len(q)
    D = np.empty((n, n + 2))  # columns: z₀, the n others, constant
    D[:, 0], D[:, 1 : n + 1], D[:, n + 1] = d, M, q
    basic, nonbasic = np.arange(n), np.arange(n - 1, 2 * n)
    nonbasic[0] = 2 * n
    column = np.full(2 * n + 1, -1, np.int64)  # where a nonbasic variable stands
    column[nonbasic] = np.arange(n + 1)
    z, row = np.zeros(n), 0
    for i in range(1, n):  # z₀ enters where q_i / d_i is least; of equals the last, which is lexicographically least
        if q[i] * d[row] <= q[row] * d[i]:
            row = i
    if n == 0 or q[row] >= 0.0:
        return SOLVED, 0, z
    entering, status, count = 0, SPENT, 0
    while count < most:
        leaving = basic[row]
        _exchange(D, row, entering)
        basic[row], nonbasic[entering] = nonbasic[entering], leaving
        column[basic[row]], column[leaving] = -1, entering
        count += 1
        if leaving == 2 * n:
            status = SOLVED
            break
        entering = column[leaving + n if leaving < n else leaving - n]
        row = _leaving_row(D, entering, basic, column, pivot)
        if row < 0:
            status = RAY
            break
    for i in range(n):
        if n <= basic[i] < 2 * n:
            z[basic[i] - n] = D[i, n + 1]
    return status, count, z


@kernel
def _exchange(D: Array, r: int, e: int) -> None:
    """Swap the basic variable of row r with the nonbasic variable of column e."""
    rows, columns = D.shape
    p = 1.0 / D[r, e]
    for c in range(columns):
        D[r, c] *= -p
    D[r, e] = p
    for i in range(rows):
        f = D[i, e]
        if i != r and f != 0.0:
            D[i, e] = 0.0
            for c in range(columns):
                D[i, c] += f * D[r, c]


@kernel
def _leaving_row(D: Array, e: int, basic: Ints, column: Ints, tolerance: float) -> int:
    """The row that blocks the growth of column e first; of equals z₀, then the lexicographically least. -1: none."""
    n, last = D.shape[0], D.shape[1] - 1
    size, constants = 0.0, 0.0
    for i in range(n):
        size, constants = max(size, abs(D[i, e])), max(constants, abs(D[i, last]))
    least = np.inf
    for i in range(n):
        if D[i, e] < -tolerance * size:
            least = min(least, max(D[i, last], 0.0) / -D[i, e])
    row = -1
    for i in range(n):
        if D[i, e] < -tolerance * size and D[i, last] + D[i, e] * least <= tolerance * constants:
            if basic[i] == 2 * n:
                return i
            if row < 0 or _is_lexicographically_less(D, i, row, e, basic, column):
                row = i
    return row


@kernel
def _is_lexicographically_less(D: Array, i: int, k: int, e: int, basic: Ints, column: Ints) -> bool:
    """Whether row i's perturbed ratio is lexicographically less than row k's."""
    for c in range(D.shape[0]):
        at = column[c]  # w_c
        a = (-D[i, at] if at >= 0 else 1.0 * (basic[i] == c)) / -D[i, e]
        b = (-D[k, at] if at >= 0 else 1.0 * (basic[k] == c)) / -D[k, e]
        if abs(a - b) > 1e-9 * max(abs(a), abs(b)):
            return bool(a < b)
    return False


# ----------------------------------------------------------------
# Free unknowns out of a mixed problem, so that a pivoting method meets a standard one.
#
# With S the free unknowns, the rows of S read K x_S = y_S - M_SB x_B - q_S, K = M_SS, y_S = 0. Where K is singular,
# complementary pairs join S until it is not: their x and y then trade places, which leaves complementarity as it is
# (a principal pivotal transform; Cottle, Pang & Stone, The Linear Complementarity Problem, 2.3). Directions of K that
# touch nothing at all, such as the spin of an object between two fingertips, are held at zero.


@dataclass(frozen=True, slots=True)
class ReducedLCP:
    """A standard problem M (k, k), q (k,), and x = back_M v + back_q, the mixed x for its unknowns v."""

    M: Array
    q: Array
    back_M: Array
    back_q: Array
    consistent: bool

    def restore(self, v: Array) -> Array:
        """The unknowns (n,) of the mixed problem, from those of the reduced one."""
        with np.errstate(over="ignore", invalid="ignore"):  # the certifier refuses what is not finite
            return self.back_M @ v + self.back_q


def eliminate_free(problem: ScaledLCP) -> ReducedLCP:
    """Eliminate the free unknowns. `consistent` is False when an equation that touches no unknown is not 0 = 0."""
    M, q, free = problem.M, problem.q, problem.free
    n = len(q)
    swapped, (U, sv, Vt) = _regularise_free(M, free)
    S, B = free | swapped, ~(free | swapped)
    keep = sv > RANK_TOLERANCE * sv.max(initial=0.0)
    # Columns of `right`: y of the swapped pairs (unknowns of the new problem), x_B, constant
    own = np.eye(int(S.sum()))[:, swapped[S]]
    right = np.hstack([own, -M[np.ix_(S, B)], -q[S, None]])
    lost = U[:, ~keep].T @ right
    consistent = bool(abs(lost[:, -1]).max(initial=0.0) <= 1e-9 * max(1.0, float(abs(q).max(initial=0.0))))
    full = np.zeros((n, right.shape[1]))
    with np.errstate(over="ignore", invalid="ignore"):
        full[S] = (Vt[keep].T / sv[keep]) @ (U[:, keep].T @ right)
    count = int(swapped.sum())
    full[np.flatnonzero(B), count + np.arange(int(B.sum()))] = 1.0
    rows = np.vstack([full[swapped], M[B] @ full])
    rows[count:, -1] += q[B]
    M, q = read_only(np.ascontiguousarray(rows[:, :-1])), read_only(rows[:, -1].copy())
    return ReducedLCP(M, q, full[:, :-1], full[:, -1], consistent)


def _regularise_free(M: Array, free: Bools) -> tuple[Bools, tuple[Array, Array, Array]]:
    """Complementary pairs whose joining makes the free block K regular, as far as they can; and K's singular values."""
    swapped = np.zeros(len(free), bool)
    while True:
        S, B = free | swapped, np.flatnonzero(~(free | swapped))
        U, sv, Vt = np.linalg.svd(M[np.ix_(S, S)])
        null = sv <= RANK_TOLERANCE * sv.max(initial=0.0)
        # How strongly each candidate resists what is singular, from its row (seen by Vt) and its column (seen by U)
        column = U[:, null].T @ M[np.ix_(S, B)]
        size, other = np.linalg.norm(column, axis=0), np.linalg.norm(M[np.ix_(B, S)] @ Vt[null].T, axis=1)
        strength = size * other
        if strength.max(initial=0.0) <= RANK_TOLERANCE:  # as where nothing is singular, or no pair is left
            return swapped, (U, sv, Vt)
        _, _, order = scipy.linalg.qr(
            column * np.sqrt(strength / np.maximum(size**2, 1e-300)), mode="economic", pivoting=True
        )
        useful = [j for j in order[: int(null.sum())] if strength[j] > RANK_TOLERANCE]
        swapped[B[useful or [int(strength.argmax())]]] = True


# ----------------------------------------------------------------
# Lemke's method (paper, Algorithm 1): the classic, exact on what it can solve.


@check_init_call()
@dataclass(frozen=True, slots=True)
class Lemke:
    """Complementary pivoting with lexicographic ties and relative tolerances, compiled.

    max_iterations : pivots at most, in each attempt; None: 50 + 20 n.
    coverings : how many covering vectors to try before a secondary ray is accepted as the outcome; the first is all
        ones (the paper's), the others are drawn from `seed`. A ray proves nothing by itself: another covering vector
        may solve the same problem (Murty's example 2.11).
    seed : of the covering vectors after the first.

    Free unknowns are eliminated first (see `eliminate_free`). The answer is recomputed from its active set.
    """

    max_iterations: int | None = None
    coverings: int = 3
    seed: int = 0
    pivot_tolerance: float = PIVOT_TOLERANCE

    def __post_init__(self) -> None:
        object.__setattr__(self, "pivot_tolerance", check_number("pivot_tolerance", self.pivot_tolerance, above=0.0))
        if self.max_iterations is not None:
            check_integer("max_iterations", self.max_iterations, 1)
        check_integer("coverings", self.coverings, 1)
        check_integer("seed", self.seed, 0)

    def propose(self, problem: ScaledLCP, start: Array | None = None) -> Proposal:
        """Pivot from the origin; Lemke's method knows no warm start, so `start` only names the size."""
        if problem.free.any():
            reduced = eliminate_free(problem)
            if not reduced.consistent:
                return Proposal(np.full(len(problem.q), np.nan), 0, "an equation without unknowns does not hold")
            v, pivots, outcome = self._solve(reduced.M, reduced.q)
            z = reduced.restore(v)
        else:
            z, pivots, outcome = self._solve(problem.M, problem.q)
        # The same active set solved afresh from M: pivoting's accumulated rounding goes away
        z, _ = polish_active_set(problem.M, problem.q, problem.free, z, SOLVE_TOLERANCE * 1e-3)
        return Proposal(z, pivots, outcome)

    def _solve(self, M: Array, q: Array) -> tuple[Array, int, str]:
        n = len(q)
        rng = np.random.default_rng(self.seed)
        most = self.max_iterations or 50 + 20 * n
        total, covering, z, status = 0, np.ones(n), np.zeros(n), SOLVED
        for _ in range(self.coverings):
            status, pivots, z = pivot_lemke(M, q, covering, most, self.pivot_tolerance)
            total += pivots
            if status == SOLVED:
                return z, total, "complementary basis"
            covering = 10.0 ** rng.uniform(-1, 1, n)
        return z, total, "secondary ray" if status == RAY else f"{total} pivots spent"
