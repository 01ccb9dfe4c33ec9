"""Mesh files, read by coal: a convex mesh becomes its hull, any other keeps its triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import coal
import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError, unreadable
from handlcp.hand.objects.object import Solid
from handlcp.hand.robot.hull import hull

__all__ = ["closed", "load_mesh", "triangles_of"]

CONVEX = 1e-3  # a mesh is convex if its volume is that of its hull to this share
_FLAT = 1e-9  # of the size cubed: a mesh with less volume than this encloses nothing


def load_mesh(path: Any, scale: Array) -> Solid:
    """Load a mesh file. Volume and centre of mass are those of the enclosed space; of the hull, where a convex mesh has
    holes. The volume of a mesh with holes that is not convex is NaN.

    Raises InputError for a file that is missing, unreadable or encloses no volume.
    """
    try:
        file = Path(path)
    except TypeError:
        raise InputError("path", "the path of a mesh file", repr(path)) from None
    if why := unreadable(file):
        raise InputError("path", "the path of a mesh file", f"{str(file)!r}, which {why}")
    try:
        tree = coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(file), scale)
    except (ValueError, RuntimeError) as error:
        lines = [line.removeprefix("message:").strip() for line in str(error).splitlines()[3:5]]
        raise InputError("path", "a mesh file that coal can load", f"{str(file)!r}: {' '.join(lines)}") from None
    triangles = triangles_of(tree)
    if not len(triangles) or not np.isfinite(triangles).all():
        raise InputError(
            "path", "a mesh of triangles with finite corners", f"{str(file)!r}: {len(triangles)} triangles"
        )
    volume, moment = _enclosed(triangles)
    if abs(volume) <= _FLAT * float(np.ptp(triangles, axis=(0, 1)).max()) ** 3:
        raise InputError("path", "a closed mesh that encloses a volume", f"{str(file)!r}: {volume:.3g} m³")
    around = hull(triangles.reshape(-1, 3))
    if around is None:  # whatever it encloses, it has no thickness that counts
        raise InputError("path", "a mesh that encloses a volume", f"{str(file)!r}, which is flat")
    filled = float(around.computeVolume())
    convex = abs(abs(volume) - filled) <= CONVEX * filled
    if closed(triangles):
        return Solid(around if convex else tree, abs(volume), read_only(moment / volume), None if convex else triangles)
    if convex:
        return Solid(around, filled, read_only(np.array(around.computeCOM()).reshape(3)))
    return Solid(tree, np.nan, read_only(moment / volume), triangles)


def triangles_of(mesh: Any) -> Array:
    """(m, 3, 3) corners of a coal mesh's triangles."""
    corners = np.array(mesh.vertices(), dtype=float)
    faces = [[t[0], t[1], t[2]] for t in (mesh.tri_indices(i) for i in range(mesh.num_tris))]
    return read_only(corners[np.array(faces, dtype=int).reshape(-1, 3)])


def _enclosed(triangles: Array) -> tuple[float, Array]:
    """Volume [m³] (< 0: triangles face inwards) and volume × centre (3,) [m⁴]: sums of tetrahedra with the origin."""
    a, b, c = triangles.transpose(1, 0, 2)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    return float(volumes.sum()), (volumes[:, None] * (a + b + c) / 4).sum(axis=0)


def closed(triangles: Array) -> bool:
    """Whether triangles (m, 3, 3) bound a volume: each edge is passed as often in one direction as in the other."""
    corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    edges = np.concatenate([corners[:, (0, 1)], corners[:, (1, 2)], corners[:, (2, 0)]])
    n = len(triangles) * 3
    there, back = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
    return bool(np.array_equal(np.sort(there), np.sort(back)))
