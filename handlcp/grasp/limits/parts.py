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
from handlcp.lcp.kernels.compile import kernel

__all__ = ["CLOSED", "CLOSES", "OPEN", "OPENS", "Parts", "Place", "inverse"]

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


@kernel
def inverse(p: Parts, closed: Ints, yields: Ints) -> tuple[Array, Array]:
    """(W, Z): the inverse (m + dof + k square; zero for what is open and does not yield), and in the columns of Z the
    motions (dof + k, l) that no contact feels.
    """
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    size = m + dof + k
    C = np.zeros((m, dof + k))
    on = np.zeros(size)
    for i in range(len(closed)):
        if closed[i] != OPEN:
            for a in range(4):
                j = p.contacts[i, a]
                if j >= 0:
                    on[j] = 1.0
    for j in range(m):
        if on[j] > 0.0:
            C[j, :dof] = p.G[:, j]
            for q in range(k):
                if yields[q] == 1:
                    C[j, dof + q] = p.rows[q, j]
    on[m : m + dof] = 1.0
    for q in range(k):
        if yields[q] == 1:
            on[m + dof + q] = 1.0
    values, vectors = np.linalg.eigh(np.dot(C.T, C))
    loose = 0
    Z = np.zeros((dof + k, dof + k))
    for c in range(dof + k):
        if values[c] <= _LOOSE * max(values[-1], 1.0):
            Z[:, loose] = vectors[:, c] * on[m:]
            if np.sum(Z[:, loose] ** 2) > 0.5:
                loose += 1
    Z = Z[:, :loose].copy()
    K = np.zeros((size, size))
    soft = 0.0
    for round_ in range(2):
        for i in range(m):
            if on[i] > 0.0:
                for j in range(m):
                    if on[j] > 0.0:
                        K[i, j] = p.E[i, j]
                K[i, i] += soft
        K[:m, m:] = C
        K[m:, :m] = C.T
        K[m:, m:] = -np.dot(Z, Z.T)
        for i in range(size):
            if on[i] == 0.0:
                K[i, i] = 1.0
        W = np.eye(size)
        if _inverted(K, W) or round_ == 1:
            break
        K[:, :] = 0.0
        soft = _RIGID * max(np.trace(p.E) / max(m, 1), 1e-30)
    for i in range(size):
        if on[i] == 0.0:
            W[i, i] = 0.0
    return W, Z


@kernel
def _inverted(K: Array, W: Array) -> bool:
    """W ← K⁻¹ W by elimination with row pivoting; K is overwritten. Whether every pivot is one."""
    n = len(K)
    for s in range(n):
        best, at = 0.0, s
        for i in range(s, n):
            if abs(K[i, s]) > best:
                best, at = abs(K[i, s]), i
        if best <= _NO_PIVOT:
            return False
        if at != s:
            for j in range(n):
                K[s, j], K[at, j] = K[at, j], K[s, j]
                W[s, j], W[at, j] = W[at, j], W[s, j]
        f = 1.0 / K[s, s]
        K[s] *= f
        W[s] *= f
        for i in range(n):
            if i != s:
                f = K[i, s]
                if f != 0.0:
                    K[i] -= f * K[s]
                    W[i] -= f * W[s]
    return True
