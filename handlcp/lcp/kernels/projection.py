"""`project_on_set`: projections on friction sets, compiled; and the certifier's residuals in natural units."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.dense import kernel, multiply_add

# ----------------------------------------------------------------
# The point nearest to a given one in the set that limits friction, and how it moves with the point and the set.
#
# The set lies about the origin of one, two or three tangents and has the radius, or the distance of its faces, `a`:
#
# tangents   faces = 0   faces = 2           faces = m ≥ 3
# 1          interval    interval            interval
# 2          disc        interval along x    regular polygon, outward normals at 2πj/m from the first tangent
# 3          ball                            polyhedron with the given outward unit normals

_CORNER_TOLERANCE = 1e-12  # a projection this close to a corner, relative, is on the side it was computed on
_PLANE_TIE = 1e-12  # how far outside, in sizes of the answer, still counts as on a plane
_MAX_PLANE_CHANGES = 60  # changes of the active planes; a polyhedron of a hundred faces takes five


@kernel
def project_on_set(
    s: Array, tangents: int, a: float, slope: float, faces: int, normals: Array, p: Array, D: Array
) -> None:
    """P (3,) ← the point of the set nearest to s (3,); D (3, 4) ← its derivative by s, and by x_N with slope = da/dx_N.

    tangents : how many entries of s count; the others are zero. normals (f, 3) : outward, of a polyhedron. Where the
    projection has a kink, D is one element of its generalised Jacobian.
    """
    for i in range(3):
        p[i] = 0.0
        for j in range(4):
            D[i, j] = 0.0
    if tangents == 1 or faces == 2:
        _project_on_interval(s, a, slope, p, D)
    elif faces == 0:
        _project_on_ball(s, tangents, a, slope, p, D)
    elif tangents == 2:
        _project_on_polygon(s, a, slope, faces, p, D)
    elif a > 0.0:
        _project_on_polyhedron(s, a, slope, normals, p, D)


@kernel
def _project_on_interval(s: Array, a: float, slope: float, p: Array, D: Array) -> None:
    if abs(s[0]) <= a:
        p[0], D[0, 0] = s[0], 1.0
    else:
        side = 1.0 if s[0] > 0.0 else -1.0
        p[0], D[0, 3] = side * a, side * slope


@kernel
def _project_on_ball(s: Array, d: int, a: float, slope: float, p: Array, D: Array) -> None:
    """P = a e with e = s / |s|, and dp = (a / |s|)(1 - e eᵀ) ds + e da."""
    square = 0.0
    for i in range(d):
        square += s[i] * s[i]
    length = np.sqrt(square)
    if length <= a:
        for i in range(d):
            p[i], D[i, i] = s[i], 1.0
        return
    share, inverse = a / length, 1.0 / length
    for i in range(d):
        e = s[i] * inverse
        p[i], D[i, 3] = a * e, slope * e
        for j in range(d):
            D[i, j] = -share * e * s[j] * inverse
        D[i, i] += share


@kernel
def _project_on_polygon(s: Array, a: float, slope: float, faces: int, p: Array, D: Array) -> None:
    if s[0] * s[0] + s[1] * s[1] <= a * a:  # within the inscribed circle
        p[0], p[1] = s[0], s[1]
        D[0, 0] = D[1, 1] = 1.0
        return
    step = 2.0 * np.pi / faces
    j = np.round(np.arctan2(s[1], s[0]) / step)
    c, n = np.cos(j * step), np.sin(j * step)
    outward, along = c * s[0] + n * s[1], c * s[1] - n * s[0]
    if outward <= a:
        p[0], p[1] = s[0], s[1]
        D[0, 0] = D[1, 1] = 1.0
        return
    half = np.tan(0.5 * step)
    if abs(along) > a * half * (1.0 + _CORNER_TOLERANCE):
        side = half if along > 0.0 else -half
        c, n = c - n * side, n + c * side
        p[0], p[1] = a * c, a * n
    else:
        p[0], p[1] = c * a - n * along, n * a + c * along
        D[0, 0], D[0, 1], D[1, 0], D[1, 1] = n * n, -n * c, -n * c, c * c
    D[0, 3], D[1, 3] = slope * c, slope * n


@kernel
def _project_on_polyhedron(s: Array, a: float, slope: float, normals: Array, p: Array, D: Array) -> None:
    """Min |p - s| with nᵀp ≤ a for every normal n. Planes are added where p is farthest outside and dropped where they
    pull: a dual active-set method (Goldfarb & Idnani, Math. Program. 27, 1983) with three planes at most.
    """
    tie = _PLANE_TIE * max(a, abs(s[0]), abs(s[1]), abs(s[2]))
    p[:] = s
    worst = _farthest_plane(p, a, normals, tie)
    for i in range(3):
        D[i, i] = 1.0
    if worst < 0:
        return
    planes, weights, r, count = np.empty(3, np.int64), np.zeros(3), np.zeros(3), 0
    for _ in range(_MAX_PLANE_CHANGES):
        count = _activate_plane(worst, a, normals, planes, count, weights, p)
        worst = _farthest_plane(p, a, normals, tie)
        if worst < 0:
            break
    # Of a change of s only what lies across the active planes is left; a change of a moves them all outward
    for c in range(3):
        for i in range(count):
            r[i] = normals[planes[i], c]
        _solve_normal_products(normals, planes, count, r)
        for i in range(count):
            for k in range(3):
                D[k, c] -= r[i] * normals[planes[i], k]
    r[:] = 1.0
    _solve_normal_products(normals, planes, count, r)
    for i in range(count):
        for k in range(3):
            D[k, 3] += slope * r[i] * normals[planes[i], k]


@kernel
def _farthest_plane(p: Array, a: float, normals: Array, tie: float) -> int:
    """The plane that p lies outside of by most; -1: by no more than `tie` of any."""
    worst, out = -1, a + tie
    for j in range(len(normals)):
        reach = normals[j, 0] * p[0] + normals[j, 1] * p[1] + normals[j, 2] * p[2]
        if reach > out:
            worst, out = j, reach
    return worst


@kernel
def _activate_plane(worst: int, a: float, normals: Array, planes: Ints, count: int, weights: Array, p: Array) -> int:
    """Move p onto the plane `worst`, as far as the active planes allow: where one of them would pull, it goes first.

    Returns how many planes are active then.
    """
    entering, n = 0.0, normals[worst]
    r, across = np.zeros(3), np.empty(3)
    while True:
        for i in range(count):
            m = normals[planes[i]]
            r[i] = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
        _solve_normal_products(normals, planes, count, r)
        across[:] = n
        drop, length = -1, np.inf
        for i in range(count):
            for k in range(3):
                across[k] -= r[i] * normals[planes[i], k]
            if r[i] > 0.0 and weights[i] / r[i] < length:
                drop, length = i, weights[i] / r[i]
        size = across[0] ** 2 + across[1] ** 2 + across[2] ** 2
        over = n[0] * p[0] + n[1] * p[1] + n[2] * p[2] - a
        full = over / size if size > 1e-14 else np.inf
        step = min(full, length)
        if step == np.inf:
            return count
        for i in range(count):
            weights[i] -= step * r[i]
        entering += step
        if size > 1e-14:
            for k in range(3):
                p[k] -= step * across[k]
        if full <= length:
            planes[count], weights[count] = worst, entering
            return count + 1
        for i in range(drop, count - 1):
            planes[i], weights[i] = planes[i + 1], weights[i + 1]
        count -= 1


@kernel
def _solve_normal_products(normals: Array, planes: Ints, count: int, x: Array) -> None:
    """X ← A⁻¹ x, A the products of the active normals, positive definite: elimination without pivoting."""
    A = np.empty((3, 3))
    for i in range(count):
        for j in range(count):
            m, n = normals[planes[i]], normals[planes[j]]
            A[i, j] = m[0] * n[0] + m[1] * n[1] + m[2] * n[2]
    for s in range(count):
        for i in range(s + 1, count):
            f = A[i, s] / A[s, s]
            for j in range(s, count):
                A[i, j] -= f * A[s, j]
            x[i] -= f * x[s]
    for s in range(count - 1, -1, -1):
        for j in range(s + 1, count):
            x[s] -= A[s, j] * x[j]
        x[s] /= A[s, s]


# ----------------------------------------------------------------
# The certifier's arithmetic: w = M z + q afresh, and the natural residual in natural units.


@kernel
def multiply_entries(a: Array, b: Array) -> Array:
    """A b, entry by entry; what overflows is infinite, and the certifier refuses it."""
    return a * b


@kernel
def recompute_residual(
    M: Array, q: Array, free: Bools, z_unit: Array, w_unit: Array, z: Array, growth: float
) -> tuple[Array, float]:
    """Recompute w = M z + q, and the worst of |min(z_i, w_i)|, |w_i| where free, in units of z and w: (w, residual).

    Divided by the size of z, clipped to [1, growth]. Infinite where anything is not finite.
    """
    n = len(q)
    w, size, worst = np.empty(n), 1.0, 0.0
    multiply_add(M, z, q, w)
    for i in range(n):
        zs, ws = z[i] / z_unit[i], w[i] / w_unit[i]
        if not (abs(zs) < np.inf and abs(ws) < np.inf):
            worst = np.inf
        else:
            size = max(size, abs(zs))
            worst = max(worst, abs(ws) if free[i] else abs(min(zs, ws)))
    return w, worst / min(size, growth)


@kernel
def recompute_natural_residual(
    M: Array, q: Array, free: Bools, z_unit: Array, w_unit: Array, x: Array, growth: float
) -> tuple[Array, Array, float]:
    """Recompute (z, w, residual) as `recompute_residual` does, for z = x in units of z."""
    z = multiply_entries(x, z_unit)
    w, residual = recompute_residual(M, q, free, z_unit, w_unit, z, growth)
    return z, w, residual


@kernel
def recompute_contact_residual(
    M: Array, q: Array, role: Ints, blocks: Ints, limits: Array, faces: int, normals: Array, x: Array
) -> tuple[Array, float, float]:
    """(y, worst, size) of a contact problem: the worst of |y_i| (free), |min(x_i, y_i)| (pairs), and for each block the
    excess of x_T over its limit and the distance of x_T from the projection of x_T - y_T; and the largest of 1 and |x|.
    """
    n = len(q)
    y, size, worst = np.empty(n), 1.0, 0.0
    multiply_add(M, x, q, y)
    for i in range(n):
        if not (abs(x[i]) < np.inf and abs(y[i]) < np.inf):
            return y, np.inf, 1.0
        size = max(size, abs(x[i]))
        if role[i] < 2:
            worst = max(worst, abs(y[i] if role[i] == 0 else min(x[i], y[i])))
    s, P, unused = np.zeros(3), np.empty(3), np.empty((3, 4))
    for k in range(len(blocks)):
        a, tangents = limits[k] * max(x[blocks[k, 0]], 0.0), blocks[k, 1:]
        for pull in (0.0, 1.0):
            d, off = 0, 0.0
            s[:] = 0.0
            for i in tangents:
                if i >= 0:
                    s[d] = x[i] - pull * y[i]
                    d += 1
            project_on_set(s, d, a, 0.0, faces, normals, P, unused)
            for m in range(d):
                off += (x[tangents[m]] - P[m]) ** 2
            worst = max(worst, np.sqrt(off))
    return y, worst, size
