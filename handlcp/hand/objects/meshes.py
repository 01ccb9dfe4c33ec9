"""Meshes, from files read by coal or from trimesh: a convex mesh becomes its hull, any other keeps its triangles."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, as_path
from handlcp.hand.objects.object import Solid
from handlcp.hand.robot.check_mesh import check_mesh_file
from handlcp.hand.robot.link_surface import hull, triangles_of
from handlcp.hand.robot.source.part import tree_of
from handlcp.hand.robot.source.units import collada_unit

CONVEX = 1e-3  # a mesh is convex if its volume is that of its hull to this share
HOW_TO_MESH = "an object: hl.Mesh(mesh, mass=...) of a mesh, which has no mass of its own"
MOST = 200_000  # triangles: these take half a minute, and more gain nothing at the size of a fingertip
_FLAT = 1e-9  # of the size cubed: a mesh with less volume than this encloses nothing
_WIDE = 5.0  # [m] a mesh for a hand that is wider was not drawn in metres
_METRES = ("m", "meter", "meters", "metre", "metres")


class Surfaces:
    """Corners (k, 3) and triangles (m, 3) of a mesh that came from memory, such as a `trimesh.Trimesh`. Immutable."""

    __slots__ = ("faces", "units", "vertices")

    vertices: Array
    faces: Any
    units: str | None

    def __init__(self, vertices: Any, faces: Any, units: Any = None) -> None:
        corners = array("mesh.vertices", np.asarray(vertices), (-1, 3))
        rows = np.array(faces, dtype=np.int64)
        fits = rows.ndim == 2 and rows.shape[1] == 3 and rows.min(initial=0) >= 0
        if not fits or rows.max(initial=0) >= len(corners):
            raise InputError("mesh.faces", "(m, 3) numbers of the mesh's corners", f"shape {rows.shape}")
        rows.flags.writeable = False
        for name, value in (("vertices", corners), ("faces", rows), ("units", units)):
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a mesh is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Surfaces, (self.vertices, self.faces, self.units))

    def __repr__(self) -> str:
        return f"<{len(self.faces)} triangles>"


def in_memory(value: Any) -> bool:
    """Whether it is a mesh and no file: a `trimesh.Trimesh`, what has corners and triangles as it has, or a Scene."""
    return (hasattr(value, "vertices") and hasattr(value, "faces")) or hasattr(value, "to_geometry")


def what_to_pass(value: Any) -> str:
    """Instead of what is no object."""
    return HOW_TO_MESH if in_memory(value) else "a Box, Sphere, Cylinder, Ellipsoid or Mesh"


def surfaces_of(value: Any) -> Surfaces:
    """Of a mesh in memory; of a `trimesh.Scene` all meshes, where they stand in it. Raises InputError."""
    whole = value.to_geometry() if hasattr(value, "to_geometry") else value
    if not (hasattr(whole, "vertices") and hasattr(whole, "faces")):
        raise InputError("path", "a trimesh.Trimesh, or a scene of such meshes", repr(value)[:80])
    return Surfaces(whole.vertices, whole.faces, getattr(value, "units", None))


def load_mesh(source: Any, scale: Array | None) -> Solid:
    """Of a mesh file, or of `Surfaces`. Volume and centre of mass are those of the enclosed space; of the hull, where a
    convex mesh has holes. The volume of a mesh with holes that is not convex is NaN. scale (3,) : None: 1, for a mesh
    that looks as if it were in metres.

    Raises InputError for a file that is missing or unreadable, a mesh that encloses no volume, has too many triangles,
    or is too wide.
    """
    name = "the mesh" if isinstance(source, Surfaces) else repr(str(source))
    if isinstance(source, Surfaces):
        tree = tree_of(source.vertices * (np.ones(3) if scale is None else scale), source.faces)
    else:
        tree = _read(source, scale)
    if tree.num_tris > MOST:
        expected = f"a mesh of at most {MOST} triangles; simplify it, or take its convex hull"
        raise InputError("path", expected, f"{name} with {tree.num_tris}")
    triangles = triangles_of(tree)
    if not len(triangles) or not np.isfinite(triangles).all():
        raise InputError("path", "a mesh of triangles with finite corners", f"{name}: {len(triangles)} triangles")
    if scale is None:
        _ask_for_metres(triangles, name, getattr(source, "units", None))
    return _solid(triangles, tree, name)


def _ask_for_metres(triangles: Array, name: str, units: Any) -> None:
    """Raises InputError for a mesh that is not in metres, or does not look like it."""
    wide, expected = float(np.ptp(triangles, axis=(0, 1)).max()), "what makes metres of the mesh: 0.001 for millimetres"
    if isinstance(units, str) and units.lower() not in _METRES:
        raise InputError("scale", expected, f"none, for {name} in units of {units!r}")
    if wide > _WIDE:
        came = f"none, and {name} would be {wide:.3g} m wide: are these millimetres?"
        raise InputError("scale", f"{expected}, 1 to keep it", came)


def _read(path: Any, scale: Array | None) -> Any:
    """None: in the unit that a Collada file says, or metres."""
    file = as_path("path", path, "the path of a mesh file, or a trimesh.Trimesh")
    check_mesh_file("path", file)
    try:
        size = collada_unit(file) * np.ones(3) if scale is None else scale
        return coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(file), size)
    except (ValueError, RuntimeError, MemoryError) as error:
        lines = [line.removeprefix("message:").strip() for line in str(error).splitlines()[3:5]]
        raise InputError("path", "a mesh file that coal can load", f"{str(file)!r}: {' '.join(lines)}") from None


def _solid(triangles: Array, tree: Any, name: str) -> Solid:
    volume, moment = _enclosed(triangles)
    if abs(volume) <= _FLAT * float(np.ptp(triangles, axis=(0, 1)).max()) ** 3:
        raise InputError("path", "a closed mesh that encloses a volume", f"{name}: {volume:.3g} m³")
    around = hull(triangles.reshape(-1, 3))
    if around is None:  # whatever it encloses, it has no thickness that counts
        raise InputError("path", "a mesh that encloses a volume", f"{name}, which is flat")
    filled = float(around.computeVolume())
    convex = abs(abs(volume) - filled) <= CONVEX * filled
    if closed(triangles):
        return Solid(around if convex else tree, abs(volume), read_only(moment / volume), None if convex else triangles)
    if convex:
        return Solid(around, filled, read_only(np.array(around.computeCOM()).reshape(3)))
    return Solid(tree, np.nan, read_only(moment / volume), triangles)


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
