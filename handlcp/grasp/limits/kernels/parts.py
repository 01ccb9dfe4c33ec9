"""What a path under a growing load is followed with: arrays of the grasp, the state on the path, and their inverse.

In natural units over the unknown force components, in the coordinates of the friction laws. With contacts that touch
(closed) and limits that give way (yielding), a small change of the load changes forces r, motion u and yields s by

    [E  Gᵀ Aᵀ] [ṙ]   [-b γ]
    [G  0  0 ] [u̇] = [-ẇ  ]
    [A  0  0 ] [ṡ]   [ 0  ]

where b γ are the slips of contacts at the limit of their friction. The inverse W of this matrix changes only where
contacts open or close and limits begin or cease to give way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel

OPEN, CLOSED, OPENS, CLOSES = 0, 1, 2, 3  # the last two: no force and no gap, after a force or after a gap
_LOOSE, _NO_PIVOT = 1e-13, 1e-12
_RIGID = 1e-8  # of the mean flexibility: where forces depend on nothing that gives way, they spread as if it gave this


class Parts(NamedTuple):
    """What stays. E (m, m), G (dof, m). rows (k, m) : A of limits that give way. contacts (n, 4) : the normal
    unknown of each contact and its tangential ones, padded by -1. mu (n,) : of its friction set. owner (f,) : the
    contact of each face; normals (f, 3) : of the face. moving (f,) : 1 where the set is round, and its one face lies
    at the force.
    """

    E: Array
    G: Array
    rows: Array
    contacts: Ints
    mu: Array
    owner: Ints
    normals: Array
    moving: Ints


class Place(NamedTuple):
    """Where on the path. r (m,), u (dof,), gap (n,). give, slack (k,) : of limits. closed (n,) : one of the constants.
    yields (k,) : 1 where a limit gives way, 2 where it is about to or not. active (f,) : 1 where the force lies on the
    face; slides (f,) : 1 where the contact slips against it.
    """

    r: Array
    u: Array
    gap: Array
    give: Array
    slack: Array
    closed: Ints
    yields: Ints
    active: Ints
    slides: Ints

    def copy(self) -> Place:
        """The same, to be changed."""
        return Place(
            self.r.copy(), self.u.copy(), self.gap.copy(), self.give.copy(), self.slack.copy(), self.closed.copy(),
            self.yields.copy(), self.active.copy(), self.slides.copy(),
        )  # fmt: skip


class Inverse(NamedTuple):
    """W (m + dof + k square), the inverse; zero for what is open and does not yield. Z (dof + k, dof + k) : its first
    `loose` columns are motions that no contact feels. closed (n,), yields (k,) : what it was made for; loose (1,) : -1
    before it was made.
    """

    W: Array
    Z: Array
    closed: Ints
    yields: Ints
    loose: Ints


def none_known(p: Parts) -> Inverse:
    """Before any was made."""
    m, dof, k, n = len(p.E), len(p.G), len(p.rows), len(p.mu)
    size = m + dof + k
    return Inverse(
        np.zeros((size, size)), np.zeros((dof + k, dof + k)), np.zeros(n, np.int64), np.zeros(k, np.int64),
        np.full(1, -1, np.int64),
    )  # fmt: skip


@kernel
def update(p: Parts, closed: Ints, yields: Ints, known: Inverse) -> None:
    """Make the inverse anew where contacts or limits are others than those it was made for. yields (k,) : 0 or 1."""
    same = known.loose[0] >= 0
    for i in range(len(closed)):
        same = same and (closed[i] == OPEN) == (known.closed[i] == OPEN)
    for q in range(len(yields)):
        same = same and yields[q] == known.yields[q]
    if same:
        return
    known.closed[:] = closed
    known.yields[:] = yields
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    on, count = np.empty(m + dof + k, np.int64), 0
    used = np.zeros(m, np.int64)
    for i in range(len(closed)):
        for a in range(4):
            if closed[i] != OPEN and p.contacts[i, a] >= 0:
                used[p.contacts[i, a]] = 1
    for j in range(m + dof + k):
        if (j < m and used[j] == 1) or m <= j < m + dof or (j >= m + dof and yields[j - m - dof] == 1):
            on[count] = j
            count += 1
    on = on[:count]
    K = np.empty((count, count))
    known.loose[0] = 0
    _saddle(p, on, K)
    if not _inverted(K):
        known.loose[0] = _loose(p, on, known.Z)
        _saddle(p, on, K)
        _hold(on, m, known, K)
        if not _inverted(K):
            _saddle(p, on, K)
            _hold(on, m, known, K)
            soft = _RIGID * max(np.trace(p.E) / max(m, 1), 1e-30)
            for i in range(count):
                if on[i] < m:
                    K[i, i] += soft
            _inverted(K)
    known.W[:, :] = 0.0
    for i in range(count):
        for j in range(count):
            known.W[on[i], on[j]] = K[i, j]


@kernel
def _saddle(p: Parts, on: Ints, K: Array) -> None:
    m, dof = len(p.E), len(p.G)
    for i in range(len(on)):
        a = on[i]
        for j in range(i + 1):
            b = on[j]
            if a < m:
                value = p.E[a, b]
            elif b >= m:
                value = 0.0
            else:
                value = p.G[a - m, b] if a < m + dof else p.rows[a - m - dof, b]
            K[i, j] = K[j, i] = value


@kernel
def _loose(p: Parts, on: Ints, Z: Array) -> int:
    """Write motions that no contact feels into the columns of Z; returns how many."""
    m, dof, count = len(p.E), len(p.G), len(on)
    moves = 0
    for a in on:
        moves += 1 if a >= m else 0
    C = np.zeros((count - moves, moves))
    for i in range(count - moves):
        for j in range(moves):
            b = on[count - moves + j] - m
            C[i, j] = p.G[b, on[i]] if b < dof else p.rows[b - dof, on[i]]
    values, vectors = np.linalg.eigh(np.dot(C.T, C))
    loose = 0
    Z[:, :] = 0.0
    for c in range(moves):
        if values[c] <= _LOOSE * max(values[-1], 1.0):
            for j in range(moves):
                Z[on[count - moves + j] - m, loose] = vectors[j, c]
            loose += 1
    return loose


@kernel
def _hold(on: Ints, m: int, known: Inverse, K: Array) -> None:
    """Subtract Z Zᵀ, so that motions that no contact feels are zero."""
    for i in range(len(on)):
        for j in range(len(on)):
            if on[i] >= m and on[j] >= m:
                for c in range(known.loose[0]):
                    K[i, j] -= known.Z[on[i] - m, c] * known.Z[on[j] - m, c]


@kernel
def _inverted(K: Array) -> bool:
    """K ← K⁻¹ in place, by Gauss and Jordan with row pivoting; whether every pivot is one."""
    n = len(K)
    swaps = np.empty(n, np.int64)
    for s in range(n):
        best, at = 0.0, s
        for i in range(s, n):
            if abs(K[i, s]) > best:
                best, at = abs(K[i, s]), i
        if best <= _NO_PIVOT:
            return False
        swaps[s] = at
        if at != s:
            for j in range(n):
                K[s, j], K[at, j] = K[at, j], K[s, j]
        f = 1.0 / K[s, s]
        K[s, s] = 1.0
        top = K[s]
        top *= f
        for i in range(n):
            if i != s:
                g = K[i, s]
                if g != 0.0:
                    K[i, s] = 0.0
                    row = K[i]
                    for j in range(n):
                        row[j] -= g * top[j]
    for s in range(n - 1, -1, -1):
        if swaps[s] != s:
            for i in range(n):
                K[i, s], K[i, swaps[s]] = K[i, swaps[s]], K[i, s]
    return True
