"""Frictional contact as equations, and their subgradients.

Unknowns x with y = M x + q. Three kinds of rows, ρ_i > 0 a scale:

    free            F_i = y_i
    pair            F_i = x_i where x_i ≤ ρ_i y_i, else ρ_i y_i                   (natural residual, times ρ)
    friction block  F_T = x_T - P(x_T - ρ y_T; μ max(x_N, 0))

P is the projection of `kernels.projection` on the set of the block's one, two or three tangents. F = 0 says: stick, or
slide against a force on the limit (Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991). The size of the problem
does not depend on the faces.

The subgradient of row i is Σ c e_a + Σ b M_j with at most four unit vectors and three rows of M.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.projection import nearest

__all__ = ["Contacts", "Subgradient", "in_order", "row_scales", "rows", "work"]


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
    """Rows Σ c[i, a] e_unit[i, a] + Σ b[i, e] M[row[i, e]]; unit, c (n, 4); row, b (n, 3)."""

    unit: Ints
    c: Array
    row: Ints
    b: Array


@kernel
def row_scales(M: Array, blocks: Ints) -> Array:
    """(n,) ρ that makes ρ y comparable with x: one over the flexibility that each contact sees, its mean in a block."""
    own, largest = np.abs(np.diag(M)), 0.0
    for flexibility in own:
        largest = max(largest, flexibility)
    for k in range(len(blocks)):
        total, count = 0.0, 0
        for i in blocks[k]:
            if i >= 0:
                total += own[i]
                count += 1
        for i in blocks[k]:
            if i >= 0:
                own[i] = total / count
    return np.where(own > 0.0, 1.0 / np.maximum(own, 1e-6 * largest), 1.0)


@kernel
def in_order(
    M: Array, q: Array, role: Ints, blocks: Ints, order: Ints, limits: Array, faces: int, normals: Array
) -> Contacts:
    """The problem with its unknowns in this order."""
    n = len(q)
    place = np.empty(n + 1, np.int64)
    place[order], place[n] = np.arange(n), -1  # no such tangent stays none
    there = place[blocks.ravel()].reshape(blocks.shape)
    scales = row_scales(M, blocks)[order]
    # A copy of the limits, so that read-only ones and others are one type to compiled code
    return Contacts(M[order][:, order], q[order], role[order], scales, there, limits.copy(), faces, normals)


@kernel
def work(n: int) -> Subgradient:
    """Room for n rows."""
    return Subgradient(np.empty((n, 4), np.int64), np.empty((n, 4)), np.empty((n, 3), np.int64), np.empty((n, 3)))


@kernel
def rows(p: Contacts, x: Array, y: Array, F: Array, g: Subgradient) -> float:
    """Write F (n,) and its subgradients g at x and y = M x + q. Returns ‖F‖²."""
    unit, c, row, b = g.unit, g.c, g.row, g.b
    for i in range(len(x)):
        if p.role[i] == 2:
            continue
        unit[i, :], row[i, :], c[i, :], b[i, :] = i, i, 0.0, 0.0
        if p.role[i] == 0:
            F[i], b[i, 0] = y[i], 1.0
        elif x[i] > p.rho[i] * y[i]:
            F[i], b[i, 0] = p.rho[i] * y[i], p.rho[i]
        else:
            F[i], c[i, 0] = x[i], 1.0
    s, P, D = np.zeros(3), np.empty(3), np.empty((3, 4))
    for k in range(len(p.blocks)):
        n, tangents = p.blocks[k, 0], 1
        while tangents < 3 and p.blocks[k, tangents + 1] >= 0:
            tangents += 1
        s[:] = 0.0
        for a in range(tangents):
            i = p.blocks[k, 1 + a]
            s[a] = x[i] - p.rho[i] * y[i]
        radius, slope = (p.limits[k] * x[n], p.limits[k]) if x[n] > 0.0 else (0.0, 0.0)
        nearest(s, tangents, radius, slope, p.faces, p.normals, P, D)
        for a in range(tangents):
            i = p.blocks[k, 1 + a]
            F[i] = x[i] - P[a]
            unit[i, :], row[i, :], c[i, :], b[i, :] = n, i, 0.0, 0.0
            for e in range(tangents):
                j = p.blocks[k, 1 + e]
                unit[i, e], c[i, e] = j, -D[a, e]
                row[i, e], b[i, e] = j, p.rho[j] * D[a, e]
            c[i, a] += 1.0
            c[i, 3] = -D[a, 3]
    total = 0.0
    for i in range(len(x)):
        total += F[i] * F[i]
    return total
