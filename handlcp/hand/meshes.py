"""Mesh files through coal: the hull of a convex mesh, the triangles of one that is not.

Measured on coal 3.0.3: the distance between a sphere and a triangle mesh is wrong once they overlap (-3.9 mm for -5
mm), and right for a sphere too small to overlap; so a mesh that is not convex is asked about points only.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError

__all__ = ["MeshShape", "closed", "hull", "load_mesh", "winding"]

# A mesh fills its hull to this share of the volume, or it is not convex.
CONVEX = 1e-3


@dataclass(frozen=True, slots=True)
class MeshShape:
    """geometry: coal's hull if convex, else its triangle tree; triangles (m, 3, 3) [m]; volume [m³] and its centre (3,)
    [m]: what the surface encloses, the hull's where a convex one has holes; NaN is the volume of another with holes.
    """

    geometry: Any
    triangles: Array
    volume: float
    centre: Array
    convex: bool


def load_mesh(argument: str, path: Any, scale: Array) -> MeshShape:
    """Load a mesh file. Raises InputError for a file that is missing, unreadable or encloses no volume."""
    try:
        file = Path(path)
    except TypeError:
        raise InputError(argument, "the path of a mesh file", repr(path)) from None
    if not file.is_file():
        raise InputError(argument, "the path of a mesh file", f"{str(file)!r}, which does not exist")
    try:
        tree = coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(file), scale)
    except (ValueError, RuntimeError) as error:
        lines = [line.removeprefix("message:").strip() for line in str(error).splitlines()[3:5]]
        raise InputError(argument, "a mesh file that coal can load", f"{str(file)!r}: {' '.join(lines)}") from None
    corners = np.array(tree.vertices(), dtype=float)
    faces = np.array([[t[0], t[1], t[2]] for t in (tree.tri_indices(i) for i in range(tree.num_tris))], dtype=int)
    if not len(faces) or not np.isfinite(corners).all():
        raise InputError(argument, "a mesh of triangles with finite corners", f"{str(file)!r}: {len(faces)} triangles")
    triangles = corners[faces]
    a, b, c = triangles.transpose(1, 0, 2)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(volumes.sum())
    size = float(np.ptp(corners, axis=0).max())
    if abs(volume) <= 1e-9 * size**3:
        raise InputError(argument, "a closed mesh that encloses a volume", f"{str(file)!r}: {volume:.3g} m³")
    centre = (volumes[:, None] * (a + b + c) / 4).sum(axis=0) / volume
    shape = hull(tree)
    enclosed = float(shape.computeVolume())
    convex = abs(abs(volume) - enclosed) <= CONVEX * enclosed
    if not closed(triangles):
        volume, centre = (enclosed, np.array(shape.computeCOM()).reshape(3)) if convex else (np.nan, centre)
    return MeshShape(shape if convex else tree, triangles, abs(volume), centre, convex)


def closed(triangles: Array) -> bool:
    """Whether triangles (m, 3, 3) bound a volume: every edge is run through as often one way as the other."""
    corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    edges = np.concatenate([corners[:, (0, 1)], corners[:, (1, 2)], corners[:, (2, 0)]])
    n = len(triangles) * 3
    there, back = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
    return bool(np.array_equal(np.sort(there), np.sort(back)))


def hull(tree: Any) -> Any:
    """Coal's convex hull of a triangle tree."""
    tree.buildConvexHull(True, "Qt")
    return tree.convex


def winding(point: Array, triangles: Array) -> float:
    """How often a closed surface winds around a point: ±1 inside, 0 outside (sum of the solid angles over 4π)."""
    a, b, c = (triangles - point).transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1), np.linalg.norm(c, axis=1)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(2 * np.arctan2(volume, below).sum() / (4 * np.pi))
