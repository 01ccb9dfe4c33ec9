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
from handlcp.grasp.derivatives.active_set import LinearLaws, active_rows, all_sticking, saddle_matrix, solve_inverse
from handlcp.grasp.verify.contact_state import SEPARATED, ContactStates
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
    kept, states = np.zeros(m + dof + k, np.bool_), all_sticking(len(closed))
    kept[m : m + dof] = True
    kept[m + dof :] = yields == 1
    for i in range(len(closed)):
        if closed[i] == OPEN:
            states.kind[i] = SEPARATED
    laws = LinearLaws(saddle_matrix(p.E, 1.0, p.G, p.rows), kept, p.contacts, p.mu, 1.0)
    known.loose[0] = 0
    if _put_inverse(laws, states, known):
        return
    known.loose[0] = _loose(p, laws, states, known.Z)
    loose = known.Z[:, : known.loose[0]].copy()
    laws.K[m:, m:] -= np.dot(loose, loose.T)  # motions that no contact feels are zero
    if _put_inverse(laws, states, known):
        return
    soft = _RIGID * max(np.trace(p.E) / max(m, 1), 1e-30)
    for i in range(m):
        laws.K[i, i] += soft
    _put_inverse(laws, states, known)


@kernel
def _put_inverse(laws: LinearLaws, states: ContactStates, known: Inverse) -> bool:
    """Write W; False where there is none."""
    A, B = active_rows(laws, states)
    X, found = solve_inverse(A, B[:, : len(A)], _NO_PIVOT)
    known.W[:] = -X
    return found


@kernel
def _loose(p: Parts, laws: LinearLaws, states: ContactStates, Z: Array) -> int:
    """Write motions that no contact feels into the columns of Z; returns how many."""
    m = len(p.E)
    moves, C = np.flatnonzero(laws.kept[m:]), np.zeros((m, len(Z)))
    for i in range(len(p.contacts)):
        for j in p.contacts[i]:
            if j >= 0 and states.kind[i] != SEPARATED:
                C[j] = laws.K[j, m:]
    C = C[:, moves]
    values, vectors = np.linalg.eigh(np.dot(C.T, C))
    loose = 0
    Z[:, :] = 0.0
    for c in range(len(moves)):
        if values[c] <= _LOOSE * max(values[-1], 1.0):
            for j in range(len(moves)):
                Z[moves[j], loose] = vectors[j, c]
            loose += 1
    return loose
