"""Continuation on contact problems: solve an easier problem and follow its answer to the one that was asked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.errors import InputError
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.result import Proposal
from handlcp.lcp.solvers.contact_run import run_contact
from handlcp.lcp.solvers.variants import converged, varied
from handlcp.tolerances import SOLVE

__all__ = ["Continuation"]


@dataclass(frozen=True, slots=True)
class Continuation:
    """Newton's method along a path of problems q(t), limits(t), t from 0 to 1, each started at the answer before.

    along : what grows or shrinks on the way, by `amount`:
        "load": the free rows of q (the balance of the object) grow from nothing; the preload alone comes first.
        "squeeze": every pair is pressed by `amount` natural forces of its own flexibility more, which fades away.
        "friction": the limits shrink to theirs from `amount` times as much.
    least_step : of t. The step halves where Newton fails and doubles where it doesn't.
    max_iterations : points of the path at most, what the result's `iterations` counts.

    Friction makes paths fold back: one that ends before t = 1 says nothing about the problem at its end.
    """

    along: Literal["load", "squeeze", "friction"] = "load"
    amount: float = 10.0
    least_step: float = 2.0**-10
    max_iterations: int = 40

    def __post_init__(self) -> None:
        """Check the settings."""
        if self.along not in ("load", "squeeze", "friction"):
            raise InputError("along", '"load", "squeeze" or "friction"', repr(self.along))
        number("amount", self.amount, minimum=0.0)
        number("least_step", self.least_step, above=0.0)
        integer("max_iterations", self.max_iterations, 1)

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """Follow the path; `start` (n,) is the first guess at its beginning, all contacts holding when None."""
        q0, limits0 = self._easy(problem)
        dq, dl = problem.q - q0, problem.limits - limits0
        p = run_contact(varied(problem, q0, limits0), 0, 0, True, SOLVE, start)
        if not converged(p):
            return replace(p, iterations=1, outcome="no answer where the path begins")
        x, t, step, solves = p.z, 0.0, 0.5, 1
        while solves < self.max_iterations and step >= self.least_step:
            to = min(1.0, t + step)
            here = varied(problem, q0 + to * dq, limits0 + to * dl) if to < 1.0 else problem
            p, solves = run_contact(here, 0, 0, True, SOLVE, x), solves + 1
            if not converged(p):
                step *= 0.5
            elif to == 1.0:
                return replace(p, iterations=solves, outcome="converged")
            else:
                x, t, step = p.z, to, 2.0 * step
        return replace(p, iterations=solves, outcome=f"the path ends at {t:.3g}")

    def _easy(self, problem: ContactProblem) -> tuple[Array, Array]:
        """(q, limits) where the path begins."""
        if self.along == "load":
            return np.where(problem.free, 0.0, problem.q), problem.limits
        if self.along == "friction":
            return problem.q, problem.limits * self.amount
        pairs = problem.role == 1
        return problem.q - np.where(pairs, self.amount * np.maximum(np.diag(problem.M), 0.0), 0.0), problem.limits
