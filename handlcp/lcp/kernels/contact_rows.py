"""Frictional contact as equations, and their subgradients.

Unknowns x with y = M x + q. Three kinds of rows, ρ_i > 0 a scale:

    free            F_i = y_i
    pair            F_i = x_i where x_i ≤ ρ_i y_i, else ρ_i y_i                   (natural residual, times ρ)
    friction block  F_T = x_T - P(x_T - ρ y_T; μ max(x_N, 0))

P is the projection of `kernels.projection` on the set of the block's one, two or three tangents. F = 0 says: stick, or
slide against a force on the limit (Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991). The size of the problem
does not depend on the faces.

With D = (∂P/∂s, ∂P/∂x_N), the subgradient of a tangent's row i is e_i - Σ D_ij e_j - D_iN e_N + Σ ρ D_ij M_j over the
tangents j of its block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.lcp.kernels.kaczmarz import Seeds, greedy_row
from handlcp.lcp.kernels.projection import nearest


class Contacts(NamedTuple):
    """A contact problem for kernels, its unknowns in the order of its `Pattern`: M (n, n), q (n,), role (n,), blocks
    (k, 4), limits (k,), faces, normals (f, 3) as in `ContactProblem`, and rho (n,) of `row_scales`.
    """

    M: Array
    q: Array
    role: Ints
    rho: Array
    blocks: Ints
    limits: Array
    faces: int
    normals: Array


class Subgradient(NamedTuple):
    """Of free rows and pairs: scale[i] M_i where scale (n,) is positive, else e_i. D (k, 3, 4): the derivative of each
    block's projection, as in `nearest`. s, P (3,) : room for a point and its projection.
    """

    scale: Array
    D: Array
    s: Array
    P: Array


@kernel
def row_scales(M: Array, blocks: Ints) -> Array:
    """(n,) ρ that makes ρ y comparable with x: one over the flexibility that each contact sees, its mean in a block."""
    n, largest = len(M), 0.0
    own = np.empty(n)
    for i in range(n):
        own[i] = abs(M[i, i])
        largest = max(largest, own[i])
    for k in range(len(blocks)):
        total, count = 0.0, 0
        for i in blocks[k]:
            if i >= 0:
                total += own[i]
                count += 1
        for i in blocks[k]:
            if i >= 0:
                own[i] = total / count
    for i in range(n):
        own[i] = 1.0 / max(own[i], 1e-6 * largest) if own[i] > 0.0 else 1.0
    return own


@kernel
def in_order(
    M: Array, q: Array, role: Ints, blocks: Ints, order: Ints, limits: Array, faces: int, normals: Array
) -> Contacts:
    """The problem with its unknowns in this order."""
    n, scales = len(q), row_scales(M, blocks)
    place, there = np.empty(n, np.int64), np.empty(blocks.shape, np.int64)
    A, b, roles, rho = np.empty((n, n)), np.empty(n), np.empty(n, np.int64), np.empty(n)
    for i in range(n):
        k = order[i]
        place[k], b[i], roles[i], rho[i] = i, q[k], role[k], scales[k]
        for j in range(n):
            A[i, j] = M[k, order[j]]
    for k in range(len(blocks)):
        for e in range(blocks.shape[1]):
            there[k, e] = place[blocks[k, e]] if blocks[k, e] >= 0 else -1
    # A copy of the limits, so that read-only ones and others are one type to compiled code
    return Contacts(A, b, roles, rho, there, limits.copy(), faces, normals)


@kernel
def work(p: Contacts) -> Subgradient:
    """Room for the subgradients of all rows."""
    return Subgradient(np.empty(len(p.rho)), np.empty((len(p.blocks), 3, 4)), np.empty(3), np.empty(3))


@kernel
def rows(p: Contacts, x: Array, y: Array, F: Array, g: Subgradient) -> float:
    """Write F (n,) and its subgradients g at x and y = M x + q. Returns ‖F‖²."""
    # Arrays of a tuple are taken out once: compiled code counts references each time
    role, rho, blocks, limits, normals, scale = p.role, p.rho, p.blocks, p.limits, p.normals, g.scale
    total = 0.0
    for i in range(len(x)):
        if role[i] == 2:
            continue
        if role[i] == 0:
            F[i], scale[i] = y[i], 1.0
        elif x[i] > rho[i] * y[i]:
            F[i], scale[i] = rho[i] * y[i], rho[i]
        else:
            F[i], scale[i] = x[i], 0.0
        total += F[i] * F[i]
    s, P, D = g.s, g.P, g.D
    for k in range(len(blocks)):
        n, tangents = blocks[k, 0], 0
        while tangents < 3 and blocks[k, tangents + 1] >= 0:
            i = blocks[k, 1 + tangents]
            s[tangents] = x[i] - rho[i] * y[i]
            tangents += 1
        for a in range(tangents, 3):
            s[a] = 0.0
        radius, slope = (limits[k] * x[n], limits[k]) if x[n] > 0.0 else (0.0, 0.0)
        nearest(s, tangents, radius, slope, p.faces, normals, P, D[k])
        for a in range(tangents):
            i = blocks[k, 1 + a]
            F[i] = x[i] - P[a]
            total += F[i] * F[i]
    return total


# ----------------------------------------------------------------
# Greedy randomized Kaczmarz steps on the rows of a contact problem.


class _Sums(NamedTuple):
    """Rows Σ c[i, a] e_unit[i, a] + Σ b[i, e] M[row[i, e]]; unit, c (n, 4); row, b (n, 3)."""

    unit: Ints
    c: Array
    row: Ints
    b: Array


@kernel
def contact_kaczmarz(
    p: Contacts, MT: Array, MMT: Array, x: Array, y: Array, state: Seeds, steps: int, tolerance: float
) -> tuple[int, float]:
    """Greedy randomized Kaczmarz on the rows of F, as in `kaczmarz` ((20)–(22) of the paper); O(n) a step, in place.

    MT (n, n) is Mᵀ and MMT (n, n) is M Mᵀ. x and y (n,) belong together on entry and on return.
    Returns (steps taken, ‖F‖₂).
    """
    n = len(x)
    F, p2, g2, at = np.empty(n), np.empty(n), np.empty(n), work(p)
    g = _Sums(np.empty((n, 4), np.int64), np.empty((n, 4)), np.empty((n, 3), np.int64), np.empty((n, 3)))
    norm = np.inf
    for step in range(steps + 1):
        if step > 0 and step % (4 * n) == 0:  # y drifts by rounding
            multiply_add(p.M, x, p.q, y)
        total = rows(p, x, y, F, at)
        _sums(p, at, g)
        norm = np.sqrt(total)
        frobenius, best = 0.0, 0.0
        for i in range(n):
            p2[i], g2[i] = F[i] * F[i], _square(p.M, MMT, g, i)
            frobenius += g2[i]
            if p2[i] > best * g2[i]:
                best = p2[i] / g2[i] if g2[i] > 0.0 else np.inf
        if not norm > tolerance or step == steps or not 0.0 < best < np.inf:
            return step, norm
        i = greedy_row(p2, g2, best, total, frobenius, state)
        _move(p.M, MT, MMT, g, i, F[i] / g2[i], x, y)
    return steps, norm


@kernel
def _sums(p: Contacts, at: Subgradient, g: _Sums) -> None:
    """Write the subgradients of all rows as sums of unit vectors and rows of M."""
    for i in range(len(p.q)):
        g.unit[i, :], g.row[i, :], g.c[i, :], g.b[i, :] = i, i, 0.0, 0.0
        if p.role[i] < 2:
            g.b[i, 0] = at.scale[i]
            g.c[i, 0] = 0.0 if at.scale[i] > 0.0 else 1.0
    for k in range(len(p.blocks)):
        for a in range(3):
            i = p.blocks[k, 1 + a]
            if i < 0:
                break
            g.unit[i, :] = p.blocks[k, 0]
            for e in range(3):
                j = p.blocks[k, 1 + e]
                if j < 0:
                    break
                d = at.D[k, a, e]
                g.unit[i, e], g.c[i, e] = j, 1.0 - d if e == a else -d
                g.row[i, e], g.b[i, e] = j, p.rho[j] * d
            g.c[i, 3] = -at.D[k, a, 3]


@kernel
def _square(M: Array, MMT: Array, g: _Sums, i: int) -> float:
    """|Σ c e_a + Σ b M_j|² of row i."""
    total = 0.0
    for e in range(3):
        if g.b[i, e] == 0.0:
            continue
        for f in range(3):
            total += g.b[i, e] * g.b[i, f] * MMT[g.row[i, e], g.row[i, f]]
        for a in range(4):
            total += 2.0 * g.b[i, e] * g.c[i, a] * M[g.row[i, e], g.unit[i, a]]
    for a in range(4):
        if g.c[i, a] == 0.0:
            continue
        for h in range(4):
            if g.unit[i, h] == g.unit[i, a]:
                total += g.c[i, a] * g.c[i, h]
    return total


@kernel
def _move(M: Array, MT: Array, MMT: Array, g: _Sums, i: int, t: float, x: Array, y: Array) -> None:
    """Take t times the subgradient of row i from x, and y along with it."""
    for e in range(3):
        f, d = t * g.b[i, e], g.row[i, e]
        if f != 0.0:
            for j in range(len(x)):
                x[j] -= f * M[d, j]
                y[j] -= f * MMT[d, j]
    for a in range(4):
        f, k = t * g.c[i, a], g.unit[i, a]
        if f != 0.0:
            x[k] -= f
            for j in range(len(x)):
                y[j] -= f * MT[k, j]
