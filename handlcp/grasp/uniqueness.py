"""What a solution leaves free: loose directions of the object, and forces that equilibrium does not determine.

Around a solution with given contact states the model is linear in the changes Δr, Δu:

    balance     G Δr = 0                        separated   Δr = 0
    sticking    Δv = 0                          sliding     nᵀΔr_T = μ_m Δr_N, Δv_N = 0, Δv_T along the face normal n
    at a vertex nᵀΔr_T = μ_m Δr_N for both faces, Δv_N = 0; the slip may turn within the two faces' normals

with Δv = GᵀΔu + EΔr. It is square; the dimension of its null space is what stays free (paper/model, "Not unique").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.assemble import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.scene import Scene
from handlcp.grasp.states import GLIDING, SEPARATED, SLIDING, VERTEX, States
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.tolerances import RANK

__all__ = ["FreeDirections", "Uniqueness", "describe", "free_directions", "minimum_norm"]


@dataclass(frozen=True, slots=True)
class Uniqueness:
    """What the solution leaves free.

    loose_motions : dimension of the object motions that the contacts, in their present states, do not resist.
    directions : (loose_motions, 6) twists spanning them, unit length in natural units scaled to SI (m, rad), about
        the grasp's reference; a motion is one-sided where it opens or turns a slip.
    forces_determined : whether no other contact forces satisfy the same conditions.
    """

    loose_motions: int
    directions: Array
    forces_determined: bool

    def __str__(self) -> str:
        motion = (
            "object motion determined"
            if not self.loose_motions
            else (
                f"object motion free in {self.loose_motions} direction{'s' if self.loose_motions > 1 else ''} "
                "(the smallest motion is given)"
            )
        )
        return f"forces {'' if self.forces_determined else 'NOT '}determined, {motion}"


@dataclass(frozen=True, slots=True)
class FreeDirections:
    """basis (3n + dof, k): orthonormal changes (Δr, Δu) in natural units that keep every active condition."""

    basis: Array


def free_directions(
    scene: Scene, effects: tuple[Effect, ...], pyramid: Pyramid, states: States, candidate: Candidate
) -> FreeDirections | None:
    """None when the solution is locally unique (decided by elimination, the cheap way), otherwise what is free."""
    G, E = scene.natural.every, scene.flexibility * (scene.units.force / scene.units.motion)
    planar = scene.plane is not None
    limits = scene.mu if planar else pyramid.limit(scene.mu)
    rows = [c for e in effects if (c := e.coupling(scene, candidate.extra)) is not None]
    coupling = np.array(rows).reshape(len(rows), 3 * scene.n)
    kind = np.where(np.array(scene.governed), states.kind, SEPARATED)
    A = _tangent(G, E, kind, states.faces, limits, planar, coupling)
    k = len(A)
    if solve_ranked(A.copy(), np.zeros(k), np.zeros(k), np.zeros(k, np.int64), RANK) == k:
        return None
    _, sv, Vt = np.linalg.svd(A)
    null = Vt[sv <= RANK * sv[0]].T[: 3 * scene.n + scene.dof]
    # Directions of multipliers alone move nothing: drop them, and make the rest orthonormal in (r, u)
    U, s, _ = np.linalg.svd(null, full_matrices=False)
    return FreeDirections(U[:, s > 1e-9]) if (s > 1e-9).any() else None


def describe(scene: Scene, free: FreeDirections | None, to_reference: Array) -> Uniqueness:
    """In SI; to_reference (6, 6) moves twists from the contacts' centre to the grasp's reference."""
    if free is None:
        return Uniqueness(0, np.zeros((0, 6)), True)
    k = 3 * scene.n
    U, s, _ = np.linalg.svd(free.basis[k:], full_matrices=False)
    moving = U[:, s > 1e-9]
    twists = np.array([to_reference @ scene.twist(t) for t in moving.T]).reshape(-1, 6)
    return Uniqueness(moving.shape[1], read_only(twists), bool(abs(free.basis[:k]).max(initial=0.0) < 1e-9))


def minimum_norm(
    scene: Scene, pyramid: Pyramid, states: States, candidate: Candidate, motion: Array, free: FreeDirections
) -> Candidate:
    """The member of least norm (natural units) that keeps every contact in its state; motion (n, 3) as it is now [m].

    min ‖x₀ + B c‖ subject to the inequalities of the states (forces push, gaps stay open, friction within its limit,
    slip against the faces): a least-distance problem, solved as nonnegative least squares (Lawson & Hanson, ch. 23).
    """
    from scipy.optimize import nnls  # half a second of import that only loose scenes should pay

    n, units, B = scene.n, scene.units, free.basis
    u0 = candidate.twist if scene.freedom is None else scene.freedom @ candidate.twist
    x0 = np.concatenate([candidate.forces.ravel() / units.force, u0 / scene.twist_units])
    rows, now = _inequalities(scene, pyramid, states, candidate.forces / units.force, motion / units.motion)
    # With y = c + Bᵀx₀: min ‖y‖ subject to A y ≥ h; rounding in `now` must not shut out the present member
    A = rows @ B
    h = A @ (B.T @ x0) - np.maximum(now, 0.0)
    E, e = np.vstack([A.T, h]), np.zeros(B.shape[1] + 1)
    e[-1] = 1.0
    r = e - E @ nnls(E, e)[0]
    if not r[-1] > 0.0:
        return candidate
    x = x0 + B @ (-r[:-1] / r[-1] - B.T @ x0)
    return Candidate((x[: 3 * n] * units.force).reshape(n, 3), scene.twist(x[3 * n :]), candidate.extra)


def _inequalities(scene: Scene, pyramid: Pyramid, states: States, forces: Array, motion: Array) -> tuple[Array, Array]:
    """(rows, now): now + rows · (Δr, Δu) ≥ 0 keeps every contact in its state; natural units."""
    n, dof = scene.n, scene.dof
    planar = scene.plane is not None
    normals = np.array([[1.0, -1.0], [0.0, 0.0]]) if planar else pyramid.normals
    limits = scene.mu if planar else pyramid.limit(scene.mu)
    force = np.eye(3 * n, 3 * n + dof)
    move = np.hstack([scene.flexibility * (scene.units.force / scene.units.motion), scene.natural.every.T])
    rows: list[Array] = []
    now: list[float] = []
    for i in range(n):
        x, y, z = 3 * i, 3 * i + 1, 3 * i + 2
        kind = states.kind[i]
        if not scene.governed[i]:
            continue
        if kind == SEPARATED:
            rows.append(move[z])
            now.append(motion[i, 2])
            continue
        rows.append(force[z])
        now.append(forces[i, 2])
        if kind != GLIDING:
            for c, s in normals.T:
                rows.append(limits[i] * force[z] - c * force[x] - s * force[y])
                now.append(limits[i] * forces[i, 2] - c * forces[i, 0] - s * forces[i, 1])
        # The slip is -(λ₁n₁ + λ₂n₂) with λ ≥ 0
        if kind == SLIDING:
            c, s = states.faces[i, 0]
            rows.append(-c * move[x] - s * move[y])
            now.append(-c * motion[i, 0] - s * motion[i, 1])
        if kind == VERTEX:
            slip = np.linalg.solve(states.faces[i].T, -np.vstack([move[x], move[y]]))
            rows += list(slip)
            now += np.linalg.solve(states.faces[i].T, -motion[i, :2]).tolist()
    return np.array(rows), np.array(now)


@kernel
def _tangent(G: Array, E: Array, kind: Array, faces: Array, limits: Array, planar: bool, coupling: Array) -> Array:
    """The square system of the module's docstring; columns Δr (3n), Δu (dof), multipliers of active couplings."""
    dof, n, extra = G.shape[0], len(kind), len(coupling)
    k = 3 * n + dof + extra
    A, V = np.zeros((k, k)), np.zeros((3 * n, k))
    A[:dof, : 3 * n] = G
    V[:, : 3 * n] = E
    V[:, 3 * n : 3 * n + dof] = G.T
    for c in range(extra):
        V[:, 3 * n + dof + c] = coupling[c]
        A[dof + 3 * n + c, : 3 * n] = coupling[c]
    for i in range(n):
        x, row = 3 * i, dof + 3 * i
        if kind[i] == 0:
            for d in range(3):
                A[row + d, x + d] = 1.0
        elif kind[i] == 4:
            A[row, x] = A[row + 1, x + 1] = 1.0
            A[row + 2] = V[x + 2]
        elif kind[i] == 1:
            for d in range(3):
                A[row + d] = V[x + d]
        else:
            A[row, x], A[row, x + 1], A[row, x + 2] = faces[i, 0, 0], faces[i, 0, 1], -limits[i]
            A[row + 1] = V[x + 2]
            if kind[i] == 2:
                A[row + 2] = faces[i, 0, 0] * V[x + 1] - faces[i, 0, 1] * V[x]
            else:
                A[row + 2, x], A[row + 2, x + 1], A[row + 2, x + 2] = faces[i, 1, 0], faces[i, 1, 1], -limits[i]
        if planar and kind[i] != 0 and kind[i] != 4:  # nothing acts out of the plane
            out = row + 1 if kind[i] == 1 else row + 2
            A[out] = 0.0
            A[out, x + 1] = 1.0
    for r in range(k):
        largest = 0.0
        for c in range(k):
            largest = max(largest, abs(A[r, c]))
        if largest > 0.0:
            A[r] /= largest
    return A
