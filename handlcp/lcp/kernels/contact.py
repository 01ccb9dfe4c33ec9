"""Frictional contact as equations: projection rows, their subgradients, Kaczmarz steps on them and Newton's method.

Unknowns x with y = M x + q. Three kinds of rows, ρ_i > 0 a scale:

    free            F_i = y_i
    pair            F_i = x_i where x_i ≤ ρ_i y_i, else ρ_i y_i                   (natural residual, times ρ)
    friction block  F_T = x_T - P(x_T - ρ y_T; μ max(x_N, 0))

P projects on the disc of that radius (faces = 0), the regular polygon of that apothem (faces ≥ 3, outward normals at
2πj/m from the first tangent) or the interval (faces = 2). F = 0 says: stick, or slide against a force on the limit
(Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991). The size of the problem does not depend on the faces.

The subgradient of row i is Σ c e_a + Σ b M_j with at most three unit vectors and two rows of M.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.arrow import Arrow, Subgradient, arrow_order, pack
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Contacts", "prepare", "project", "roles", "row_scales", "rows", "work"]


class Contacts(NamedTuple):
    """A contact problem as kernels pass it on, unknowns in the order of its arrow M: q (n,), role (n,) of `roles`,
    rho (n,) of `row_scales`, blocks (k, 3), limits (k,), faces.
    """

    M: Arrow
    q: Array
    role: Ints
    rho: Array
    blocks: Ints
    limits: Array
    faces: int


@kernel
def roles(free: Bools, blocks: Ints) -> Ints:
    """(n,) 0 free, 1 pair, 2 tangent of a friction block."""
    role = np.ones(len(free), np.int64)
    for i in range(len(free)):
        if free[i]:
            role[i] = 0
    for k in range(len(blocks)):
        for a in range(1, 3):
            if blocks[k, a] >= 0:
                role[blocks[k, a]] = 2
    return role


@kernel
def row_scales(M: Array, blocks: Ints) -> Array:
    """(n,) ρ that makes ρ y comparable with x: one over the flexibility that each contact sees, its mean in a block."""
    n = len(M)
    own, largest = np.empty(n), 0.0
    for i in range(n):
        own[i] = abs(M[i, i])
        largest = max(largest, own[i])
    for k in range(len(blocks)):
        total, count = 0.0, 0
        for a in range(blocks.shape[1]):
            if blocks[k, a] >= 0:
                total += own[blocks[k, a]]
                count += 1
        for a in range(blocks.shape[1]):
            if blocks[k, a] >= 0:
                own[blocks[k, a]] = total / count
    for i in range(n):
        own[i] = 1.0 / max(own[i], 1e-6 * largest) if own[i] > 0.0 else 1.0
    return own


@kernel
def prepare(
    M: Array, q: Array, role: Ints, blocks: Ints
) -> tuple[Ints, Ints, Array, Array, Array, Array, Ints, Array, Ints]:
    """(order, starts, own, side, below) of the arrow, then (q, role, rho, blocks) of `Contacts` in that order."""
    n = len(q)
    order, starts = arrow_order(M, role, blocks)
    own, side, below = pack(M, order, starts)
    place, moved = np.empty(n + 1, np.int64), blocks.copy()
    place[n] = -1
    for s in range(n):
        place[order[s]] = s
    for k in range(len(blocks)):
        for a in range(3):
            moved[k, a] = place[blocks[k, a]]  # -1, no second tangent, stays -1
    return order, starts, own, side, below, q[order], role[order], row_scales(M, blocks)[order], moved


_TIE = 1e-12  # a projection this close to a corner, relative, is on the side it was computed on


@kernel
def project(x: float, y: float, a: float, slope: float, faces: int, P: Array, D: Array) -> None:
    """P (2,): nearest point to (x, y) of the set with apothem (radius) a; D (2, 3): its derivative by x, y and x_N.

    slope = da/dx_N. An element of the generalised Jacobian where there are several.
    """
    D[:, :] = 0.0
    if faces == 2:
        P[1] = 0.0
        if abs(x) <= a:
            P[0], D[0, 0] = x, 1.0
        else:
            side = 1.0 if x > 0.0 else -1.0
            P[0], D[0, 2] = side * a, side * slope
        return
    if faces == 0:
        r = np.sqrt(x * x + y * y)
        if r <= a:
            P[0], P[1] = x, y
            D[0, 0] = D[1, 1] = 1.0
        else:
            c, s = x / r, y / r
            P[0], P[1] = a * c, a * s
            k = a / r
            D[0, 0], D[0, 1], D[1, 0], D[1, 1] = k * s * s, -k * c * s, -k * c * s, k * c * c
            D[0, 2], D[1, 2] = slope * c, slope * s
        return
    step = 2.0 * np.pi / faces
    j = np.round(np.arctan2(y, x) / step)
    c, s = np.cos(j * step), np.sin(j * step)
    outward, along = c * x + s * y, c * y - s * x
    if outward <= a:
        P[0], P[1] = x, y
        D[0, 0] = D[1, 1] = 1.0
        return
    half = np.tan(0.5 * step)
    if abs(along) > a * half * (1.0 + _TIE):
        side = half if along > 0.0 else -half
        c, s = c - s * side, s + c * side
        P[0], P[1] = a * c, a * s
    else:
        P[0], P[1] = c * a - s * along, s * a + c * along
        D[0, 0], D[0, 1], D[1, 0], D[1, 1] = s * s, -s * c, -s * c, c * c
    D[0, 2], D[1, 2] = slope * c, slope * s


@kernel
def work(n: int) -> Subgradient:
    """Room for n rows."""
    return Subgradient(np.empty((n, 3), np.int64), np.empty((n, 3)), np.empty((n, 2), np.int64), np.empty((n, 2)))


@kernel
def rows(p: Contacts, x: Array, y: Array, F: Array, g: Subgradient) -> float:
    """F (n,) and its subgradients g at x and y = M x + q. Returns ‖F‖²."""
    role, rho, blocks, limits, faces = p.role, p.rho, p.blocks, p.limits, p.faces
    unit, c, row, b = g.unit, g.c, g.row, g.b
    for i in range(len(x)):
        if role[i] == 2:
            continue
        c[i, 0] = c[i, 1] = c[i, 2] = b[i, 0] = b[i, 1] = 0.0
        unit[i, :], row[i, :] = i, i
        if role[i] == 0:
            F[i], b[i, 0] = y[i], 1.0
        elif x[i] > rho[i] * y[i]:
            F[i], b[i, 0] = rho[i] * y[i], rho[i]
        else:
            F[i], c[i, 0] = x[i], 1.0
    P, D = np.empty(2), np.empty((2, 3))
    for k in range(len(blocks)):
        n, t, o = blocks[k, 0], blocks[k, 1], blocks[k, 2]
        planar = o < 0
        r = rho[t]
        a, slope = (limits[k] * x[n], limits[k]) if x[n] > 0.0 else (0.0, 0.0)
        side = 0.0 if planar else x[o] - r * y[o]
        project(x[t] - r * y[t], side, a, slope, faces, P, D)
        for axis in range(1 if planar else 2):
            i = t if axis == 0 else o
            F[i] = x[i] - P[axis]
            unit[i, 0], unit[i, 1], unit[i, 2] = t, t if planar else o, n
            c[i, 0], c[i, 1], c[i, 2] = -D[axis, 0], 0.0 if planar else -D[axis, 1], -D[axis, 2]
            c[i, axis] += 1.0
            row[i, 0], row[i, 1] = t, t if planar else o
            b[i, 0], b[i, 1] = r * D[axis, 0], 0.0 if planar else r * D[axis, 1]
    total = 0.0
    for i in range(len(x)):
        total += F[i] * F[i]
    return total
