"""Doors into the equations of an active set, and into forces without slip."""

import numpy as np

from handlcp.grasp.derivatives.active_set import (
    solve_without_slip as _without_slip,
)


def without_slip(grasp):
    """(n, 3) forces of a grasp under its load in which nothing slips and nothing opens."""
    scene = grasp.scene
    found, _ = _without_slip(scene, scene.flexibility, scene.offset[:, None], scene.geometry.wrench[:, None])
    return np.asarray(scene.forces_to_contact_axes(found[:, 0])[: 3 * scene.n]).reshape(-1, 3)
