"""Newton's method on many contacts whose flexibility is a block for each and a few motions that all of them share.

    y = P r + W z + d,    0 = Rᵀ r - S z + w

r (3n,) are the contacts' forces, normal first, P (n, 3, 3) blocks, z (m,) what the contacts share: torques of the
joints (S = 1, their columns of W are J A with K⁻¹ = A Aᵀ) and, last, the object's motion (S = 0, columns Gᵀ). R is W
where forces do not turn. The rows of the friction laws (`contact_rows`) have A δr + C δy = F with blocks of three, so
that

    δr = H⁻¹ (F - C W δz),   H = A + C P,     (Σ Rᵀ H⁻¹ C W + S) δz = Σ Rᵀ H⁻¹ F - (Rᵀ r - S z + w)

contact by contact: one step costs O(n m²), and no matrix of all contacts is formed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.contact_rows import Contacts, Subgradient, rows, work
from handlcp.lcp.kernels.dense import kernel, solve_ranked, solve_wide


class Linked(NamedTuple):
    """P (n, 3, 3), W and R (3n, m), d (3n,), S (m, m) and w (m,) as above; natural units, each contact's normal first.
    own : roles, scales and friction sets of the 3n rows; its M and q are empty. least : pivots below this share of the
    largest are none.
    """

    P: Array
    W: Array
    R: Array
    d: Array
    S: Array
    w: Array
    own: Contacts
    least: float


class Split(NamedTuple):
    """A and C (n, 3, 3) : rows of the laws, A δr + C δy = F."""

    A: Array
    C: Array


@kernel
def motions(p: Linked, r: Array, z: Array, y: Array, core: Array) -> float:
    """Write y (3n,) and the shared rows (m,). Returns the square of the latter."""
    P, W, R, d, S, w = p.P, p.W, p.R, p.d, p.S, p.w
    m, total = len(z), 0.0
    for j in range(m):
        core[j] = w[j]
        for e in range(m):
            core[j] -= S[j, e] * z[e]
    for i in range(len(P)):
        for a in range(3):
            k = 3 * i + a
            f, value = r[k], d[k]
            for b in range(3):
                value += P[i, a, b] * r[3 * i + b]
            for j in range(m):
                value += W[k, j] * z[j]
            if f != 0.0:
                for j in range(m):
                    core[j] += R[k, j] * f
            y[k] = value
    for j in range(m):
        total += core[j] * core[j]
    return total


class _Core(NamedTuple):
    """What is left for z when contacts are eliminated: matrix (m, m) z = right (m,). X (n, 3, 3) : H⁻¹ C."""

    matrix: Array
    right: Array
    X: Array


@kernel
def eliminated(p: Linked, split: Split, F: Array, core: Array, dr: Array, dz: Array) -> bool:
    """Write the solution of the linearised rows into dr (3n,) and dz (m,). Returns whether every pivot is well above
    rounding: nothing is free.
    """
    n, m = len(p.P), len(dz)
    left = _Core(np.zeros((m, m)), np.empty(m), np.empty((n, 3, 3)))
    determined = _onto_core(p, split, F, core, dr, left)
    rank = solve_ranked(left.matrix, left.right, dz, np.empty(m, np.int64), p.least)
    W, X = p.W, left.X
    for i in range(n):
        for b in range(3):
            value = 0.0
            for j in range(m):
                value += W[3 * i + b, j] * dz[j]
            for a in range(3):
                dr[3 * i + a] -= X[i, a, b] * value
    return determined and rank == m


@kernel
def _onto_core(p: Linked, split: Split, F: Array, core: Array, dr: Array, left: _Core) -> bool:
    """Eliminate contact by contact: write H⁻¹ F into dr (3n,), and what is left, its matrix beginning from zeros.
    Returns whether each contact's pivots are well above rounding.
    """
    P, W, R, A, C, X = p.P, p.W, p.R, split.A, split.C, left.X
    n, m, core_matrix, right = len(P), len(core), left.matrix, left.right
    determined = True
    core_matrix[:] = p.S
    for j in range(m):
        right[j] = -core[j]
    H, Y = np.empty((3, 7)), np.empty((3, m))
    # Indices instead of views throughout: compiled code counts references to each view
    for i in range(n):
        k, still = 3 * i, True
        for a in range(3):
            for b in range(3):
                H[a, b] = A[i, a, b] + C[i, a, 0] * P[i, 0, b] + C[i, a, 1] * P[i, 1, b] + C[i, a, 2] * P[i, 2, b]
                H[a, 3 + b] = C[i, a, b]
                still = still and C[i, a, b] == 0.0
            H[a, 6] = F[k + a]
        determined = _solved(H, p.least) and determined
        for a in range(3):
            dr[k + a] = H[a, 6]
            for b in range(3):
                X[i, a, b] = H[a, 3 + b]
        f0, f1, f2 = H[0, 6], H[1, 6], H[2, 6]
        for j in range(m):
            right[j] += R[k, j] * f0 + R[k + 1, j] * f1 + R[k + 2, j] * f2
        if still:
            continue
        for a in range(3):
            x0, x1, x2 = X[i, a, 0], X[i, a, 1], X[i, a, 2]
            for j in range(m):
                Y[a, j] = x0 * W[k, j] + x1 * W[k + 1, j] + x2 * W[k + 2, j]
        for j in range(m):
            w0, w1, w2 = R[k, j], R[k + 1, j], R[k + 2, j]
            if w0 != 0.0 or w1 != 0.0 or w2 != 0.0:  # a finger's joints move no other finger
                for e in range(m):
                    core_matrix[j, e] += w0 * Y[0, e] + w1 * Y[1, e] + w2 * Y[2, e]
    return determined


@kernel
def _solved(H: Array, least: float) -> bool:
    """Solve with the first three columns of H (3, 7) in place, the right sides being the others. Returns whether every
    pivot is more than this share of the largest.
    """
    largest, found = 0.0, True
    for a in range(3):
        for b in range(3):
            largest = max(largest, abs(H[a, b]))
    for s in range(3):
        best = s
        for a in range(s + 1, 3):
            if abs(H[a, s]) > abs(H[best, s]):
                best = a
        pivot = H[best, s]
        if not abs(pivot) > least * largest:
            found = False
            if pivot == 0.0:
                pivot = 1.0
        for j in range(7):
            value = H[best, j]
            H[best, j] = H[s, j]
            H[s, j] = value / pivot
        for a in range(3):
            f = H[a, s]
            if a != s and f != 0.0:
                for j in range(7):
                    H[a, j] -= f * H[s, j]
    return found


@kernel
def split_rows(p: Linked, g: Subgradient, out: Split) -> None:
    """Write A and C of the subgradients of `contact_rows`."""
    rho, D, A, C = p.own.rho, g.D, out.A, out.C
    for i in range(len(A)):
        for a in range(3):
            for b in range(3):
                A[i, a, b] = C[i, a, b] = 0.0
        if g.scale[3 * i] == 0.0:
            A[i, 0, 0] = 1.0
        else:
            C[i, 0, 0] = g.scale[3 * i]
        for a in range(2):
            for b in range(2):
                A[i, 1 + a, 1 + b] = 1.0 - D[i, a, b] if a == b else -D[i, a, b]
                C[i, 1 + a, 1 + b] = rho[3 * i + 1 + b] * D[i, a, b]
            A[i, 1 + a, 0] = -D[i, a, 3]


@kernel
def _linearised(p: Linked, r: Array, z: Array) -> tuple[Subgradient, Split, Array, Array]:
    """(subgradients, their A and C, F (3n,), core (m,)) about an answer."""
    n, m = len(p.P), len(z)
    y, F, core, g = np.empty(3 * n), np.empty(3 * n), np.empty(m), work(p.own)
    motions(p, r, z, y, core)
    rows(p.own, r, y, F, g)
    split = Split(np.empty((n, 3, 3)), np.empty((n, 3, 3)))
    split_rows(p, g, split)
    return g, split, F, core


@kernel
def determined_by(p: Linked, r: Array, z: Array, D: Array, pushes: Bools) -> bool:
    """Whether the laws, linearised about an answer, leave nothing free. Writes the derivatives of the projections
    into D (n, 3, 4), and which contacts push into pushes (n,).
    """
    g, split, F, core = _linearised(p, r, z)
    for i in range(len(p.P)):
        pushes[i] = g.scale[3 * i] > 0.0
    D[:] = g.D
    return eliminated(p, split, F, core, np.empty(len(r)), np.empty(len(z)))


@kernel
def met_blocks(p: Linked, r: Array, z: Array) -> tuple[bool, Array]:
    """(whether there is one, (6, 6)): the wrench that a small motion of the object, the last of z, meets about an
    answer, contacts and joints following it as they are; along the motion where it drives it further.
    """
    n, m = len(p.P), len(z)
    _, split, F, core = _linearised(p, r, z)
    left = _Core(np.zeros((m, m)), np.empty(m), np.empty((n, 3, 3)))
    _onto_core(p, split, F, core, np.empty(3 * n), left)
    M, k = left.matrix, m - 6
    A, out = M[:k].copy(), np.empty((6, 6))
    found = solve_wide(A, 0.0)
    for i in range(6):
        for j in range(6):
            out[i, j] = -M[k + i, k + j]
            for e in range(k):
                out[i, j] += M[k + i, e] * A[e, k + j]
    return found, out
