"""Dense linear algebra for the small systems of active sets: elimination that knows its rank."""

from __future__ import annotations

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["eliminate", "solve_ranked"]


@kernel
def solve_ranked(A: Array, b: Array, x: Array, col: Ints, rank_tolerance: float) -> int:
    """Solve A x = b as `eliminate` does; a pivot below this share of the largest entry of A is none."""
    largest = 0.0
    for i in range(len(b)):
        for j in range(len(b)):
            largest = max(largest, abs(A[i, j]))
    return eliminate(A, b, x, col, rank_tolerance * largest)


@kernel
def eliminate(A: Array, b: Array, x: Array, col: Ints, tiny: float) -> int:
    """Solve A x = b by Gaussian elimination with partial pivoting, complete pivoting once a column gives no pivot.

    A (k, k) and b (k,) are overwritten, col (k,) int is work. Unknowns without a pivot above `tiny` are set to zero:
    for a consistent singular system that is one solution of many. Returns the rank.
    """
    k = len(b)
    for i in range(k):
        col[i] = i
    rank = k
    for s in range(k):
        # partial pivoting in column s
        p, c, best = s, s, 0.0
        for i in range(s, k):
            if abs(A[i, s]) > best:
                best, p = abs(A[i, s]), i
        if best <= tiny:
            # no pivot here: look everywhere (rare, so its k² comparisons don't matter)
            for i in range(s, k):
                for j in range(s, k):
                    if abs(A[i, j]) > best:
                        best, p, c = abs(A[i, j]), i, j
            if best <= tiny:
                rank = s
                break
            for i in range(k):
                A[i, s], A[i, c] = A[i, c], A[i, s]
            col[s], col[c] = col[c], col[s]
        if p != s:
            for j in range(s, k):
                A[s, j], A[p, j] = A[p, j], A[s, j]
            b[s], b[p] = b[p], b[s]
        pivot = 1.0 / A[s, s]
        for i in range(s + 1, k):
            f = A[i, s] * pivot
            if f != 0.0:
                for j in range(s + 1, k):
                    A[i, j] -= f * A[s, j]
                b[i] -= f * b[s]
    for i in range(rank, k):
        x[col[i]] = 0.0
    for s in range(rank - 1, -1, -1):
        t = b[s]
        for j in range(s + 1, rank):
            t -= A[s, j] * b[j]
        b[s] = t / A[s, s]
        x[col[s]] = b[s]
    return rank
