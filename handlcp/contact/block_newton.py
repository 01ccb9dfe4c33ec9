"""`newton_blocks`: Newton's method on many contacts, each with a flexibility of its own and a few shared motions.

    y = P r + W z + d,    0 = Rᵀ r - S z + w

r (3n,) are the contacts' forces, normal first, P (n, 3, 3) blocks, z (m,) what the contacts share: torques of the
joints (S = 1, their columns of W are J A with K⁻¹ = A Aᵀ) and, last, the object's motion (S = 0, columns Gᵀ). R is W
where forces do not turn. The rows of the friction laws (`evaluate_rows`) have A δr + C δy = F with blocks of three, so
that

    δr = H⁻¹ (F - C W δz),   H = A + C P,     (Σ Rᵀ H⁻¹ C W + S) δz = Σ Rᵀ H⁻¹ F - (Rᵀ r - S z + w)

contact by contact: one step costs O(n m²), and no matrix of all contacts is formed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.contact_newton import (
    BALL_TOLERANCE,
    LINE_SEARCH_MEMORY,
    MAX_BALL_STEPS,
    MAX_NEWTON_STEPS,
    MIN_STEP_LENGTH,
    ContactArrays,
    Subgradient,
    evaluate_rows,
    new_subgradient,
)
from handlcp.lcp.kernels.dense import kernel, solve_ranked, solve_wide
from handlcp.tolerances import SOLVE_TOLERANCE


class LinkedContacts(NamedTuple):
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
    own: ContactArrays
    least: float


class LawRows(NamedTuple):
    """Rows A and C (n, 3, 3) of the laws, A δr + C δy = F."""

    A: Array
    C: Array


@kernel
def write_motions(p: LinkedContacts, r: Array, z: Array, y: Array, core: Array) -> float:
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


class _CoreSystem(NamedTuple):
    """What is left for z when contacts are eliminated: matrix (m, m) z = right (m,). X (n, 3, 3) : H⁻¹ C."""

    matrix: Array
    right: Array
    X: Array


@kernel
def eliminate_contacts(p: LinkedContacts, split: LawRows, F: Array, core: Array, dr: Array, dz: Array) -> bool:
    """Write the solution of the linearised rows into dr (3n,) and dz (m,). Returns whether every pivot is well above
    rounding: nothing is free.
    """
    n, m = len(p.P), len(dz)
    left = _CoreSystem(np.zeros((m, m)), np.empty(m), np.empty((n, 3, 3)))
    determined = _reduce_to_core(p, split, F, core, dr, left)
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
def _reduce_to_core(p: LinkedContacts, split: LawRows, F: Array, core: Array, dr: Array, left: _CoreSystem) -> bool:
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
        determined = _solve_columns(H, p.least) and determined
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
def _solve_columns(H: Array, least: float) -> bool:
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
def write_law_rows(p: LinkedContacts, g: Subgradient, out: LawRows) -> None:
    """Write A and C of the subgradients of `evaluate_rows`."""
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
def _linearise(p: LinkedContacts, r: Array, z: Array) -> tuple[Subgradient, LawRows, Array, Array]:
    """(subgradients, their A and C, F (3n,), core (m,)) about an answer."""
    n, m = len(p.P), len(z)
    y, F, core, g = np.empty(3 * n), np.empty(3 * n), np.empty(m), new_subgradient(p.own)
    write_motions(p, r, z, y, core)
    evaluate_rows(p.own, r, y, F, g)
    split = LawRows(np.empty((n, 3, 3)), np.empty((n, 3, 3)))
    write_law_rows(p, g, split)
    return g, split, F, core


@kernel
def is_determined(p: LinkedContacts, r: Array, z: Array, D: Array, pushes: Bools) -> bool:
    """Whether the laws, linearised about an answer, leave nothing free. Writes the derivatives of the projections
    into D (n, 3, 4), and which contacts push into pushes (n,).
    """
    g, split, F, core = _linearise(p, r, z)
    for i in range(len(p.P)):
        pushes[i] = g.scale[3 * i] > 0.0
    D[:] = g.D
    return eliminate_contacts(p, split, F, core, np.empty(len(r)), np.empty(len(z)))


@kernel
def tangent_stiffness_blocks(p: LinkedContacts, r: Array, z: Array) -> tuple[bool, Array]:
    """The tangent stiffness (6, 6) of the object about an answer, after whether there is one.

    It is the wrench that a small motion of the object, the last of z, meets while contacts and joints follow it as they
    are; along the motion where it drives it further.
    """
    n, m = len(p.P), len(z)
    _, split, F, core = _linearise(p, r, z)
    left = _CoreSystem(np.zeros((m, m)), np.empty(m), np.empty((n, 3, 3)))
    _reduce_to_core(p, split, F, core, np.empty(3 * n), left)
    M, k = left.matrix, m - 6
    A, out = M[:k].copy(), np.empty((6, 6))
    found = solve_wide(A, 0.0)
    for i in range(6):
        for j in range(6):
            out[i, j] = -M[k + i, k + j]
            for e in range(k):
                out[i, j] += M[k + i, e] * A[e, k + j]
    return found, out


# ----------------------------------------------------------------
# Newton's method contact by contact, and what leads there: contacts that all stick, then proximal steps.


_ADMM_RELAXATION = 1.6  # over-relaxation of ADMM
# Proximal steps before Newton's method is tried again: of 20 grasps that it fails on at first, ten were enough for 19.
# Each is a linear solve as Newton's are, and they are counted as such.
_PROXIMAL_ROUNDS, _PROXIMAL_WEIGHT = (10, 20, 70), 10.0


@kernel
def solve_blocks(p: LinkedContacts, r: Array, z: Array, begun: bool) -> tuple[int, float]:
    """Solve the contact problem in place, contact by contact: (linear solves, residual), inf where contacts cannot be
    eliminated.

    begun : whether to begin at r (3n,) and z (m,). Where that leads nowhere, contacts that all stick are the start,
        then with proximal steps between Newton's.
    """
    newton, residual = 0, np.inf
    if begun:
        newton, residual = _run_newton(p, r, z, False)
        if residual <= SOLVE_TOLERANCE:
            return newton, residual
    apart = np.empty(len(p.P), np.bool_)
    for i in range(len(apart)):
        apart[i] = p.d[3 * i] > 0.0
    if not solve_sticking_blocks(p, apart, r, z):
        return newton, np.inf
    steps, residual = _run_newton(p, r, z, True)
    newton += steps
    copies, pull, k = np.zeros(len(r)), np.zeros(len(r)), 0
    while not residual <= SOLVE_TOLERANCE and k < len(_PROXIMAL_ROUNDS):
        proximal_blocks(p, copies, pull, _PROXIMAL_ROUNDS[k], _PROXIMAL_WEIGHT, z)
        r[:] = copies
        steps, residual = _run_newton(p, r, z, False)
        newton += _PROXIMAL_ROUNDS[k] + steps
        k += 1
    return newton, residual


@kernel
def _run_newton(p: LinkedContacts, r: Array, z: Array, cold: bool) -> tuple[int, float]:
    """Newton's method in place; a polygon is approached from the answer on the ball, except from a good start."""
    before, own = 0, p.own
    if cold and own.faces > 2:
        ball = ContactArrays(own.M, own.q, own.role, own.rho, own.blocks, own.limits, 0, own.normals)
        before, _ = newton_blocks(
            LinkedContacts(p.P, p.W, p.R, p.d, p.S, p.w, ball, p.least), r, z, MAX_BALL_STEPS, BALL_TOLERANCE
        )
    steps, residual = newton_blocks(p, r, z, MAX_NEWTON_STEPS, SOLVE_TOLERANCE * 1e-2)
    return before + steps, residual


@kernel
def solve_sticking_blocks(p: LinkedContacts, apart: Bools, r: Array, z: Array) -> bool:
    """Write the linear solution in which contacts are open where `apart` (n,) and all others stick. Returns whether
    nothing is free then; contacts that cannot give way by themselves cannot be eliminated.
    """
    n, m = len(p.P), len(z)
    split, F, core = LawRows(np.zeros((n, 3, 3)), np.zeros((n, 3, 3))), np.zeros(3 * n), p.w.copy()
    for i in range(n):
        for a in range(3):
            if apart[i]:
                split.A[i, a, a] = 1.0
            else:
                split.C[i, a, a], F[3 * i + a] = 1.0, p.d[3 * i + a]
    dr, dz = np.empty(3 * n), np.empty(m)
    determined = eliminate_contacts(p, split, F, core, dr, dz)
    for k in range(3 * n):
        r[k] = -dr[k]
    for j in range(m):
        z[j] = -dz[j]
    return determined


@kernel
def _unknown_size(r: Array, z: Array) -> float:
    """max(1, largest |x|) of forces and the object's motion: what a residual is measured against."""
    largest = 1.0
    for x in r:
        largest = max(largest, abs(x))
    for j in range(len(z) - 6, len(z)):
        largest = max(largest, abs(z[j]))
    return largest


@kernel
def newton_blocks(p: LinkedContacts, r: Array, z: Array, steps: int, tolerance: float) -> tuple[int, float]:
    """`run_contact_newton` in place, each step by elimination. Returns (steps, ‖F‖ over the size of the unknowns)."""
    n3, m = len(r), len(z)
    y, F, core, g = np.empty(n3), np.empty(n3), np.empty(m), new_subgradient(p.own)
    total = write_motions(p, r, z, y, core) + evaluate_rows(p.own, r, y, F, g)
    relative = np.sqrt(total) / _unknown_size(r, z)
    if relative <= tolerance:
        return 0, relative
    split = LawRows(np.empty((n3 // 3, 3, 3)), np.empty((n3 // 3, 3, 3)))
    dr, dz, r1, z1, recent = np.empty(n3), np.empty(m), np.empty(n3), np.empty(m), np.zeros(LINE_SEARCH_MEMORY)
    for step in range(steps + 1):
        relative = np.sqrt(total) / _unknown_size(r, z)
        if not total < np.inf:
            return step, np.inf
        if relative <= tolerance or step == steps:
            return step, relative
        write_law_rows(p, g, split)
        eliminate_contacts(p, split, F, core, dr, dz)
        recent[step % LINE_SEARCH_MEMORY] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            for k in range(n3):
                r1[k] = r[k] - t * dr[k]
            for j in range(m):
                z1[j] = z[j] - t * dz[j]
            total = write_motions(p, r1, z1, y, core) + evaluate_rows(p.own, r1, y, F, g)
            if total <= (1.0 - 1e-4 * t) * ceiling or t < MIN_STEP_LENGTH:
                break
            t *= 0.5
        r[:] = r1
        z[:] = z1
    return steps, relative


@kernel
def proximal_blocks(p: LinkedContacts, copies: Array, pull: Array, steps: int, weight: float, z: Array) -> None:
    """Steps of ADMM on friction with dilatancy (De Saxcé & Feng, Math. Comput. Model. 28, 1998): forces that meet the
    linear laws and their copies (3n,) in the cones draw each other near, pull (3n,) being what holds them together.
    Both in place; z (m,) is written. Far from any answer they lead to where Newton's method converges.

    weight : of the distance, over each contact's own softness.
    """
    n, m, rho, limits = len(p.P), len(z), p.own.rho, p.own.limits
    split, F = LawRows(np.zeros((n, 3, 3)), np.zeros((n, 3, 3))), np.empty(3 * n)
    dr, dz, t = np.empty(3 * n), np.empty(m), np.empty(3)
    for i in range(n):
        for a in range(3):
            split.A[i, a, a], split.C[i, a, a] = weight / rho[3 * i], 1.0
    for _ in range(steps):
        for i in range(n):
            k, own = 3 * i, weight / rho[3 * i]
            for a in range(3):
                F[k + a] = p.d[k + a] + pull[k + a] - own * copies[k + a]
            F[k] += limits[i] * np.sqrt(pull[k + 1] ** 2 + pull[k + 2] ** 2)
        eliminate_contacts(p, split, F, p.w, dr, dz)
        for i in range(n):
            k, own, mu = 3 * i, weight / rho[3 * i], limits[i]
            for a in range(3):
                pull[k + a] -= own * (_ADMM_RELAXATION * dr[k + a] + (_ADMM_RELAXATION - 1.0) * copies[k + a])
                t[a] = pull[k + a] / own
            push, across = t[0], np.sqrt(t[1] * t[1] + t[2] * t[2])
            share = 1.0
            if across > mu * push:
                push = max((push + mu * across) / (1.0 + mu * mu), 0.0)
                share = mu * push / across if across > 0.0 else 0.0
            copies[k], copies[k + 1], copies[k + 2] = push, share * t[1], share * t[2]
            for a in range(3):
                pull[k + a] -= own * copies[k + a]
    for j in range(m):
        z[j] = -dz[j]
