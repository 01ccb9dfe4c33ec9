"""Convex parts of meshes that are not convex, by coacd, an optional package (pip install coacd)."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.extras import missing
from handlcp.hand.robot.link_surface import hull

_NEAR = 0.05  # how far parts may stand off the mesh, as coacd counts it: of half the mesh's size


def available() -> bool:
    """Whether coacd is installed."""
    return find_spec("coacd") is not None


def convex_parts(triangles: Array) -> tuple[Any, ...]:
    """Hulls, coal's shapes, that together fill a closed mesh of triangles (m, 3, 3) [m], and stand off it by up to a
    twentieth of half its size. Always the same for the same mesh. Raises Unsupported without coacd.

    Source: Wei, Liu, Ling & Su, Approximate convex decomposition for 3D meshes with collision-aware concavity and tree
    search, ACM Trans. Graphics 41 (2022).
    """
    if not available():
        raise missing("convex parts of a mesh that is not convex need coacd", "coacd")
    import coacd  # type: ignore[import-untyped]

    coacd.set_log_level("error")
    corners, faces = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    parts = coacd.run_coacd(coacd.Mesh(corners, faces.reshape(-1, 3).astype(np.int32)), threshold=_NEAR, seed=0)
    return tuple([made for points, _ in parts if (made := hull(np.asarray(points, dtype=float))) is not None])
