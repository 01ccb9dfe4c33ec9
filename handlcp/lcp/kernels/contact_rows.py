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
from handlcp.lcp.kernels.compile import kernel
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
    block's projection, as in `nearest`.
    """

    scale: Array
    D: Array


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
    return Subgradient(np.empty(len(p.q)), np.empty((len(p.blocks), 3, 4)))


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
    s, P, D = np.empty(3), np.empty(3), g.D
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
