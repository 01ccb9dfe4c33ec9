"""The active conditions of a solution with soft fingers, as `tangent` has them for points: three tangents, and any
number of faces that a contact slides against.

    sticking    Δv = 0                  sliding     nᵀΔr_t = μ_m Δr_N for each face n, Δv_N = 0,
    separated   Δr = 0                              Δv_t in the span of those normals

(on the ellipsoid slip and force turn together: P Δv_t = -|v_t|/|r_t| P Δr_t, P across the force)
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr

from handlcp.check import Array, Ints
from handlcp.grasp.limit_surface import LimitSurface, limit_surface
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.states import GLIDING, SEPARATED, SLIDING, STICKING, VERTEX, States
from handlcp.lcp.kernels.dense import solve_ranked
from handlcp.tolerances import RANK

__all__ = ["soft_inequalities", "soft_system"]


def soft_system(scene: Scene, section: Section, kind: Ints, states: States, coupling: Array) -> tuple[Array, int]:
    """The square system and its rank; columns Δr (c), Δu (dof), multipliers of couplings, as `tangent_system`."""
    c, dof, extra = scene.components, scene.dof, len(coupling)
    softness = scene.units.force / scene.units.motion
    R = np.eye(c, c + dof + extra)
    V = np.hstack([scene.flexibility * softness, scene.natural.every.T, coupling.T])
    rows = [np.hstack([scene.natural.every, np.zeros((dof, dof + extra))])]
    points = section.limit(scene.mu)
    soft = {i: k for k, i in enumerate(scene.soft)}
    for i in range(scene.n):
        z, k = 3 * i + 2, soft.get(i)
        t = [3 * i, 3 * i + 1] if k is None else scene.soft_index[k].tolist()
        if kind[i] == SEPARATED:
            rows.append(R[[*t, z]])
        elif kind[i] == GLIDING:
            rows += [R[t], V[[z]]]
        elif kind[i] == STICKING:
            rows.append(V[[*t, z]])
        else:
            limit = points[i] if k is None else float(limit_surface(section).limit(scene.mu)[i])
            faces = 2 if kind[i] == VERTEX else 1
            N = states.faces[i, :faces].T if k is None else _independent(states.soft[k])
            across = _across(N)
            rows += [N.T @ R[t] - limit * R[z], V[[z]]]
            turn = states.turn[i] * softness if kind[i] == SLIDING else 0.0
            rows.append(across.T @ (V[t] + turn * R[t]))
    rows.append(np.hstack([coupling, np.zeros((extra, dof + extra))]))
    A = np.vstack(rows)
    largest = abs(A).max(axis=1, keepdims=True)
    A = A / np.where(largest > 0.0, largest, 1.0)
    k = len(A)
    return A, solve_ranked(A.copy(), np.zeros(k), np.zeros(k), np.zeros(k, np.int64), RANK)


def soft_inequalities(
    surface: LimitSurface, mu: float, normals: Array, tangents: Ints, z: int, force: Array, move: Array
) -> tuple[Array, Array]:
    """(rows, now): rows · (Δr, Δu) + now · (r, v) ≥ 0 keeps one soft contact's friction within its limit, and its slip
    against the faces (3, j) `normals`. force, move (c, c + dof): rows of Δr and Δv.
    """
    c, bound = len(force), float(surface.limit(np.array(mu)))
    inside = np.zeros((surface.normals.shape[1], c))
    inside[:, z] = bound
    inside[:, tangents] = -surface.normals.T
    rows, now = [inside @ force], [np.hstack([inside, np.zeros_like(inside)])]
    if normals.shape[1]:
        against = -np.linalg.pinv(_independent(normals))
        rows.append(against @ move[tangents])
        part = np.zeros((len(against), 2 * c))
        part[:, c + tangents] = against
        now.append(part)
    return np.vstack(rows), np.vstack(now)


def _independent(normals: Array) -> Array:
    """(3, j) as many of the normals as are independent."""
    _, R, order = qr(normals, mode="economic", pivoting=True)
    size = abs(np.diagonal(R))
    return np.asarray(normals[:, order[: int((size > 1e-9 * size.max(initial=0.0)).sum())]])


def _across(N: Array) -> Array:
    """(d, d - j) orthonormal basis of what is across the columns of N (d, j)."""
    U, _, _ = np.linalg.svd(N)
    return np.asarray(U[:, N.shape[1] :])
