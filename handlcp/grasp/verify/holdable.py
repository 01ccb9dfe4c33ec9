"""Holdability: is there any contact force within friction that balances the load? Compliance plays no part.

If not, a twist t proves it (Farkas): every force the contacts can exert does work ≥ 0 on t, and so does the load, > 0.
The object escapes along t, and no contact resists.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section, limit_set
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.contact_states import BALANCED, ESCAPES, find_escape
from handlcp.grasp.verify.judge import every_limit, stacked
from handlcp.tolerances import CERTIFY


def escaping_twist(scene: Scene, section: Section) -> Array | None:
    """(6,) certified motion about the contacts' centre in which the object escapes, for one metre of travel.

    None: some force in the friction pyramids balances the load, or no proof was found that none does.
    """
    t = np.zeros(scene.dof)
    own, every = scene.kind.contact_components, scene.natural.every
    found = find_escape(every, scene.natural.w, own, scene.limits(section), section.faces, t)
    if found == BALANCED:
        return None
    return escape_of(scene, t) if found == ESCAPES else _vertex(scene, section)


def escape_of(scene: Scene, t: Array) -> Array:
    """(6,) the motion t (dof,), natural units, in SI, for one metre of travel."""
    return read_only(scene.twist(t / float(np.sqrt(t @ t))) / scene.units.motion)


def _vertex(scene: Scene, section: Section) -> Array | None:
    """A linear program's vertex keeps every sign, but is an arbitrary one of the motions in which it escapes."""
    from scipy.optimize import linprog  # half a second of import that few failed solves should pay

    load, (_, W) = scene.natural.w, generators(scene, section)
    W = W if W.size else np.zeros((scene.dof, 1))
    lp = linprog(-load, A_ub=-W.T, b_ub=np.zeros(W.shape[1]), bounds=[(-1.0, 1.0)] * scene.dof, method="highs")
    return escape_of(scene, lp.x) if lp.x is not None and is_escape(scene, section, lp.x) else None


def is_escape(scene: Scene, section: Section, proof: Array, effects: tuple[Effect, ...] = ()) -> bool:
    """Whether a twist t (dof,), natural units, proves that nothing balances the load; or t and, behind it, motions y of
    the effects' limits, that nothing within those does (`limit_load`). Signs recomputed, no solver involved.

    The gain must exceed what the resisting work could hide: forces of a thousand times the load.
    """
    rows, room = stacked(scene, every_limit(scene, effects))
    load, (F, W) = scene.natural.w, generators(scene, section)
    if proof.shape != (scene.dof + len(room),) or not np.isfinite(proof).all():
        return False
    t, y = np.split(proof, [scene.dof])
    resisting = float(np.minimum(W.T @ t + (rows @ F).T @ y, 0.0).sum() + 1e3 * np.minimum(y, 0.0).sum())
    gain = float(load @ t - room @ y)
    size = float(np.sqrt(load @ load) * np.sqrt(t @ t) + abs(room) @ abs(y))
    return gain > CERTIFY * size and gain > -1e3 * resisting


def least_total(scene: Scene, section: Section) -> float | None:
    """Least sum of the fingers' unknown normal forces [N] with which friction balances the load; None: none does."""
    from scipy.optimize import linprog

    F, W = generators(scene, section)
    if not W.size:
        return None
    normals = F[2 : 3 * (scene.n - scene.environment) : 3]  # each generator has a normal force of one, its finger's
    lp = linprog(normals.sum(axis=0), A_eq=W, b_eq=-scene.natural.w, method="highs")
    return None if lp.x is None else float(lp.fun) * scene.units.force


def jammed(scene: Scene) -> bool:
    """Whether rigid fingers overlap the object wherever it goes: no small motion of it opens all gaps."""
    m = len(scene.kind.normal_index)
    if scene.kind.flexible or not m:
        return False
    from scipy.optimize import linprog

    G, d = scene.natural.G[:, :m], scene.natural.d[:m]
    # The widest least gap g: gaps Gᵀu + d ≥ g
    A = np.column_stack([-G.T, np.ones(len(d))])
    size = float(abs(d).max())
    free: list[tuple[float | None, float | None]] = [(None, None)] * scene.dof
    lp = linprog(np.append(np.zeros(scene.dof), -1.0), A_ub=A, b_ub=d, bounds=[*free, (None, size)], method="highs")
    return lp.x is not None and float(lp.x[-1]) < -CERTIFY * size


def generators(scene: Scene, section: Section) -> tuple[Array, Array]:
    """(c, g) forces along the edges of all friction pyramids (the normals where there is no friction), each with a
    normal force of one; and their (dof, g) wrenches.
    """
    limits, parts = scene.limits(section), []
    for own, tangents, limit in zip(scene.kind.contact_components, scene.kind.tangents, limits, strict=True):
        if own[0] < 0:
            continue
        edges = limit * limit_set(section, tangents).vertices if tangents else np.zeros((0, 1))
        part = np.zeros((scene.components, edges.shape[1]))
        part[own[1 : 1 + tangents]], part[own[0]] = edges, 1.0
        parts.append(part)
    forces = np.hstack(parts) if parts else np.zeros((scene.components, 0))
    return forces, scene.natural.every @ forces
