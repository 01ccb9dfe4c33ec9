"""Compiled steps of `mode_walk`: eliminating one contact in one mode from the table x = c + P y, and judging signs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel

SIGNS = 1e-6  # a sign may be wrong by this share of the largest force or motion; the certifier decides afterwards
REGULAR, SINGULAR, CONTRADICTS = 0, 1, 2
_PIVOT, _ZERO = 1e-8, 1e-12  # of the table's largest entry: below, a pivot is none; below, an entry is zero
_GROWTH = 1e5  # of the table, beyond which it is not used: rounding of 1e-16 stays far below SIGNS


class Modes(NamedTuple):
    """What every contact may do. choices (n,) modes of each contact. Of mode k of contact i (0 open, 1 stuck, then
    slides, s ≥ 0): p = rank[i, k]; A[i, k] (3, 3), with rows beyond p zero; B[i, k] (3, 3), with columns beyond p zero;
    and its signs, signs[i, k] rows X x_i + Y y_i ≥ 0.
    """

    choices: Ints
    rank: Ints
    A: Array
    B: Array
    X: Array
    Y: Array
    signs: Ints


class Walk(NamedTuple):
    """Work space of a walk. P (n, N, N), c (n, N): the table before contact i is eliminated, of which the rows and
    columns from 3i on are in use. s = -(h + H y of the contacts that follow), h (n, 3), H (n, 3, N). W (3, 4 + N) is
    scratch, and so is taken (3,); size_c and size_p are those of the first table.
    """

    P: Array
    c: Array
    h: Array
    H: Array
    W: Array
    taken: Ints
    size_c: float
    size_p: float


@kernel
def new_walk(P: Array, c: Array) -> Walk:
    """Room for a walk over the table x = c + P y."""
    N = len(c)
    n = N // 3
    Ps, cs, h, H, W = np.zeros((n, N, N)), np.zeros((n, N)), np.zeros((n, 3)), np.zeros((n, 3, N)), np.zeros((3, 4 + N))
    Ps[0], cs[0] = P, c
    return Walk(Ps, cs, h, H, W, np.zeros(3, np.int64), max(1.0, np.max(np.abs(c))), np.max(np.abs(P)))


@kernel
def solve_contact(w: Walk, i: int, k: int, m: Modes) -> int:
    """Write h = (A P_ii B)⁻¹ A c_i and H = (A P_ii B)⁻¹ A P_i· : REGULAR. SINGULAR where there is no inverse, and
    CONTRADICTS where besides A P_ii B s + A P_i· y + A c_i = 0 holds for no s, and no y of the contacts that follow.
    """
    p, o, e, N = m.rank[i, k], 3 * i, 3 * i + 3, w.c.shape[1]
    W, A, B, P, columns = w.W, m.A, m.B, w.P, 4 + N - e
    for r in range(p):
        for j in range(columns):
            W[r, j] = 0.0
        for b in range(3):
            t = 0.0
            for a in range(3):
                t += A[i, k, r, a] * P[i, o + a, o + b]
            for q in range(p):
                W[r, q] += t * B[i, k, b, q]
        for a in range(3):
            f = A[i, k, r, a]
            if f != 0.0:
                W[r, 3] += f * w.c[i, o + a]
                for j in range(e, N):
                    W[r, 4 + j - e] += f * P[i, o + a, j]
    w.taken[:] = -1  # the row that solves for each unknown
    for step in range(p):
        best, row, col = _PIVOT * w.size_p, -1, 0
        for r in range(step, p):
            for q in range(p):
                if w.taken[q] < 0 and abs(W[r, q]) > best:
                    best, row, col = abs(W[r, q]), r, q
        if row < 0:
            return _why_not(w, step, p, columns)
        w.taken[col] = step
        for j in range(columns):
            W[step, j], W[row, j] = W[row, j], W[step, j]
        pivot = 1.0 / W[step, col]
        for j in range(columns):
            W[step, j] *= pivot
        for r in range(p):
            f = W[r, col]
            if r != step and f != 0.0:
                for j in range(columns):
                    W[r, j] -= f * W[step, j]
    for q in range(p):
        r = w.taken[q]
        w.h[i, q] = W[r, 3]
        for j in range(e, N):
            w.H[i, q, j] = W[r, 4 + j - e]
    return REGULAR


@kernel
def _why_not(w: Walk, step: int, p: int, columns: int) -> int:
    """Whether a row is left with its constant only. Most singular nodes end here."""
    zero = _ZERO * w.size_p
    for r in range(step, p):
        if abs(w.W[r, 3]) > SIGNS * w.size_c:
            rest = 0.0
            for q in range(3):
                if w.taken[q] < 0:
                    rest = max(rest, abs(w.W[r, q]))
            for j in range(4, columns):
                rest = max(rest, abs(w.W[r, j]))
            if rest <= zero:
                return CONTRADICTS
    return SINGULAR


@kernel
def hand_on(w: Walk, i: int, k: int, m: Modes) -> bool:
    """Write the table of the contacts that follow: P - P_·i B H, c - P_·i B h.

    False where it grows so much beyond the first one's size (of c and of P) that rounding would count.
    """
    o, e, N = 3 * i, 3 * i + 3, w.c.shape[1]
    P, c = w.P, w.c
    largest_c, largest_p = 0.0, 0.0
    for r in range(e, N):
        c[i + 1, r] = c[i, r]
        for j in range(e, N):
            P[i + 1, r, j] = P[i, r, j]
        for q in range(m.rank[i, k]):
            f = 0.0
            for a in range(3):
                f += P[i, r, o + a] * m.B[i, k, a, q]
            c[i + 1, r] -= f * w.h[i, q]
            for j in range(e, N):
                P[i + 1, r, j] -= f * w.H[i, q, j]
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
        s = -w.h[i, q]
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
    x[:] = c + P @ y
    force, motion = SIGNS * max(1.0, np.max(np.abs(x))), SIGNS * max(1.0, np.max(np.abs(y)))
    right = True
    for i in range(len(mode)):
        right = right and _signs(i, mode[i], m, x, y, force, motion)
    return right


@kernel
def _signs(i: int, k: int, m: Modes, x: Array, y: Array, force: float, motion: float) -> bool:
    """X x_i + Y y_i ≥ 0, to the given sizes of rounding."""
    for q in range(m.signs[i, k]):
        value = 0.0
        for a in range(3):
            u, v, r = m.X[i, k, q, a], m.Y[i, k, q, a], 3 * i + a
            value += u * x[r] + v * y[r] + abs(u) * force + abs(v) * motion
        if not value >= 0.0:
            return False
    return True
