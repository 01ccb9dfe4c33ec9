"""Holdability: is there any contact force within friction that balances the load? Compliance plays no part.

If not, a twist t proves it (Farkas): every force the contacts can exert does work ≥ 0 on t, and so does the load, > 0.
The object escapes along t, and no contact resists.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.tolerances import CERTIFY

__all__ = ["escaping_twist", "is_escape", "load_to_balance"]


def escaping_twist(scene: Scene, section: Section, load: Array) -> Array | None:
    """(6,) certified motion about the contacts' centre in which the object escapes, for one metre of travel.

    load : (dof,) wrench in natural units, prescribed forces included. None: some force in the pyramids balances it.

    t = load + W a with the a ≥ 0 that makes it smallest: what is left of the load when the fingers do all they can. By
    the optimality of a, Wᵀt ≥ 0 and load·t = |t|², so t is the proof as well as the direction in which the object
    goes. The point is then checked by its signs alone.
    """
    from scipy.optimize import linprog, nnls  # half a second of import that only a failed solve should pay

    W = _generators(scene, section)
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
            load += scene.natural.every[:, 3 * e.contact : 3 * e.contact + 3] @ (e.force / scene.units.force)
    return load


def is_escape(scene: Scene, section: Section, load: Array, twist: Array) -> bool:
    """Whether twist (dof,), natural units, proves that nothing balances `load`: signs recomputed, no solver involved.

    The gain must exceed what the resisting work could hide: forces of a thousand times the load.
    """
    W = _generators(scene, section)
    if not np.isfinite(twist).all():
        return False
    resisting = float(np.minimum(W.T @ twist, 0.0).sum()) if W.size else 0.0
    size = float(np.sqrt(load @ load) * np.sqrt(twist @ twist))
    return float(load @ twist) > CERTIFY * size and float(load @ twist) > -1e3 * resisting


def _generators(scene: Scene, section: Section) -> Array:
    """(dof, g) wrenches of the edges of all friction pyramids (of the normals where there is no friction)."""
    edges, limits = section.edges, section.limit(scene.mu)
    G = scene.natural.every.reshape(scene.dof, scene.n, 3)
    out = []
    for i in range(scene.n):
        if not scene.governed[i]:
            continue
        r = (
            np.array([[0.0], [0.0], [1.0]])
            if limits[i] <= 0
            else np.vstack([limits[i] * edges, np.ones(edges.shape[1])])
        )
        out.append(G[:, i] @ r)
    return np.hstack(out) if out else np.zeros((scene.dof, 0))
