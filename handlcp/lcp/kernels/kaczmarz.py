"""Newton–subgradient non-smooth greedy randomized Kaczmarz steps (paper, equations (18)–(22) and Algorithm 2).

Fischer–Burmeister rows φ_i = √(z_i² + w_i²) - z_i - w_i for complementary pairs, plain rows φ_i = w_i for free ones.
The analytic subgradient of row i is g_i = a e_i + b M_i with a = z_i/ρ - 1, b = w_i/ρ - 1, ρ = √(z_i² + w_i²)
(a = b = 1/√2 - 1 at the origin, an element of the subdifferential; a = 0, b = 1 for a free row). A step

    z ← z - t g_i,  t = φ_i / |g_i|²

changes z along row i of M, and w = M z + q by -t (a M e_i + b M Mᵀ e_i): with M Mᵀ in hand a step costs O(n).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel

__all__ = ["kaczmarz", "multiply_add"]

Seeds = npt.NDArray[np.uint64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_CORNER = 1.0 / np.sqrt(2.0) - 1.0


@kernel
def uniform(state: Seeds) -> float:
    """A number in [0, 1) from the SplitMix64 generator; `state` (1,) uint64 moves on."""
    state[0] += _GOLDEN
    x = state[0]
    x = (x ^ (x >> _S30)) * _MIX1
    x = (x ^ (x >> _S27)) * _MIX2
    x = x ^ (x >> _S31)
    return float(x >> _S11) * 1.1102230246251565e-16  # 53 bits


@kernel
def multiply_add(M: Array, z: Array, q: Array, w: Array) -> None:
    """W ← M z + q."""
    n = len(q)
    for i in range(n):
        w[i] = q[i]
        for j in range(n):
            w[i] += M[i, j] * z[j]


@kernel
def kaczmarz(
    M: Array,
    MT: Array,
    MMT: Array,
    q: Array,
    free: Bools,
    z: Array,
    w: Array,
    state: Seeds,
    steps: int,
    tolerance: float,
    stride: int,
    history: Array,
) -> tuple[int, float, int]:
    """Take up to `steps` steps in place; stop at ‖Φ(z)‖₂ ≤ tolerance.

    MT (n, n) is Mᵀ and MMT (n, n) is M Mᵀ, all contiguous, so that every loop below runs along a row; z and w (n,)
    belong together on entry and on return. Every `stride` steps (0: never) a row (step, ‖Φ‖) goes into `history`.
    Returns (steps taken, ‖Φ‖₂, rows of history written).
    """
    n = len(q)
    a, b, p2, g2, phi = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    two_diagonal, rows = np.empty(n), np.empty(n)
    for i in range(n):
        two_diagonal[i], rows[i] = 2.0 * M[i, i], MMT[i, i]
    norm, written = np.inf, 0
    for step in range(steps + 1):
        if step % (4 * n) == 0 and step > 0:  # w drifts by rounding: renewed at O(n) a step in the mean
            multiply_add(M, z, q, w)
        total, frobenius, best = 0.0, 0.0, 0.0
        for i in range(n):
            if free[i]:
                phi[i], a[i], b[i] = w[i], 0.0, 1.0
            else:
                s, rho = z[i] + w[i], np.sqrt(z[i] * z[i] + w[i] * w[i])
                if rho > 0.0:
                    # ρ - s, which cancels where z and w are both positive, equals -2 z w / (ρ + s)
                    phi[i] = -2.0 * z[i] * w[i] / (rho + s) if s > 0.0 else rho - s
                    a[i], b[i] = z[i] / rho - 1.0, w[i] / rho - 1.0
                else:
                    phi[i], a[i], b[i] = 0.0, _CORNER, _CORNER
            g2[i] = a[i] * a[i] + b[i] * (two_diagonal[i] * a[i] + b[i] * rows[i])
            p2[i] = phi[i] * phi[i]
            total += p2[i]
            frobenius += g2[i]
            if p2[i] > best * g2[i]:
                best = p2[i] / g2[i]
        norm = np.sqrt(total)
        if stride > 0 and step % stride == 0 and written < len(history):
            history[written, 0], history[written, 1] = step, norm
            written += 1
        # NaN stops, too, and so does a row of zeros that no step can mend
        if not norm > tolerance or step == steps or not best < np.inf:
            return step, norm, written
        # threshold (21) times ‖Φ‖², set (22); ties of the last bit must not empty the set
        bar = 0.5 * (best + total / frobenius) * (1.0 - 1e-12)
        mass = 0.0
        for i in range(n):
            if p2[i] >= bar * g2[i]:
                mass += p2[i]
        # a row of the set with probability |φ|² / Σ|φ|²
        pick, chosen = uniform(state) * mass, -1
        for i in range(n):
            if p2[i] >= bar * g2[i] and p2[i] > 0.0:
                pick -= p2[i]
                chosen = i
                if pick < 0.0:
                    break
        t = phi[chosen] / g2[chosen]
        ta, tb = t * a[chosen], t * b[chosen]
        for j in range(n):
            z[j] -= tb * M[chosen, j]
            w[j] -= ta * MT[chosen, j] + tb * MMT[chosen, j]
        z[chosen] -= ta
    return steps, norm, written
