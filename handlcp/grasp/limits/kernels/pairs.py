"""Small complementarity problems of rates: γ ≥ 0, y = M γ + q ≥ 0, γᵀ y = 0, where M may be any matrix.

Tried in this order: the pairs that were active before; pivots from there; Lemke's method; every choice of up to `_ALL`
pairs, after which it is proven that there is no solution. With more pairs Lemke's method is started from several sides,
and where it fails nothing is proven.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.parts import CLOSED, Parts, Place
from handlcp.lcp.kernels.dense import kernel, solve_wide
from handlcp.lcp.lemke import SOLVED, pivot_lemke
from handlcp.tolerances import PIVOT_TOLERANCE

# ----------------------------------------------------------------
# What may slip, open or give way at one place of a path, and how forces respond to it: pairs of γ ≥ 0 and -a·ṙ ≥ 0.

NORMAL, LIMIT = -1, -2  # kinds of pairs besides faces, whose kind is the number of their contact


class Solved(NamedTuple):
    """The inverse at a place, and the response x0 (m + dof + k) to the load where nothing slips."""

    W: Array
    x0: Array


@kernel
def face_of_force(p: Parts, f: int, r: Array) -> None:
    """Turn a moving face to where the force lies."""
    i, size = p.owner[f], 0.0
    for a in range(3):
        j = p.contacts[i, a + 1]
        if j >= 0:
            size += r[j] * r[j]
    size = np.sqrt(size)
    if size > 0.0:
        for a in range(3):
            j = p.contacts[i, a + 1]
            p.normals[f, a] = r[j] / size if j >= 0 else 0.0


@kernel
def respond(p: Parts, at: Solved, kinds: Ints, index: Ints) -> tuple[Array, Array, Array]:
    """(X, M, q): responses (pairs, m + dof + k) to each γ in rows, and the complementarity problem of the pairs."""
    m, count = len(p.E), len(kinds)
    X, M, q = np.zeros((count, len(at.x0))), np.empty((count, count)), np.empty(count)
    for c in range(count):
        kind, own = kinds[c], index[c]
        x = X[c]
        if kind == NORMAL:
            x += at.W[p.contacts[own, 0]]
        elif kind == LIMIT:
            for j in range(m):
                if p.rows[own, j] != 0.0:
                    x -= p.rows[own, j] * at.W[j]
        else:
            for a in range(3):
                j = p.contacts[kind, a + 1]
                if j >= 0 and p.normals[own, a] != 0.0:
                    x -= p.normals[own, a] * at.W[j]
    for c in range(count):
        q[c] = _used(p, kinds[c], index[c], at.x0)
        for b in range(count):
            M[c, b] = _used(p, kinds[c], index[c], X[b])
    return X, M, q


@kernel
def _used(p: Parts, kind: int, own: int, r: Array) -> float:
    """-a·r of a face (kind ≥ 0: its contact), a normal or a limit."""
    if kind == NORMAL:
        return float(r[p.contacts[own, 0]])
    total = 0.0
    if kind == LIMIT:
        for j in range(p.rows.shape[1]):
            total -= p.rows[own, j] * r[j]
        return float(total)
    total = float(p.mu[kind] * r[p.contacts[kind, 0]])
    for a in range(3):
        j = p.contacts[kind, a + 1]
        if j >= 0:
            total -= p.normals[own, a] * r[j]
    return total


@kernel
def pairs_at(p: Parts, s: Place, closed: Ints) -> tuple[Ints, Ints, Ints]:
    """(kinds, index, basis) of all pairs; `closed` with the contacts that touch decided."""
    n, f, k = len(p.mu), len(p.owner), len(p.rows)
    kinds, index = np.empty(f + n + k, np.int64), np.empty(f + n + k, np.int64)
    basis, count = np.zeros(f + n + k, np.int64), 0
    for j in range(f):
        i = p.owner[j]
        if closed[i] == CLOSED and (s.closed[i] != CLOSED or s.active[j] == 1):
            kinds[count], index[count] = i, j
            basis[count] = s.slides[j] if s.closed[i] == CLOSED else 0
            count += 1
    for i in range(n):
        if closed[i] == CLOSED and s.closed[i] != CLOSED:
            kinds[count], index[count] = NORMAL, i
            count += 1
    for q in range(k):
        if s.yields[q] == 2:
            kinds[count], index[count], basis[count] = LIMIT, q, 1
            count += 1
    return kinds[:count], index[:count], basis[:count]


# ----------------------------------------------------------------

NONE, SOME, UNKNOWN = 0, 1, 2  # of solutions

_TINY, _SINGULAR = 1e-9, 1e-11
_ALL, _PIVOTS, _SIDES = 10, 20, 24


@kernel
def solve_pairs(M: Array, q: Array, basis: Ints, gamma: Array) -> int:
    """Write γ (p,); whether there is one: NONE, SOME or UNKNOWN. basis (p,) : 1 where γ > 0 is expected; overwritten
    with what is.
    """
    p = len(q)
    if p == 0:
        return SOME
    size = np.max(np.abs(q))
    if size == 0.0:
        gamma[:] = 0.0
        basis[:] = 0
        return SOME
    first = basis.copy()
    for _ in range(3 * p):
        worst = _miss(M, q, basis, gamma, size)
        if worst == -1:
            return SOME
        if worst == -2:  # singular
            break
        basis[worst] = 1 - basis[worst]
    if _by_lemke(M, q, np.full(p, size), basis, gamma, size):
        return SOME
    if p <= _ALL:
        for choice in range(2**p):
            for i in range(p):
                basis[i] = (choice >> i & 1) ^ first[i]
            if _miss(M, q, basis, gamma, size) == -1:
                return SOME
        return NONE
    cover = np.empty(p)
    for side in range(_SIDES):
        for i in range(p):
            cover[i] = size * (1.0 + 0.95 * np.sin(1.0 + (side + 1.0) * (i + 1.0)))
        if _by_lemke(M, q, cover, basis, gamma, size):
            return SOME
    return UNKNOWN


@kernel
def _by_lemke(M: Array, q: Array, cover: Array, basis: Ints, gamma: Array, size: float) -> bool:
    ended, _, z = pivot_lemke(M, q, cover, _PIVOTS * len(q), PIVOT_TOLERANCE)
    if ended != SOLVED:
        return False
    for i in range(len(q)):
        basis[i] = 1 if z[i] > 0.0 else 0
    return bool(_miss(M, q, basis, gamma, size) == -1)


@kernel
def _miss(M: Array, q: Array, basis: Ints, gamma: Array, size: float) -> int:
    """Write γ of this basis; which pair is worst: -1: none, -2: no such γ."""
    p, k = len(q), 0
    at = np.empty(p, np.int64)
    for i in range(p):
        gamma[i] = 0.0
        if basis[i] == 1:
            at[k] = i
            k += 1
    wide, largest = np.empty((k, k + 1)), 0.0
    for i in range(k):
        wide[i, k] = -q[at[i]]
        for j in range(k):
            wide[i, j] = M[at[i], at[j]]
            largest = max(largest, abs(wide[i, j]))
    if not solve_wide(wide, _SINGULAR * largest):
        return -2
    x, biggest = wide[:, k], 0.0
    for i in range(k):
        gamma[at[i]] = x[i]
        biggest = max(biggest, abs(x[i]))
    worst, by = -1, 1.0
    for i in range(p):
        if basis[i] == 1:
            over = -gamma[i] / (_TINY * biggest) if biggest > 0.0 else 0.0
        else:
            y = q[i]
            for j in range(k):
                y += M[i, at[j]] * x[j]
            over = -y / (_TINY * size)
        if over > by:
            worst, by = i, over
    if worst == -1:
        for i in range(p):
            gamma[i] = max(gamma[i], 0.0)
    return worst
