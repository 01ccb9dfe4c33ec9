"""The default: a documented chain of methods, each started where it pays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import LCP
from handlcp.lcp.result import Proposal
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.lcp.solvers.nsngrk import NSNGRK

__all__ = ["Auto"]


@dataclass(frozen=True, slots=True)
class Auto:
    """NSNGRK with polish first, on a small budget; then Lemke; then NSNGRK with other seeds and more steps.

    seed : of the first run; later runs use the seeds that follow.
    restarts : NSNGRK runs with other seeds, after Lemke.
    search_seconds : where none of these solves a grasp that could be held, or an LCP that is not proven infeasible:
        time for an exact search over all contact modes or active sets, which finds a solution or, for a grasp, proves
        that there is none within bounds. 0: no search.
    """

    seed: int = 0
    restarts: int = 3
    search_seconds: float = 2.0

    def __post_init__(self) -> None:
        """Check the settings."""
        for name in ("seed", "restarts"):
            integer(name, getattr(self, name), 0)
        number("search_seconds", self.search_seconds, minimum=0.0)

    def stages(self, problem: LCP, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) for a plain LCP, each computed when asked for."""
        n = problem.n
        if (contact := problem.contact) is not None and start is None:
            small = _nsngrk(self.seed, _FEW * contact.n).propose_contact(contact)
            yield "NSNGRK on the friction set", Proposal(problem.lift(small.z), small.iterations, small.outcome)
        else:
            yield "NSNGRK", _nsngrk(self.seed, 3 * n).propose(problem.scaled, start)
        yield "Lemke", Lemke(seed=self.seed).propose(problem.scaled)
        for k in range(self.restarts):
            yield "NSNGRK", _nsngrk(self.seed + 1 + k, 200 * n).propose(problem.scaled)

    def contact_stages(self, problem: ContactProblem, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) for a contact problem, each computed when asked for."""
        n = problem.n
        yield "NSNGRK", _nsngrk(self.seed, _FEW * n).propose_contact(problem, start)
        plain = None
        if problem.pyramid is not None:
            own = problem.faces if 3 <= problem.faces <= 16 else 8
            exact = (problem.faces,) if 16 < problem.faces <= 64 else ()
            for faces in dict.fromkeys((own, 4, 16, *exact)):
                lcp, back = problem.pyramid(faces)
                plain = plain or (lcp, back)
                pivoted = Lemke(seed=self.seed).propose(lcp.scaled)
                x = back(pivoted.z)
                if not np.isfinite(x).all():
                    continue
                if faces == problem.faces or problem.faces == 2:
                    yield "Lemke", replace(pivoted, z=x)
                near = _nsngrk(self.seed, _FEW * n).propose_contact(problem, x)
                yield f"NSNGRK from Lemke, {faces} faces", near
        for k in range(self.restarts):
            again = _nsngrk(self.seed + 1 + k, 100 * n)
            yield "NSNGRK", again.propose_contact(problem)
            if plain is not None:
                lcp, back = plain
                slow = again.propose(lcp.scaled)
                yield "NSNGRK with multipliers", replace(slow, z=back(slow.z))

    def plan(self, problem: LCP | ContactProblem) -> tuple[str, ...]:
        """What would run on this problem, in order, until one answer is certified."""
        seeds = [f"NSNGRK, seed {self.seed + 1 + k}" for k in range(self.restarts)]
        if isinstance(problem, ContactProblem):
            first = ["NSNGRK on the friction set"]
            pivots = ["Lemke on pyramids, NSNGRK from its answer"] if problem.pyramid is not None else []
            return (*first, *pivots, *seeds)
        return ("NSNGRK on the friction set" if problem.contact is not None else "NSNGRK", "Lemke", *seeds)


_FEW = 4  # Kaczmarz steps per unknown before Lemke's method gets its turn


@lru_cache(maxsize=256)
def _nsngrk(seed: int, most: int) -> NSNGRK:
    """The same few solvers are asked for again and again; checking their settings would cost a tenth of a solve."""
    return NSNGRK(seed=seed, max_iterations=most)
