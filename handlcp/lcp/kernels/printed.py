"""Algorithm 2 of the paper as printed: the whole subgradient matrix by forward differences in every step.

Row i of the matrix (19) is ((φ_i(z + h e_j) - φ_i(z)) / h)_j with h = 1e-6. Since w_i(z + h e_j) = w_i + h M_ij, an
entry costs one square root and a step O(n²).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.kaczmarz import Seeds, greedy_row, multiply_add

__all__ = ["printed_kaczmarz"]


@kernel
def _phi(z: float, w: float, free: bool) -> float:
    """√(z² + w²) - z - w, in the order in which it is printed; w for a free row, which the paper has none of."""
    return w if free else float(np.sqrt(z * z + w * w) - z - w)


@kernel
def printed_kaczmarz(
    M: Array,
    q: Array,
    free: Bools,
    z: Array,
    state: Seeds,
    steps: int,
    tolerance: float,
    h: float,
    stride: int,
    history: Array,
) -> tuple[int, float, int]:
    """Take up to `steps` steps in place on z (n,); stop at ‖Φ(z)‖₂ ≤ tolerance.

    Every `stride` steps (0: never) a row (step, ‖Φ‖) goes into `history`.
    Returns (steps taken, ‖Φ‖₂, rows of history written).
    """
    n = len(q)
    w, phi, p2, g2 = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    J = np.empty((n, n))
    norm, written = np.inf, 0
    for step in range(steps + 1):
        multiply_add(M, z, q, w)
        total = 0.0
        for i in range(n):
            phi[i] = _phi(z[i], w[i], free[i])
            p2[i] = phi[i] * phi[i]
            total += p2[i]
        norm = np.sqrt(total)
        if stride > 0 and step % stride == 0 and written < len(history):
            history[written, 0], history[written, 1] = step, norm
            written += 1
        if not norm > tolerance or step == steps:  # NaN stops, too
            return step, norm, written
        frobenius, best = 0.0, 0.0
        for i in range(n):
            for j in range(n):
                J[i, j] = (_phi(z[i], w[i] + h * M[i, j], free[i]) - phi[i]) / h
            J[i, i] = (_phi(z[i] + h, w[i] + h * M[i, i], free[i]) - phi[i]) / h
            g2[i] = 0.0
            for j in range(n):
                g2[i] += J[i, j] * J[i, j]
            frobenius += g2[i]
            if p2[i] > best * g2[i]:
                best = p2[i] / g2[i]
        if not best < np.inf:  # a row of zeros that no step can mend
            return step, norm, written
        i = greedy_row(p2, g2, best, total, frobenius, state)
        t = phi[i] / g2[i]
        for j in range(n):
            z[j] -= t * J[i, j]
    return steps, norm, written
