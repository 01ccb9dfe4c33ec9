"""Compiled steps of `every_mode`: eliminating one contact in one mode from the table x = c + P y, and judging signs.

Ps (n, N, N), cs (n, N) : the table before contact i is eliminated, of which the rows and columns from 3i on are in use.
The rest is described in `every_mode`.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["SIGNS", "contradicts", "eliminate", "fits", "invert", "last", "norms"]

SIGNS = 1e-6  # a sign may be wrong by this share of the largest force or motion; the certifier decides afterwards
_PIVOT = 1e-8  # share of the product of its rows' norms below which the determinant of A P_ii B counts as zero
_GROWTH = 1e5  # of the table, beyond which it is not used: rounding of 1e-16 stays far below SIGNS


@kernel
def norms(P: Array, i: int, k: int, rank: Ints, A: Array, B: Array) -> float:
    """_PIVOT times the product of the norms of the rows of |A| |P_ii| |B|."""
    out = _PIVOT
    for r in range(rank[i, k]):
        total = 0.0
        for col in range(rank[i, k]):
            entry = 0.0
            for a in range(3):
                for b in range(3):
                    entry += abs(A[i, k, r, a] * P[3 * i + a, 3 * i + b] * B[i, k, b, col])
            total += entry * entry
        out *= np.sqrt(total)
    return out


@kernel
def invert(Ps: Array, i: int, k: int, rank: Ints, A: Array, B: Array, S: Array, T: Array, floor: float) -> bool:
    """T[i] = (A P_ii B)⁻¹ A; False where that is singular. S (3, 3) is work."""
    p, o = rank[i, k], 3 * i
    if p == 0:
        return True
    for r in range(p):
        for col in range(p):
            S[r, col] = 0.0
        for b in range(3):
            t = 0.0
            for a in range(3):
                t += A[i, k, r, a] * Ps[i, o + a, o + b]
            for col in range(p):
                S[r, col] += t * B[i, k, b, col]
    c0 = c1 = c2 = 0.0
    det = S[0, 0]
    if p == 2:
        det = S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0]
    elif p == 3:
        c0 = S[1, 1] * S[2, 2] - S[1, 2] * S[2, 1]
        c1 = S[1, 2] * S[2, 0] - S[1, 0] * S[2, 2]
        c2 = S[1, 0] * S[2, 1] - S[1, 1] * S[2, 0]
        det = S[0, 0] * c0 + S[0, 1] * c1 + S[0, 2] * c2
    if not abs(det) > floor:
        return False
    inverse = 1.0 / det
    for a in range(3):
        f0 = A[i, k, 0, a] * inverse
        if p == 1:
            T[i, 0, a] = f0
            continue
        f1 = A[i, k, 1, a] * inverse
        if p == 2:
            T[i, 0, a] = S[1, 1] * f0 - S[0, 1] * f1
            T[i, 1, a] = S[0, 0] * f1 - S[1, 0] * f0
            continue
        f2 = A[i, k, 2, a] * inverse
        T[i, 0, a] = (
            c0 * f0 + (S[0, 2] * S[2, 1] - S[0, 1] * S[2, 2]) * f1 + (S[0, 1] * S[1, 2] - S[0, 2] * S[1, 1]) * f2
        )
        T[i, 1, a] = (
            c1 * f0 + (S[0, 0] * S[2, 2] - S[0, 2] * S[2, 0]) * f1 + (S[0, 2] * S[1, 0] - S[0, 0] * S[1, 2]) * f2
        )
        T[i, 2, a] = (
            c2 * f0 + (S[0, 1] * S[2, 0] - S[0, 0] * S[2, 1]) * f1 + (S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0]) * f2
        )
    return True


@kernel
def contradicts(
    Ps: Array,
    cs: Array,
    i: int,
    k: int,
    rank: Ints,
    A: Array,
    S: Array,
    W: Array,
    size: tuple[float, float],
) -> bool:
    """Whether A P_ii B s + A P_i· y + A c_i = 0 holds for no s, and no y of the contacts that follow: a combination of
    rows is left with the constant only. Most singular nodes end here. W is work; size: of c and of P.
    """
    p, o, e, N = rank[i, k], 3 * i, 3 * i + 3, cs.shape[1]
    for r in range(p):
        for q in range(p):
            W[r, q] = S[r, q]
        W[r, 3] = 0.0
        for a in range(3):
            W[r, 3] += A[i, k, r, a] * cs[i, o + a]
        for j in range(e, N):
            W[r, 4 + j] = 0.0
            for a in range(3):
                W[r, 4 + j] += A[i, k, r, a] * Ps[i, o + a, j]
    for step in range(p):
        best, row, col = 1e-4 * _PIVOT * size[1], -1, 0
        for r in range(step, p):
            for q in range(p):
                if abs(W[r, q]) > best:
                    best, row, col = abs(W[r, q]), r, q
        if row < 0:
            for r in range(step, p):
                rest = 0.0
                for j in range(e, N):
                    rest = max(rest, abs(W[r, 4 + j]))
                if rest <= 1e-4 * _PIVOT * size[1] and abs(W[r, 3]) > SIGNS * size[0]:
                    return True
            return False
        for j in range(4 + N):
            W[step, j], W[row, j] = W[row, j], W[step, j]
        for r in range(step + 1, p):
            f = W[r, col] / W[step, col]
            for j in range(4 + N):
                W[r, j] -= f * W[step, j]
    return False


@kernel
def eliminate(
    Ps: Array,
    cs: Array,
    i: int,
    k: int,
    rank: Ints,
    B: Array,
    T: Array,
    h: Array,
    H: Array,
    size: tuple[float, float],
) -> bool:
    """Of s = -(h + H y): h = T c_i, H = T P_i·. The table of the contacts that follow: P - P_·i B H, c - P_·i B h.

    False where it grows so much beyond the first one's size (of c and of P) that rounding would count.
    """
    o, e, N = 3 * i, 3 * i + 3, cs.shape[1]
    for r in range(rank[i, k]):
        t = 0.0
        for a in range(3):
            t += T[i, r, a] * cs[i, o + a]
        h[i, r] = t
        for j in range(e, N):
            t = 0.0
            for a in range(3):
                t += T[i, r, a] * Ps[i, o + a, j]
            H[i, r, j] = t
    largest_c, largest_p = 0.0, 0.0
    for r in range(e, N):
        cs[i + 1, r] = cs[i, r]
        for j in range(e, N):
            Ps[i + 1, r, j] = Ps[i, r, j]
        for q in range(rank[i, k]):
            w = 0.0
            for a in range(3):
                w += Ps[i, r, o + a] * B[i, k, a, q]
            cs[i + 1, r] -= w * h[i, q]
            for j in range(e, N):
                Ps[i + 1, r, j] -= w * H[i, q, j]
        largest_c = max(largest_c, abs(cs[i + 1, r]))
        for j in range(e, N):
            largest_p = max(largest_p, abs(Ps[i + 1, r, j]))
    return largest_c <= _GROWTH * size[0] and largest_p <= _GROWTH * size[1]


@kernel
def last(
    Ps: Array, cs: Array, i: int, k: int, rank: Ints, B: Array, T: Array, X: Array, Y: Array, count: Ints,
    x: Array, y: Array,
) -> bool:  # fmt: skip
    """Motion and force of the last contact, and whether their signs are right, roughly: few choices get further."""
    o = 3 * i
    for a in range(3):
        y[o + a] = 0.0
    for q in range(rank[i, k]):
        s = 0.0
        for a in range(3):
            s -= T[i, q, a] * cs[i, o + a]
        if k > 1 and s < -100 * SIGNS:  # it would slide against friction
            return False
        for a in range(3):
            y[o + a] += B[i, k, a, q] * s
    for a in range(3):
        t = cs[i, o + a]
        for b in range(3):
            t += Ps[i, o + a, o + b] * y[o + b]
        x[o + a] = t
    return _signs(i, k, X, Y, count, x, y, 100 * SIGNS, 100 * SIGNS)


@kernel
def fits(P: Array, c: Array, mode: Ints, X: Array, Y: Array, count: Ints, x: Array, y: Array) -> bool:
    """Whether the signs of all contacts are right; x becomes c + P y."""
    N, fx, fy = len(c), 1.0, 1.0
    for r in range(N):
        x[r] = c[r]
        for j in range(N):
            x[r] += P[r, j] * y[j]
        fx, fy = max(fx, abs(x[r])), max(fy, abs(y[r]))
    right = True
    for i in range(len(mode)):
        right = right and _signs(i, mode[i], X, Y, count, x, y, SIGNS * fx, SIGNS * fy)
    return right


@kernel
def _signs(i: int, k: int, X: Array, Y: Array, count: Ints, x: Array, y: Array, force: float, motion: float) -> bool:
    """X x_i + Y y_i ≥ 0, to the given sizes of rounding."""
    for q in range(count[i, k]):
        value = 0.0
        for a in range(3):
            u, v, r = X[i, k, q, a], Y[i, k, q, a], 3 * i + a
            value += u * x[r] + v * y[r] + abs(u) * force + abs(v) * motion
        if not value >= 0.0:
            return False
    return True
