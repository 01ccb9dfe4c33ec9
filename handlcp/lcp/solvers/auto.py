"""The default: a documented chain of methods, each started where it pays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from handlcp.errors import InputError
from handlcp.lcp.problem import LCP
from handlcp.lcp.solvers.base import Solver
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.lcp.solvers.nsngrk import NSNGRK

__all__ = ["Auto"]


@dataclass(frozen=True, slots=True)
class Auto:
    """NSNGRK with polish first, on a small budget; then Lemke; then NSNGRK with other seeds and more steps.

    seed : of the first run; later runs use the seeds that follow.
    restarts : NSNGRK runs with other seeds, after Lemke.
    """

    seed: int = 0
    restarts: int = 3

    def __post_init__(self) -> None:
        """Check the settings."""
        for name in ("seed", "restarts"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 0:
                raise InputError(name, "an integer ≥ 0", repr(value))

    def stages(self, n: int) -> Iterator[Solver]:
        """The solvers for a problem of n unknowns, in the order in which they run until one is certified."""
        yield NSNGRK(seed=self.seed, max_iterations=3 * n)
        yield Lemke(seed=self.seed)
        for k in range(self.restarts):
            yield NSNGRK(seed=self.seed + 1 + k, max_iterations=200 * n)

    def plan(self, problem: LCP) -> tuple[str, ...]:
        """What would run on this problem, in order, until one answer is certified."""
        return tuple(repr(s) for s in self.stages(problem.n))
