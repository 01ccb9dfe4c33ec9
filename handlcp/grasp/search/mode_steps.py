"""Compiled steps of `mode_walk`: eliminating one contact in one mode from the table x = c + P y, and judging signs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["SIGNS", "Modes", "Walk", "contradicts", "eliminate", "fits", "invert", "last", "new_walk", "pivot_floor"]

SIGNS = 1e-6  # a sign may be wrong by this share of the largest force or motion; the certifier decides afterwards
_PIVOT = 1e-8  # share of the product of its rows' norms below which the determinant of A P_ii B counts as zero
_GROWTH = 1e5  # of the table, beyond which it is not used: rounding of 1e-16 stays far below SIGNS


class Modes(NamedTuple):
    """What every contact may do. choices (n,) modes of each contact. Of mode k of contact i (0 open, 1 stuck, then
    slides, s ≥ 0): p = rank[i, k]; A[i, k] (3, 3), with rows beyond p zero; B[i, k] (3, 3), with columns beyond p zero;
    and its signs, count[i, k] rows X x_i + Y y_i ≥ 0.
    """

    choices: Ints
    rank: Ints
    A: Array
    B: Array
    X: Array
    Y: Array
    count: Ints


class Walk(NamedTuple):
    """Work space of a walk. P (n, N, N), c (n, N): the table before contact i is eliminated, of which the rows and
    columns from 3i on are in use. T (n, 3, 3): (A P_ii B)⁻¹ A. s = -(h + H y of the contacts that follow), h (n, 3),
    H (n, 3, N). S (3, 3) and W (3, 4 + N) are scratch; size_c and size_p are those of the first table.
    """

    P: Array
    c: Array
    T: Array
    h: Array
    H: Array
    S: Array
    W: Array
    size_c: float
    size_p: float


@kernel
def new_walk(P: Array, c: Array) -> Walk:
    """Room for a walk over the table x = c + P y."""
    N = len(c)
    n = N // 3
    Ps, cs = np.zeros((n, N, N)), np.zeros((n, N))
    Ps[0], cs[0] = P, c
    size_c, size_p = max(1.0, np.max(np.abs(c))), np.max(np.abs(P))
    T, h, H = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros((n, 3, N))
    return Walk(Ps, cs, T, h, H, np.zeros((3, 3)), np.zeros((3, 4 + N)), size_c, size_p)


@kernel
def pivot_floor(P: Array, i: int, k: int, m: Modes) -> float:
    """_PIVOT times the product of the norms of the rows of |A| |P_ii| |B|."""
    out = _PIVOT
    for r in range(m.rank[i, k]):
        total = 0.0
        for col in range(m.rank[i, k]):
            entry = 0.0
            for a in range(3):
                for b in range(3):
                    entry += abs(m.A[i, k, r, a] * P[3 * i + a, 3 * i + b] * m.B[i, k, b, col])
            total += entry * entry
        out *= np.sqrt(total)
    return out


@kernel
def invert(w: Walk, i: int, k: int, m: Modes, floor: float) -> bool:
    """T[i] = (A P_ii B)⁻¹ A; False where that is singular."""
    p, o, S, T, A = m.rank[i, k], 3 * i, w.S, w.T, m.A
    if p == 0:
        return True
    for r in range(p):
        for col in range(p):
            S[r, col] = 0.0
        for b in range(3):
            t = 0.0
            for a in range(3):
                t += A[i, k, r, a] * w.P[i, o + a, o + b]
            for col in range(p):
                S[r, col] += t * m.B[i, k, b, col]
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
def contradicts(w: Walk, i: int, k: int, m: Modes) -> bool:
    """Whether A P_ii B s + A P_i· y + A c_i = 0 holds for no s, and no y of the contacts that follow: a combination of
    rows is left with the constant only. Most singular nodes end here.
    """
    p, o, e, N = m.rank[i, k], 3 * i, 3 * i + 3, w.c.shape[1]
    W, A, tiny = w.W, m.A, 1e-4 * _PIVOT * w.size_p
    for r in range(p):
        for q in range(p):
            W[r, q] = w.S[r, q]
        W[r, 3] = 0.0
        for a in range(3):
            W[r, 3] += A[i, k, r, a] * w.c[i, o + a]
        for j in range(e, N):
            W[r, 4 + j] = 0.0
            for a in range(3):
                W[r, 4 + j] += A[i, k, r, a] * w.P[i, o + a, j]
    for step in range(p):
        best, row, col = tiny, -1, 0
        for r in range(step, p):
            for q in range(p):
                if abs(W[r, q]) > best:
                    best, row, col = abs(W[r, q]), r, q
        if row < 0:
            for r in range(step, p):
                rest = 0.0
                for j in range(e, N):
                    rest = max(rest, abs(W[r, 4 + j]))
                if rest <= tiny and abs(W[r, 3]) > SIGNS * w.size_c:
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
def eliminate(w: Walk, i: int, k: int, m: Modes) -> bool:
    """Of s = -(h + H y): h = T c_i, H = T P_i·. The table of the contacts that follow: P - P_·i B H, c - P_·i B h.

    False where it grows so much beyond the first one's size (of c and of P) that rounding would count.
    """
    o, e, N = 3 * i, 3 * i + 3, w.c.shape[1]
    P, c, T, h, H = w.P, w.c, w.T, w.h, w.H
    for r in range(m.rank[i, k]):
        t = 0.0
        for a in range(3):
            t += T[i, r, a] * c[i, o + a]
        h[i, r] = t
        for j in range(e, N):
            t = 0.0
            for a in range(3):
                t += T[i, r, a] * P[i, o + a, j]
            H[i, r, j] = t
    largest_c, largest_p = 0.0, 0.0
    for r in range(e, N):
        c[i + 1, r] = c[i, r]
        for j in range(e, N):
            P[i + 1, r, j] = P[i, r, j]
        for q in range(m.rank[i, k]):
            f = 0.0
            for a in range(3):
                f += P[i, r, o + a] * m.B[i, k, a, q]
            c[i + 1, r] -= f * h[i, q]
            for j in range(e, N):
                P[i + 1, r, j] -= f * H[i, q, j]
        largest_c = max(largest_c, abs(c[i + 1, r]))
        for j in range(e, N):
            largest_p = max(largest_p, abs(P[i + 1, r, j]))
    return largest_c <= _GROWTH * w.size_c and largest_p <= _GROWTH * w.size_p


@kernel
def last(w: Walk, i: int, k: int, m: Modes, x: Array, y: Array) -> bool:
    """Motion and force of the last contact, and whether their signs are right, roughly: few choices get further."""
    o = 3 * i
    for a in range(3):
        y[o + a] = 0.0
    for q in range(m.rank[i, k]):
        s = 0.0
        for a in range(3):
            s -= w.T[i, q, a] * w.c[i, o + a]
        if k > 1 and s < -100 * SIGNS:  # it would slide against friction
            return False
        for a in range(3):
            y[o + a] += m.B[i, k, a, q] * s
    for a in range(3):
        t = w.c[i, o + a]
        for b in range(3):
            t += w.P[i, o + a, o + b] * y[o + b]
        x[o + a] = t
    return _signs(i, k, m, x, y, 100 * SIGNS, 100 * SIGNS)


@kernel
def fits(P: Array, c: Array, mode: Ints, m: Modes, x: Array, y: Array) -> bool:
    """Whether the signs of all contacts are right; x becomes c + P y."""
    N, fx, fy = len(c), 1.0, 1.0
    for r in range(N):
        x[r] = c[r]
        for j in range(N):
            x[r] += P[r, j] * y[j]
        fx, fy = max(fx, abs(x[r])), max(fy, abs(y[r]))
    right = True
    for i in range(len(mode)):
        right = right and _signs(i, mode[i], m, x, y, SIGNS * fx, SIGNS * fy)
    return right


@kernel
def _signs(i: int, k: int, m: Modes, x: Array, y: Array, force: float, motion: float) -> bool:
    """X x_i + Y y_i ≥ 0, to the given sizes of rounding."""
    for q in range(m.count[i, k]):
        value = 0.0
        for a in range(3):
            u, v, r = m.X[i, k, q, a], m.Y[i, k, q, a], 3 * i + a
            value += u * x[r] + v * y[r] + abs(u) * force + abs(v) * motion
        if not value >= 0.0:
            return False
    return True
