"""Doors into the equations of an active set, and into forces without slip."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp.grasp.tangent.active_set import Laws, active_rows, inverted, rank_of, saddle
from handlcp.grasp.tangent.solutions import smallest, without_slip as _without_slip
from handlcp.grasp.verify.contact_states import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, States

__all__ = [
    "GLIDING", "RESTING", "SEPARATED", "SLIDING", "STICKING", "Laws", "States", "active_rows", "inverted", "rank_of",
    "saddle", "smallest", "without_slip",
]  # fmt: skip


def without_slip(grasp: hl.Grasp) -> Any:
    """(n, 3) forces of a grasp under its load in which nothing slips and nothing opens."""
    scene = grasp.scene
    found, _ = _without_slip(scene, scene.flexibility, scene.offset[:, None], scene.geometry.wrench[:, None])
    return np.asarray(scene.physical(found[:, 0])[: 3 * scene.n]).reshape(-1, 3)
