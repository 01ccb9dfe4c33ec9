"""The paper's Algorithm 2 with nothing improved, compiled: what `NSNGRK` is measured against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.lcp.kernels.printed import printed_kaczmarz
from handlcp.lcp.problem import Scaled
from handlcp.lcp.result import Proposal
from handlcp.tolerances import SOLVE

__all__ = ["AsPrinted"]

_H = 1e-6  # the paper, Algorithm 2, line 6


@dataclass(frozen=True, slots=True)
class AsPrinted:
    """Newton–subgradient non-smooth greedy randomized Kaczmarz as printed (paper, Algorithm 2).

    tol : stop at ‖Φ(z)‖₂ ≤ tol, in the units that it is handed (the paper: 1e-5).
    max_iterations : steps at most (the paper: 20 000).
    seed : of the row sampling; equal seeds give equal runs.
    stride : record (step, ‖Φ‖) every so many steps in the result's `history`; 0: not at all.

    Subgradients are forward differences of Φ with h = 1e-6, all n² of them in every step. Where both of a pair vanish
    these are no subgradients, and the run stands still at ‖Φ‖ of about 1e-6. It works in the units it gets: natural
    ones through `solve_lcp`; with `problem.unscaled()` metres and newtons, as in the paper. Free rows, which the paper
    has none of, are φ = w. Raises InputError for settings that are not as described.
    """

    tol: float = SOLVE
    max_iterations: int = 20_000
    seed: int = 0
    stride: int = 0

    def __post_init__(self) -> None:
        """Check the settings."""
        object.__setattr__(self, "tol", number("tol", self.tol, above=0.0))
        for name in ("max_iterations", "seed", "stride"):
            object.__setattr__(self, name, integer(name, getattr(self, name), 0))

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """Run from `start` (n,), zero when None."""
        z = np.zeros(len(problem.q)) if start is None else np.array(start, dtype=float)
        history = np.empty((1 + self.max_iterations // self.stride if self.stride else 0, 2))
        steps, norm, written = printed_kaczmarz(
            problem.M,
            problem.q,
            problem.free,
            z,
            np.full(1, self.seed, np.uint64),
            self.max_iterations,
            self.tol,
            _H,
            self.stride,
            history,
        )
        outcome = "converged" if norm <= self.tol else f"{steps} Kaczmarz steps spent"
        return Proposal(z, steps, outcome, history[:written] if self.stride else None)
