"""Newton–subgradient non-smooth greedy randomized Kaczmarz steps (paper, equations (18)–(22) and Algorithm 2).

Fischer–Burmeister rows φ_i = √(z_i² + w_i²) - z_i - w_i for complementary pairs, plain rows φ_i = w_i for free ones.
The analytic subgradient of row i is g_i = a e_i + b M_i with a = z_i/ρ - 1, b = w_i/ρ - 1, ρ = √(z_i² + w_i²)
(a = b = 1/√2 - 1 at the origin, an element of the subdifferential; a = 0, b = 1 for a free row). A step

    z ← z - t g_i,  t = φ_i / |g_i|²

changes z along row i of M, and w = M z + q by -t (a M e_i + b M Mᵀ e_i): with M Mᵀ in hand a step costs O(n).

Two rules choose the row: the paper's greedy one, and for comparison the oldest randomized one, all rows alike.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Seeds", "greedy_row", "kaczmarz", "multiply_add", "uniform"]

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
def greedy_row(p2: Array, g2: Array, best: float, total: float, frobenius: float, state: Seeds) -> int:
    """A row of set (22), drawn with probability |φ|² / Σ|φ|² over the set.

    p2, g2 (n,) are φ_i² and |g_i|², `total` and `frobenius` their sums, `best` is max p2 / g2.
    """
    n = len(p2)
    # threshold (21) times ‖Φ‖²; ties of the last bit must not empty the set
    bar = 0.5 * (best + total / frobenius) * (1.0 - 1e-12)
    mass = 0.0
    for i in range(n):
        if p2[i] >= bar * g2[i]:
            mass += p2[i]
    pick, chosen = uniform(state) * mass, -1
    for i in range(n):
        if p2[i] >= bar * g2[i] and p2[i] > 0.0:
            pick -= p2[i]
            chosen = i
            if pick < 0.0:
                break
    return chosen


@kernel
def any_row(p2: Array, g2: Array, state: Seeds) -> int:
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


@kernel
def linearise(
    two_diagonal: Array, rows: Array, free: Bools, z: Array, w: Array, phi: Array, a: Array, b: Array, p2: Array,
    g2: Array,
) -> tuple[float, float, float]:  # fmt: skip
    """Write φ, a, b, φ² and |g|² of every row; (Σ φ², Σ |g|², max φ² / |g|²)."""
    total, frobenius, best, best_size = 0.0, 0.0, 0.0, 1.0
    for i in range(len(z)):
        if free[i]:
            f, c, d = w[i], 0.0, 1.0
        else:
            s, rho = z[i] + w[i], np.sqrt(z[i] * z[i] + w[i] * w[i])
            if rho > 0.0:
                # ρ - s, which cancels where z and w are both positive, equals -2 z w / (ρ + s)
                f = -2.0 * z[i] * w[i] / (rho + s) if s > 0.0 else rho - s
                c, d = z[i] / rho - 1.0, w[i] / rho - 1.0
            else:
                f, c, d = 0.0, _CORNER, _CORNER
        square, size = f * f, c * c + d * (two_diagonal[i] * c + d * rows[i])
        total += square
        frobenius += size
        if square * best_size > best * size:
            best, best_size = square, size
        phi[i], a[i], b[i], p2[i], g2[i] = f, c, d, square, size
    return total, frobenius, best / best_size


@kernel
def project(M: Array, MT: Array, MMT: Array, i: int, t: float, a: float, b: float, z: Array, w: Array) -> None:
    """Z ← z - t (a e_i + b M_i), and w along with it."""
    ta, tb = t * a, t * b
    for j in range(len(z)):
        z[j] -= tb * M[i, j]
        w[j] -= ta * MT[i, j] + tb * MMT[i, j]
    z[i] -= ta


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
    greedy: bool,
) -> tuple[int, float, int]:
    """Take up to `steps` steps in place, on rows of `greedy_row` or else of `any_row`; stop at ‖Φ(z)‖₂ ≤ tolerance.

    MT (n, n) is Mᵀ and MMT (n, n) is M Mᵀ, all contiguous, so that every loop runs along a row; z and w (n,) belong
    together on entry and on return. Every `stride` steps (0: never) a row (step, ‖Φ‖) goes into `history`.
    Returns (steps taken, ‖Φ‖₂, rows of history written).
    """
    n = len(q)
    a, b, p2, g2, phi = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    two_diagonal, rows = 2.0 * np.diag(M), np.diag(MMT).copy()
    norm, written = np.inf, 0
    for step in range(steps + 1):
        if step % (4 * n) == 0 and step > 0:  # w drifts by rounding: renewed at O(n) a step in the mean
            multiply_add(M, z, q, w)
        total, frobenius, best = linearise(two_diagonal, rows, free, z, w, phi, a, b, p2, g2)
        norm = np.sqrt(total)
        if stride > 0 and step % stride == 0 and written < len(history):
            history[written, 0], history[written, 1] = step, norm
            written += 1
        if not norm > tolerance or step == steps:  # NaN stops, too
            return step, norm, written
        if greedy:  # a row of zeros that no step can mend has them all
            i = greedy_row(p2, g2, best, total, frobenius, state) if best < np.inf else -1
        else:
            i = any_row(p2, g2, state)
        if i < 0:
            return step, norm, written
        project(M, MT, MMT, i, phi[i] / g2[i], a[i], b[i], z, w)
    return steps, norm, written
