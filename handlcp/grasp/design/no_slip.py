"""Forces and motion of a grasp in which nothing slips and nothing opens: linear in offsets and load.

    E r + Gᵀ u = -d,    G r = -w

Where these equations leave something open, the smallest answer is taken.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.scene import Scene


def without_slip(scene: Scene, flexibility: Array, offsets: Array, loads: Array) -> tuple[Array, Array]:
    """(c, m) forces in the laws' coordinates [N], and (6, m) twists of the object about the contacts' centre.

    flexibility (c, c), offsets (c, m) [m] : in the laws' coordinates. loads (6, m) : about the contacts' centre.
    """
    index, posed = scene.kind.index, scene.geometry
    e0 = float(np.diagonal(scene.flexibility).mean()) or 1.0
    rows = scene.freedom / np.repeat([1.0, posed.length], 3)
    G, E = rows @ posed.grasp_matrix[:, index], flexibility[np.ix_(index, index)] / e0
    dof = len(G)
    K = np.block([[E, G.T], [G, np.zeros((dof, dof))]])
    answer = np.linalg.lstsq(K, -np.vstack([offsets[index] / e0, rows @ loads]), rcond=1e-10)[0]
    forces = np.zeros((scene.components, offsets.shape[1]))
    forces[index] = answer[: len(index)]
    return forces, np.asarray(e0 * (rows.T @ answer[len(index) :]))
