"""Small complementarity problems with known answers, each named by its source or by what it exercises."""

import numpy as np

# (M, q); solvable, by Lemke's method with covering vector e where the source says so
KNOWN = {
    # K. G. Murty, Linear Complementarity, Linear and Nonlinear Programming (1988), example 2.8
    "Murty_2_8": ([[1, -1, -1, -1], [-1, 1, -1, -1], [1, 1, 2, 0], [1, 1, 0, 2]], [3, 5, -9, -5]),
    # M. M. Kostreva, Cycling in linear complementarity problems, Math. Program. 16 (1979), example 1: cycles without
    # an order among ties
    "Kostreva_1": ([[1, 2, 0], [0, 1, 2], [2, 0, 1]], [-1, -1, -1]),
    "identity": (np.eye(3), [-1, 2, -3]),
    "q_nonnegative": ([[0, 1], [-1, 0]], [1, 0]),
    # a bimatrix-like skew problem: positive semidefinite, every row ties
    "skew": ([[0, -1, 2], [1, 0, -3], [-2, 3, 0]], [1, -1, 1]),
    # the saddle point of a small quadratic program
    "saddle": ([[2, 1, -1], [1, 2, -2], [1, 2, 0]], [-3, -1, 2]),
    # the same, degenerate: z_i = w_i = 0
    "degenerate": ([[2, 1], [1, 2]], [-2, -1]),
    # columns and rows scaled over ten decades
    "badly_scaled": (
        np.diag([1e-5, 1, 1e5]) @ np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]]) @ np.diag([1e5, 1, 1e-5]),
        [-1e-5, 1.0, -1e5],
    ),
}


def random_p(rng, n):
    """A P-matrix problem (positive definite, not symmetric): exactly one solution."""
    A = rng.normal(size=(n, n))
    B = rng.normal(size=(n, n))
    return A @ A.T / n + 0.1 * np.eye(n) + (B - B.T), rng.normal(size=n)


def semidefinite(rng, n):
    """Of half rank, and not symmetric."""
    A, B = rng.normal(size=(n, n // 2)), rng.normal(size=(n, n))
    return A @ A.T + 0.3 * (B - B.T)


def random_psd(rng, n):
    """A positive semidefinite problem with a solution by construction."""
    M = semidefinite(rng, n)
    on = rng.random(n) < 0.5
    z, w = np.where(on, rng.uniform(0.5, 2, n), 0), np.where(on, 0, rng.uniform(0.5, 2, n))
    return M, w - M @ z
