"""Contact modes, and the mixed-integer program whose points are equilibria in some choice of them.

A contact is open, sticks, slides against a face, or slides at an edge between two faces. In each mode its force r and
its motion v are nonnegative multiples of a few generators: edges of the friction pyramid, normal and face normals.

    G r + w = 0,  v = Gᵀu + E r + d,  r_i = F_i a_i,  v_i = V_i c_i
    0 ≤ a_i ≤ b A_iᵀ y_i,  0 ≤ c_i ≤ b B_iᵀ y_i,  Σ y_i = 1

with binary y_i, natural units: normal forces, gaps and slips along each face up to b, any u. HiGHS branches and bounds.
Its tolerances only widen what counts, so "none" stands. The exact cone is enclosed in sectors: a force within a thin
triangle around the arc, and a slip within the opposite sector. No point of that proves a solution; none proves none.

An effect's limit (`effects.limit`) holds or gives way: two modes more, with a slack t or a motion s,

    v += Aᵀ s,  A r + t = room,  0 ≤ t_j ≤ T_j y_j,  0 ≤ s_j ≤ b y'_j,  y_j + y'_j = 1

where T_j is the most that forces up to b can leave: s alone is cut off at b. (t in units of the room where it is > 1.)
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.limits import every_limit, motions_in_si, stacked
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_modes import soft_modes

__all__ = ["Program"]

_SECTORS = 16  # that enclose the exact cone


def _modes(mu: float, section: Section) -> tuple[Array, Array, Bools, Bools]:
    """Force generators (3, a), motion generators (3, c), and which of them each mode allows, (modes, a), (modes, c).

    mu : the section's limit. Modes: open; stuck; sliding along each face's normal and at each edge (interval: at each
    end; cone: within each sector). Without friction: open, touching. Motion generators end with the normal: the gap.
    """
    up = np.array([[0.0], [0.0], [1.0]])
    if mu <= 0.0:
        return up, up, np.array([[False], [True]]), np.array([[True], [False]])
    if section.faces == 2:
        ends = np.array([[mu, -mu], [0.0, 0.0], [1.0, 1.0]])
        motion = np.hstack([np.array([[-1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]), up])
        return ends, motion, _rows([0, 0], [1, 1], np.eye(2)), _rows([1, 1, 1], [0, 0, 0], np.eye(2, 3))
    m = section.faces or _SECTORS
    a, one = 2 * np.pi * np.arange(m) / m, np.eye(m)
    inner = np.vstack([np.cos(a), np.sin(a)])  # face normals; for the cone: the rays between sectors
    outer = np.vstack([np.cos(a + np.pi / m), np.sin(a + np.pi / m)]) / np.cos(np.pi / m)  # between j and j + 1
    motion = np.hstack([np.vstack([-inner, np.zeros(m)]), up])
    both, neither = one + np.roll(one, 1, 1), np.zeros((m, 1))  # row j: j and j + 1
    if section.faces:
        before = one + np.roll(one, -1, 1)  # row j: the edges j - 1 and j on both sides of face j
        force = np.vstack([mu * outer, np.ones(m)])
        return (
            force,
            motion,
            _rows(np.zeros(m), np.ones(m), before, one),
            _rows(np.ones(m + 1), np.zeros(m + 1), np.hstack([one, neither]), np.hstack([both, neither])),
        )
    force = np.vstack([mu * np.hstack([outer, inner]), np.ones(2 * m)])
    stuck = np.append(np.ones(m), np.zeros(m))
    return (
        force,
        motion,
        _rows(np.zeros(2 * m), stuck, np.hstack([one, both])),
        _rows(np.ones(m + 1), np.zeros(m + 1), np.hstack([both, neither])),
    )


def _rows(*parts: Any) -> Bools:
    return np.vstack([np.atleast_2d(np.asarray(p)) for p in parts]) > 0


class Program:
    """The program of the module's docstring. Unknowns: per governed contact a_i, c_i, y_i, β_i; t, s, y, y'; then u.

    β_i are bits of the direction in which the contact slides, in Gray code: sums of y_i that have to be integers, too,
    so that branching can split directions in halves. Half the time at 8 and 16 faces.
    """

    def __init__(self, scene: Scene, effects: tuple[Effect, ...], section: Section) -> None:
        assert not scene.soft or section.faces == 0  # polyhedra have multipliers instead, and `lcp.search`
        units, dof = scene.units, scene.dof
        self.scene, self.given, self.exhausted = scene, np.zeros(scene.components), False
        for e in effects:
            if isinstance(e, PrescribedForce):
                self.given[3 * e.contact : 3 * e.contact + 3] = scene.lawful_at(e.contact, e.force) / units.force
        E = scene.flexibility * (units.force / units.motion)
        self.offset = scene.every_offset / units.motion + E @ self.given
        limits = section.limit(scene.mu)
        mine = [i for i in range(scene.n) if scene.governed[i]]
        soft = dict(zip(scene.soft, scene.soft_index.tolist(), strict=True)) if scene.soft else {}
        kinds = [soft_modes(float(scene.mu[i])) if i in soft else _modes(float(limits[i]), section) for i in mine]
        codes = [_gray(len(A) - 2, section.faces) for _, _, A, _ in kinds]
        sizes = [(F.shape[1], V.shape[1], len(A), len(c)) for (F, V, A, _), c in zip(kinds, codes, strict=True)]
        self.every = every_limit(scene, effects)
        limited, room = stacked(scene, self.every)
        m = len(room)
        self.nv = nv = int(np.sum(sizes)) + 4 * m + dof
        self.force, self.motion = np.zeros((scene.components, nv)), np.zeros((scene.components, nv))
        self.allow, self.one = np.zeros((nv, nv), bool), np.zeros((len(mine) + m, nv))
        self.share = np.zeros((len(mine), nv))  # Σ a_i: the normal force
        self.bits = np.zeros((sum(s[3] for s in sizes), nv))  # Σ y_i - β_i
        self.opened: list[int] = []
        rows, at, bit = [], 0, 0
        for k, (i, (F, V, A, B), code) in enumerate(zip(mine, kinds, codes, strict=True)):
            f, v, y, beta = np.split(np.arange(at, at + sum(sizes[k])), np.cumsum(sizes[k])[:-1])
            own = [*soft.get(i, (3 * i, 3 * i + 1)), 3 * i + 2]
            self.force[np.ix_(own, f)], self.motion[np.ix_(own, v)] = F, V
            self.allow[np.ix_(f, y)], self.allow[np.ix_(v, y)] = A.T, B.T
            self.one[k, y], self.share[k, f] = 1.0, 1.0
            self.bits[bit : bit + len(beta), y[2:]] = code
            self.bits[bit + np.arange(len(beta)), beta] = -1.0
            self.opened.append(int(y[0]))
            tangents = [] if limits[i] <= 0 else own[:1] if scene.plane is not None else own[:-1]
            rows += [*tangents, 3 * i + 2]
            at, bit = at + sum(sizes[k]), bit + len(beta)
        self.t, self.s, holds, yields = np.arange(at, at + 4 * m).reshape(4, m)
        self.allow[self.t, holds] = self.allow[self.s, yields] = True
        each = len(mine) + np.arange(m)
        self.one[each, holds] = self.one[each, yields] = 1.0
        self.mode, self.bounded = self.one.any(0), self.allow.any(1)
        self.integer = self.mode | (self.bits < 0).any(0)
        twist = np.zeros((scene.components, nv))
        twist[:, nv - dof :] = scene.natural.every.T
        twist[:, self.s] = limited.T
        held = limited @ self.force
        reach = (np.maximum(-held, 0.0)[:, None] * self.share).max(axis=2).sum(axis=1)
        size = np.maximum(abs(room), 1.0)  # of t, so that HiGHS meets no numbers beyond its tolerances
        self.leaves = room / size, reach / size, _opposite(limited, room) / size
        held /= size[:, None]
        held[np.arange(m), self.t] = 1.0
        self.eq = np.vstack([(self.motion - E @ self.force - twist)[rows], scene.natural.every @ self.force, held])
        balance = -scene.natural.w - scene.natural.every @ self.given
        self.rhs = np.concatenate([self.offset[rows], balance, room / size])
        self.low = np.where(np.arange(nv) < nv - dof, 0.0, -np.inf)
        self.cost = (self.motion != 0).any(0).astype(float)
        self.cost[self.s] = 1.0

    def visit(self, b: float, end: float, most: int) -> Iterator[Iterator[Candidate]]:
        """One choice of modes after the other (at most `most`), each as candidates; a choice is cut off once visited.

        `exhausted` says afterwards whether HiGHS proved that no choice within the bound b is left.
        """
        from scipy.optimize import Bounds, LinearConstraint, milp  # half a second of import that few solves should pay

        self.exhausted = False
        tight = self.share.copy()  # an open contact carries nothing
        tight[np.arange(len(tight)), self.opened] = b
        size = np.full((self.nv, 1), b)
        size[self.t, 0] = self._slack(b)
        big = np.vstack([tight, np.eye(self.nv)[self.bounded] - (size * self.allow)[self.bounded]])
        top = np.append(np.full(len(tight), b), np.zeros(int(self.bounded.sum())))
        constraints = [
            LinearConstraint(np.vstack([self.eq, self.bits]), *[np.append(self.rhs, np.zeros(len(self.bits)))] * 2),
            LinearConstraint(self.one, 1, 1),
            LinearConstraint(big, -np.inf, top),
        ]
        bounds = Bounds(self.low, np.where(self.integer, 1.0, np.inf))
        for _ in range(most + 1):
            if (left := end - time.monotonic()) <= 0:
                return
            options = {"time_limit": left, "mip_rel_gap": 1e9}  # any feasible point will do
            r = milp(self.cost, constraints=constraints, integrality=self.integer, bounds=bounds, options=options)
            if r.x is None:
                self.exhausted = r.status == 2
                return
            y = self.mode & (r.x > 0.5)
            yield self._members(y, r.x)
            constraints.append(LinearConstraint(y.astype(float)[None], -np.inf, len(self.one) - 1))

    def _slack(self, b: float) -> Array:
        """(m,) T: the most slack of each limit with normal forces up to b and the limit the other way kept."""
        room, reach, opposite = self.leaves
        return np.asarray(np.clip(room + b * reach, 0.0, np.maximum(opposite, 0.0)))

    def _members(self, y: Bools, near: Array) -> Iterator[Candidate]:
        """Of the modes y: a vertex, its support solved once more to the last digits, then without that; then `near`."""
        from scipy.optimize import linprog

        use = (~self.bounded | self.allow[:, y].any(1)) & ~self.integer
        lp = linprog(
            self.cost[use],
            A_eq=self.eq[:, use],
            b_eq=self.rhs,
            bounds=np.column_stack([self.low[use], np.full(int(use.sum()), np.inf)]),
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10},
        )
        if lp.x is not None:
            x = np.zeros(self.nv)
            x[use] = lp.x
            support = use & ((x > 0.0) | (self.low < 0.0))
            exact = x.copy()
            exact[support] += np.linalg.lstsq(self.eq[:, support], self.rhs - self.eq @ x, rcond=1e-13)[0]
            yield self._decode(np.maximum(exact, self.low))
            yield self._decode(x)
        yield self._decode(near)

    def _decode(self, x: Array) -> Candidate:
        s = self.scene
        forces = (self.force @ x + self.given) * s.units.force
        extra = motions_in_si(s, self.every, x[self.s])
        n = 3 * s.n
        return Candidate(forces[:n].reshape(-1, 3), s.twist(x[self.nv - s.dof :]), extra, forces[n:])


def _opposite(A: Array, room: Array) -> Array:
    """(m,) the slack of each limit A r ≤ room where the one the other way, if there is one, has none left; else inf."""
    against = (A[:, None] + A[None] == 0.0).all(axis=2)
    return np.asarray(room + np.where(against, room, np.inf).min(axis=1, initial=np.inf))


def _gray(slides: int, faces: int) -> Array:
    """(bits, slides) Gray code of the directions in the order of their angles: faces, then the edges that follow each;
    or the sectors of the cone.
    """
    if slides <= 2:
        return np.zeros((0, max(slides, 0)))
    order = np.arange(slides) if not faces else np.append(2 * np.arange(faces), 2 * np.arange(faces) + 1)
    return np.array([((order ^ (order >> 1)) >> k) & 1 for k in range(int(slides - 1).bit_length())], dtype=float)
