"""`MeshSurface`: a triangulated surface, and its nearest point to a point, in closed form and compiled.

coal 3.0.3 measures a wrong distance between a triangle mesh and a ball that overlaps it: -3.9 mm instead of -5 mm.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import coal
import numpy as np

from handlcp.check import Array, Ints, check_array, read_only
from handlcp.errors import InputError, as_path
from handlcp.geometry.object import ObjectSolid
from handlcp.lcp.kernels.dense import kernel
from handlcp.robot.link_shape import build_mesh_tree, collada_unit
from handlcp.robot.link_surface import convex_hull, hull_planes, mesh_triangles
from handlcp.robot.mesh_file import check_mesh_file

_ON_SURFACE_TOLERANCE = 1e-9  # of the size: a point this near to the surface takes its normal from the triangle
_POINTS_PER_BATCH = 1024  # points that are measured together: what they take stays in the processor's cache
_SAME_FACE_TOLERANCE = 1e-12  # of the size: a foot that is beyond no other face by more lies on the hull


class HullFaces(NamedTuple):
    """The triangles (m, 3, 3) of a hull, balls (m, 4) that hold them, their outward normals (m, 3) and offsets (m,)."""

    triangles: Array
    balls: Array
    normals: Array
    offsets: Array


class HullSurface:
    """The surface of a convex hull of coal's: its planes n · x = offset with outward normals, and its triangles."""

    __slots__ = ("_faces", "_size")

    def __init__(self, hull: Any) -> None:
        triangles, normals, offsets = hull_planes(hull)
        self._faces = HullFaces(triangles, _triangle_balls(triangles), normals, offsets)
        self._size = _longest_edge(triangles)

    def face_distances(self, points: Array) -> Array:
        """(m,) how far points (m, 3) are beyond the face that they are furthest beyond [m]: inside, minus the depth."""
        return plane_distances(points, self._faces.normals, self._faces.offsets)

    def closest(self, points: Array) -> tuple[Array, Array, Array]:
        """Signed distances (m,) [m] of points (m, 3), nearest surface points and outward normals (m, 3), own axes."""
        away, on, out = np.empty(len(points)), np.empty_like(points), np.empty_like(points)
        _write_closest_on_hull(points, self._faces, _SAME_FACE_TOLERANCE * self._size, away, on, out)
        return away, on, out


class ClosedSurface:
    """A closed surface of triangles (m, 3, 3) that need not be convex."""

    __slots__ = ("_balls", "_numbers", "_size", "_triangles")

    def __init__(self, triangles: Array) -> None:
        self._triangles, self._balls, self._size = triangles, _triangle_balls(triangles), _longest_edge(triangles)
        self._numbers = np.arange(len(triangles))

    def closest(self, points: Array) -> tuple[Array, Array, Array]:
        """As of a hull."""
        away, on, out = np.empty(len(points)), np.empty_like(points), np.empty_like(points)
        for i, point in enumerate(points):
            away[i], on[i], out[i] = self._closest(point)
        return away, on, out

    def _closest(self, point: Array) -> tuple[float, Array, Array]:
        """Distance, nearest point and outward normal of one point (3,)."""
        x = np.empty(3)
        k = _nearest_triangle(point, self._triangles, self._balls, self._numbers, x)
        apart = point - x
        distance = float(np.sqrt(apart @ apart))
        inside = abs(winding_number(point, self._triangles)) > 0.5
        if distance > _ON_SURFACE_TOLERANCE * self._size:
            return (-distance, x, -apart / distance) if inside else (distance, x, apart / distance)
        a, b, c = self._triangles[k]
        out = np.cross(b - a, c - a)
        out /= np.linalg.norm(out)
        if abs(winding_number(x + 1e-6 * self._size * out, self._triangles)) > 0.5:
            out = -out
        return -distance if inside else distance, x, out


def plane_distances(points: Array, normals: Array, offsets: Array) -> Array:
    """(m,) how far points (m, 3) are beyond the farthest of the planes n · x = offset, normals (k, 3)."""
    out = np.empty(len(points))
    for k in range(0, len(points), _POINTS_PER_BATCH):
        out[k : k + _POINTS_PER_BATCH] = (points[k : k + _POINTS_PER_BATCH] @ normals.T - offsets).max(axis=1)
    return out


def _triangle_balls(triangles: Array) -> Array:
    """(m, 4) middles and radii of balls that hold triangles (m, 3, 3)."""
    middles = triangles.mean(axis=1)
    radii = np.linalg.norm(triangles - middles[:, None], axis=2).max(axis=1)
    return np.column_stack([middles, radii])


def _longest_edge(triangles: Array) -> float:
    """The longest edge of a box around triangles (m, 3, 3) [m]."""
    return float(np.ptp(triangles, axis=(0, 1)).max())


def winding_number(point: Array, triangles: Array) -> float:
    """How often a closed surface winds around a point: ±1 inside, 0 outside. The sum of the solid angles over 4π."""
    return float(solid_angles(triangles - point).sum() / (4 * np.pi))


def solid_angles(triangles: Array) -> Array:
    """(k,) of triangles (k, 3, 3) seen from the origin, < 0 from their front: Van Oosterom and Strackee (1983)."""
    a, b, c = triangles.transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1), np.linalg.norm(c, axis=1)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.asarray(2 * np.arctan2(volume, below))


# ----------------------------------------------------------------


@kernel
def _write_closest_on_hull(points: Array, faces: HullFaces, same: float, away: Array, on: Array, out: Array) -> None:
    """Write distances (m,) of points (m, 3) from a hull, signed; nearest points of its surface; the normals there."""
    triangles, balls, normals, offsets = faces
    visible = np.empty(len(offsets), np.int64)
    for m in range(len(points)):
        point, x = points[m], on[m]
        furthest, k, count = -np.inf, 0, 0
        for i in range(len(offsets)):
            over = normals[i, 0] * point[0] + normals[i, 1] * point[1] + normals[i, 2] * point[2] - offsets[i]
            if over > 0.0:
                visible[count] = i
                count += 1
            if over > furthest:
                furthest, k = over, i
        for a in range(3):
            x[a], out[m, a] = point[a] - furthest * normals[k, a], normals[k, a]
        away[m], on_face = furthest, True
        for i in range(len(offsets) if count > 0 else 0):
            if normals[i, 0] * x[0] + normals[i, 1] * x[1] + normals[i, 2] * x[2] - offsets[i] > same:
                on_face = False
                break
        if not on_face:
            # The nearest point lies on a face that is visible
            _nearest_triangle(point, triangles, balls, visible[:count], x)
            away[m] = np.sqrt((point[0] - x[0]) ** 2 + (point[1] - x[1]) ** 2 + (point[2] - x[2]) ** 2)
            if away[m] > 0.0:
                for a in range(3):
                    out[m, a] = (point[a] - x[a]) / away[m]


@kernel
def _nearest_triangle(point: Array, triangles: Array, balls: Array, among: Ints, x: Array) -> int:
    """Write the nearest point (3,) of those of the triangles (m, 3, 3) whose numbers are given; returns the number.
    balls (m, 4) : a triangle is looked at where its ball could be nearer than what was found, the nearest one first.
    """
    far, first = np.empty(len(among)), 0
    for i in range(len(among)):
        b = balls[among[i]]
        far[i] = np.sqrt((point[0] - b[0]) ** 2 + (point[1] - b[1]) ** 2 + (point[2] - b[2]) ** 2) - b[3]
        if far[i] < far[first]:
            first = i
    best, found = np.inf, among[first]
    foot, n, along, to = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for number in range(-1, len(among)):
        k = first if number < 0 else number
        if number == first or (far[k] > 0.0 and far[k] * far[k] >= best):
            continue
        i = among[k]
        for j in range(3):
            length2, share = 0.0, 0.0
            for a in range(3):
                along[j, a] = triangles[i, (j + 1) % 3, a] - triangles[i, j, a]
                to[j, a] = point[a] - triangles[i, j, a]
                length2 += along[j, a] * along[j, a]
                share += to[j, a] * along[j, a]
            share = min(max(share / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
            off = 0.0
            for a in range(3):
                foot[a] = triangles[i, j, a] + share * along[j, a]
                off += (point[a] - foot[a]) ** 2
            if off < best:
                best, found = off, i
                x[:] = foot
        size2, above = 0.0, 0.0
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            n[a] = along[0, b] * along[1, c] - along[0, c] * along[1, b]
            size2 += n[a] * n[a]
            above += to[0, a] * n[a]
        over = size2 > 0.0 and above * above < best * size2
        for j in range(3):  # over the face: on the inner side of each edge
            beside = 0.0
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                beside += (along[j, b] * to[j, c] - along[j, c] * to[j, b]) * n[a]
            over = over and beside >= 0.0
        if over:
            best, found = above * above / size2, i
            for a in range(3):
                x[a] = point[a] - above / size2 * n[a]
    return int(found)


# ----------------------------------------------------------------
# Meshes, from files read by coal or from trimesh: a convex mesh becomes its hull, any other keeps its triangles.


CONVEXITY_TOLERANCE = 1e-3  # a mesh is convex if its volume is that of its hull to this share
MESH_ADVICE = "an object: hl.Mesh(mesh, mass=...) of a mesh, which has no mass of its own"
MAX_TRIANGLES = 200_000  # triangles: these take half a minute, and more gain nothing at the size of a fingertip
_MIN_VOLUME_RATIO = 1e-9  # of the size cubed: a mesh with less volume than this encloses nothing
_MAX_MESH_WIDTH = 5.0  # [m] a mesh for a hand that is wider was not drawn in metres
_METRE_WORDS = ("m", "meter", "meters", "metre", "metres")


class MeshSurface:
    """Corners (k, 3) and triangles (m, 3) of a mesh that came from memory, such as a `trimesh.Trimesh`. Immutable."""

    __slots__ = ("faces", "units", "vertices")

    vertices: Array
    faces: Any
    units: str | None

    def __init__(self, vertices: Any, faces: Any, units: Any = None) -> None:
        corners = check_array("mesh.vertices", np.asarray(vertices), (-1, 3))
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
        return (MeshSurface, (self.vertices, self.faces, self.units))

    def __repr__(self) -> str:
        return f"<{len(self.faces)} triangles>"


def is_mesh_in_memory(value: Any) -> bool:
    """Whether it is a mesh and no file: a `trimesh.Trimesh`, what has corners and triangles as it has, or a Scene."""
    return (hasattr(value, "vertices") and hasattr(value, "faces")) or hasattr(value, "to_geometry")


def object_advice(value: Any) -> str:
    """Instead of what is no object."""
    return MESH_ADVICE if is_mesh_in_memory(value) else "a Box, Sphere, Cylinder, Ellipsoid or Mesh"


def read_mesh_surface(value: Any) -> MeshSurface:
    """Of a mesh in memory; of a `trimesh.Scene` all meshes, where they stand in it. Raises InputError."""
    whole = value.to_geometry() if hasattr(value, "to_geometry") else value
    if not (hasattr(whole, "vertices") and hasattr(whole, "faces")):
        raise InputError("path", "a trimesh.Trimesh, or a scene of such meshes", repr(value)[:80])
    return MeshSurface(whole.vertices, whole.faces, getattr(value, "units", None))


def load_mesh(source: Any, scale: Array | None) -> ObjectSolid:
    """Of a mesh file, or of `MeshSurface`. Volume and centre of mass are those of the enclosed space; of the hull,
    where a convex mesh has holes. The volume of a mesh with holes that is not convex is NaN. scale (3,) : None: 1, for
    a mesh that looks as if it were in metres.

    Raises InputError for a file that is missing or unreadable, a mesh that encloses no volume, has too many triangles,
    or is too wide.
    """
    name = "the mesh" if isinstance(source, MeshSurface) else repr(str(source))
    if isinstance(source, MeshSurface):
        tree = build_mesh_tree(source.vertices * (np.ones(3) if scale is None else scale), source.faces)
    else:
        tree = _read_mesh_file(source, scale)
    if tree.num_tris > MAX_TRIANGLES:
        expected = f"a mesh of at most {MAX_TRIANGLES} triangles; simplify it, or take its convex hull"
        raise InputError("path", expected, f"{name} with {tree.num_tris}")
    triangles = mesh_triangles(tree)
    if not len(triangles) or not np.isfinite(triangles).all():
        raise InputError("path", "a mesh of triangles with finite corners", f"{name}: {len(triangles)} triangles")
    wide = float(np.ptp(triangles, axis=(0, 1)).max())
    if scale is None:
        units, expected = getattr(source, "units", None), "what makes metres of the mesh: 0.001 for millimetres"
        if isinstance(units, str) and units.lower() not in _METRE_WORDS:
            raise InputError("scale", expected, f"none, for {name} in units of {units!r}")
        if wide > _MAX_MESH_WIDTH:
            came = f"none, and {name} would be {wide:.3g} m wide: are these millimetres?"
            raise InputError("scale", f"{expected}, 1 to keep it", came)
    # Tetrahedra with the origin; below 0 where triangles face inwards
    a, b, c = triangles.transpose(1, 0, 2)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    volume = float(volumes.sum())
    if abs(volume) <= _MIN_VOLUME_RATIO * wide**3:
        raise InputError("path", "a closed mesh that encloses a volume", f"{name}: {volume:.3g} m³")
    around = convex_hull(triangles.reshape(-1, 3))
    if around is None:  # whatever it encloses, it has no thickness that counts
        raise InputError("path", "a mesh that encloses a volume", f"{name}, which is flat")
    filled = float(around.computeVolume())
    convex = abs(abs(volume) - filled) <= CONVEXITY_TOLERANCE * filled
    centre = read_only((volumes[:, None] * (a + b + c) / 4).sum(axis=0) / volume)
    if is_closed(triangles):
        return ObjectSolid(around if convex else tree, abs(volume), centre, None if convex else triangles)
    if convex:
        return ObjectSolid(around, filled, read_only(np.array(around.computeCOM()).reshape(3)))
    return ObjectSolid(tree, np.nan, centre, triangles)


def _read_mesh_file(path: Any, scale: Array | None) -> Any:
    """Load a mesh file at a scale. None: in the unit that a Collada file says, or metres."""
    file = as_path("path", path, "the path of a mesh file, or a trimesh.Trimesh")
    check_mesh_file("path", file)
    try:
        size = collada_unit(file) * np.ones(3) if scale is None else scale
        return coal.MeshLoader(coal.NODE_TYPE.BV_OBBRSS).load(str(file), size)
    except (ValueError, RuntimeError, MemoryError) as error:
        lines = [line.removeprefix("message:").strip() for line in str(error).splitlines()[3:5]]
        raise InputError("path", "a mesh file that coal can load", f"{str(file)!r}: {' '.join(lines)}") from None


def is_closed(triangles: Array) -> bool:
    """Whether triangles (m, 3, 3) bound a volume: each edge is passed as often in one direction as in the other."""
    corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    edges = np.concatenate([corners[:, (0, 1)], corners[:, (1, 2)], corners[:, (2, 0)]])
    n = len(triangles) * 3
    there, back = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
    return bool(np.array_equal(np.sort(there), np.sort(back)))
