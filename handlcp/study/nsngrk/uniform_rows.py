"""NSNGRK's steps on rows that are all equally likely, to be compared with the paper's greedy choice."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.kernels.kaczmarz import Rows, Seeds, linearise, project, recorded, slopes, uniform
from handlcp.lcp.problem import Scaled
from handlcp.study.nsngrk.as_printed import AsPrinted


class UniformRows(AsPrinted):
    """The settings and the record of `AsPrinted`; the steps are those of `NSNGRK`, without its exact ending."""

    __slots__ = ()

    def run(self, problem: Scaled, z: Array, state: Seeds, history: Array) -> tuple[int, float, int]:
        """As there."""
        M = problem.M
        rows = Rows(M, np.ascontiguousarray(M.T), M @ M.T, problem.q, problem.free)
        return _steps(rows, z, state, self.max_iterations, self.tol, self.stride, history)


@kernel
def _steps(
    p: Rows, z: Array, state: Seeds, steps: int, tolerance: float, stride: int, history: Array
) -> tuple[int, float, int]:
    """Take up to `steps` steps in place on z (n,). Returns (steps taken, ‖Φ‖₂, rows of history written)."""
    n, s, norm, written = len(z), slopes(len(z)), np.inf, 0
    w = np.empty(n)
    for step in range(steps + 1):
        if step % max(4 * n, 1) == 0:  # w drifts by rounding: renewed at O(n) a step in the mean
            multiply_add(p.M, z, p.q, w)
        total, _, _ = linearise(p, z, w, s)
        norm = np.sqrt(total)
        written = recorded(history, written, stride, step, norm)
        if not norm > tolerance or step == steps:  # NaN stops, too
            return step, norm, written
        i = _any_row(s.phi2, s.g2, state)
        if i < 0:
            return step, norm, written
        project(p, s, i, z, w)
    return steps, norm, written


@kernel
def _any_row(p2: Array, g2: Array, state: Seeds) -> int:
    """Any row with a residual and a subgradient, each as likely as the others; -1 where there is none."""
    n, many = len(p2), 0
    for i in range(n):
        many += p2[i] > 0.0 and g2[i] > 0.0
    pick, chosen = uniform(state) * many, -1
    for i in range(n):
        if p2[i] > 0.0 and g2[i] > 0.0:
            pick -= 1.0
            chosen = i
            if pick < 0.0:
                break
    return chosen
