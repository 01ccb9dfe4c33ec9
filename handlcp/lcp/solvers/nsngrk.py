"""NSNGRK, the core: greedy randomized Kaczmarz steps, ended by exact Newton steps once the active set settles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.errors import InputError
from handlcp.keywords import helped_init
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.kernels.kaczmarz import Rows, Seeds, kaczmarz
from handlcp.lcp.kernels.newton import active_set, damped_newton, size
from handlcp.lcp.problem import Proposal, Scaled
from handlcp.lcp.solvers.base import run_contact
from handlcp.tolerances import SOLVE


@helped_init()
@dataclass(frozen=True, slots=True)
class NSNGRK:
    """Newton–subgradient non-smooth greedy randomized Kaczmarz (paper, Algorithm 2), compiled.

    tol : stop at ‖Φ(z)‖₂ ≤ tol in natural units (polished: natural residual ≤ tol).
    max_iterations : Kaczmarz steps at most.
    seed : of the row sampling; equal seeds give equal runs.
    polish : end with exact active-set and semismooth Newton steps, and go back to more Kaczmarz steps, twice as many
        each time, when they don't help. On contact problems Newton's method comes first. False: the paper's method
        alone.
    stride : record (step, ‖Φ‖) every so many steps in the result's `history`; 0: not at all. Plain problems only.

    The paper's analytic subgradient is used instead of forward differences (n times cheaper, and exact).
    """

    tol: float = SOLVE
    max_iterations: int = 20_000
    seed: int = 0
    polish: bool = True
    stride: int = 0

    def __post_init__(self) -> None:
        # One number type each: another would be compiled anew
        object.__setattr__(self, "tol", number("tol", self.tol, above=0.0))
        for name in ("max_iterations", "seed", "stride"):
            object.__setattr__(self, name, integer(name, getattr(self, name), 0))
        if not isinstance(self.polish, bool):
            raise InputError("polish", "True or False", repr(self.polish))

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """Run from `start` (n,), zero when None."""
        M, n = problem.M, len(problem.q)
        z = np.zeros(n) if start is None else np.array(start, dtype=float)
        history = np.empty((1 + self.max_iterations // self.stride if self.stride else 0, 2))
        rows = Rows(M, np.ascontiguousarray(M.T), M @ M.T, problem.q, problem.free)
        state, most = np.full(1, self.seed, np.uint64), self.max_iterations
        if self.polish:
            steps, solved, written = _polished(rows, z, state, most, self.tol, self.stride, history)
        else:
            w = np.empty(n)
            multiply_add(M, z, problem.q, w)
            steps, norm, written = kaczmarz(rows, z, w, state, most, self.tol, self.stride, history)
            solved = norm <= self.tol
        words = "converged" if solved else f"{steps} Kaczmarz steps spent"
        return Proposal(z, steps, words, history[:written] if self.stride else None)

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """The same method on the rows of a contact problem, from `start` (n,); None: where every contact sticks."""
        return run_contact(problem, self.seed, self.max_iterations, self.polish, self.tol, start)


@kernel
def _polished(
    p: Rows, z: Array, state: Seeds, most: int, tolerance: float, stride: int, history: Array
) -> tuple[int, bool, int]:
    """Kaczmarz steps in place, with Newton's in between. (steps, converged, history rows)."""
    n = len(z)
    w = np.empty(n)
    multiply_add(p.M, z, p.q, w)
    taken, written, batch = 0, 0, n
    zt, wt = np.empty(n), np.empty(n)
    best, best_z = np.inf, z.copy()
    while True:
        done, _norm, rows = kaczmarz(p, z, w, state, min(batch, most - taken), tolerance, stride, history[written:])
        for k in range(written, written + rows):
            history[k, 0] += taken
        taken, written = taken + done, written + rows
        zt[:], wt[:] = z, w
        _, r = active_set(p.M, p.q, p.free, zt, wt, 16, tolerance)
        if batch > n and not r <= tolerance * size(zt):
            zt[:], wt[:] = z, w
            _, r = damped_newton(p.M, p.q, p.free, zt, wt, 30, tolerance)
            if r > tolerance:
                _, r = active_set(p.M, p.q, p.free, zt, wt, 4, tolerance)
        if r < best:
            best = r
            best_z[:] = zt
        if r <= tolerance * size(zt):
            z[:] = zt
            return taken, True, written
        if taken >= most or done < batch:  # spent, or stalled where no row moves any more
            z[:] = best_z
            return taken, False, written
        batch *= 2
