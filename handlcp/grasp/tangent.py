"""The changes of forces and object motion that keep every active condition of a solution.

Around a solution with given contact states the model is linear in the changes Δr, Δu:

    balance     G Δr = 0                        separated   Δr = 0
    sticking    Δv = 0                          sliding     nᵀΔr_T = μ_m Δr_N, Δv_N = 0, Δv_T along the face normal n
    gliding     Δr_T = 0, Δv_N = 0              at a vertex nᵀΔr_T = μ_m Δr_N for both faces, Δv_N = 0

(on the exact cone a sliding contact's slip and friction turn together: tᵀΔv_T = -|v_T|/|r_T| tᵀΔr_T)

with Δv = GᵀΔu + EΔr. It is square; what its null space spans stays free (model, "Not unique"). A contact that rests,
touching without force, may either take up force or open: each choice is a branch of its own, with one-sided changes.
So is each choice for an effect's limit that is just reached; one that gives way adds Δv = AᵀΔs and the row A Δr = 0.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.limits import at_answer
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_tangent import soft_inequalities, soft_system
from handlcp.grasp.states import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, VERTEX, States
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.tolerances import RANK

__all__ = ["Branch", "free_branches", "inequalities"]

_MOST_RESTING = 4  # contacts at rest whose 2^k branches are all looked at; beyond that only all-open and all-closed
_FAR = 1e6  # a row that no unit change lifts beyond 1 / _FAR is 0


@dataclass(frozen=True, slots=True)
class Branch:
    """One choice for what is at rest: kind (n,) as in `states`, active (m,) which of the effects' limits give way, and
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
    planar = scene.plane is not None
    limits = section.limit(scene.mu)
    limited = at_answer(scene, effects, candidate)
    governed = states.kind if all(scene.governed) else np.where(scene.governed_mask, states.kind, SEPARATED)
    softness = scene.units.force / scene.units.motion
    out = []
    for kind, active in itertools.product(_choices(governed, limits), limited.choices()):
        if scene.soft:
            A, rank = soft_system(scene, section, kind, states, limited.rows[active])
        else:
            A, rank = tangent_system(
                scene.natural.every, scene.flexibility, softness, kind, states.faces, states.turn, limits, planar,
                limited.rows[active],
            )  # fmt: skip
        if rank == len(A):
            continue
        _, sv, Vt = np.linalg.svd(A)
        # Directions of multipliers alone move nothing: dropped, and the rest made orthonormal in (r, u)
        basis, multipliers = _orthonormal(Vt[sv <= RANK * sv[0]].T, scene.components + scene.dof)
        resting = np.flatnonzero(governed == RESTING)
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


def _choices(kind: Ints, limits: Array) -> list[Ints]:
    if RESTING not in kind.tolist():
        return [kind]
    resting = np.flatnonzero(kind == RESTING)
    closed = np.where(limits > 0, STICKING, GLIDING)
    patterns = itertools.product((False, True), repeat=len(resting))
    if len(resting) > _MOST_RESTING:
        patterns = iter([(False,) * len(resting), (True,) * len(resting)])  # type: ignore[assignment]
    out = []
    for pattern in patterns:
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
    found = linprog(
        np.append(np.zeros(k), -np.ones(rows)),
        A_ub=np.hstack([-D, np.eye(rows)]),
        b_ub=np.zeros(rows),
        bounds=[(-_FAR, _FAR)] * k + [(0.0, 1.0)] * rows,
        method="highs",
    )
    tight = D[:0] if found.x is None else D[found.x[k:] < 0.5]
    if not len(tight):
        return np.eye(k)
    _, sv, Vt = np.linalg.svd(tight)
    return Vt[int((sv > 1e-9).sum()) :].T


def inequalities(
    scene: Scene,
    section: Section,
    kind: Ints,
    states: States,
    forces: Array,
    motion: Array,
    contacts: Ints | None = None,
) -> tuple[Array, Array]:
    """(rows, now): now + rows · (Δr, Δu) ≥ 0 keeps the given contacts (None: all) in their states; forces and motion
    (c,), natural units.
    """
    n, c, dof, faces = scene.n, scene.components, scene.dof, states.faces
    normals, limits = section.normals, section.limit(scene.mu)
    force = np.eye(c, c + dof)
    move = np.hstack([scene.flexibility * (scene.units.force / scene.units.motion), scene.natural.every.T])
    rows: list[Array] = []
    now: list[float] = []
    for i in range(n) if contacts is None else contacts.tolist():
        x, y, z = 3 * i, 3 * i + 1, 3 * i + 2
        if not scene.governed[i]:
            continue
        if kind[i] == SEPARATED:
            rows.append(move[z])
            now.append(motion[z])
            continue
        rows.append(force[z])
        now.append(forces[z])
        if i in scene.soft:
            k = scene.soft.index(i)
            more, room = soft_inequalities(
                limit_surface(section), scene.mu[i], states.soft[k], scene.soft_index[k], z, force, move
            )
            rows += list(more)
            now += (room @ np.append(forces, motion)).tolist()
            continue
        if kind[i] != GLIDING:
            for a, s in normals.T:
                rows.append(limits[i] * force[z] - a * force[x] - s * force[y])
                now.append(limits[i] * forces[z] - a * forces[x] - s * forces[y])
        # The slip is -(λ₁n₁ + λ₂n₂) with λ ≥ 0
        if kind[i] == SLIDING:
            a, s = faces[i, 0]
            rows.append(-a * move[x] - s * move[y])
            now.append(-a * motion[x] - s * motion[y])
        if kind[i] == VERTEX:
            rows += list(np.linalg.solve(faces[i].T, -np.vstack([move[x], move[y]])))
            now += np.linalg.solve(faces[i].T, -motion[x:z]).tolist()
    return np.array(rows).reshape(-1, c + dof), np.array(now)


@kernel
def tangent_system(
    G: Array,
    E: Array,
    softness: float,
    kind: Ints,
    faces: Array,
    turn: Array,
    limits: Array,
    planar: bool,
    coupling: Array,
) -> tuple[Array, int]:
    """The square system of the module's docstring and its rank; columns Δr (3n), Δu (dof), multipliers of couplings."""
    dof, n, extra = G.shape[0], len(kind), len(coupling)
    k = 3 * n + dof + extra
    A, V = np.zeros((k, k)), np.zeros((3 * n, k))
    A[:dof, : 3 * n] = G
    V[:, : 3 * n] = E * softness
    V[:, 3 * n : 3 * n + dof] = G.T
    for c in range(extra):
        V[:, 3 * n + dof + c] = coupling[c]
        A[dof + 3 * n + c, : 3 * n] = coupling[c]
    for i in range(n):
        x, row = 3 * i, dof + 3 * i
        if kind[i] == SEPARATED:
            for d in range(3):
                A[row + d, x + d] = 1.0
        elif kind[i] == GLIDING:
            A[row, x] = A[row + 1, x + 1] = 1.0
            A[row + 2] = V[x + 2]
        elif kind[i] == STICKING:
            for d in range(3):
                A[row + d] = V[x + d]
        else:
            A[row, x], A[row, x + 1], A[row, x + 2] = faces[i, 0, 0], faces[i, 0, 1], -limits[i]
            A[row + 1] = V[x + 2]
            if kind[i] == SLIDING:
                A[row + 2] = faces[i, 0, 0] * V[x + 1] - faces[i, 0, 1] * V[x]
                A[row + 2, x + 1] += turn[i] * softness * faces[i, 0, 0]
                A[row + 2, x] -= turn[i] * softness * faces[i, 0, 1]
            else:
                A[row + 2, x], A[row + 2, x + 1], A[row + 2, x + 2] = faces[i, 1, 0], faces[i, 1, 1], -limits[i]
        if planar and kind[i] != SEPARATED and kind[i] != GLIDING:  # nothing acts out of the plane
            out = row + 1 if kind[i] == STICKING else row + 2
            A[out] = 0.0
            A[out, x + 1] = 1.0
    for r in range(k):
        largest = 0.0
        for c in range(k):
            largest = max(largest, abs(A[r, c]))
        if largest > 0.0:
            A[r] /= largest
    rank = solve_ranked(A.copy(), np.zeros(k), np.zeros(k), np.zeros(k, np.int64), RANK)
    return A, rank
