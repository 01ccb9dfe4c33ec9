"""`solve_ranked`: dense linear algebra for small systems, products and elimination that knows its rank."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.compiler.kernel import Kernel

# ----------------------------------------------------------------
# One decorator for every kernel, typed so that strict checks see through it.

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Run as Python at first and compiled where that pays, by itself or called from other kernels; see
    `handlcp.lcp.compiler.compile_policy`. Compiled code is kept on disk. Threads run it side by side.
    """
    return cast(F, Kernel(function))


# ----------------------------------------------------------------

# A pivot this share of its column's largest entry will do: growth stays small, and rows keep their zeros
_PIVOT_SHARE = 0.1
_EPS = float(np.finfo(float).eps)


@kernel
def multiply_add(M: Array, z: Array, q: Array, w: Array) -> None:
    """Write M z + q into w (n,). Zeros of z cost nothing, and four rows are summed side by side: each sum waits for its
    last term.
    """
    n, at, count = len(q), np.empty(len(q), np.int64), 0
    for j in range(n):
        if z[j] != 0.0:
            at[count] = j
            count += 1
    whole = n - n % 4
    for i in range(0, whole, 4):
        a, b, c, d = q[i], q[i + 1], q[i + 2], q[i + 3]
        for k in range(count):
            j = at[k]
            x = z[j]
            a += M[i, j] * x
            b += M[i + 1, j] * x
            c += M[i + 2, j] * x
            d += M[i + 3, j] * x
        w[i], w[i + 1], w[i + 2], w[i + 3] = a, b, c, d
    for i in range(whole, n):
        a = q[i]
        for k in range(count):
            a += M[i, at[k]] * z[at[k]]
        w[i] = a


@kernel
def product(A: Array, B: Array) -> Array:
    """(i, j) A B of small or sparse matrices: zeros of A (i, k) cost nothing."""
    out = np.zeros((A.shape[0], B.shape[1]))
    for i in range(A.shape[0]):
        row = out[i]
        for k in range(A.shape[1]):
            a, other = A[i, k], B[k]
            if a != 0.0:
                for j in range(len(row)):
                    row[j] += a * other[j]
    return out


@kernel
def add_product(A: Array, x: Array, times: float, out: Array) -> None:
    """Add times A x to out (m,); A (m, n)."""
    for i in range(len(out)):
        total = 0.0
        for j in range(len(x)):
            total += A[i, j] * x[j]
        out[i] += times * total


@kernel
def add_transposed(A: Array, x: Array, times: float, out: Array) -> None:
    """Add times Aᵀ x to out (n,); A (m, n)."""
    for i in range(len(x)):
        if x[i] != 0.0:
            for j in range(len(out)):
                out[j] += times * x[i] * A[i, j]


@kernel
def solve_least_squares(A: Array, b: Array, rank_tolerance: float) -> Array:
    """(n,) the shortest x of those with the smallest |A x - b|; A (m, n). Singular values below this share of the
    largest count as zero.
    """
    return np.linalg.lstsq(A, b, rank_tolerance)[0].astype(np.float64)


@kernel
def inverse_root(K: Array, A: Array) -> bool:
    """Write L⁻ᵀ of K = L Lᵀ (n, n) into A (n, n), of zeros; False where K is not positive definite."""
    n = len(K)
    L = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            left = K[i, j]
            for k in range(j):
                left -= L[i, k] * L[j, k]
            if i > j:
                L[i, j] = left / L[j, j]
            elif left > 0.0:
                L[i, i] = np.sqrt(left)
            else:
                return False
    for j in range(n):
        A[j, j] = 1.0 / L[j, j]
        for i in range(j + 1, n):
            for k in range(j, i):
                A[j, i] -= L[i, k] * A[j, k]
            A[j, i] /= L[i, i]
    return True


@kernel
def bounded_least_squares(A: Array, b: Array, least: Array, bounded: Bools) -> Array:
    """(n,) x of the smallest |A x - b| with x ≥ least where it is bounded; A (m, n) of full rank. Active sets: Lawson
    and Hanson, Solving Least Squares Problems (1974), chapter 23.
    """
    n, best, free, tried, x = A.shape[1], -1, ~bounded, np.zeros(A.shape[1], np.bool_), np.zeros(A.shape[1])
    for i in range(n):
        x[i] = least[i] if bounded[i] else 0.0
    for _ in range(10 * n + 10):
        hit = 0
        while hit >= 0:  # on to the least of the free ones, or to the first bound on the way there
            chosen, left, share = np.flatnonzero(free), b.copy(), 1.0
            columns = np.empty((len(b), len(chosen)))
            add_product(A, x, -1.0, left)
            for k in range(len(chosen)):
                for i in range(len(b)):
                    columns[i, k] = A[i, chosen[k]]
            way, hit = np.zeros(0), -1
            if len(chosen) > 0:
                way = solve_least_squares(columns, left, _EPS * len(b))
            for k in range(len(chosen)):
                i = chosen[k]
                if bounded[i] and x[i] + way[k] < least[i] and (x[i] - least[i]) / -way[k] <= share:
                    share, hit = (x[i] - least[i]) / -way[k], i
            for k in range(len(chosen)):
                x[chosen[k]] += share * way[k]
            if hit >= 0:
                x[hit], free[hit] = least[hit], False
        if best >= 0 and free[best]:
            tried[:] = False
        slope, left, best = np.zeros(n), b.copy(), -1
        add_product(A, x, -1.0, left)
        add_transposed(A, left, 1.0, slope)
        for i in range(n):
            if not free[i] and not tried[i] and slope[i] > 0.0 and (best < 0 or slope[i] > slope[best]):
                best = i
        if best < 0:
            break
        free[best] = tried[best] = True
    return x


@kernel
def solve_wide(A: Array, least: float) -> bool:
    """Solve L X = B in place: A (k, k + m) is [L, B] before, and X is in its last m columns after; False where a pivot
    of L is no larger than `least`, or is not finite. Unknowns are eliminated from the last to the first, zeros of L
    cost nothing.
    """
    k, wide = A.shape
    for s in range(k - 1, -1, -1):
        p = s
        for i in range(s):
            if abs(A[i, s]) > abs(A[p, s]):
                p = i
        if not abs(A[p, s]) > least:
            return False
        if p != s:
            for j in range(wide):
                A[p, j], A[s, j] = A[s, j], A[p, j]
        top, pivot = A[s], 1.0 / A[s, s]
        for i in range(s):
            f, row = A[i, s] * pivot, A[i]
            if f != 0.0:
                for j in range(s):
                    row[j] -= f * top[j]
                for j in range(k, wide):
                    row[j] -= f * top[j]
    for s in range(k):
        top, pivot = A[s], 1.0 / A[s, s]
        for j in range(k, wide):
            top[j] *= pivot
        for i in range(s + 1, k):
            f, row = A[i, s], A[i]
            if f != 0.0:
                for j in range(k, wide):
                    row[j] -= f * top[j]
    return True


@kernel
def solve_ranked(A: Array, b: Array, x: Array, col: Ints, rank_tolerance: float) -> int:
    """Solve A x = b by Gaussian elimination with threshold pivoting, complete pivoting once a column gives no pivot.

    A (k, k) and b (k,) are overwritten, col (k,) int is work. A pivot below this share of the largest entry of A is
    none, and unknowns without a pivot are set to zero: for a consistent singular system that is one solution of many.
    Returns the rank.
    """
    k = len(b)
    tiny, rank, best = rank_tolerance * _largest(A, x), k, 0.0
    for i in range(k):
        col[i] = i
        best = max(best, abs(A[i, 0]))
    for s in range(k):
        if best <= tiny:
            best = _pivot_anywhere(A, b, col, s)
            if best <= tiny:
                rank = s
                break
        p = s
        while abs(A[p, s]) < _PIVOT_SHARE * best:
            p += 1
        if p != s:
            _swap(A, b, s, p)
        pivot, top, best = 1.0 / A[s, s], A[s, s + 1 :], 0.0
        for i in range(s + 1, k):
            f, row = A[i, s] * pivot, A[i, s + 1 :]
            if f != 0.0:
                for j in range(len(row)):
                    row[j] -= f * top[j]
                b[i] -= f * b[s]
            best = max(best, abs(row[0]))  # of the next column
    for i in range(rank, k):
        x[col[i]] = 0.0
    for s in range(rank - 1, -1, -1):
        t = b[s] / A[s, s]
        for i in range(s):
            b[i] -= A[i, s] * t
        x[col[s]] = t
    return rank


@kernel
def _largest(A: Array, work: Array) -> float:
    """The largest |entry|, column by column: numbers of one row are compared side by side."""
    work[:] = 0.0
    for i in range(len(A)):
        row = A[i]
        for j in range(len(work)):
            work[j] = max(work[j], abs(row[j]))
    largest = 0.0
    for value in work:
        largest = max(largest, value)
    return largest


@kernel
def _pivot_anywhere(A: Array, b: Array, col: Ints, s: int) -> float:
    """Bring the largest entry of what is left to A[s, s]; returns its size. Rare: k² comparisons don't matter."""
    best, p, c = 0.0, s, s
    for i in range(s, len(b)):
        for j in range(s, len(b)):
            if abs(A[i, j]) > best:
                best, p, c = abs(A[i, j]), i, j
    for i in range(len(b)):
        A[i, s], A[i, c] = A[i, c], A[i, s]
    col[s], col[c] = col[c], col[s]
    _swap(A, b, s, p)
    return best


@kernel
def _swap(A: Array, b: Array, s: int, p: int) -> None:
    """Swap two rows, from column s on."""
    for j in range(s, len(b)):
        A[s, j], A[p, j] = A[p, j], A[s, j]
    b[s], b[p] = b[p], b[s]
