"""Doors into the bound without compliance."""

import numpy as np

from handlcp.contact.friction import as_section
from handlcp.grasp.verify.static_load_bound import static_load_bounds


def bounds(grasp, wrenches, faces="cone", base=(0.0,) * 6, torques=True):
    """Of wrenches (k, 6) about the grasp's reference, beside a base (6,); None: the weight."""
    section = as_section(faces, planar=grasp.scene.kind.planar)
    there = None if base is None else np.array(base, dtype=float)
    return static_load_bounds(grasp.spec, section, np.array(wrenches, dtype=float), there, torques)
