"""Holdability: is there any contact force within friction that balances the load? Compliance plays no part.

If not, a twist t proves it (Farkas): every force the contacts can exert does work ≥ 0 on t, and so does the load, > 0.
The object escapes along t, and no contact resists.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.tolerances import CERTIFY

__all__ = ["escaping_twist", "generators", "is_escape", "jammed", "least_total", "load_to_balance"]


def escaping_twist(scene: Scene, section: Section, load: Array) -> Array | None:
    """(6,) certified motion about the contacts' centre in which the object escapes, for one metre of travel.

    load : (dof,) wrench in natural units, prescribed forces included. None: some force in the pyramids balances it.

    t = load + W a with the a ≥ 0 that makes it smallest: what is left of the load when the fingers do all they can. By
    the optimality of a, Wᵀt ≥ 0 and load·t = |t|², so t is the proof as well as the direction in which the object
    goes. The point is then checked by its signs alone.
    """
    from scipy.optimize import linprog, nnls  # half a second of import that only a failed solve should pay

    _, W = generators(scene, section)
    if not W.size:
        W = np.zeros((scene.dof, 1))
    t = load + W @ nnls(W, -load)[0]
    if not is_escape(scene, section, load, t):
        # Generators that depend on each other can stop nnls early; the vertex of a linear program is exact, if crooked
        lp = linprog(-load, A_ub=-W.T, b_ub=np.zeros(W.shape[1]), bounds=[(-1.0, 1.0)] * scene.dof, method="highs")
        if lp.x is None or not is_escape(scene, section, load, lp.x):
            return None
        t = lp.x
    size = float(np.sqrt(t @ t))
    return read_only(scene.twist(t / size) / scene.units.motion)


def load_to_balance(scene: Scene, effects: tuple[Effect, ...]) -> Array:
    """(dof,) natural wrench that the governed contacts must balance: the load and prescribed forces."""
    load = scene.natural.w.copy()
    for e in effects:
        if isinstance(e, PrescribedForce):
            load += scene.natural.every[:, 3 * e.contact : 3 * e.contact + 3] @ (
                scene.lawful_at(e.contact, e.force) / scene.units.force
            )
    return load


def is_escape(scene: Scene, section: Section, load: Array, twist: Array) -> bool:
    """Whether twist (dof,), natural units, proves that nothing balances `load`: signs recomputed, no solver involved.

    The gain must exceed what the resisting work could hide: forces of a thousand times the load.
    """
    _, W = generators(scene, section)
    if not np.isfinite(twist).all():
        return False
    resisting = float(np.minimum(W.T @ twist, 0.0).sum()) if W.size else 0.0
    size = float(np.sqrt(load @ load) * np.sqrt(twist @ twist))
    return float(load @ twist) > CERTIFY * size and float(load @ twist) > -1e3 * resisting


def least_total(scene: Scene, section: Section, load: Array) -> float | None:
    """Least sum of the fingers' unknown normal forces [N] with which forces within friction balance the load (dof,),
    natural units; None where none do.
    """
    from scipy.optimize import linprog

    F, W = generators(scene, section)
    if not W.size:
        return None
    normals = F[2 : 3 * (scene.n - scene.environment) : 3]  # each generator has a normal force of one, its finger's
    lp = linprog(normals.sum(axis=0), A_eq=W, b_eq=-load, method="highs")
    return None if lp.x is None else float(lp.fun) * scene.units.force


def jammed(scene: Scene) -> bool:
    """Whether rigid fingers overlap the object wherever it goes: no small motion of it opens all gaps."""
    if scene.flexible or not len(scene.normal_index):
        return False
    from scipy.optimize import linprog

    G, d = scene.natural.G[:, : scene.natural.split], scene.natural.d[: scene.natural.split]
    # The widest least gap g: gaps Gᵀu + d ≥ g
    A = np.column_stack([-G.T, np.ones(len(d))])
    size = float(abs(d).max())
    free: list[tuple[float | None, float | None]] = [(None, None)] * scene.dof
    lp = linprog(np.append(np.zeros(scene.dof), -1.0), A_ub=A, b_ub=d, bounds=[*free, (None, size)], method="highs")
    return lp.x is not None and float(lp.x[-1]) < -CERTIFY * size


def generators(scene: Scene, section: Section) -> tuple[Array, Array]:
    """(c, g) forces along the edges of all friction pyramids (the normals where there is no friction), each with a
    normal force of one, contact axes; and their (dof, g) wrenches.
    """
    edges, limits = section.edges, section.limit(scene.mu)
    parts = []
    for i in range(scene.n):
        if not scene.governed[i]:
            continue
        if i in scene.soft:
            k, surface = scene.soft.index(i), limit_surface(section)
            part = np.zeros((scene.components, surface.vertices.shape[1]))
            part[scene.soft_index[k]] = surface.limit(scene.mu)[i] * surface.vertices
            part[3 * i + 2] = 1.0
            parts.append(part)
            continue
        r = np.ones((1, 1)) if limits[i] <= 0 else np.vstack([limits[i] * edges, np.ones(edges.shape[1])])
        part = np.zeros((scene.components, r.shape[1]))
        part[3 * i + 3 - len(r) : 3 * i + 3] = r
        parts.append(part)
    forces = np.hstack(parts) if parts else np.zeros((scene.components, 0))
    return forces, scene.natural.every @ forces
