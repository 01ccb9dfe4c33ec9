"""Doors into the bound without compliance."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp.contact.friction import as_section
from handlcp.grasp.verify.static_load_bound import StaticLoadBounds, static_load_bounds


def bounds(
    grasp: hl.Grasp, wrenches: Any, faces: Any = "cone", base: Any = (0.0,) * 6, torques: bool = True
) -> StaticLoadBounds:
    """Of wrenches (k, 6) about the grasp's reference, beside a base (6,); None: the weight."""
    section = as_section(faces, planar=grasp.scene.kind.planar)
    there = None if base is None else np.array(base, dtype=float)
    return static_load_bounds(grasp.spec, section, np.array(wrenches, dtype=float), there, torques)
