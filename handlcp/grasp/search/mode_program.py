"""The mixed-integer program whose points are equilibria on cones or pyramids, in some choice of contact modes.

A contact is open, sticks, or slides within one of the cells that enclose its friction set (`cells`). In each mode its
force r and its motion v are nonnegative multiples of a few generators.

    G r + w = 0,  v = Gᵀu + E r + d,  r_i = F_i a_i,  v_i = V_i c_i
    0 ≤ a_i ≤ b A_iᵀ y_i,  0 ≤ c_i ≤ b B_iᵀ y_i,  Σ y_i = 1

with binary y_i, natural units: normal forces, gaps and slips along each generator up to b, any u. HiGHS branches and
bounds. Its tolerances only widen what counts, so "none" stands. The cells enclose force and slip, so that no point of
the program proves a solution; none proves none.

An effect's limit (`effects.limit`) holds or gives way: two modes more, with a slack t or a motion s,

    v += Aᵀ s,  A r + t = room,  0 ≤ t_j ≤ T_j y_j,  0 ≤ s_j ≤ b y'_j,  y_j + y'_j = 1

where T_j is the most that forces up to b can leave: s alone is cut off at b. (t in units of the room where it is > 1.)
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContact
from handlcp.grasp.search.cells import cell_modes, slide_bits
from handlcp.grasp.verify.limits_at_answer import every_limit, motions_in_si, stacked

__all__ = ["Program"]


class Program:
    """The program of the module's docstring. Unknowns: per governed contact a_i, c_i, y_i, β_i; t, s, y, y'; then u.

    β_i are bits of the direction in which the contact slides, in Gray code: sums of y_i that have to be integers, too,
    so that branching can split directions in halves.
    """

    def __init__(self, problem: GraspContact) -> None:
        scene = self.scene = problem.scene
        kind, limits = scene.kind, scene.limits(problem.section)
        contacts = [(i, own[own >= 0]) for i, own in enumerate(kind.contact_components) if own[0] >= 0]
        modes = [cell_modes(float(limits[i]), len(own) - 1, problem.faces) for i, own in contacts]
        codes = [slide_bits(len(A) - 2) for _, _, A, _ in modes]
        sizes = [(F.shape[1], V.shape[1], len(A), len(c)) for (F, V, A, _), c in zip(modes, codes, strict=True)]
        self.every = every_limit(scene, problem.effects)
        self.rows, self.room = stacked(scene, self.every)
        m, many, c = len(self.room), len(contacts), scene.components
        self.nv = nv = int(np.sum(sizes)) + 4 * m + scene.dof
        self.force, self.motion, self.allow = np.zeros((c, nv)), np.zeros((c, nv)), np.zeros((nv, nv), bool)
        self.one, self.share = np.zeros((many + m, nv)), np.zeros((many, nv))  # Σ y_i; Σ a_i, the normal force
        self.bits, self.opened = np.zeros((sum(s[3] for s in sizes), nv)), np.zeros(many, int)  # Σ y_i - β_i
        at, bit = 0, 0
        for k, ((_, own), (F, V, A, B), code) in enumerate(zip(contacts, modes, codes, strict=True)):
            f, v, y, beta = np.split(np.arange(at, at + sum(sizes[k])), np.cumsum(sizes[k])[:-1])
            place = [*own[1:], own[0]]  # the normal comes last in the modes
            self.force[np.ix_(place, f)], self.motion[np.ix_(place, v)] = F, V
            self.allow[np.ix_(f, y)], self.allow[np.ix_(v, y)] = A.T, B.T
            self.one[k, y], self.share[k, f], self.opened[k] = 1.0, 1.0, y[0]
            self.bits[bit : bit + len(beta), y[2:]] = code
            self.bits[bit + np.arange(len(beta)), beta] = -1.0
            at, bit = at + sum(sizes[k]), bit + len(beta)
        self.t, self.s, holds, yields = np.arange(at, at + 4 * m).reshape(4, m)
        self.allow[self.t, holds] = self.allow[self.s, yields] = True
        each = many + np.arange(m)
        self.one[each, holds] = self.one[each, yields] = 1.0
        self.mode, self.bounded = self.one.any(0), self.allow.any(1)
        self.integer = self.mode | (self.bits < 0).any(0)
        self.low = np.where(np.arange(nv) < nv - scene.dof, 0.0, -np.inf)
        self.cost = (self.motion != 0).any(0).astype(float)
        self.cost[self.s] = 1.0
        self._equations()
        self.exhausted = False

    def _equations(self) -> None:
        """Balance, motions of the unknown components, and what limits leave."""
        scene, m, softness = self.scene, len(self.room), self.scene.units.force / self.scene.units.motion
        E, every, index = scene.flexibility * softness, scene.natural.every, scene.kind.index
        given = scene.given.prescribed / scene.units.force
        self.offset = scene.offset / scene.units.motion + E @ given
        twist = np.zeros((scene.components, self.nv))
        twist[:, self.nv - scene.dof :], twist[:, self.s] = every.T, self.rows.T
        held = self.rows @ self.force
        reach = (np.maximum(-held, 0.0)[:, None] * self.share).max(axis=2, initial=0.0).sum(axis=1)
        size = np.maximum(abs(self.room), 1.0)  # of t, so that HiGHS meets no numbers beyond its tolerances
        self.leaves = self.room / size, reach / size, _opposite(self.rows, self.room) / size
        held /= size[:, None]
        held[np.arange(m), self.t] = 1.0
        self.eq = np.vstack([(self.motion - E @ self.force - twist)[index], every @ self.force, held])
        self.rhs = np.concatenate([self.offset[index], -scene.natural.w, self.room / size])

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
        forces = self.force @ x * s.units.force + s.given.prescribed
        return Candidate(forces, s.twist(x[self.nv - s.dof :]), motions_in_si(s, self.every, x[self.s]))


def _opposite(A: Array, room: Array) -> Array:
    """(m,) the slack of each limit A r ≤ room where the one the other way, if there is one, has none left; else inf."""
    against = (A[:, None] + A[None] == 0.0).all(axis=2)
    return np.asarray(room + np.where(against, room, np.inf).min(axis=1, initial=np.inf))
