"""Newton's last steps: exact active-set solves, and a damped semismooth Newton method where those don't settle."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.dense import kernel, multiply_add, solve_ranked
from handlcp.tolerances import RANK_TOLERANCE

_ACTIVE_SET_TIE = 1e-11  # of the unknowns' size: as far as rounding moves z - w, an unknown keeps its side
_ORIGIN_WEIGHT = 1.0 / np.sqrt(2.0) - 1.0  # both derivatives of Φ at (0, 0), those along z = w


@kernel
def complementarity_residual(z: Array, w: Array, free: Bools) -> float:
    """Max |min(z_i, w_i)| over complementary and |w_i| over free rows; NaN counts as infinite."""
    worst = 0.0
    for i in range(len(z)):
        r = abs(w[i]) if free[i] else abs(min(z[i], w[i]))
        if not r <= worst:
            worst = r if r == r else np.inf
    return worst


@kernel
def unknown_size(z: Array) -> float:
    """The size of the unknowns that a residual is measured against, max(1, largest |z_i|)."""
    largest = 1.0
    for x in z:
        largest = max(largest, abs(x))
    return largest


@kernel
def run_active_set(
    M: Array, q: Array, free: Bools, z: Array, w: Array, steps: int, tolerance: float
) -> tuple[int, float]:
    """Semismooth Newton on min(z, w): with A = {free} ∪ {z_i > w_i}, solve M_AA z_A = -q_A, z elsewhere zero; repeat.

    On entry z and w guess the active set, on return they hold the last iterate. Stops when the residual is at most
    `tolerance` × max(1, largest |z|), when the set repeats, or after `steps`. Returns (steps taken, residual).
    """
    n = len(q)
    on, seen, col = free | (z > w), np.empty((steps, n), np.bool_), np.empty(n, np.int64)
    r = np.inf
    for step in range(steps):
        for before in seen[:step]:
            if np.array_equal(before, on):  # a cycle, or a fixed point whose system was singular
                return step, r
        seen[step] = on
        index = np.flatnonzero(on)
        k = len(index)
        A, x = np.empty((k, k)), np.empty(k)
        for s in range(k):
            for t in range(k):
                A[s, t] = M[index[s], index[t]]
        solve_ranked(A, -q[index], x, col, RANK_TOLERANCE)
        z[:] = 0.0
        z[index] = x
        for i in range(n):
            w[i] = q[i]
            for s in range(k):
                w[i] += M[i, index[s]] * x[s]
        r = complementarity_residual(z, w, free)
        if r <= tolerance * unknown_size(z):
            return step + 1, r
        # a tie within rounding keeps its side: which way the last bit falls must not choose the path
        tie = _ACTIVE_SET_TIE * unknown_size(z)
        for i in range(n):
            if abs(z[i] - w[i]) > tie:
                on[i] = free[i] or z[i] > w[i]
    return steps, r


@kernel
def polish_active_set(M: Array, q: Array, free: Bools, z: Array, tolerance: float) -> tuple[Array, float]:
    """(z, residual) with the active set of z solved afresh; z itself where that is no better."""
    w, better = np.empty(len(q)), z.copy()
    multiply_add(M, z, q, w)
    r = complementarity_residual(z, w, free)
    _, after = run_active_set(M, q, free, better, w, 4, tolerance)
    return (better, after) if after < r else (z, r)


@kernel
def _fischer_burmeister_rows(z: Array, w: Array, free: Bools, phi: Array) -> float:
    """Write the Fischer–Burmeister rows φ. Returns ½‖Φ‖²."""
    merit = 0.0
    for i in range(len(z)):
        phi[i] = w[i] if free[i] else np.sqrt(z[i] * z[i] + w[i] * w[i]) - z[i] - w[i]
        merit += 0.5 * phi[i] * phi[i]
    return merit


@kernel
def run_damped_newton(
    M: Array, q: Array, free: Bools, z: Array, w: Array, steps: int, tolerance: float
) -> tuple[int, float]:
    """Semismooth Newton on the Fischer–Burmeister rows with Armijo's rule on ½‖Φ‖² and a Levenberg–Marquardt step
    where the Newton direction fails (De Luca, Facchinei & Kanzow, Math. Program. 75, 1996). In place.

    Returns (steps taken, residual).
    """
    n = len(q)
    J, phi, new_phi, gradient = np.empty((n, n)), np.empty(n), np.empty(n), np.empty(n)
    d, z1, w1, col = np.empty(n), np.empty(n), np.empty(n), np.empty(n, np.int64)
    multiply_add(M, z, q, w)
    merit = _fischer_burmeister_rows(z, w, free, phi)
    for step in range(steps):
        r = complementarity_residual(z, w, free)
        if r <= tolerance or r == np.inf:
            return step, r
        gradient[:] = 0.0
        for i in range(n):
            a, b = 0.0, 1.0
            if not free[i]:
                rho = np.sqrt(z[i] * z[i] + w[i] * w[i])
                a, b = (z[i] / rho - 1.0, w[i] / rho - 1.0) if rho > 0.0 else (_ORIGIN_WEIGHT, _ORIGIN_WEIGHT)
            for j in range(n):
                J[i, j] = b * M[i, j]
            J[i, i] += a
            for j in range(n):
                gradient[j] += J[i, j] * phi[i]
        solve_ranked(J.copy(), -phi, d, col, RANK_TOLERANCE)
        slope = np.sum(gradient * d)
        if not slope <= -1e-9 * np.sum(d * d):
            # (JᵀJ + ν I) d = -Jᵀ φ with ν = ‖Φ‖²: always a direction of descent
            H = np.dot(J.T, J)
            for i in range(n):
                H[i, i] += 2.0 * merit if merit < 0.5 else 1.0
            solve_ranked(H, -gradient, d, col, 0.0)
            slope = np.sum(gradient * d)
            if not slope < 0.0:
                return step, r
        t = 1.0
        while True:
            z1[:] = z + t * d
            multiply_add(M, z1, q, w1)
            new = _fischer_burmeister_rows(z1, w1, free, new_phi)
            if new <= merit + 1e-4 * t * slope:
                break
            t *= 0.5
            if t < 1e-9:
                return step, r
        z[:], w[:], phi[:], merit = z1, w1, new_phi, new
    return steps, complementarity_residual(z, w, free)
