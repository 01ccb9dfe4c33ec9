"""Dense linear algebra for small systems: products, and elimination that knows its rank."""

from __future__ import annotations

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["multiply_add", "solve_ranked"]

_NEAR = 0.1  # a pivot this share of its column's largest entry will do: growth stays small, and rows keep their zeros


@kernel
def multiply_add(M: Array, z: Array, q: Array, w: Array) -> None:
    """Write M z + q into w (n,)."""
    for i in range(len(q)):
        total = q[i]
        for j in range(len(q)):
            total += M[i, j] * z[j]
        w[i] = total


@kernel
def solve_ranked(A: Array, b: Array, x: Array, col: Ints, rank_tolerance: float) -> int:
    """Solve A x = b by Gaussian elimination with threshold pivoting, complete pivoting once a column gives no pivot.

    A (k, k) and b (k,) are overwritten, col (k,) int is work. A pivot below this share of the largest entry of A is
    none, and unknowns without a pivot are set to zero: for a consistent singular system that is one solution of many.
    Returns the rank.
    """
    k, largest = len(b), 0.0
    for i in range(k):
        col[i] = i
        for j in range(k):
            largest = max(largest, abs(A[i, j]))
    tiny, rank = rank_tolerance * largest, k
    for s in range(k):
        p, c, best = s, s, 0.0
        for i in range(s, k):
            best = max(best, abs(A[i, s]))
        if best <= tiny:
            # No pivot in this column: look everywhere. That is rare, so its k² comparisons don't matter
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
        else:
            while abs(A[p, s]) < _NEAR * best:
                p += 1
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
