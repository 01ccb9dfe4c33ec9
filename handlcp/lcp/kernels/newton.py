"""Newton's last steps: exact active-set solves, and a damped semismooth Newton method where those don't settle."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import multiply_add, solve_ranked

__all__ = ["active_set", "damped_newton", "residual", "size"]

_TIE = 1e-11


@kernel
def residual(z: Array, w: Array, free: Bools) -> float:
    """Max |min(z_i, w_i)| over complementary and |w_i| over free rows; NaN counts as infinite."""
    worst = 0.0
    for i in range(len(z)):
        r = abs(w[i]) if free[i] else abs(min(z[i], w[i]))
        if not r <= worst:
            worst = r if r == r else np.inf
    return worst


@kernel
def size(z: Array) -> float:
    """max(1, largest |z_i|): what a residual is measured against."""
    largest = 1.0
    for x in z:
        largest = max(largest, abs(x))
    return largest


@kernel
def active_set(
    M: Array,
    q: Array,
    free: Bools,
    z: Array,
    w: Array,
    steps: int,
    tolerance: float,
    rank_tolerance: float,
) -> tuple[int, float]:
    """Semismooth Newton on min(z, w): with A = {free} ∪ {z_i > w_i}, solve M_AA z_A = -q_A, z elsewhere zero; repeat.

    On entry z and w guess the active set, on return they hold the last iterate. Stops when the residual is at most
    `tolerance` × max(1, largest |z|), when the set repeats, or after `steps`. Returns (steps taken, residual).
    """
    n = len(q)
    on = np.empty(n, np.bool_)
    index, col = np.empty(n, np.int64), np.empty(n, np.int64)
    seen = np.zeros(steps, np.uint64)
    for i in range(n):
        on[i] = free[i] or z[i] > w[i]
    r = np.inf
    for step in range(steps):
        k, key = 0, np.uint64(1469598103934665603)
        for i in range(n):
            if on[i]:
                index[k] = i
                k += 1
                key = (key ^ np.uint64(i + 1)) * np.uint64(1099511628211)
        for s in range(step):
            if seen[s] == key:  # a cycle, or a fixed point whose system was singular
                return step, r
        seen[step] = key
        A, b, x = np.empty((k, k)), np.empty(k), np.empty(k)
        for s in range(k):
            b[s] = -q[index[s]]
            for t in range(k):
                A[s, t] = M[index[s], index[t]]
        solve_ranked(A, b, x, col, rank_tolerance)
        for i in range(n):
            z[i] = 0.0
        for s in range(k):
            z[index[s]] = x[s]
        for i in range(n):
            w[i] = q[i]
            for s in range(k):
                w[i] += M[i, index[s]] * x[s]
        r = residual(z, w, free)
        if r <= tolerance * size(z):
            return step + 1, r
        # a tie within rounding keeps its side: which way the last bit falls must not choose the path
        tie = _TIE * size(z)
        for i in range(n):
            if abs(z[i] - w[i]) > tie:
                on[i] = free[i] or z[i] > w[i]
    return steps, r


@kernel
def damped_newton(
    M: Array,
    q: Array,
    free: Bools,
    z: Array,
    w: Array,
    steps: int,
    tolerance: float,
    rank_tolerance: float,
) -> tuple[int, float]:
    """Semismooth Newton on the Fischer–Burmeister rows with Armijo's rule on ½‖Φ‖² and a Levenberg–Marquardt step
    where the Newton direction fails (De Luca, Facchinei & Kanzow, Math. Program. 75, 1996). In place.

    Returns (steps taken, residual).
    """
    n = len(q)
    J, H = np.empty((n, n)), np.empty((n, n))
    phi, gradient, d, rhs = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    z1, w1, col = np.empty(n), np.empty(n), np.empty(n, np.int64)
    multiply_add(M, z, q, w)
    for step in range(steps):
        r = residual(z, w, free)
        if r <= tolerance or r == np.inf:
            return step, r
        merit = 0.0
        for i in range(n):
            a, b = 0.0, 1.0
            phi[i] = w[i]
            if not free[i]:
                rho = np.sqrt(z[i] * z[i] + w[i] * w[i])
                phi[i] = rho - z[i] - w[i]
                a = z[i] / rho - 1.0 if rho > 0.0 else 1.0 / np.sqrt(2.0) - 1.0
                b = w[i] / rho - 1.0 if rho > 0.0 else 1.0 / np.sqrt(2.0) - 1.0
            for j in range(n):
                J[i, j] = b * M[i, j]
            J[i, i] += a
            merit += 0.5 * phi[i] * phi[i]
        for j in range(n):
            gradient[j] = 0.0
        for i in range(n):
            for j in range(n):
                gradient[j] += J[i, j] * phi[i]
        H[:, :] = J
        for i in range(n):
            rhs[i] = -phi[i]
        solve_ranked(H, rhs, d, col, rank_tolerance)
        slope, length = 0.0, 0.0
        for j in range(n):
            slope += gradient[j] * d[j]
            length += d[j] * d[j]
        if not slope <= -1e-9 * length:
            # (JᵀJ + ν I) d = -Jᵀ φ with ν = ‖Φ‖²: always a direction of descent
            H[:, :] = np.dot(J.T, J)
            for i in range(n):
                H[i, i] += 2.0 * merit if merit < 0.5 else 1.0
                rhs[i] = -gradient[i]
            solve_ranked(H, rhs, d, col, 0.0)
            slope = 0.0
            for j in range(n):
                slope += gradient[j] * d[j]
            if not slope < 0.0:
                return step, r
        t = 1.0
        while True:
            for j in range(n):
                z1[j] = z[j] + t * d[j]
            multiply_add(M, z1, q, w1)
            new = 0.0
            for i in range(n):
                f = w1[i] if free[i] else np.sqrt(z1[i] * z1[i] + w1[i] * w1[i]) - z1[i] - w1[i]
                new += 0.5 * f * f
            if new <= merit + 1e-4 * t * slope:
                break
            t *= 0.5
            if t < 1e-9:
                return step, r
        z[:] = z1
        w[:] = w1
    return steps, residual(z, w, free)
