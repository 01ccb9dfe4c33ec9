"""`ModeCones`: what a contact may do in each mode, as cones: generators of its force and of its motion.

    open     motion: the gap up
    stuck    force: its whole friction cone
    slides   force: what encloses a patch of the cone's surface; slip: the cone of directions against that patch
    touches  force: its whole friction cone: stuck and slides together
    any      open and stuck together, which encloses every mode

Contacts that are open, touch or may do anything also slip as they will. `equations` leaves the rows of these slips out,
so there are no generators of them.

A patch is an end of the interval; a run of neighbouring faces and vertices of the polygon; an arc of the disc between
two unit vectors; a triangle of the ball between three. On disc and ball the corners n_a, the points where the tangents
(tangent planes) of two corners meet, (n_a + n_b) / (1 + n_a·n_b), and where all three do enclose the patch. Patches are
split until they decide.

The generators are never listed: `support` finds the one that points most along a given vector.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import RANK_TOLERANCE

ANY, OPEN, STUCK, SLIDES, TOUCHES = 0, 1, 2, 3, 4
# Columns of disc and ball lie this share outside, so that finitely many enclose them; those that enclose the right
# directions only count where the true set still reaches further
_CIRCUMSCRIBED_EXCESS = 1e-5


class ModeCones(NamedTuple):
    """n contacts (or pairs, which have no tangents), in R equations: Σ X x + Σ Y y = b.

    columns (R, n, 8) : of each contact's normal force and up to three tangential ones, then of its motion likewise;
    zero where there are none. products (n, 2, 4, 4) : of the columns of each, with each other.
    tangents, limits (n,), faces : as in `ContactProblem`.
    """

    columns: Array
    products: Array
    tangents: Ints
    limits: Array
    faces: int


@kernel
def new_mode_cones(columns: Array, tangents: Ints, limits: Array, faces: int) -> ModeCones:
    """With the products of the columns (R, n, 8)."""
    R, n = columns.shape[:2]
    products = np.zeros((n, 2, 4, 4))
    for j in range(R):
        for i in range(n):
            row = columns[j, i]
            for k in range(2):
                for p in range(1 + tangents[i]):
                    x = row[4 * k + p]
                    if x != 0.0:
                        for q in range(1 + tangents[i]):
                            products[i, k, p, q] += x * row[4 * k + q]
    return ModeCones(columns, products, tangents, limits, faces)


@kernel
def count_patches(tangents: int) -> int:
    """Into how many patches sliding is divided at first."""
    return 0 if tangents == 0 else 2 if tangents == 1 else 8 if tangents == 3 else 4


@kernel
def write_first_patch(k: int, tangents: int, faces: int, corners: Array) -> None:
    """Write patch k (of `count_patches`) into corners (3, 3): unit vectors, or first and last position on a polygon,
    where face j has position 2j and the vertex behind it 2j + 1.
    """
    corners[:, :] = 0.0
    if tangents == 1:
        corners[0, 0] = 1.0 if k == 0 else -1.0
    elif tangents == 3:
        for a in range(3):
            corners[a, a] = 1.0 if (k >> a) & 1 == 0 else -1.0
    elif faces > 2:
        corners[0, 0], corners[0, 1] = (k * 2 * faces) // 4, ((k + 1) * 2 * faces) // 4 - 1
    else:
        for a in range(2):
            corners[a, 0], corners[a, 1] = np.cos(0.5 * np.pi * (k + a)), np.sin(0.5 * np.pi * (k + a))


@kernel
def count_parts(corners: Array, tangents: int, faces: int) -> int:
    """Into how many a patch can be split; none where it is one face or vertex."""
    if tangents == 3:
        return 4
    if tangents == 1:
        return 0
    return 2 if faces == 0 or corners[0, 1] > corners[0, 0] else 0


@kernel
def split_patch(corners: Array, k: int, tangents: int, faces: int, out: Array) -> None:
    """Write part k of a patch (of `parts`) into out (3, 3)."""
    out[:, :] = corners
    if tangents == 3:
        middles = np.empty((3, 3))
        for a in range(3):
            _write_middle(corners[a], corners[(a + 1) % 3], middles[a])
        if k == 3:
            out[:, :] = middles
        else:
            out[(k + 1) % 3], out[(k + 2) % 3] = middles[k], middles[(k + 2) % 3]
    elif faces > 2:
        middle = np.floor(0.5 * (corners[0, 0] + corners[0, 1]))
        if k == 0:
            out[0, 1] = middle
        else:
            out[0, 0] = middle + 1.0
    else:
        _write_middle(corners[0], corners[1], out[1 - k])


@kernel
def _write_middle(a: Array, b: Array, out: Array) -> None:
    size = 0.0
    for i in range(3):
        out[i] = a[i] + b[i]
        size += out[i] * out[i]
    for i in range(3):
        out[i] /= np.sqrt(size)


@kernel
def write_reach(c: ModeCones, rest: Array, along: Array) -> None:
    """How far every column reaches along rest (R,), into along (n, 2, 4)."""
    columns, flat = c.columns.reshape(len(rest), -1), along.reshape(-1)
    flat[:] = 0.0
    for j in range(len(rest)):
        f, row = rest[j], columns[j]
        for k in range(len(flat)):
            flat[k] += f * row[k]


@kernel
def find_support(c: ModeCones, i: int, code: int, corners: Array, along: Array, of: Array) -> tuple[float, float]:
    """How far the generators of contact i reach, per unit of normal force and of motion, where its columns reach as far
    as along (2, 4) says: the best of the forces, and of the motions; -inf where the mode has none. Their components go
    to of (2, 4).
    """
    d, mu = c.tangents[i], c.limits[i]
    of[:, :] = 0.0
    if code == SLIDES:
        return _patch_support(d, mu, c.faces, corners, along, of)
    force, motion = -np.inf, -np.inf
    if code != OPEN:
        force = _cone_support(d, mu, c.faces, along[0], of[0])
    if code in (OPEN, ANY):
        of[1, 0], motion = 1.0, along[1, 0]
    return force, motion


@kernel
def _cone_support(d: int, mu: float, faces: int, along: Array, of: Array) -> float:
    """The generator of a friction cone that reaches furthest."""
    of[0] = 1.0
    if d == 0:
        return float(along[0])
    if d == 2 and faces > 2:
        position = int(np.floor(np.arctan2(along[2], along[1]) / (2.0 * np.pi / faces)))
        angle, radius = 2.0 * np.pi * (position + 0.5) / faces, mu / np.cos(np.pi / faces)
        of[1], of[2] = radius * np.cos(angle), radius * np.sin(angle)
        return float(along[0] + of[1] * along[1] + of[2] * along[2])
    size = 0.0
    for a in range(1, 1 + d):
        size += along[a] * along[a]
    size = np.sqrt(size)
    if size > 0.0:
        beyond = mu if d == 1 else mu * (1.0 + _CIRCUMSCRIBED_EXCESS)
        for a in range(1, 1 + d):
            of[a] = beyond * along[a] / size
    return float(along[0] + mu * size)


@kernel
def _patch_support(d: int, mu: float, faces: int, corners: Array, along: Array, of: Array) -> tuple[float, float]:
    """The generators of a patch, and of the slip against it, that reach furthest."""
    force, motion = -np.inf, -np.inf
    p = np.zeros(3)
    if d == 2 and faces > 2:
        low, high = int(corners[0, 0]), int(corners[0, 1])
        for k in range(low - 1, high + 2):
            odd = k % 2 != 0
            if (k < low and odd == (low % 2 != 0)) or (k > high and odd == (high % 2 != 0)):
                continue
            radius = 1.0 / np.cos(np.pi / faces) if odd else 1.0
            p[0], p[1] = radius * np.cos(np.pi * k / faces), radius * np.sin(np.pi * k / faces)
            if odd:
                force = _further_force(d, mu, p, along, force, of)
            else:
                motion = _further_motion(d, p, along, motion, of)
        return force, motion
    corner = 1 if d == 1 else d
    for a in range(corner):
        force = _further_force(d, mu, corners[a], along, force, of)
        motion = _further_motion(d, corners[a], along, motion, of)
        if d > 1 and (d > 2 or a == 0):
            b, dot = (a + 1) % d, 0.0
            for k in range(3):
                dot += corners[a, k] * corners[b, k]
            for k in range(3):
                p[k] = (corners[a, k] + corners[b, k]) / (1.0 + dot)
            force = _further_force(d, mu, p, along, force, of)
    if d == 3:
        x, y, z = corners[0], corners[1], corners[2]
        p[:] = np.cross(x, y) + np.cross(y, z) + np.cross(z, x)
        det = 0.0
        for k in range(3):
            det += x[k] * p[k]
        p /= det
        force = _further_force(d, mu, p, along, force, of)
    return force, motion


@kernel
def _further_force(d: int, mu: float, p: Array, along: Array, best: float, of: Array) -> float:
    """The better of the best so far and the force at the point p (3,) of the unit set."""
    value = along[0, 0]
    for a in range(d):
        value += mu * p[a] * along[0, 1 + a]
    if value <= best:
        return best
    of[0, 0] = 1.0
    for a in range(d):
        of[0, 1 + a] = mu * p[a]
    return float(value)


@kernel
def _further_motion(d: int, p: Array, along: Array, best: float, of: Array) -> float:
    """The better of the best so far and the slip against p (3,)."""
    value = 0.0
    for a in range(d):
        value -= p[a] * along[1, 1 + a]
    if value <= best:
        return best
    for a in range(d):
        of[1, 1 + a] = -p[a]
    return float(value)


# ----------------------------------------------------------------
# The equations that a choice of modes has to fit, M x + F u + q = y, without what is free in them.
#
# Contacts that are open, that touch somehow, or of which nothing is known slip as they will: rows of their slips say
# nothing, and are left out. Of the rest, what the free unknowns u can make is taken out by reflections. With 45
# contacts of which little is known 45 rows are left of 135, and a fit costs a tenth.


class FullEquations(NamedTuple):
    """All N rows of the laws, before the free unknowns are taken out.

    M (N, n, 4) : by each contact's normal force and up to three tangential ones.
    F (N, f) : by the free unknowns.
    q (N,) : what is given.
    row (n, 4) : the row of each of its motions, -1 where there is none; of other rows y = 0.
    tangents, limits (n,), faces : as in `ModeCones`.
    """

    M: Array
    F: Array
    q: Array
    row: Ints
    tangents: Ints
    limits: Array
    faces: int


class ReducedEquations(NamedTuple):
    """The equations of one choice of modes, without the free unknowns.

    cones, b : what a fit is asked for.
    top (rank, f + 1 + 8n) : rows that give the free unknowns `taken` (rank,), a triangle in these columns, by q, forces
        and motions.
    """

    cones: ModeCones
    b: Array
    top: Array
    taken: Ints


@kernel
def reduce_equations(w: FullEquations, codes: Ints) -> ReducedEquations:
    """Reduce the equations to those of one choice of contact modes, codes (n,)."""
    N, f, n = len(w.q), w.F.shape[1], len(codes)
    known = np.ones(N, np.bool_)
    for i in range(n):
        if codes[i] != STUCK and codes[i] != SLIDES:
            for q in range(1, 1 + w.tangents[i]):
                known[w.row[i, q]] = False
    place, count = np.full(N, -1), 0
    for j in range(N):
        if known[j]:
            place[j] = count
            count += 1
    A = np.zeros((count, f + 1 + 8 * n))
    for j in range(N):
        if known[j]:
            to = A[place[j]]
            to[:f], to[f] = w.F[j], w.q[j]
            for i in range(n):
                for q in range(4):
                    to[f + 1 + 8 * i + q] = w.M[j, i, q]
    for i in range(n):
        for q in range(1 + w.tangents[i]):
            if known[w.row[i, q]]:
                A[place[w.row[i, q]], f + 5 + 8 * i + q] = -1.0
    taken, rank = _reflect(A, f)
    columns = A[rank:, f + 1 :].copy()
    cones = new_mode_cones(columns.reshape(len(columns), n, 8), w.tangents, w.limits, w.faces)
    return ReducedEquations(cones, -A[rank:, f].copy(), A[:rank].copy(), taken[:rank].copy())


@kernel
def _reflect(A: Array, f: int) -> tuple[Ints, int]:
    """Make the first f columns a triangle in the first `rank` rows, and rounding below; the longest column first.
    Returns (its columns, rank).
    """
    rows, wide = A.shape
    taken, rank, first = np.full(f, -1), 0, 0.0
    v, along = np.empty(rows), np.empty(wide)
    while rank < min(f, rows):
        best, most = -1, 0.0
        for j in range(f):
            total = 0.0
            for i in range(rank, rows):
                total += A[i, j] * A[i, j]
            if total > most and not np.any(taken[:rank] == j):
                best, most = j, total
        most = np.sqrt(most)
        first = max(first, most)
        if best < 0 or most <= RANK_TOLERANCE * first:
            break
        for i in range(rank, rows):
            v[i] = A[i, best]
        v[rank] += most if v[rank] > 0.0 else -most
        size = 0.0
        for i in range(rank, rows):
            size += v[i] * v[i]
        along[:] = 0.0
        for i in range(rank, rows):
            for k in range(wide):
                along[k] += v[i] * A[i, k]
        for i in range(rank, rows):
            share = 2.0 * v[i] / size
            for k in range(wide):
                A[i, k] -= share * along[k]
        taken[rank] = best
        rank += 1
    return taken, rank


@kernel
def write_free(w: FullEquations, r: ReducedEquations, codes: Ints, x: Array, y: Array, u: Array) -> None:
    """Write the free unknowns u (f,) of forces x and motions y (n, 4), and into y the slips that rows left out give."""
    n, f, rank = len(codes), len(u), len(r.taken)
    u[:] = 0.0
    for k in range(rank - 1, -1, -1):
        row = r.top[k]
        value = -row[f]
        for i in range(n):
            for q in range(1 + w.tangents[i]):
                value -= row[f + 1 + 8 * i + q] * x[i, q] + row[f + 5 + 8 * i + q] * y[i, q]
        for e in range(k + 1, rank):
            value -= row[r.taken[e]] * u[r.taken[e]]
        u[r.taken[k]] = value / row[r.taken[k]]
    for i in range(n):
        if codes[i] == STUCK or codes[i] == SLIDES:
            continue
        for q in range(1, 1 + w.tangents[i]):
            j = w.row[i, q]
            value = w.q[j]
            for e in range(n):
                for p in range(1 + w.tangents[e]):
                    value += w.M[j, e, p] * x[e, p]
            for e in range(f):
                value += w.F[j, e] * u[e]
            y[i, q] = value
