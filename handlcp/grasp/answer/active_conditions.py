"""The changes of forces and object motion that keep every active condition of a solution.

Around a solution with given contact states the model is linear in the changes Δr, Δu, with Δv = GᵀΔu + EΔr:

    balance     G Δr = 0                        sticking    Δv = 0
    separated   Δr = 0                          gliding     Δr_T = 0, Δv_N = 0
    sliding     nᵀΔr_T = μ_m Δr_N for each face n that it slides against, Δv_N = 0, Δv_T in the span of those n

(on a round set a sliding contact's slip and friction turn together: P Δv_T = -|v_T|/|r_T| P Δr_T, P across the force)

The system is square; what its null space spans stays free. A contact that rests, touching without
force, may either begin to push or open: each choice is a branch of its own, with one-sided changes. So is each choice
for an effect's limit that is just reached; one that gives way adds Δv = AᵀΔs and the row A Δr = 0.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section, limit_set
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.contact_states import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, States, complement
from handlcp.grasp.verify.judge import limits_at_answer
from handlcp.lcp.kernels.dense import kernel, solve_ranked
from handlcp.tolerances import RANK

_MOST_RESTING = 4  # contacts at rest whose 2^k branches are all looked at; beyond that only all-open and all-closed
_FAR = 1e6  # bound of the linear program's unknowns; a condition that stays below 1 / _FAR within it is always active


@dataclass(frozen=True, slots=True)
class Branch:
    """One choice for what is at rest: kind (n,) as in `States`, active (m,) which of the effects' limits give way, and
    basis (c + dof, k), orthonormal changes (Δr, Δu) in natural units, k ≥ 1. multipliers (active.sum(), k): the Δs
    that go with them.
    """

    kind: Ints
    active: Bools
    basis: Array
    multipliers: Array


def free_branches(
    scene: Scene, effects: tuple[Effect, ...], section: Section, states: States, candidate: Candidate
) -> tuple[Branch, ...]:
    """The branches that leave something free; none when the solution is locally unique (decided by elimination)."""
    limits, limited = scene.limits(section), limits_at_answer(scene, effects, candidate)
    contacts, softness, out = scene.kind.contact_components, scene.units.force / scene.units.motion, []
    for kind, active in itertools.product(_choices(scene, states.kind), limited.choices()):
        A, rank = active_system(
            scene.natural.every, scene.flexibility, softness, contacts, states._replace(kind=kind), limits,
            limited.rows[active],
        )  # fmt: skip
        if rank == len(A):
            continue
        _, sv, Vt = np.linalg.svd(A)
        # Directions of multipliers alone move nothing: dropped, and the rest made orthonormal in (r, u)
        basis, multipliers = _orthonormal(Vt[sv <= RANK * sv[0]].T, scene.components + scene.dof)
        resting = np.flatnonzero(states.kind == RESTING)
        if (len(resting) or limited.resting.any()) and basis.shape[1]:
            nothing = np.zeros(scene.components)
            D, _ = inequalities(scene, section, kind, states, nothing, nothing, resting)
            # Rows of a friction beyond measure are as long as it is; only their directions matter
            D = D / abs(D).max(axis=1, keepdims=True) @ basis
            at_limits, _ = limited.conditions(basis, active, multipliers)
            span = _span(np.vstack([D, at_limits[limited.resting]]))
            basis, multipliers = basis @ span, multipliers @ span
        if basis.shape[1]:
            out.append(Branch(kind, active, basis, multipliers))
    return tuple(out)


def _choices(scene: Scene, kind: Ints) -> list[Ints]:
    """The states with contacts at rest closed or open, in every way."""
    resting, out = np.flatnonzero(kind == RESTING), []
    closed = np.where(np.array(scene.kind.tangents) > 0, STICKING, GLIDING)
    every = resting if len(resting) <= _MOST_RESTING else resting[:1]  # or all alike
    for pattern in itertools.product((False, True), repeat=len(every)):
        choice = kind.copy()
        choice[resting] = np.where(pattern, closed[resting], SEPARATED)
        out.append(choice)
    return out


def _orthonormal(columns: Array, k: int) -> tuple[Array, Array]:
    """An orthonormal basis of the first k rows, and the other rows that go with it."""
    U, s, Wt = np.linalg.svd(columns[:k], full_matrices=False)
    kept = s > 1e-9
    basis = U[:, kept]
    return basis, columns[k:] @ Wt[kept].T / s[kept] if len(columns) > k else np.empty((0, basis.shape[1]))


def _span(D: Array) -> Array:
    """(k, j) orthonormal basis of the span of the cone {c : D c ≥ 0}, D (rows, k).

    One linear program finds every row that is 0 throughout: the largest Σ t with D c ≥ t, 0 ≤ t ≤ 1, has t = 1 for the
    others, because the cone holds the sum of its members. Without an answer no row is called 0.
    """
    from scipy.optimize import linprog  # half a second of import that only degenerate, loose scenes should pay

    D = D[abs(D).max(axis=1) > 1e-9]
    rows, k = D.shape
    bounds = [(-_FAR, _FAR)] * k + [(0.0, 1.0)] * rows
    most, within = np.append(np.zeros(k), -np.ones(rows)), np.hstack([-D, np.eye(rows)])
    found = linprog(most, within, np.zeros(rows), bounds=bounds, method="highs").x
    _, sv, Vt = np.linalg.svd(D[:0] if found is None else D[found[k:] < 0.5])
    return Vt[int((sv > 1e-9).sum()) :].T


def inequalities(
    scene: Scene, section: Section, kind: Ints, states: States, forces: Array, motion: Array, contacts: Ints
) -> tuple[Array, Array]:
    """(rows, now): now + rows · (Δr, Δu) ≥ 0 keeps these contacts in their states; forces and motion (c,), natural
    units.
    """
    c, limits = scene.components, scene.limits(section)
    force = np.eye(c, c + scene.dof)
    move = np.hstack([scene.flexibility * (scene.units.force / scene.units.motion), scene.natural.every.T])
    rows, now = [np.zeros((0, c + scene.dof))], [np.zeros(0)]
    for i in contacts.tolist():
        z, *own = scene.kind.contact_components[i].tolist()
        t = own[: scene.kind.tangents[i]]
        if z < 0:
            continue
        rows.append((move if kind[i] == SEPARATED else force)[[z]])
        now.append((motion if kind[i] == SEPARATED else forces)[[z]])
        if kind[i] == SEPARATED:
            continue
        if kind[i] != GLIDING and t:
            outward = limit_set(section, len(t)).normals.T
            rows.append(limits[i] * force[z] - outward @ force[t])
            now.append(limits[i] * forces[z] - outward @ forces[t])
        if kind[i] == SLIDING:  # the slip is -Σ λ n with λ ≥ 0
            against = -np.linalg.pinv(states.faces[i, : states.against[i], : len(t)].T)
            rows.append(against @ move[t])
            now.append(against @ motion[t])
    return np.concatenate(rows), np.concatenate(now)


@kernel
def active_system(
    G: Array, E: Array, softness: float, contacts: Ints, states: States, limits: Array, coupling: Array
) -> tuple[Array, int]:
    """The square system of the module's docstring and its rank; columns Δr (c), Δu (dof), multipliers of couplings.

    G (dof, c) natural, E (c, c) SI and softness: what makes it natural. contacts (n, 4) : as in `contact_laws`.
    coupling (m, c) : natural rows of the limits that give way.
    """
    dof, c, extra = G.shape[0], G.shape[1], len(coupling)
    k = c + dof + extra
    # The contacts' rows come first: a finger's meet few columns but its own, so that elimination finds many zeros
    A, V = np.zeros((k, k)), np.empty((c, k))
    for i in range(c):
        for j in range(c):
            V[i, j] = E[i, j] * softness
        for j in range(dof):
            V[i, c + j] = A[c + j, i] = G[j, i]
    for e in range(extra):
        V[:, c + dof + e] = coupling[e]
        A[dof + c + e, :c] = coupling[e]
    across = np.zeros((3, 3))
    for i in range(len(contacts)):
        z, d, kind = 3 * i + 2, 0, states.kind[i]
        A[z - 2, z - 2] = A[z - 1, z - 1] = 1.0  # what is no tangent carries nothing
        while d < 3 and contacts[i, d + 1] >= 0:
            d += 1
        held = contacts[i, 0] < 0 or kind == SEPARATED
        if held:
            A[z, z] = 1.0
        else:
            A[z] = V[z]
        count = states.against[i] if kind == SLIDING else 0
        if kind == SLIDING:
            complement(states.faces[i], count, d, across)
        for a in range(d):
            j = contacts[i, a + 1]
            if held or kind == GLIDING:
                A[j, j] = 1.0
            elif kind == STICKING:
                A[j] = V[j]
            elif a < count:
                A[j, z] = -limits[i]
                for b in range(d):
                    A[j, contacts[i, b + 1]] = states.faces[i, a, b]
            else:
                A[j, j] = 0.0
                for b in range(d):
                    A[j] += across[a - count, b] * V[contacts[i, b + 1]]
                for b in range(d):
                    A[j, contacts[i, b + 1]] += states.turn[i] * softness * across[a - count, b]
    for row in A:
        largest = 0.0
        for value in row:
            largest = max(largest, abs(value))
        if largest > 0.0:
            for j in range(k):
                row[j] /= largest
    return A, solve_ranked(A.copy(), np.zeros(k), np.empty(k), np.empty(k, np.int64), RANK)
