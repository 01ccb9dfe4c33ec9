"""Free unknowns out of a mixed problem, so that a pivoting method meets a standard one.

With S the free unknowns, the rows of S read K x_S = y_S - M_SB x_B - q_S, K = M_SS, y_S = 0. Where K is singular,
complementary pairs join S until it is not: their x and y then trade places, which leaves complementarity as it is
(a principal pivotal transform; Cottle, Pang & Stone, The Linear Complementarity Problem, 2.3). Directions of K that
touch nothing at all, such as the spin of an object between two fingertips, are held at zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.lcp.problem import Scaled
from handlcp.tolerances import RANK


@dataclass(frozen=True, slots=True)
class Reduced:
    """A standard problem M (k, k), q (k,), and x = back_M v + back_q, the mixed x for its unknowns v."""

    M: Array
    q: Array
    back_M: Array
    back_q: Array
    consistent: bool

    def restore(self, v: Array) -> Array:
        """(n,) the mixed unknowns."""
        with np.errstate(over="ignore", invalid="ignore"):  # the certifier refuses what is not finite
            return self.back_M @ v + self.back_q


def reduce(problem: Scaled) -> Reduced:
    """Eliminate the free unknowns. `consistent` is False when an equation that touches no unknown is not 0 = 0."""
    M, q, free = problem.M, problem.q, problem.free
    n = len(q)
    swapped, (U, sv, Vt) = _swap(M, free)
    S, B = free | swapped, ~(free | swapped)
    keep = sv > RANK * sv.max(initial=0.0)
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
    return Reduced(M, q, full[:, :-1], full[:, -1], consistent)


def _swap(M: Array, free: Bools) -> tuple[Bools, tuple[Array, Array, Array]]:
    """Complementary pairs whose joining makes the free block K regular, as far as they can; and K's singular values."""
    swapped = np.zeros(len(free), bool)
    while True:
        S, B = free | swapped, np.flatnonzero(~(free | swapped))
        U, sv, Vt = np.linalg.svd(M[np.ix_(S, S)])
        null = sv <= RANK * sv.max(initial=0.0)
        # How strongly each candidate resists what is singular, from its row (seen by Vt) and its column (seen by U)
        column = U[:, null].T @ M[np.ix_(S, B)]
        size, other = np.linalg.norm(column, axis=0), np.linalg.norm(M[np.ix_(B, S)] @ Vt[null].T, axis=1)
        strength = size * other
        if strength.max(initial=0.0) <= RANK:  # as where nothing is singular, or no pair is left
            return swapped, (U, sv, Vt)
        from scipy.linalg import qr  # a tenth of a second of import that only singular blocks should pay

        _, _, order = qr(column * np.sqrt(strength / np.maximum(size**2, 1e-300)), mode="economic", pivoting=True)
        useful = [j for j in order[: int(null.sum())] if strength[j] > RANK]
        swapped[B[useful or [int(strength.argmax())]]] = True
