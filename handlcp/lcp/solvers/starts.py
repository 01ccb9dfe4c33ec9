"""Newton's method from other places: a nearby answer, or where only some of the contacts (or pairs) hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from handlcp.check import Array, integer
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import Proposal, Scaled
from handlcp.lcp.solvers.base import converged, held, run_contact
from handlcp.lcp.solvers.newton import SemismoothNewton
from handlcp.tolerances import FINE

_NEWTON = SemismoothNewton(max_iterations=30)  # from each start of a plain problem


@dataclass(frozen=True, slots=True)
class OtherStarts:
    """Newton's method from where other subsets of the contacts stick, slip without friction, or stay apart; of a plain
    LCP from other active sets.

    tries : starts at most, what the result's `iterations` counts. seed : of the subsets.

    Newton's method converges from near enough or not at all, and soon: many short runs find more than a few long ones.
    """

    tries: int = 40
    seed: int = 0

    def __post_init__(self) -> None:
        integer("tries", self.tries, 1)
        integer("seed", self.seed, 0)

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """The first start that converges, else the last; a `start` (n,) is tried before all others."""
        rng = np.random.default_rng(self.seed)

        def held_by_some(k: int) -> Array:
            # Every share of contacts apart is as likely as any other; in every second start nothing slips
            apart = rng.random(problem.n) < rng.random()
            slippery = rng.random(len(problem.blocks)) < (k % 2) * rng.random()
            return held(problem, apart, slippery)

        return self._first(lambda x: run_contact(problem, 0, 0, True, FINE, x), held_by_some, start)

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """The same for a plain problem: the unknowns of a random active set start at 0.1 to 10, the others at 0."""
        rng, n = np.random.default_rng(self.seed), len(problem.q)

        def some_active(k: int) -> Array:
            return np.where(rng.random(n) < rng.random(), 10.0 ** rng.uniform(-1.0, 1.0, n), 0.0)

        return self._first(partial(_NEWTON.propose, problem), some_active, start)

    def _first(
        self, newton: Callable[[Array], Proposal], place: Callable[[int], Array], start: Array | None
    ) -> Proposal:
        for k in range(self.tries):
            p = newton(start if k == 0 and start is not None else place(k))
            if converged(p):
                return replace(p, iterations=k + 1, outcome=f"converged from start {k + 1}")
        return replace(p, iterations=self.tries, outcome="all starts spent")
