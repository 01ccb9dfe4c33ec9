"""What every contact may do, as small matrices, and how contact forces answer to motions: the input of `mode_walk`.

With all contacts stuck a grasp is a linear system. Its inverse gives the forces x that other motions y would cause,

    x = c + P y        from  [[E, GᵀU], [UᵀG, 0]] (x, u') = (y - d, -Uᵀw)

with U a basis of the object motions that move any contact. Rigid fingers whose forces are not determined have no
inverse, and no table. A limit of an effect is one more contact without friction: it "pushes" with the slack t that is
left, and "opens" by the motion s that gives way (`model.limit`); two limits on the same, one each way, are one.

    t = room - A x,  x = c + P (y - Aᵀs)

Slacks are told in units of the room, where that is large, so that nothing looks small beside a bound out of reach.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.friction import Pyramid
from handlcp.grasp.search.mode_steps import Modes
from handlcp.grasp.search.mode_walk import visit
from handlcp.lcp.compiler.when import at_once
from handlcp.tolerances import RANK

PER_SECOND = 4e6  # choices of modes that are visited in a second, a careful count

_MOST, _MOST_WHOLE = 2048, 1_000_000
_SAME = 1e-9


@dataclass(frozen=True, slots=True)
class Table:
    """x = c + P y (N = 3n components, those that a contact lacks zero; n counts limits, too), and the modes.

    problem : what it was made of. back (problem.n, N), back0 (problem.n,): all its unknowns are back0 + back y.
    """

    problem: GraspContactProblem
    back: Array
    back0: Array
    P: Array
    c: Array
    modes: Modes

    @property
    def choices(self) -> float:
        """How many choices of modes there are."""
        return float(np.prod(self.modes.choices.astype(float)))

    def visit(self) -> tuple[Iterator[Candidate | None], bool]:
        """What the signs of some choice of modes allow, to rounding; and whether all choices were visited. Of a choice
        that leaves something free one member only, when asked for (a millisecond or more); None where it has none.
        """
        with at_once(self.choices / 1000):  # of which Python visits ten thousand a second
            motions, free, complete = visit(self.P, self.c, self.modes, _MOST, _MOST_WHOLE)
        every = itertools.chain(motions, (self._member(mode) for mode in free))
        return (None if y is None else self.problem.candidate(self.back0 + self.back @ y) for y in every), complete

    def _member(self, mode: Ints) -> Array | None:
        """(N,) motions that satisfy one choice of modes: a point of a linear program, after the signs that are not
        free at all have been looked at.
        """
        from scipy.optimize import linprog  # half a second of import that only loose scenes should pay

        m, at = self.modes, (np.arange(len(mode)), mode)
        A, B = _stacked(m.A[at], m.rank[at]), _stacked(m.B[at].transpose(0, 2, 1), m.rank[at])
        X, Y = _stacked(m.X[at], m.signs[at]), _stacked(m.Y[at], m.signs[at])
        S, b = A @ self.P @ B.T, -A @ self.c
        signs, now = X @ self.P @ B.T + Y @ B.T, X @ self.c
        U, size, Vt = np.linalg.svd(S)
        rank = int((size > RANK * size[0]).sum())
        s = Vt[:rank].T @ ((U[:, :rank].T @ b) / size[:rank])
        free = Vt[rank:].T
        fixed = abs(signs @ free).max(axis=1) <= _SAME * abs(signs).max(axis=1)
        value, allowed = signs @ s + now, 1e-6 * max(1.0, float(abs(s).max()))
        if (value[fixed] < -allowed).any():
            return None
        rows, room = -(signs @ free)[~fixed], value[~fixed] + _SAME * allowed
        found = linprog(np.zeros(free.shape[1]), rows, room, bounds=(None, None), method="highs").x
        return None if found is None else np.asarray(B.T @ (s + free @ found))


def _stacked(blocks: Array, counts: Ints) -> Array:
    """(Σ counts, 3n) the first rows of each contact's block (n, rows, 3), as many as it counts."""
    n, rows, _ = blocks.shape
    each, out = np.arange(n), np.zeros((n, rows, n, 3))
    out[each, :, each] = blocks
    return out[np.arange(rows) < counts[:, None]].reshape(-1, 3 * n)


def mode_table(problem: GraspContactProblem) -> Table | None:
    """For a pyramid or a planar problem. None for the cone, for contacts with three tangents, and where the forces of
    sticking contacts are not determined.
    """
    if not problem.faces or (problem.blocks[:, 3] >= 0).any():
        return None
    friction = {int(b[0]): (b[:3], float(mu)) for b, mu in zip(problem.blocks, problem.limits, strict=True)}
    signed = np.setdiff1d(np.flatnonzero(problem.role == 1), problem.limited).tolist()
    contacts = [friction.get(i, (np.array([i, -1, -1]), 0.0)) for i in signed]
    if not contacts:
        return None
    pairs = _paired(problem)
    place = np.concatenate([block for block, _ in contacts] + pairs)
    limit = np.isin(place, problem.limited)
    here, there = np.flatnonzero((place >= 0) & ~limit), np.flatnonzero(limit)
    free = np.flatnonzero(problem.role == 0)
    own, limited = place[here], place[there]
    G = problem.M[np.ix_(free, own)]
    U, size, _ = np.linalg.svd(G, full_matrices=False)
    U = U[:, size > RANK * size[0]]
    k, moves = len(own), U.shape[1]
    K = np.block([[problem.M[np.ix_(own, own)], G.T @ U], [U.T @ G, np.zeros((moves, moves))]])
    if not np.linalg.cond(K) < 1.0 / RANK:
        return None
    inverse = np.linalg.inv(K)
    start = -inverse @ np.append(problem.q[own], U.T @ problem.q[free])
    N = len(place)
    P, c, back, back0 = np.zeros((N, N)), np.zeros(N), np.zeros((problem.n, N)), np.zeros(problem.n)
    P[np.ix_(here, here)], c[here] = inverse[:k, :k], start[:k]
    back[np.ix_(own, here)], back[np.ix_(free, here)] = inverse[:k, :k], U @ inverse[k:, :k]
    back0[own], back0[free] = start[:k], U @ start[k:]
    if len(there):
        A = -problem.M[np.ix_(limited, own)]
        back[:, there] = -back[:, here] @ A.T
        back[limited, there] = 1.0
        P[np.ix_(here, there)] = back[np.ix_(own, there)]
        room = problem.q[limited]
        size = np.maximum(abs(room), 1.0)
        P[there], c[there] = -A @ back[own] / size[:, None], (room - A @ start[:k]) / size
    kinds = [_contact_modes(int((block >= 0).sum()), mu, problem.faces) for block, mu in contacts]
    kinds += [_contact_modes(1, 0.0, 0) if block[1] < 0 else _BOTH_WAYS for block in pairs]
    return Table(problem, back, back0, P, c, _padded(kinds))


def coarse(problem: GraspContactProblem, faces: int, seconds: float) -> Iterator[Candidate | None]:
    """As `Table.visit` of the scene on a pyramid of so many faces; nothing where that would take longer."""
    table = mode_table(GraspContactProblem(problem.scene, Pyramid(faces), problem.asked))
    if table is not None and table.choices <= PER_SECOND * seconds:
        yield from table.visit()[0]


def _padded(kinds: list[list[Mode]]) -> Modes:
    """The modes of all contacts as arrays."""
    shape = len(kinds), max(len(modes) for modes in kinds)
    deepest = max(len(X) for modes in kinds for _, _, X, _ in modes)
    rank, count = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    A, B, X, Y = (np.zeros((*shape, *s)) for s in ((3, 3), (3, 3), (deepest, 3), (deepest, 3)))
    for i, modes in enumerate(kinds):
        for j, (a, b, x, y) in enumerate(modes):
            p, q, d = len(a), *x.shape
            rank[i, j], count[i, j] = p, q
            A[i, j, :p, :d], B[i, j, :d, :p], X[i, j, :q, :d], Y[i, j, :q, :d] = a, b, x, y
    return Modes(np.array([len(modes) for modes in kinds]), rank, A, B, X, Y, count)


def _paired(problem: GraspContactProblem) -> list[Ints]:
    """(3,) unknowns of each limit, or of two on the same thing, one each way; padded by -1."""
    out, left = [], problem.limited.tolist()
    while left:
        i = left.pop(0)
        against = [j for j in left if not (problem.M[i] + problem.M[j]).any() and problem.q[i] + problem.q[j] > 0.0]
        out.append(np.array([i, *against[:1], -1, -1])[:3])
        if against:
            left.remove(against[0])
    return out


Mode = tuple[Array, Array, Array, Array]
_FIRST, _SECOND = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
_BOTH_WAYS: list[Mode] = [  # one way, not at all, the other way: s ≥ 0 of the one, t ≥ 0 of the other
    (_FIRST, _FIRST.T, np.vstack([0 * _FIRST, _SECOND]), np.vstack([_FIRST, 0 * _SECOND])),
    (np.zeros((0, 2)), np.zeros((2, 0)), np.eye(2), np.zeros((2, 2))),
    (_SECOND, _SECOND.T, np.vstack([0 * _SECOND, _FIRST]), np.vstack([_SECOND, 0 * _FIRST])),
]


def _contact_modes(d: int, mu: float, faces: int) -> list[Mode]:
    """(A, B, X, Y) of each mode of a contact with d components: A x = 0, y = B s, X x + Y y ≥ 0."""
    up, one, none = np.eye(d)[:1], np.eye(d), np.zeros((0, d))
    opened = (one, one, 0 * up, up)
    if d == 1:
        return [opened, (none, none.T, up, 0 * up)]
    a = 2 * np.pi * np.arange(faces) / faces
    normals = np.column_stack([np.zeros(faces), np.cos(a), np.sin(a)])[:, :d]  # outward, in (N, T, O)
    limits = mu * up - normals  # · x ≥ 0 inside, = 0 on the face
    modes = [opened, (none, none.T, limits, 0 * limits)]
    for j, out in enumerate(normals):
        beside = limits[[j - 1, (j + 1) % faces]] if d == 3 else up
        rows = np.vstack([-out, 0 * beside])  # the slip is against the face …
        modes.append((limits[j : j + 1], -out[:, None], np.vstack([0 * up, beside]), rows))
    for j in range(faces if d == 3 else 0):
        pair = [j, (j + 1) % faces]
        against = np.zeros((2, 3))  # … or within the angle between two: y_T = -(s₁ n₁ + s₂ n₂), s ≥ 0
        against[:, 1:] = -np.linalg.inv(normals[pair, 1:].T)
        rows = np.vstack([up, 0 * against])
        modes.append((limits[pair], -normals[pair].T, rows, np.vstack([0 * up, against])))
    return modes
