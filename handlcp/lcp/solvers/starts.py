"""Newton's method from other places: a nearby answer, or where only some of the contacts (or pairs) hold."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import Array, integer
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import Scaled
from handlcp.lcp.result import Proposal
from handlcp.lcp.solvers.contact_run import FINE, converged, held, run_contact
from handlcp.lcp.solvers.newton import SemismoothNewton

__all__ = ["OtherStarts"]

_STEPS = 30  # of Newton's method from each start of a plain problem


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
        """Check the settings."""
        integer("tries", self.tries, 1)
        integer("seed", self.seed, 0)

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """The first start that converges, else the last; a `start` (n,) is tried before all others."""
        rng, p = np.random.default_rng(self.seed), None
        for k in range(self.tries):
            if k == 0 and start is not None:
                x = start
            else:
                # Every share of contacts apart is as likely as any other; in every second start nothing slips
                apart = rng.random(problem.n) < rng.random()
                slippery = rng.random(len(problem.blocks)) < (k % 2) * rng.random()
                x = held(problem, apart, slippery)
            p = run_contact(problem, 0, 0, True, FINE, x)
            if converged(p):
                return replace(p, iterations=k + 1, outcome=f"converged from start {k + 1}")
        assert p is not None  # there is one try at least
        return replace(p, iterations=self.tries, outcome="all starts spent")

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """The same for a plain problem: the unknowns of a random active set start at 0.1 to 10, the others at 0."""
        rng, n = np.random.default_rng(self.seed), len(problem.q)
        newton = SemismoothNewton(max_iterations=_STEPS)
        p = None
        for k in range(self.tries):
            if k == 0 and start is not None:
                z = start
            else:
                z = np.where(rng.random(n) < rng.random(), 10.0 ** rng.uniform(-1.0, 1.0, n), 0.0)
            p = newton.propose(problem, z)
            if converged(p):
                return replace(p, iterations=k + 1, outcome=f"converged from start {k + 1}")
        assert p is not None  # there is one try at least
        return replace(p, iterations=self.tries, outcome="all starts spent")
