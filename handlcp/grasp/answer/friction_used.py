"""How much of its friction a contact uses.

    used = |r̂_T| / (μ r_N)        margin = μ r_N - |r̂_T|

r̂_T are the tangential forces in the coordinates of the friction law (`grasp/friction/law.py`), the moment of a soft
finger among them, so that used = 1 is the limit of every law.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.model.scene import Scene


def friction_used(scene: Scene, forces: Array, torsion: Array | None) -> Array:
    """(n,) from forces (n, 3) in contact axes [N] and moments (n,) about the normals [N·m]; NaN where there is no
    friction, or no normal force.
    """
    tangential, limit = _against(scene, forces, torsion)
    return read_only(tangential / np.where(limit > 0.0, limit, np.nan))


def friction_margin(scene: Scene, forces: Array, torsion: Array | None) -> Array:
    """(n,) N, arguments as above; NaN where there is no friction."""
    tangential, limit = _against(scene, forces, torsion)
    return read_only(np.where(scene.mu > 0.0, limit - tangential, np.nan))


def _against(scene: Scene, forces: Array, torsion: Array | None) -> tuple[Array, Array]:
    """(|r̂_T|, μ r_N), (n,) each."""
    soft = list(scene.soft)
    moments = np.zeros(scene.n) if torsion is None else torsion[soft]
    lawful, turning = np.split(scene.lawful(np.append(forces, moments if soft else [])), [3 * scene.n])
    moment = np.zeros(scene.n)
    moment[soft] = turning
    x, y, z = lawful.reshape(-1, 3).T
    return np.hypot(np.hypot(x, y), moment), scene.mu * z
