"""Elimination of trailing unknowns, with an estimate of how much accuracy that costs."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["schur"]


@kernel
def schur(M: Array, q: Array, c: int) -> tuple[Array, Array, Array, Array, float]:
    """Eliminate the unknowns from c on: with F = M[c:, c:], C the rest,

        X = F⁻¹ M_FC,  x₀ = -F⁻¹ q_F,  S = M_CC - M_CF X,  s = q_C + M_CF x₀,

    so that x_F = x₀ - X x_C makes the rows of F zero. Returns (S, s, X, x₀, rcond): rcond estimates 1 / (‖F‖₁ ‖F⁻¹‖₁),
    zero where F is singular (the other results are then meaningless). Zeros of M_CF cost nothing.
    """
    f = len(q) - c
    F = M[c:, c:].copy()
    norm = 0.0
    for j in range(f):
        norm = max(norm, np.sum(np.abs(F[:, j])))
    B = np.empty((f, c + 1))
    B[:, :c] = M[c:, :c]
    B[:, c] = q[c:]
    order = np.arange(f)
    S, s = M[:c, :c].copy(), q[:c].copy()
    for k in range(f):
        p = k
        for i in range(k + 1, f):
            if abs(F[i, k]) > abs(F[p, k]):
                p = i
        if F[p, k] == 0.0:
            return S, s, B[:, :c], -B[:, c], 0.0
        if p != k:
            for j in range(f):
                F[k, j], F[p, j] = F[p, j], F[k, j]
            for j in range(c + 1):
                B[k, j], B[p, j] = B[p, j], B[k, j]
            order[k], order[p] = order[p], order[k]
        for i in range(k + 1, f):
            if F[i, k] != 0.0:
                m = F[i, k] / F[k, k]
                F[i, k] = m
                for j in range(k + 1, f):
                    F[i, j] -= m * F[k, j]
                for j in range(c + 1):
                    B[i, j] -= m * B[k, j]
    for k in range(f - 1, -1, -1):
        for i in range(k + 1, f):
            m = F[k, i]
            if m != 0.0:
                for j in range(c + 1):
                    B[k, j] -= m * B[i, j]
        m = 1.0 / F[k, k]
        for j in range(c + 1):
            B[k, j] *= m
    for i in range(c):
        for k in range(f):
            m = M[i, c + k]
            if m != 0.0:
                for j in range(c):
                    S[i, j] -= m * B[k, j]
                s[i] -= m * B[k, c]
    inverse = _inverse_norm(F, order)
    return S, s, B[:, :c].copy(), -B[:, c], 1.0 / (norm * inverse) if inverse < np.inf else 0.0


@kernel
def _inverse_norm(LU: Array, order: Ints) -> float:
    """‖F⁻¹‖₁ from the factors P F = L U, estimated from below (Hager 1984; Higham, Accuracy and Stability, 15.2)."""
    f = len(order)
    x, y, z = np.full(f, 1.0 / max(f, 1)), np.empty(f), np.empty(f)
    estimate = 0.0
    for _ in range(5):
        for i in range(f):  # L U y = P x
            y[i] = x[order[i]]
            for j in range(i):
                y[i] -= LU[i, j] * y[j]
        for i in range(f - 1, -1, -1):
            for j in range(i + 1, f):
                y[i] -= LU[i, j] * y[j]
            y[i] /= LU[i, i]
        estimate = max(estimate, np.sum(np.abs(y)))
        if not estimate < np.inf:
            return np.inf
        for i in range(f):  # Uᵀ Lᵀ z = sign(y), then rows back in their order
            z[i] = 1.0 if y[i] >= 0.0 else -1.0
            for j in range(i):
                z[i] -= LU[j, i] * z[j]
            z[i] /= LU[i, i]
        for i in range(f - 1, -1, -1):
            for j in range(i + 1, f):
                z[i] -= LU[j, i] * z[j]
        for i in range(f):
            y[order[i]] = z[i]
        steepest, along = 0, 0.0
        for i in range(f):
            along += y[i] * x[i]
            if abs(y[i]) > abs(y[steepest]):
                steepest = i
        if abs(y[steepest]) <= along:
            break
        x[:] = 0.0
        x[steepest] = 1.0
    return estimate
