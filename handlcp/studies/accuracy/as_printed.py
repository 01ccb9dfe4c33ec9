"""The paper's Algorithm 2 with nothing improved, compiled: the whole subgradient matrix by forward differences.

Row i of the matrix (19) is ((φ_i(z + h e_j) - φ_i(z)) / h)_j with h = 1e-6. Since w_i(z + h e_j) = w_i + h M_ij, an
entry costs one square root and a step O(n²).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from handlcp.check import Array, Bools, check_integer, check_number
from handlcp.lcp import LCP, Proposal
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.kernels.kaczmarz import Seeds, draw_greedy_row, record_step
from handlcp.lcp.problem import ScaledLCP
from handlcp.tolerances import SOLVE_TOLERANCE

# ----------------------------------------------------------------
# The paper's settings, and the units in which a problem is solved.

RES, STEPS = 1e-5, 20_000  # where the paper stops: ‖Φ‖₂ < RES, or after so many steps (section 5)

UnitsOf = Literal["natural", "given"]


def in_units(problem: LCP, units: UnitsOf) -> tuple[ScaledLCP, Array]:
    """The problem in these units, and sizes (n,) by which z in them is divided to be z in natural units.

    "natural": the problem's own. "given": the user's, metres and newtons, as in the paper.
    """
    scaled = problem.scaled if units == "natural" else problem.unscaled().scaled
    return scaled, problem.scaled.units.z / scaled.units.z


# ----------------------------------------------------------------

_H = 1e-6  # the paper, Algorithm 2, line 6


@dataclass(frozen=True, slots=True)
class AsPrinted:
    """Newton–subgradient non-smooth greedy randomized Kaczmarz as printed (paper, Algorithm 2).

    tol : stop at ‖Φ(z)‖₂ ≤ tol, in the units that it is handed (the paper: 1e-5).
    max_iterations : steps at most (the paper: 20 000).
    seed : of the row sampling; equal seeds give equal runs.
    stride : record (step, ‖Φ‖) every so many steps in the result's `history`; 0: not at all.

    Where both of a pair vanish forward differences are no subgradients, and the run stands still at ‖Φ‖ of about 1e-6.
    It works in the units it gets: natural ones through `solve_lcp`; with `problem.unscaled()` metres and newtons, as in
    the paper. Free rows, which the paper has none of, are φ = w. Raises InputError.
    """

    tol: float = SOLVE_TOLERANCE
    max_iterations: int = 20_000
    seed: int = 0
    stride: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "tol", check_number("tol", self.tol, above=0.0))
        for name in ("max_iterations", "seed", "stride"):
            object.__setattr__(self, name, check_integer(name, getattr(self, name), 0))

    @compile_now()
    def propose(self, problem: ScaledLCP, start: Array | None = None) -> Proposal:
        """Run from `start` (n,), zero when None."""
        z = np.zeros(len(problem.q)) if start is None else np.array(start, dtype=float)
        history = np.empty((1 + self.max_iterations // self.stride if self.stride else 0, 2))
        steps, norm, written = self.run(problem, z, np.full(1, self.seed, np.uint64), history)
        words = "converged" if norm <= self.tol else f"{steps} Kaczmarz steps spent"
        return Proposal(z, steps, words, history[:written] if self.stride else None)

    def run(self, problem: ScaledLCP, z: Array, state: Seeds, history: Array) -> tuple[int, float, int]:
        """Take the steps, in place on z. Returns (steps taken, ‖Φ‖₂, rows of history written)."""
        M, q, free = problem.M, problem.q, problem.free
        return _run_steps(M, q, free, z, state, self.max_iterations, self.tol, self.stride, history)


@kernel
def _phi(z: float, w: float, free: bool) -> float:
    """√(z² + w²) - z - w, in the order in which it is printed; w for a free row, which the paper has none of."""
    return w if free else float(np.sqrt(z * z + w * w) - z - w)


@kernel
def _run_steps(
    M: Array, q: Array, free: Bools, z: Array, state: Seeds, steps: int, tolerance: float, stride: int, history: Array
) -> tuple[int, float, int]:
    """Take up to `steps` steps in place on z (n,). Returns (steps taken, ‖Φ‖₂, rows of history written)."""
    n = len(q)
    w, phi, p2, g2, J = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty((n, n))
    norm, written = np.inf, 0
    for step in range(steps + 1):
        multiply_add(M, z, q, w)
        total = 0.0
        for i in range(n):
            phi[i] = _phi(z[i], w[i], free[i])
            p2[i] = phi[i] * phi[i]
            total += p2[i]
        norm = np.sqrt(total)
        written = record_step(history, written, stride, step, norm)
        if not norm > tolerance or step == steps:  # NaN stops, too
            return step, norm, written
        frobenius, best = 0.0, 0.0
        for i in range(n):
            for j in range(n):
                J[i, j] = (_phi(z[i], w[i] + _H * M[i, j], free[i]) - phi[i]) / _H
            J[i, i] = (_phi(z[i] + _H, w[i] + _H * M[i, i], free[i]) - phi[i]) / _H
            g2[i] = 0.0
            for j in range(n):
                g2[i] += J[i, j] * J[i, j]
            frobenius += g2[i]
            if p2[i] > best * g2[i]:
                best = p2[i] / g2[i]
        if not best < np.inf:  # a row of zeros that no step can mend
            return step, norm, written
        i = draw_greedy_row(p2, g2, best, total, frobenius, state)
        t = phi[i] / g2[i]
        for j in range(n):
            z[j] -= t * J[i, j]
    return steps, norm, written
