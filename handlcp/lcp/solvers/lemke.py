"""Lemke's method (paper, Algorithm 1): the classic, exact on what it can solve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.keywords import helped_init
from handlcp.lcp.kernels.lemke import RAY, SOLVED, lemke
from handlcp.lcp.kernels.newton import settled
from handlcp.lcp.problem import Proposal, Scaled
from handlcp.lcp.reduce import reduce
from handlcp.tolerances import PIVOT, SOLVE


@helped_init()
@dataclass(frozen=True, slots=True)
class Lemke:
    """Complementary pivoting with lexicographic ties and relative tolerances, compiled.

    max_iterations : pivots at most, in each attempt; None: 50 + 20 n.
    coverings : how many covering vectors to try before a secondary ray is accepted as the outcome; the first is all
        ones (the paper's), the others are drawn from `seed`. A ray proves nothing by itself: another covering vector
        may solve the same problem (Murty's example 2.11).
    seed : of the covering vectors after the first.

    Free unknowns are eliminated first (see `reduce`). The answer is recomputed from its active set.
    """

    max_iterations: int | None = None
    coverings: int = 3
    seed: int = 0
    pivot_tolerance: float = PIVOT

    def __post_init__(self) -> None:
        object.__setattr__(self, "pivot_tolerance", number("pivot_tolerance", self.pivot_tolerance, above=0.0))
        if self.max_iterations is not None:
            integer("max_iterations", self.max_iterations, 1)
        integer("coverings", self.coverings, 1)
        integer("seed", self.seed, 0)

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """Pivot from the origin; Lemke's method knows no warm start, so `start` only names the size."""
        if problem.free.any():
            reduced = reduce(problem)
            if not reduced.consistent:
                return Proposal(np.full(len(problem.q), np.nan), 0, "an equation without unknowns does not hold")
            v, pivots, outcome = self._solve(reduced.M, reduced.q)
            z = reduced.restore(v)
        else:
            z, pivots, outcome = self._solve(problem.M, problem.q)
        # The same active set solved afresh from M: pivoting's accumulated rounding goes away
        z, _ = settled(problem.M, problem.q, problem.free, z, SOLVE * 1e-3)
        return Proposal(z, pivots, outcome)

    def _solve(self, M: Array, q: Array) -> tuple[Array, int, str]:
        n = len(q)
        rng = np.random.default_rng(self.seed)
        most = self.max_iterations or 50 + 20 * n
        total, covering, z, status = 0, np.ones(n), np.zeros(n), SOLVED
        for _ in range(self.coverings):
            status, pivots, z = lemke(M, q, covering, most, self.pivot_tolerance)
            total += pivots
            if status == SOLVED:
                return z, total, "complementary basis"
            covering = 10.0 ** rng.uniform(-1, 1, n)
        return z, total, "secondary ray" if status == RAY else f"{total} pivots spent"
