"""The printed numbers in the paper's own equations: how far they miss each.

    (1)            balance           G_N r_N + G_T r_T = F_ext
    (8)            friction limit    r_T in the polygon of apothem μ cos(π/m) r_N
    (2),(5),(13)   compatibility     Gᵀu + E r = slip; normal: 0 at contact, tangential: against the faces at the limit
    (3),(4)        unilateral        0 ≤ r_N ⟂ ε_N ≥ 0, for the printed object displacement
    (11),(12)      complementarity   slip against the faces that the force is on, for the printed object displacement

Signs are lost in print. Forces get the signs that balance best, displacements those that fit the printed slips best.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import linprog, nnls

from handlcp.check import Array, Bools
from handlcp.grasp import Grasp, PrescribedForce, Pyramid
from handlcp.method.paper.data import PaperTable

# A force counts as on a face within this share of the largest force, which is generous to the printed numbers
LIMIT = 1e-3


@dataclass(frozen=True, slots=True)
class SignedForces:
    """forces (n, 3) N in contact axes with the signs that balance best; force [N] and moment [N·m] left unbalanced.

    recovered : (contact, axis, value) of entries that were not printed and follow from balance.
    """

    forces: Array
    force: float
    moment: float
    recovered: tuple[tuple[int, int, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Motion:
    """The printed object displacement, with the signs and the E_T that fit the printed slips best.

    twist (6,) m, rad about the origin; tangential [m/N]: that E_T; slip_miss [m]: worst miss of the tangential
    equation; slip (n, 2) m and gap (n,) m: ε_T and ε_N that follow, NaN where the force is prescribed.
    """

    twist: Array
    tangential: float
    slip_miss: float
    slip: Array
    gap: Array


def signed_forces(grasp: Grasp, table: PaperTable, read: bool = True) -> SignedForces:
    """Best balance over all signs of the tangential forces; overwritten entries are solved for when `read`."""
    scene = grasp.scene
    printed = np.nan_to_num(table.forces(scene.n, read)).ravel()
    for effect in grasp.effects:
        if isinstance(effect, PrescribedForce):
            printed[3 * effect.contact : 3 * effect.contact + 3] = effect.force
    missing = [3 * i + k for i, k in table.overwritten_entries()] if read else []
    printed[missing] = 0.0
    signed = [i for i in range(len(printed)) if i % 3 != 2 and printed[i] != 0.0]
    choices = np.tile(printed, (2 ** len(signed), 1))
    choices[:, signed] *= np.array(list(product((1.0, -1.0), repeat=len(signed)))).reshape(-1, len(signed))
    G, scale = scene.geometry.grasp_matrix, np.repeat([1.0, 1.0 / scene.units.length], 3)
    if missing:
        left = (choices @ G.T + scene.geometry.wrench) * scale
        choices[:, missing] = -left @ np.linalg.pinv(scale[:, None] * G[:, missing]).T
    left = choices @ G.T + scene.geometry.wrench
    best = int(np.argmin(np.linalg.norm(left * scale, axis=1)))
    f, (force, moment) = choices[best], np.linalg.norm(left[best].reshape(2, 3), axis=1).tolist()
    return SignedForces(f.reshape(-1, 3), force, moment, tuple((i // 3, i % 3, float(f[i])) for i in missing))


def excess(grasp: Grasp, faces: int, forces: Array) -> Array:
    """(n,) N by which each tangential force leaves its inscribed polygon; < 0 inside, NaN where no law governs it."""
    return np.where(_frictional(grasp), -_slack(grasp, faces, forces).min(axis=1), np.nan)


def compatibility(grasp: Grasp, faces: int, forces: Array) -> tuple[float, float]:
    """(miss, largest elastic displacement) [m]: least worst residual of Gᵀu + E r + Nλ = 0 over all twists u and λ ≥ 0.

    Rows are the normals and tangents of fingers whose force is not prescribed. λ may act on the faces at the limit
    (`LIMIT`), also where the force is beyond it. A linear program.
    """
    scene, normals = grasp.scene, Pyramid(faces).normals
    limit = _slack(grasp, faces, forces) <= LIMIT * float(abs(forces).max())
    elastic = scene.flexibility @ forces.ravel()
    frictional = _frictional(grasp)
    rows = np.column_stack([frictional, frictional, scene.governed_mask]).ravel()
    at, face = np.nonzero(limit & frictional[:, None])
    slides = np.zeros((len(at), scene.n, 3))
    slides[np.arange(len(at)), at, :2] = normals.T[face]
    size = float(abs(elastic[rows]).max())
    A = np.column_stack([scene.geometry.grasp_matrix.T, slides.reshape(len(at), 3 * scene.n).T])[rows]
    b, k, one = -elastic[rows] / size, A.shape[1], -np.ones((len(A), 1))
    bounds = [(None, None)] * 6 + [(0.0, None)] * (k - 6 + 1)  # of u, of λ and of the worst residual, which is least
    lp = linprog(np.append(np.zeros(k), 1.0), np.block([[A, one], [-A, one]]), np.append(b, -b), bounds=bounds)
    return float(lp.fun) * size, size


def motion(grasp: Grasp, table: PaperTable, forces: Array, tangentials: tuple[float, ...]) -> Motion:
    """Which signs of the printed displacement, and which E_T, fit the printed slips; and the gaps that follow."""
    scene = grasp.scene
    printed, slips = np.array([x.value for x in table.object]), table.slips(scene.n)
    given, ruled = np.isfinite(slips[:, 0]), scene.governed_mask
    E_N = scene.flexibility.diagonal()[2::3]
    found = []
    for signs in product((1.0, -1.0), repeat=6):
        twist = printed * signs
        point = twist[:3] + np.cross(twist[3:], scene.positions)
        moves = (scene.frames.transpose(0, 2, 1) @ point[:, :, None])[:, :, 0]
        gap = np.where(ruled, moves[:, 2] + E_N * forces[:, 2], np.nan)
        for E_T in tangentials:
            slip = moves[:, :2] + E_T * forces[:, :2]
            miss = float(abs(abs(slip) - slips)[given].max())
            found.append(Motion(twist, E_T, miss, np.where(ruled[:, None], slip, np.nan), gap))
    return min(found, key=lambda m: m.slip_miss)


def against_faces(grasp: Grasp, faces: int, forces: Array, slip: Array) -> float:
    """Worst distance [m] of the slips (n, 2) from -Nλ, λ ≥ 0, over the faces that each force is on (`LIMIT`)."""
    normals, worst = Pyramid(faces).normals, 0.0
    limit = _slack(grasp, faces, forces) <= LIMIT * float(abs(forces).max())
    for i in np.flatnonzero(_frictional(grasp)):
        N = normals[:, limit[i]]
        worst = max(worst, float(nnls(N, -slip[i])[1]) if N.size else float(np.linalg.norm(slip[i])))
    return worst


def _frictional(grasp: Grasp) -> Bools:
    """(n,) bool: whether friction governs the contact: it has some, and its force is not prescribed."""
    return np.asarray(grasp.scene.governed_mask & (grasp.scene.mu > 0))


def _slack(grasp: Grasp, faces: int, forces: Array) -> Array:
    """(n, faces) N from each tangential force to the faces of its inscribed polygon; < 0 beyond a face."""
    pyramid = Pyramid(faces)
    return np.asarray(pyramid.limit(grasp.scene.mu)[:, None] * forces[:, 2:] - forces[:, :2] @ pyramid.normals)
