"""The semismooth Newton method alone: few steps where it converges, from a start that is near enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.keywords import helped_init
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.newton import damped_newton, settled
from handlcp.lcp.problem import Proposal, Scaled
from handlcp.lcp.solvers.base import run_contact
from handlcp.tolerances import SOLVE


@helped_init()
@dataclass(frozen=True, slots=True)
class SemismoothNewton:
    """Damped semismooth Newton on the Fischer–Burmeister equations (De Luca, Facchinei & Kanzow 1996), compiled; on
    contact problems, with cones or faces, on the projection equations of Alart & Curnier (1991).

    tol : stop at a natural residual ≤ tol in natural units.
    max_iterations : Newton steps at most; a contact problem gets no more than 32.

    It descends on ½‖Φ‖², whose local minima may not solve the problem: friction makes it non-monotone.
    """

    tol: float = SOLVE
    max_iterations: int = 100

    def __post_init__(self) -> None:
        object.__setattr__(self, "tol", number("tol", self.tol, above=0.0))
        object.__setattr__(self, "max_iterations", integer("max_iterations", self.max_iterations, 1))

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """Run from `start` (n,), zero when None; an exact active-set solve takes the last digits."""
        M, q, free = problem.M, problem.q, problem.free
        z = np.zeros(len(q)) if start is None else np.array(start, dtype=float)
        steps, _ = damped_newton(M, q, free, z, np.empty(len(q)), self.max_iterations, self.tol)
        z, r = settled(M, q, free, z, self.tol * 1e-3)
        return Proposal(z, steps, "converged" if r <= self.tol else f"stalled after {steps} Newton steps")

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """Run from `start` (n,); None: from where every contact sticks that starts without a gap."""
        return run_contact(problem, 0, 0, True, self.tol, start)
