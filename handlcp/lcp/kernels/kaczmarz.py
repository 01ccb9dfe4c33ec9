"""`run_kaczmarz`: greedy randomized Kaczmarz steps, NSNGRK (paper, equations (18)–(22) and Algorithm 2).

Fischer–Burmeister rows φ_i = √(z_i² + w_i²) - z_i - w_i for complementary pairs, plain rows φ_i = w_i for free ones.
The analytic subgradient of row i is g_i = a e_i + b M_i with a = z_i/ρ - 1, b = w_i/ρ - 1, ρ = √(z_i² + w_i²)
(a = b = 1/√2 - 1 at the origin, an element of the subdifferential; a = 0, b = 1 for a free row). A step

    z ← z - t g_i,  t = φ_i / |g_i|²

changes z along row i of M, and w = M z + q by -t (a M e_i + b M Mᵀ e_i): with M Mᵀ in hand a step costs O(n).

The row is chosen by the paper's greedy rule.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.dense import kernel, multiply_add

Seeds = npt.NDArray[np.uint64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_ORIGIN_WEIGHT = 1.0 / np.sqrt(2.0) - 1.0  # both derivatives of Φ at (0, 0), those along z = w


@kernel
def draw_uniform(state: Seeds) -> float:
    """A number in [0, 1) from the SplitMix64 generator; `state` (1,) uint64 moves on."""
    state[0] += _GOLDEN
    x = state[0]
    x = (x ^ (x >> _S30)) * _MIX1
    x = (x ^ (x >> _S27)) * _MIX2
    x = x ^ (x >> _S31)
    return float(x >> _S11) * 1.1102230246251565e-16  # 53 bits


@kernel
def draw_greedy_row(p2: Array, g2: Array, best: float, total: float, frobenius: float, state: Seeds) -> int:
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
    pick, chosen = draw_uniform(state) * mass, -1
    for i in range(n):
        if p2[i] >= bar * g2[i] and p2[i] > 0.0:
            pick -= p2[i]
            chosen = i
            if pick < 0.0:
                break
    return chosen


class PlainRows(NamedTuple):
    """What every row needs of M (n, n): M, its transpose and M Mᵀ, all contiguous, so that every loop runs along a row;
    q (n,) and free (n,) bool.
    """

    M: Array
    MT: Array
    MMT: Array
    q: Array
    free: Bools


class RowSubgradients(NamedTuple):
    """Of every row i, (n,) each: φ, the subgradient a e_i + b M_i, φ² and |a e_i + b M_i|²."""

    phi: Array
    a: Array
    b: Array
    phi2: Array
    g2: Array


@kernel
def new_row_subgradients(n: int) -> RowSubgradients:
    """Room for n rows."""
    return RowSubgradients(np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n))


@kernel
def linearise_rows(p: PlainRows, z: Array, w: Array, s: RowSubgradients) -> tuple[float, float, float]:
    """Write `Slopes` at z and w (n,). Returns (Σ φ², Σ |g|², max φ² / |g|²)."""
    total, frobenius, best, best_size = 0.0, 0.0, 0.0, 1.0
    for i in range(len(z)):
        if p.free[i]:
            f, c, d = w[i], 0.0, 1.0
        else:
            sum_, rho = z[i] + w[i], np.sqrt(z[i] * z[i] + w[i] * w[i])
            if rho > 0.0:
                # ρ - (z + w), which cancels where z and w are both positive, equals -2 z w / (ρ + z + w)
                f = -2.0 * z[i] * w[i] / (rho + sum_) if sum_ > 0.0 else rho - sum_
                c, d = z[i] / rho - 1.0, w[i] / rho - 1.0
            else:
                f, c, d = 0.0, _ORIGIN_WEIGHT, _ORIGIN_WEIGHT
        square, size = f * f, c * c + d * (2.0 * p.M[i, i] * c + d * p.MMT[i, i])
        total += square
        frobenius += size
        if square * best_size > best * size:
            best, best_size = square, size
        s.phi[i], s.a[i], s.b[i], s.phi2[i], s.g2[i] = f, c, d, square, size
    return total, frobenius, best / best_size


@kernel
def project_on_row(p: PlainRows, s: RowSubgradients, i: int, z: Array, w: Array) -> None:
    """Project z (n,) on the linearised row i, and move w (n,) along with it."""
    t = s.phi[i] / s.g2[i]
    ta, tb = t * s.a[i], t * s.b[i]
    for j in range(len(z)):
        z[j] -= tb * p.M[i, j]
        w[j] -= ta * p.MT[i, j] + tb * p.MMT[i, j]
    z[i] -= ta


@kernel
def record_step(history: Array, written: int, stride: int, step: int, norm: float) -> int:
    """Write (step, ‖Φ‖) into the next row of history, every `stride` steps (0: never). Returns the rows written."""
    if stride > 0 and step % stride == 0 and written < len(history):
        history[written, 0], history[written, 1] = step, norm
        written += 1
    return written


@kernel
def run_kaczmarz(
    p: PlainRows, z: Array, w: Array, state: Seeds, steps: int, tolerance: float, stride: int, history: Array
) -> tuple[int, float, int]:
    """Take up to `steps` greedy steps in place; stop at ‖Φ(z)‖₂ ≤ tolerance.

    z and w (n,) belong together on entry and on return. Every `stride` steps (0: never) a row (step, ‖Φ‖) goes into
    `history`. Returns (steps taken, ‖Φ‖₂, rows of history written).
    """
    n, s = len(z), new_row_subgradients(len(z))
    norm, written = np.inf, 0
    for step in range(steps + 1):
        if step > 0 and step % (4 * n) == 0:  # w drifts by rounding: renewed at O(n) a step in the mean
            multiply_add(p.M, z, p.q, w)
        total, frobenius, best = linearise_rows(p, z, w, s)
        norm = np.sqrt(total)
        written = record_step(history, written, stride, step, norm)
        if not norm > tolerance or step == steps:  # NaN stops, too
            return step, norm, written
        # a row of zeros that no step can mend has them all
        i = draw_greedy_row(s.phi2, s.g2, best, total, frobenius, state) if best < np.inf else -1
        if i < 0:
            return step, norm, written
        project_on_row(p, s, i, z, w)
    return steps, norm, written
