"""Solutions of these equations where they leave something open, and forces where nothing slips."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.tangent.active_set import Laws, saddle

_CONSISTENT = 1e-8  # of a right-hand side: what is missed by less is met
_OPEN = 1e-10  # of the largest singular value: forces and motions that smaller ones determine are left open


def laws_of(scene: Scene, limits: Array, rows: Array, gives: Bools) -> Laws:
    """Of a grasp, its motions about the contacts' centre. limits (n,) : of the friction sets. rows (m, c) : of limits,
    natural units; gives (m,) : those that give way.
    """
    softness = scene.units.force / scene.units.motion
    K = saddle(scene.flexibility, softness, scene.natural.every, rows)
    kept = np.concatenate([np.zeros(scene.components, bool), np.ones(scene.dof, bool), gives])
    return Laws(K, kept, scene.kind.contact_components, limits, softness)


def smallest(A: Array, b: Array, rank: float) -> tuple[Array, Array]:
    """(x, N): the smallest x (k, p) with A x = b, NaN in columns without one, and what spans A's null space (k, j).

    rank : singular values below this share of the largest count as zero.
    """
    U, s, Vt = np.linalg.svd(A)
    count = int((s > rank * s[0]).sum())
    x = Vt[:count].T @ ((U[:, :count].T @ b) / s[:count, None])
    size = np.maximum(abs(b).max(axis=0, initial=0.0), 1e-300)
    x[:, abs(U[:, count:].T @ b).max(axis=0, initial=0.0) > _CONSISTENT * size] = np.nan
    return x, Vt[count:].T


def without_slip(scene: Scene, flexibility: Array, offsets: Array, loads: Array) -> tuple[Array, Array]:
    """(c, m) forces in the laws' coordinates [N], and (6, m) twists of the object about the contacts' centre, of a
    grasp in which nothing slips and nothing opens: linear in offsets and loads.

        E r + Gᵀ u = -d,    G r = -w

    Where these equations leave something open, the smallest answer is taken; where they have none, the nearest.

    flexibility (c, c), offsets (c, m) [m] : in the laws' coordinates. loads (6, m) : about the contacts' centre.
    """
    index, posed = scene.kind.index, scene.geometry
    e0 = float(np.diagonal(scene.flexibility).mean()) or 1.0
    rows = scene.freedom / np.repeat([1.0, posed.length], 3)
    E, G = flexibility[np.ix_(index, index)], rows @ posed.grasp_matrix[:, index]
    K = saddle(E, 1.0 / e0, G, np.zeros((0, len(index))))
    answer = np.linalg.lstsq(K, -np.vstack([offsets[index] / e0, rows @ loads]), rcond=_OPEN)[0]
    forces = np.zeros((scene.components, offsets.shape[1]))
    forces[index] = answer[: len(index)]
    return forces, np.asarray(e0 * (rows.T @ answer[len(index) :]))
