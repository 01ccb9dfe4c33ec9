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

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.lcp.kernels.kaczmarz import Seeds, multiply_add, uniform

__all__ = ["contact_kaczmarz", "contact_newton", "contact_residual", "project", "roles", "row_scales"]


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
        for a in range(3):
            if blocks[k, a] >= 0:
                total += own[blocks[k, a]]
                count += 1
        for a in range(3):
            if blocks[k, a] >= 0:
                own[blocks[k, a]] = total / count
    for i in range(n):
        own[i] = 1.0 / max(own[i], 1e-6 * largest) if own[i] > 0.0 else 1.0
    return own


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
def _rows(
    x: Array,
    y: Array,
    role: Ints,
    rho: Array,
    blocks: Ints,
    limits: Array,
    faces: int,
    F: Array,
    unit: Ints,
    c: Array,
    row: Ints,
    b: Array,
) -> float:
    """F (N,) and its subgradients: c (N, 3) at unit vectors `unit` (N, 3), b (N, 2) at rows of M `row` (N, 2). ‖F‖²."""
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


@kernel
def contact_residual(x: Array, y: Array, role: Ints, rho: Array, blocks: Ints, limits: Array, faces: int) -> float:
    """‖F‖_∞; infinite where anything is not a number."""
    n = len(x)
    F, unit, c = np.empty(n), np.empty((n, 3), np.int64), np.empty((n, 3))
    row, b = np.empty((n, 2), np.int64), np.empty((n, 2))
    total = _rows(x, y, role, rho, blocks, limits, faces, F, unit, c, row, b)
    return np.max(np.abs(F)) if total < np.inf else np.inf


@kernel
def contact_newton(
    M: Array,
    q: Array,
    role: Ints,
    rho: Array,
    blocks: Ints,
    limits: Array,
    faces: int,
    x: Array,
    steps: int,
    tolerance: float,
    rank_tolerance: float,
) -> tuple[int, float]:
    """Semismooth Newton on F in place, with a line search that lets ‖F‖ rise for a while (Grippo, Lampariello &
    Lucidi 1986). Stops at ‖F‖ ≤ tolerance × max(1, largest |x|). Returns (steps, ‖F‖ over that size).
    """
    n = len(x)
    y, F, dx = np.empty(n), np.empty(n), np.empty(n)
    x1, y1, F1 = np.empty(n), np.empty(n), np.empty(n)
    unit, c = np.empty((n, 3), np.int64), np.empty((n, 3))
    row, b = np.empty((n, 2), np.int64), np.empty((n, 2))
    J, col, recent = np.empty((n, n)), np.empty(n, np.int64), np.zeros(8)
    multiply_add(M, x, q, y)
    relative = np.inf
    for step in range(steps + 1):
        total = _rows(x, y, role, rho, blocks, limits, faces, F, unit, c, row, b)
        size = 1.0
        for i in range(n):
            size = max(size, abs(x[i]))
        relative = np.sqrt(total) / size
        if not total < np.inf:
            return step, np.inf
        if relative <= tolerance or step == steps:
            return step, relative
        for i in range(n):
            for j in range(n):
                J[i, j] = b[i, 0] * M[row[i, 0], j]
            if b[i, 1] != 0.0:
                for j in range(n):
                    J[i, j] += b[i, 1] * M[row[i, 1], j]
            for a in range(3):
                J[i, unit[i, a]] += c[i, a]
            F1[i] = -F[i]
        solve_ranked(J, F1, dx, col, rank_tolerance)
        recent[step % 8] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            for i in range(n):
                x1[i] = x[i] + t * dx[i]
            multiply_add(M, x1, q, y1)
            if _rows(x1, y1, role, rho, blocks, limits, faces, F1, unit, c, row, b) <= (1.0 - 1e-4 * t) * ceiling:
                break
            t *= 0.5
            if t < 1e-2:
                break
        x[:], y[:] = x1, y1
    return steps, relative


@kernel
def contact_kaczmarz(
    M: Array,
    MT: Array,
    MMT: Array,
    q: Array,
    role: Ints,
    rho: Array,
    blocks: Ints,
    limits: Array,
    faces: int,
    x: Array,
    y: Array,
    state: Seeds,
    steps: int,
    tolerance: float,
) -> tuple[int, float]:
    """Greedy randomized Kaczmarz on the rows of F, as in `kaczmarz` ((20)–(22) of the paper); O(n) a step, in place.

    x and y (n,) belong together on entry and on return. Returns (steps taken, ‖F‖₂).
    """
    n = len(x)
    F, g2 = np.empty(n), np.empty(n)
    unit, c = np.empty((n, 3), np.int64), np.empty((n, 3))
    row, b = np.empty((n, 2), np.int64), np.empty((n, 2))
    norm = np.inf
    for step in range(steps + 1):
        if step % (4 * n) == 0 and step > 0:
            multiply_add(M, x, q, y)
        total = _rows(x, y, role, rho, blocks, limits, faces, F, unit, c, row, b)
        norm = np.sqrt(total)
        frobenius, best = 0.0, 0.0
        for i in range(n):
            p, r = row[i, 0], row[i, 1]
            s = b[i, 0] * b[i, 0] * MMT[p, p] + b[i, 1] * b[i, 1] * MMT[r, r] + 2.0 * b[i, 0] * b[i, 1] * MMT[p, r]
            for a in range(3):
                k = unit[i, a]
                s += 2.0 * c[i, a] * (b[i, 0] * M[p, k] + b[i, 1] * M[r, k])
                for e in range(3):
                    if unit[i, e] == k:
                        s += c[i, a] * c[i, e]
            g2[i] = s
            frobenius += s
            if F[i] * F[i] > best * s:
                best = F[i] * F[i] / s if s > 0.0 else 0.0
        if not norm > tolerance or step == steps or not 0.0 < best < np.inf:
            return step, norm
        bar = 0.5 * (best + total / frobenius) * (1.0 - 1e-12)
        mass = 0.0
        for i in range(n):
            if F[i] * F[i] >= bar * g2[i] > 0.0:
                mass += F[i] * F[i]
        pick, chosen = uniform(state) * mass, -1
        for i in range(n):
            if F[i] * F[i] >= bar * g2[i] > 0.0:
                pick -= F[i] * F[i]
                chosen = i
                if pick < 0.0:
                    break
        t = F[chosen] / g2[chosen]
        for e in range(2):
            f, p = t * b[chosen, e], row[chosen, e]
            if f != 0.0:
                for j in range(n):
                    x[j] -= f * M[p, j]
                    y[j] -= f * MMT[p, j]
        for a in range(3):
            f, k = t * c[chosen, a], unit[chosen, a]
            if f != 0.0:
                x[k] -= f
                for j in range(n):
                    y[j] -= f * MT[k, j]
    return steps, norm
