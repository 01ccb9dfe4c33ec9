"""Every choice of contact modes, one after the other, compiled: all isolated equilibria of a pyramid at once.

A mode of contact i, with forces x_i = (r_N, r_T) and motions y_i = (v_N, v_T), has p unknowns s and p conditions:

    y_i = B s,  A x_i = 0        open: A = B = I; stuck: p = 0; against face j: A = (-μ, n_j), B = (0, -n_j);
                                 at the edge between two faces: both rows, both columns

With x = c + P y (`mode_table`) s = -(A P_ii B)⁻¹ A (c_i + P_i· y) eliminates contact i from the contacts after it, and
a depth-first walk through the tree of choices costs one small elimination a node, tens of nanoseconds a choice. What
satisfies the signs of its modes is an equilibrium. A node whose A P_ii B is singular (say, all but two fingers open:
the object spins about the line between them) is not eliminated; the choices below it are solved whole, and those that
leave something free are handed back.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.mode_steps import SIGNS, contradicts, eliminate, fits, invert, last, norms
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.tolerances import RANK

__all__ = ["visit", "whole"]


@kernel
def visit(
    P: Array,
    c: Array,
    modes: Ints,
    rank: Ints,
    A: Array,
    B: Array,
    X: Array,
    Y: Array,
    count: Ints,
    most: int,
    most_whole: int,
) -> tuple[Array, Ints, bool]:
    """(motions (k, N) of what satisfies all signs, forces distinct; modes (f, n) of choices that leave something free;
    whether all choices were visited, with at most `most` of each kind and `most_whole` solved whole).

    P (N, N), c (N,), N = 3n: components that a contact lacks are zero. Of mode k of contact i (0 open, 1 stuck, then
    slides, s ≥ 0): p = rank[i, k]; A[i, k] (3, 3), with rows beyond p zero; B[i, k] (3, 3), with columns beyond p zero;
    and its signs, count[i, k] rows X x_i + Y y_i ≥ 0.
    """
    n, N = len(modes), len(c)
    Ps, cs = np.zeros((n, N, N)), np.zeros((n, N))  # the table before contact i is eliminated
    Ps[0], cs[0] = P, c
    T, S, W = np.zeros((n, 3, 3)), np.zeros((3, 3)), np.zeros((3, 4 + N))
    size = max(1.0, np.max(np.abs(c))), np.max(np.abs(P))
    h, H = np.zeros((n, 3)), np.zeros((n, 3, N))  # s = -(h + H y of the contacts that follow)
    floor = np.zeros((n, modes.max()))
    for i in range(n):
        for k in range(modes[i]):
            floor[i, k] = norms(P, i, k, rank, A, B)
    mode = np.full(n, -1, np.int64)
    x, y = np.zeros(N), np.zeros(N)
    found, forces, frees = np.zeros((most, N)), np.zeros((most, N)), np.zeros((most, n), np.int64)
    many, free, solved, level, singular = 0, 0, 0, 0, n
    while level >= 0:
        i = level
        mode[i] += 1
        k = mode[i]
        if k == modes[i]:
            mode[i] = -1
            level -= 1
            continue
        if singular >= i:  # the contacts before this one were eliminated; now this one, if it can be
            singular = n
            if not invert(Ps, i, k, rank, A, B, S, T, floor[i, k]):
                if contradicts(Ps, cs, i, k, rank, A, S, W, size):
                    continue
                singular = i
        if i < n - 1:
            if singular == n and not eliminate(Ps, cs, i, k, rank, B, T, h, H, size):
                singular = i
            level += 1
            continue
        if singular < n:
            ok, unique = whole(P, c, mode, rank, A, B, y)
            solved += 1
            if ok and not unique:
                if free < most:
                    frees[free] = mode
                free += 1
            if solved > most_whole or free > most:
                return found[:many], frees[: min(free, most)], False
            if not (ok and unique):
                continue
        else:
            if not last(Ps, cs, i, k, rank, B, T, X, Y, count, x, y):
                continue
            for j in range(n - 2, -1, -1):
                for r in range(3 * j, 3 * j + 3):
                    y[r] = 0.0
                for q in range(rank[j, mode[j]]):
                    s = -h[j, q]
                    for r in range(3 * j + 3, N):
                        s -= H[j, q, r] * y[r]
                    for r in range(3 * j, 3 * j + 3):
                        y[r] += B[j, mode[j], r - 3 * j, q] * s
        if not fits(P, c, mode, X, Y, count, x, y):
            continue
        fresh, tx = True, 0.1 * SIGNS * max(1.0, np.max(np.abs(x)))
        for j in range(many):
            fresh = fresh and np.max(np.abs(forces[j] - x)) > tx
        if fresh:
            if many == most:
                return found[:many], frees[:free], False
            found[many], forces[many] = y, x
            many += 1
    return found[:many], frees[:free], True


@kernel
def whole(P: Array, c: Array, mode: Ints, rank: Ints, A: Array, B: Array, y: Array) -> tuple[bool, bool]:
    """One choice of modes without the tree: (whether its conditions have a solution, one only); y (N,) is one."""
    n, N = len(mode), len(c)
    AA, BB, p = np.zeros((N, N)), np.zeros((N, N)), 0
    for i in range(n):
        for a in range(rank[i, mode[i]]):
            for d in range(3):
                AA[p, 3 * i + d] = A[i, mode[i], a, d]
                BB[3 * i + d, p] = B[i, mode[i], d, a]
            p += 1
    y[:] = 0.0
    if p == 0:
        return True, True
    S, b, s = np.zeros((p, p)), np.zeros(p), np.zeros(p)
    for r in range(p):
        for j in range(N):
            if AA[r, j] != 0.0:
                b[r] -= AA[r, j] * c[j]
                for m in range(N):
                    t = AA[r, j] * P[j, m]
                    for col in range(p):
                        S[r, col] += t * BB[m, col]
    unique = solve_ranked(S.copy(), b.copy(), s, np.zeros(p, np.int64), RANK) == p
    missed, size = 0.0, max(1.0, np.max(np.abs(s)))
    for r in range(p):
        t = -b[r]
        for col in range(p):
            t += S[r, col] * s[col]
        missed = max(missed, abs(t))
    for m in range(N):
        for col in range(p):
            y[m] += BB[m, col] * s[col]
    return missed <= SIGNS * size, unique
