"""Meshes of an MJCF model as MuJoCo compiled them, with scale, refpos and refquat; also those written inside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import coal
import numpy as np

from handlcp.check import Array, read_only
from handlcp.hand.robot.joints import Doubt
from handlcp.hand.robot.source.part import CompiledMesh, rotation_of

_SAME = 1e-5  # of a mesh's size: corners of a file and of the compiled model that are closer are the same


def mesh_name(model: Any, mesh: int) -> str:
    """Of a mesh, by its number."""
    return str(model.mesh(mesh).name or f"mesh {mesh}")


def mesh_path(model: Any, mesh: int) -> str:
    """Where a mesh was read from; "" for one that is written inside the file."""
    start = int(model.mesh_pathadr[mesh])
    return bytes(model.paths)[start:].split(b"\0", 1)[0].decode(errors="replace") if start >= 0 else ""


def compiled_meshes(model: Any, path: Path | None) -> tuple[dict[str, CompiledMesh], list[Doubt]]:
    """Every mesh by name, and doubts about those that are read in part. Corners are MuJoCo's float32 numbers.

    MuJoCo moves corners to the mesh's principal axes, which is undone: they are in the axes in which the file places
    the mesh. Of an OBJ file with several objects it keeps all corners, but the triangles of the first object alone;
    those of the file are taken where its corners are the compiled ones. path : of the MJCF file.
    """
    found, partial = dict[str, CompiledMesh](), list[str]()
    for mesh in range(model.nmesh):
        name, made = mesh_name(model, mesh), _compiled(model, mesh)
        file = Path(mesh_path(model, mesh))
        if file.suffix.lower() == ".obj" and _has_objects(file := (path or file).parent / file):
            whole = _read(file, np.array(model.mesh_scale[mesh], dtype=float))
            if whole is not None and _has_corners(whole.corners, made.corners):
                made = whole
            else:
                partial.append(name)
        found[name] = made
    what = f"of meshes with several objects the first alone is read: {', '.join(partial)}"
    return found, [Doubt("hand", what, "OBJ files with one object", "minor", "geometry")] if partial else []


def _compiled(model: Any, mesh: int) -> CompiledMesh:
    first, faces = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    own = np.asarray(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], dtype=float)
    corners = own @ rotation_of(model.mesh_quat[mesh]).T + model.mesh_pos[mesh]
    triangles = np.array(model.mesh_face[faces : faces + int(model.mesh_facenum[mesh])], dtype=np.int64)
    return CompiledMesh(read_only(corners), triangles)


def _has_objects(file: Path) -> bool:
    """Whether an OBJ file has more than one object or group."""
    try:
        lines = file.read_bytes().splitlines()
    except OSError:
        return False
    return sum(line.startswith((b"o ", b"g ")) for line in lines) > 1


def _read(file: Path, scale: Array) -> CompiledMesh | None:
    try:
        tree = coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(file), scale)
    except (ValueError, RuntimeError):
        return None
    triangles = [[t[0], t[1], t[2]] for t in (tree.tri_indices(i) for i in range(tree.num_tris))]
    return CompiledMesh(read_only(np.array(tree.vertices(), dtype=float)), np.array(triangles, dtype=np.int64))


def _has_corners(file: Array, compiled: Array) -> bool:
    """Whether each of corners (k, 3) is among those of a file (m, 3)."""
    from scipy.spatial import cKDTree  # a tenth of a second that few meshes should pay

    away = cKDTree(file).query(compiled)[0]
    return bool(away.max() <= _SAME * np.ptp(file, axis=0).max())
