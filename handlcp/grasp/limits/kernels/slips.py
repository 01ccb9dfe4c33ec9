"""What may slip, open or give way at one place of a path, and how forces respond to it: pairs of γ ≥ 0 and -a·ṙ ≥ 0."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.parts import CLOSED, Parts, Place
from handlcp.lcp.kernels.compile import kernel

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
