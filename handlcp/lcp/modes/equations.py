"""The equations that a choice of modes has to fit, M x + F u + q = y, without what is free in them.

Contacts that are open, that touch somehow, or of which nothing is known slip as they will: rows of their slips say
nothing, and are left out. Of the rest, what the free unknowns u can make is taken out by reflections. With 45 contacts
of which little is known 45 rows are left of 135, and a fit costs a tenth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.modes.generators import SLIDES, STUCK, Cones, new_cones
from handlcp.tolerances import RANK


class Whole(NamedTuple):
    """All N rows. M (N, n, 4) : by each contact's normal force and up to three tangential ones. F (N, f) : by the free
    unknowns. q (N,). row (n, 4) : the row of each of its motions, -1 where there is none; of other rows y = 0.
    tangents, limits (n,), faces : as in `Cones`.
    """

    M: Array
    F: Array
    q: Array
    row: Ints
    tangents: Ints
    limits: Array
    faces: int


class Reduced(NamedTuple):
    """cones, b : what a fit is asked for. top (rank, f + 1 + 8n) : rows that give the free unknowns `taken` (rank,), a
    triangle in these columns, by q, forces and motions.
    """

    cones: Cones
    b: Array
    top: Array
    taken: Ints


@kernel
def reduced(w: Whole, codes: Ints) -> Reduced:
    """Of modes codes (n,)."""
    N, f, n = len(w.q), w.F.shape[1], len(codes)
    known = np.ones(N, np.bool_)
    for i in range(n):
        if codes[i] != STUCK and codes[i] != SLIDES:
            for q in range(1, 1 + w.tangents[i]):
                known[w.row[i, q]] = False
    place, count = np.full(N, -1), 0
    for j in range(N):
        if known[j]:
            place[j] = count
            count += 1
    A = np.zeros((count, f + 1 + 8 * n))
    for j in range(N):
        if known[j]:
            to = A[place[j]]
            to[:f], to[f] = w.F[j], w.q[j]
            for i in range(n):
                for q in range(4):
                    to[f + 1 + 8 * i + q] = w.M[j, i, q]
    for i in range(n):
        for q in range(1 + w.tangents[i]):
            if known[w.row[i, q]]:
                A[place[w.row[i, q]], f + 5 + 8 * i + q] = -1.0
    taken, rank = _reflect(A, f)
    columns = A[rank:, f + 1 :].copy()
    cones = new_cones(columns.reshape(len(columns), n, 8), w.tangents, w.limits, w.faces)
    return Reduced(cones, -A[rank:, f].copy(), A[:rank].copy(), taken[:rank].copy())


@kernel
def _reflect(A: Array, f: int) -> tuple[Ints, int]:
    """Make the first f columns a triangle in the first `rank` rows, and rounding below; the longest column first.
    Returns (its columns, rank).
    """
    rows, wide = A.shape
    taken, rank, first = np.full(f, -1), 0, 0.0
    v, along = np.empty(rows), np.empty(wide)
    while rank < min(f, rows):
        best, most = -1, 0.0
        for j in range(f):
            total = 0.0
            for i in range(rank, rows):
                total += A[i, j] * A[i, j]
            if total > most and not np.any(taken[:rank] == j):
                best, most = j, total
        most = np.sqrt(most)
        first = max(first, most)
        if best < 0 or most <= RANK * first:
            break
        for i in range(rank, rows):
            v[i] = A[i, best]
        v[rank] += most if v[rank] > 0.0 else -most
        size = 0.0
        for i in range(rank, rows):
            size += v[i] * v[i]
        along[:] = 0.0
        for i in range(rank, rows):
            for k in range(wide):
                along[k] += v[i] * A[i, k]
        for i in range(rank, rows):
            share = 2.0 * v[i] / size
            for k in range(wide):
                A[i, k] -= share * along[k]
        taken[rank] = best
        rank += 1
    return taken, rank


@kernel
def put_free(w: Whole, r: Reduced, codes: Ints, x: Array, y: Array, u: Array) -> None:
    """Write the free unknowns u (f,) that go with forces x and motions y (n, 4), and the slips that the rows left out
    give, into y.
    """
    n, f, rank = len(codes), len(u), len(r.taken)
    u[:] = 0.0
    for k in range(rank - 1, -1, -1):
        row = r.top[k]
        value = -row[f]
        for i in range(n):
            for q in range(1 + w.tangents[i]):
                value -= row[f + 1 + 8 * i + q] * x[i, q] + row[f + 5 + 8 * i + q] * y[i, q]
        for e in range(k + 1, rank):
            value -= row[r.taken[e]] * u[r.taken[e]]
        u[r.taken[k]] = value / row[r.taken[k]]
    for i in range(n):
        if codes[i] == STUCK or codes[i] == SLIDES:
            continue
        for q in range(1, 1 + w.tangents[i]):
            j = w.row[i, q]
            value = w.q[j]
            for e in range(n):
                for p in range(1 + w.tangents[e]):
                    value += w.M[j, e, p] * x[e, p]
            for e in range(f):
                value += w.F[j, e] * u[e]
            y[i, q] = value
