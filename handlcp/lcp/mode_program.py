"""The mixed-integer program whose points are the solutions of a contact problem, in some choice of modes.

A pair is zero on one side or the other; a contact with friction is open, sticks, or slides within one of the cells that
enclose its set (`cells`). In each mode its part of x and of y are nonnegative multiples of a few generators:

    M x + q = y,    x_i = F_i a_i,  y_i = V_i c_i        (free unknowns: x any, y = 0)
    0 ≤ a_i ≤ X A_iᵀ s_i,  0 ≤ c_i ≤ Y B_iᵀ s_i,  Σ s_i = 1

with binary s_i, natural units, and bounds X and Y for each. HiGHS branches and bounds. Its tolerances only widen what
counts, so "none" stands, within the bounds. The cells enclose what slides, and solvers round: a point of the program
proves no solution.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.cells import cell_modes, slide_bits
from handlcp.lcp.contact import ContactProblem

__all__ = ["ModeProgram"]


class ModeProgram:
    """The program of the module's docstring. Columns: a_i, c_i, s_i, β_i for each pair or contact, then free unknowns.

    most_x, most_y (n,) : bounds of the pairs; those of a normal unknown hold for its contact's tangents as well.
    β_i are bits of the direction in which a contact slides, in Gray code: sums of s_i that have to be integers, too, so
    that branching can split directions in halves.
    """

    def __init__(self, problem: ContactProblem, most_x: Array, most_y: Array) -> None:
        n, role = problem.n, problem.role
        friction = {int(b[0]): (b[b >= 0], float(mu)) for b, mu in zip(problem.blocks, problem.limits, strict=True)}
        own = [friction.get(i, (np.array([i]), 0.0)) for i in np.flatnonzero(role == 1).tolist()]
        modes = [cell_modes(mu, len(places) - 1, problem.faces) for places, mu in own]
        codes = [slide_bits(len(A) - 2) for _, _, A, _ in modes]
        sizes = [(F.shape[1], V.shape[1], len(A), len(c)) for (F, V, A, _), c in zip(modes, codes, strict=True)]
        free, many = np.flatnonzero(role == 0), len(own)
        nv = int(np.sum(sizes)) + len(free)
        self.X, Y, self.allow = np.zeros((n, nv)), np.zeros((n, nv)), np.zeros((nv, nv), bool)
        self.one, self.tight = np.zeros((many, nv)), np.zeros((many, nv))  # Σ s_i; Σ a_i + X s_open ≤ X
        self.bits = np.zeros((sum(s[3] for s in sizes), nv))  # Σ s_i - β_i
        self.low, self.top, self.room = np.zeros(nv), np.full(nv, np.inf), np.empty(many)
        size, at, bit = np.ones(n), 0, 0  # of rows and their y, so that HiGHS meets no numbers beyond its tolerances
        for k, ((places, _), (F, V, A, B), code) in enumerate(zip(own, modes, codes, strict=True)):
            a, c, s, beta = np.split(np.arange(at, at + sum(sizes[k])), np.cumsum(sizes[k])[:-1])
            i, place = places[0], [*places[1:], places[0]]  # the normal comes last in the modes
            size[i] = 1.0 if len(places) > 1 else max(1.0, abs(problem.q[i]))
            self.X[np.ix_(place, a)], Y[np.ix_(place, c)] = F, V * size[i]
            self.top[a], self.top[c] = most_x[i], most_y[i] / size[i]
            self.allow[np.ix_(a, s)], self.allow[np.ix_(c, s)] = A.T, B.T
            self.one[k, s], self.tight[k, a], self.tight[k, s[0]], self.room[k] = 1.0, 1.0, most_x[i], most_x[i]
            self.bits[bit : bit + len(beta), s[2:]] = code
            self.bits[bit + np.arange(len(beta)), beta] = -1.0
            at, bit = at + sum(sizes[k]), bit + len(beta)
        self.X[free, at + np.arange(len(free))], self.low[at:] = 1.0, -np.inf
        self.mode, self.bounded = self.one.any(0), self.allow.any(1)
        self.integer = self.mode | (self.bits < 0).any(0)
        self.eq, self.rhs = (problem.M @ self.X - Y) / size[:, None], -problem.q / size
        self.cost = (self.bounded & ~self.X.any(0)).astype(float)  # Σ c: any would do, this one proves soonest
        self.exhausted = False

    def visit(self, end: float, most: int) -> Iterator[Iterator[Array]]:
        """One choice of modes after the other (at most `most`), each as x (n,); a choice is cut off once visited.

        end : of `time.monotonic`. `exhausted` says afterwards whether HiGHS proved that no choice is left.
        """
        from scipy.optimize import Bounds, LinearConstraint, milp  # half a second of import that few solves should pay

        self.exhausted = False
        big = np.eye(len(self.top)) - np.where(self.allow, self.top[:, None], 0.0)
        parts = (
            (np.vstack([self.eq, self.bits]), *[np.append(self.rhs, np.zeros(len(self.bits)))] * 2),
            (self.one, 1, 1),
            (self.tight, -np.inf, self.room),
            (big[self.bounded], -np.inf, 0.0),
        )
        constraints = [LinearConstraint(*part) for part in parts if len(part[0])]
        bounds = Bounds(self.low, np.where(self.integer, 1.0, np.inf))
        for _ in range(most + 1):
            if (left := end - time.monotonic()) <= 0:
                return
            options = {"time_limit": left, "mip_rel_gap": 1e9}  # any feasible point will do
            r = milp(self.cost, constraints=constraints, integrality=self.integer, bounds=bounds, options=options)
            if r.x is None:
                self.exhausted = r.status == 2
                return
            s = self.mode & (r.x > 0.5)
            yield self._members(s, r.x)
            constraints.append(LinearConstraint(s.astype(float)[None], -np.inf, len(self.one) - 1))

    def _members(self, s: Bools, near: Array) -> Iterator[Array]:
        """Of the modes s: a vertex, its support solved once more to the last digits, then without that; then `near`."""
        from scipy.optimize import linprog

        use = (~self.bounded | self.allow[:, s].any(1)) & ~self.integer
        lp = linprog(
            self.cost[use],
            A_eq=self.eq[:, use],
            b_eq=self.rhs,
            bounds=np.column_stack([self.low[use], np.full(int(use.sum()), np.inf)]),
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10},
        )
        if lp.x is not None:
            v = np.zeros(len(self.low))
            v[use] = lp.x
            support = use & ((v > 0.0) | (self.low < 0.0))
            exact = v.copy()
            exact[support] += np.linalg.lstsq(self.eq[:, support], self.rhs - self.eq @ v, rcond=1e-13)[0]
            yield self.X @ np.maximum(exact, self.low)
            yield self.X @ v
        yield self.X @ near
