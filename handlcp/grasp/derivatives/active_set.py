"""`active_rows`: the linear equations that changes of an answer obey while every contact stays in its state, compiled.

One matrix holds the laws of a grasp, whatever its contacts do. With forces r, motion u of the object and motions s of
limits that give way, all in natural units,

    K = [E  Gᵀ Aᵀ]        v = E r + Gᵀ u + Aᵀ s + d
        [G  0  0 ]        w + G r = 0
        [A  0  0 ]        A r = room

A row of K x changes by K Δx + b, where b is what a parameter changes in this law while x stays. The active set says
which rows keep their values, and what other equations the contacts have instead:

    balance    K Δx = -b                          limits    K Δx = -b for those that give way, else Δs = 0
    separated  Δr = 0                             sticking  K Δx = -b
    sliding    nᵀΔr_T - μ Δr_N = δμ r_N for each face n that it slides against, K_N Δx = -b_N, and across these faces
               P K_T Δx + α P Δr_T = -P b_T  (on a round set friction and slip turn together, v_T = -α r_T; else α = 0)

which is friction with maximum dissipation: the slip is against the faces that the force lies on. Without friction
Δr_T = 0. Source: the implicit function theorem; Robinson, Mathematics of Operations Research 5 (1980), for the
one-sided case.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.contact_state import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, ContactStates
from handlcp.lcp.kernels.dense import kernel, solve_ranked, solve_wide
from handlcp.tolerances import RANK_TOLERANCE


class LinearLaws(NamedTuple):
    """The laws of an answer, linear while contacts keep their states.

    K (k, k) : natural units, square.
    kept (k,) : rows that keep their values whatever contacts do.
    contacts (n, 4) : the row of each contact's normal component and those of its tangents, padded by -1. What is
        neither kept nor of a contact is zero and stays so.
    limits (n,) : μ.
    stiffness_unit [N/m] : natural unit of force over that of motion.
    """

    K: Array
    kept: Bools
    contacts: Ints
    limits: Array
    stiffness_unit: float


@kernel
def saddle_matrix(E: Array, stiffness_unit: float, G: Array, A: Array) -> Array:
    """K of E (c, c) [m/N], and G (dof, c) and A (m, c) in natural units."""
    c, dof, m = len(E), len(G), len(A)
    K = np.zeros((c + dof + m, c + dof + m))
    for j in range(c):
        for i in range(c):
            K[j, i] = E[j, i] * stiffness_unit
        for i in range(dof):
            K[c + i, j] = K[j, c + i] = G[i, j]
        for i in range(m):
            K[c + dof + i, j] = K[j, c + dof + i] = A[i, j]
    return K


@kernel
def all_sticking(n: int) -> ContactStates:
    """The states of n contacts that stick."""
    return ContactStates(np.full(n, STICKING), np.zeros(n, np.int64), np.zeros((n, 3, 3)), np.zeros(n))


@kernel
def active_rows(laws: LinearLaws, states: ContactStates) -> tuple[Array, Array]:
    """(A (k, k), B (k, k + n)) of A Δx = B b in natural units, b : of the rows of K, then δμ r_N of the contacts.

    states : RESTING counts as separated. Rows are scaled to a largest entry of one.
    """
    n, k = len(laws.contacts), len(laws.K)
    A, B, kept = laws.K.copy(), np.zeros((k, k + n)), laws.kept.copy()
    for i in range(n):
        own, kind = laws.contacts[i], states.kind[i]
        if own[0] >= 0 and kind != SEPARATED and kind != RESTING:
            kept[own[0]] = True
            for j in own[1:]:
                if j >= 0 and kind != GLIDING:
                    kept[j] = True
    for i in range(k):
        if kept[i]:
            B[i, i] = -1.0
        else:
            A[i] = 0.0
            A[i, i] = 1.0
    for i in range(n):
        if states.kind[i] == SLIDING:
            _write_sliding_rows(A, B, laws, states, i)
    for i in range(k):
        row, largest = A[i], 0.0
        for value in row:
            largest = max(largest, abs(value))
        if largest > 0.0:
            scale, right = 1.0 / largest, B[i]
            for j in range(k):
                row[j] *= scale
            for j in range(k + n):
                right[j] *= scale
    return A, B


@kernel
def _write_sliding_rows(A: Array, B: Array, laws: LinearLaws, states: ContactStates, i: int) -> None:
    """Write the rows of a contact's tangents: along the faces that it slides against, then across them."""
    own, count, d, across = laws.contacts[i], states.face_count[i], 0, np.zeros((3, 3))
    while d < 3 and own[d + 1] >= 0:
        d += 1
    write_complement(states.faces[i], count, d, across)
    for a in range(d):
        j = own[a + 1]
        A[j] = 0.0
        B[j, j] = 0.0
        if a < count:
            A[j, own[0]] = -laws.limits[i]
            B[j, len(A) + i] = 1.0
            for b in range(d):
                A[j, own[b + 1]] += states.faces[i, a, b]
        else:
            for b in range(d):
                A[j] += across[a - count, b] * laws.K[own[b + 1]]
                B[j, own[b + 1]] = -across[a - count, b]
            for b in range(d):
                A[j, own[b + 1]] += states.turn[i] * laws.stiffness_unit * across[a - count, b]


@kernel
def write_complement(normals: Array, count: int, d: int, across: Array) -> None:
    """Write an orthonormal basis of what is across the first `count` rows of normals (3, d) into the rows of across."""
    basis = np.zeros((3, 3))
    for q in range(d):
        best, length = np.zeros(3), 0.0
        for a in range(d if q >= count else 1):  # the unit vector that is farthest from the span, or the next normal
            v = np.zeros(3)
            if q < count:
                v[:d] = normals[q, :d]
            else:
                v[a] = 1.0
            for p in range(q):
                v -= (basis[p] @ v) * basis[p]
            size = float(np.sqrt(v @ v))
            if size > length:
                best, length = v, size
        basis[q] = best
        if length > 0.0:
            basis[q] /= length
        if q >= count:
            across[q - count] = basis[q]


# ----------------------------------------------------------------


@kernel
def matrix_rank(A: Array) -> int:
    """How many of the rows of A (k, k) are independent; A is overwritten."""
    k = len(A)
    return solve_ranked(A, np.zeros(k), np.empty(k), np.empty(k, np.int64), RANK_TOLERANCE)


@kernel
def solve_inverse(A: Array, B: Array, least: float) -> tuple[Array, bool]:
    """Solve A x = B for B (k, p), and say whether A (k, k) has an inverse: (A⁻¹ B, regular).

    It has one where every unknown has a pivot larger than `least`.
    """
    k, p = B.shape
    wide = np.empty((k, k + p))
    wide[:, :k], wide[:, k:] = A, B
    found = solve_wide(wide, least)
    return wide[:, k:].copy(), found


# ----------------------------------------------------------------
# Solutions of these equations where they leave something open, and forces where nothing slips.


_CONSISTENCY_TOLERANCE = 1e-8  # of a right-hand side: what is missed by less is met
# Of the largest singular value: forces and motions that smaller ones determine are left open
_OPEN_SINGULAR_SHARE = 1e-10


def linear_laws(scene: Scene, limits: Array, rows: Array, gives: Bools) -> LinearLaws:
    """Of a grasp, its motions about the contacts' centre. limits (n,) : of the friction sets. rows (m, c) : of limits,
    natural units; gives (m,) : those that give way.
    """
    stiffness_unit = scene.units.force_unit / scene.units.motion_unit
    K = saddle_matrix(scene.flexibility, stiffness_unit, scene.natural.full_G, rows)
    kept = np.concatenate([np.zeros(scene.components, bool), np.ones(scene.dof, bool), gives])
    return LinearLaws(K, kept, scene.kind.contact_components, limits, stiffness_unit)


def least_norm_solutions(A: Array, b: Array, rank: float) -> tuple[Array, Array]:
    """The smallest x (k, p) with A x = b, NaN in columns without one, and what spans A's null space (k, j).

    rank : singular values below this share of the largest count as zero.
    """
    U, s, Vt = np.linalg.svd(A)
    count = int((s > rank * s[0]).sum())
    x = Vt[:count].T @ ((U[:, :count].T @ b) / s[:count, None])
    size = np.maximum(abs(b).max(axis=0, initial=0.0), 1e-300)
    x[:, abs(U[:, count:].T @ b).max(axis=0, initial=0.0) > _CONSISTENCY_TOLERANCE * size] = np.nan
    return x, Vt[count:].T


def solve_without_slip(scene: Scene, flexibility: Array, offsets: Array, loads: Array) -> tuple[Array, Array]:
    """(c, m) forces in the laws' coordinates [N], and (6, m) twists of the object about the contacts' centre, of a
    grasp in which nothing slips and nothing opens: linear in offsets and loads.

        E r + Gᵀ u = -d,    G r = -w

    Where these equations leave something open, the smallest answer is taken; where they have none, the nearest.

    flexibility (c, c), offsets (c, m) [m] : in the laws' coordinates. loads (6, m) : about the contacts' centre.
    """
    index, posed = scene.kind.index, scene.geometry
    e0 = float(np.diagonal(scene.flexibility).mean()) or 1.0
    rows = scene.freedom / np.repeat([1.0, posed.length_unit], 3)
    E, G = flexibility[np.ix_(index, index)], rows @ posed.grasp_matrix[:, index]
    K = saddle_matrix(E, 1.0 / e0, G, np.zeros((0, len(index))))
    answer = np.linalg.lstsq(K, -np.vstack([offsets[index] / e0, rows @ loads]), rcond=_OPEN_SINGULAR_SHARE)[0]
    forces = np.zeros((scene.components, offsets.shape[1]))
    forces[index] = answer[: len(index)]
    return forces, np.asarray(e0 * (rows.T @ answer[len(index) :]))
