"""The linear equations that changes of an answer obey, compiled.

While every contact stays in its state, changes (Δr, Δu, Δs) of forces, object motion and yielding limits obey

    balance    G Δr = -δb                 V Δ = GᵀΔu + E Δr + AᵀΔs, the change of v but for δv
    separated  Δr = 0                     sticking   V Δ = -δv
    sliding    nᵀΔr_T - μ Δr_N = δμ r_N for each face n that it slides against, V_N Δ = -δv_N, and across these faces
               P V_T Δ + α P Δr_T = -P δv_T  (on a round set friction and slip turn together, v_T = -α r_T; else α = 0)
    limits     A Δr = δb_s - δA r         for those that give way

δv, δb, δμ, δA and δb_s are what a parameter changes in each law while forces and motion stay. The right-hand sides are
unit vectors here, so that one elimination serves all parameters. Source: the implicit function theorem; Robinson,
Mathematics of Operations Research 5 (1980), for the one-sided case.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.grasp_matrix import wrench_map
from handlcp.grasp.verify.contact_laws import Friction
from handlcp.grasp.verify.contact_states import (
    GLIDING,
    RESTING,
    SEPARATED,
    SLIDING,
    STICKING,
    States,
    complement,
    find_states,
)
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import RANK


@kernel
def respond(
    positions: Array, frames: Array, spin: Array, E: Array, offset: Array, tangent: Array, freedom: Array,
    reference: Array, forces: Array, twist: Array, contacts: Ints, friction: Friction, coupling: Array, sizes: Array,
) -> tuple[Array, Array, Ints, Ints, Array, Array, Ints, Array, bool]:  # fmt: skip
    """(G, v, kind, against, faces, turn, edge, X, regular): `stand`, and X (c + dof + m, c + dof + n + m) the changes
    in natural units that unit right-hand sides cause, ordered as in `active_rows`; regular : whether they are unique.

    sizes (5,) : natural units of force, motion and length; `weak` and `slow` of `find_states`. coupling (m, c) :
    natural rows of the limits that give way.
    """
    G, v, states, edge = stand(
        positions, frames, spin, E, offset, reference, forces, twist, contacts, friction, sizes[3], sizes[4]
    )
    A, B = active_rows(G, tangent, freedom, contacts, states, friction.limits, coupling, sizes)
    regular = eliminated(A, B)
    return G, v, states.kind, states.against, states.faces, states.turn, edge, B, regular


@kernel
def stand(
    positions: Array, frames: Array, spin: Array, E: Array, offset: Array, reference: Array, forces: Array,
    twist: Array, contacts: Ints, friction: Friction, weak: float, slow: float,
) -> tuple[Array, Array, States, Ints]:  # fmt: skip
    """(G, v, states, edge): G (6, c) about the reference, v (c,) as the certifier has it, the contacts' states, and
    edge (n,): 1 where a contact rests, or sticks at its limit, so that its next state depends on the change.
    """
    G, c = wrench_map(positions, reference, frames, spin), len(forces)
    v = offset.copy()
    for i in range(c):
        for k in range(6):
            v[i] += G[k, i] * twist[k]
        for j in range(c):
            v[i] += E[i, j] * forces[j]
    states = find_states(contacts, friction, forces, v, weak, slow)
    edge = np.zeros(len(contacts), np.int64)
    for i in range(len(contacts)):
        if contacts[i, 0] < 0:
            continue
        if states.kind[i] == RESTING:
            edge[i] = 1
        elif states.kind[i] == STICKING:
            spare = friction.limits[i] * forces[3 * i + 2] - _reach(contacts[i], friction, forces)
            if spare <= weak:
                edge[i] = 1
    return G, v, states, edge


@kernel
def _reach(own: Ints, friction: Friction, forces: Array) -> float:
    """The length of a contact's friction force, or the largest component across a face [N]."""
    r, d = np.zeros(3), 0
    while d < 3 and own[d + 1] >= 0:
        r[d] = forces[own[d + 1]]
        d += 1
    if d == 1:
        return float(abs(r[0]))
    if friction.faces == 0:
        return float(np.sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]))
    reach = 0.0
    if d == 2:
        for j in range(friction.faces):
            a = 2.0 * np.pi * j / friction.faces
            reach = max(reach, np.cos(a) * r[0] + np.sin(a) * r[1])
        return float(reach)
    for normal in friction.normals:
        reach = max(reach, normal[0] * r[0] + normal[1] * r[1] + normal[2] * r[2])
    return float(reach)


@kernel
def active_rows(
    G: Array, E: Array, freedom: Array, contacts: Ints, states: States, limits: Array, coupling: Array, sizes: Array
) -> tuple[Array, Array]:
    """(A, B) of A x = B b in natural units: x = (Δr, Δu, Δs), b = (δv (c,), δb (dof,), δμ r_N (n,), limits' (m,)).

    G (6, c) SI, E (c, c) SI: ∂v/∂r. freedom (dof, 6) as in `Scene`. states : RESTING counts as separated.
    """
    force, motion, length = sizes[0], sizes[1], sizes[2]
    dof, c, n, m = len(freedom), len(E), len(contacts), len(coupling)
    k = c + dof + m
    A, B, V, softness = np.zeros((k, k)), np.zeros((k, k + n)), np.empty((c, k)), force / motion
    for i in range(dof):
        B[c + i, c + i] = -1.0
        for j in range(c):
            total = 0.0
            for a in range(6):
                total += freedom[i, a] * G[a, j] / (length if a >= 3 else 1.0)
            V[j, c + i] = A[c + i, j] = total
    for i in range(c):
        for j in range(c):
            V[i, j] = E[i, j] * softness
        for e in range(m):
            V[i, c + dof + e] = coupling[e, i]
    for e in range(m):
        A[c + dof + e, :c] = coupling[e]
        B[c + dof + e, c + dof + n + e] = 1.0
    across = np.zeros((3, 3))
    for i in range(n):
        z, d, kind = 3 * i + 2, 0, states.kind[i]
        A[z - 2, z - 2] = A[z - 1, z - 1] = 1.0  # what is no tangent carries nothing
        while d < 3 and contacts[i, d + 1] >= 0:
            d += 1
        held = contacts[i, 0] < 0 or kind in (SEPARATED, RESTING)
        if held:
            A[z, z] = 1.0
        else:
            A[z] = V[z]
            B[z, z] = -1.0
        count = states.against[i] if kind == SLIDING else 0
        if kind == SLIDING:
            complement(states.faces[i], count, d, across)
        for a in range(d):
            j = contacts[i, a + 1]
            A[j, j] = 0.0
            if held or kind == GLIDING:
                A[j, j] = 1.0
            elif kind == STICKING:
                A[j] = V[j]
                B[j, j] = -1.0
            elif a < count:
                A[j, z] = -limits[i]
                B[j, c + dof + i] = 1.0
                for b in range(d):
                    A[j, contacts[i, b + 1]] += states.faces[i, a, b]
            else:
                for b in range(d):
                    A[j] += across[a - count, b] * V[contacts[i, b + 1]]
                    B[j, contacts[i, b + 1]] = -across[a - count, b]
                for b in range(d):
                    A[j, contacts[i, b + 1]] += states.turn[i] * softness * across[a - count, b]
    for i in range(k):
        largest = 0.0
        for value in A[i]:
            largest = max(largest, abs(value))
        if largest > 0.0:
            A[i] /= largest
            B[i] /= largest
    return A, B


@kernel
def eliminated(A: Array, B: Array) -> bool:
    """Overwrite B with A⁻¹ B by Gauss and Jordan with row pivoting; False where a pivot is as good as none."""
    k, width = len(A), B.shape[1]
    for s in range(k):
        p, best = s, abs(A[s, s])
        for i in range(s + 1, k):
            if abs(A[i, s]) > best:
                p, best = i, abs(A[i, s])
        if best <= RANK:
            return False
        if p != s:
            for j in range(s, k):
                A[s, j], A[p, j] = A[p, j], A[s, j]
            for j in range(width):
                B[s, j], B[p, j] = B[p, j], B[s, j]
        pivot = 1.0 / A[s, s]
        top, right = A[s, s + 1 :], B[s]
        for j in range(len(top)):
            top[j] *= pivot
        for j in range(width):
            right[j] *= pivot
        for i in range(k):
            f = A[i, s]
            if i != s and f != 0.0:
                row, other = A[i, s + 1 :], B[i]
                for j in range(len(top)):
                    row[j] -= f * top[j]
                for j in range(width):
                    other[j] -= f * right[j]
    return True
