"""`LinkSurface`: a link's collision geometry as points, close enough to see it in an object.

coal measures wrong depths between some shapes that overlap, and a link's mesh need not be convex. So a ball is its
centre with a radius, and every other shape a net of points on its surface, at most `POINT_SPACING` apart.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import coal
import numpy as np
import scipy

from handlcp.check import Array, Ints, read_only
from handlcp.errors import missing_library
from handlcp.lazy_property import lazy_property
from handlcp.robot.description import COLLISION, RobotDescription

# ---------------------------------------------------------------- Convex hulls as coal's shapes.
#
# coal 3.0.3 refuses hulls with a vertex of 255 or more neighbours: the tip of a fine cone, and one corner of a lid with
# as many corners, which is cut into triangles like a fan. It crashes the process on points of one plane.

# Neighbours that a vertex keeps, and how many those have that come in its place
_MAX_NEIGHBOURS, _NEIGHBOURS_PER_CUT = 250, 100
_VERTEX_CUT_SHARE = 1e-6  # of the edges' lengths: how much of such a vertex is cut off
_FLAT_WIDTH_RATIO = 1e-9  # of its width: a hull that is thinner is flat


def convex_hull(points: Array) -> Any | None:
    """The convex hull of points (k, 3) [m], a `coal.Convex`; None where they lie in a plane.

    A vertex with too many neighbours is cut off by a millionth of its edges, and several come in its place.
    """
    points = np.unique(points, axis=0)
    width = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1] if len(points) > 3 else np.zeros(3)
    if not width[2] > _FLAT_WIDTH_RATIO * width[0]:
        return None
    try:
        return coal.Convex.convexHull(_to_coal_points(points), True, "Qt")
    except RuntimeError:
        return _hull_with_few_neighbours(points)


def hull_planes(shape: Any) -> tuple[Array, Array, Array]:
    """The triangles (m, 3, 3) of a hull, their outward normals (m, 3) and offsets (m,): n · x = offset on each."""
    polygons = [shape.polygons(i) for i in range(shape.num_polygons)]
    triangles = np.array(shape.points(), dtype=float)[[[t[0], t[1], t[2]] for t in polygons]]
    if shape.num_normals_and_offsets == len(polygons):
        return triangles, np.array(shape.normals(), dtype=float), -np.array(shape.offsets(), dtype=float)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1)
    triangles, normals = triangles[length > 0.0], normals[length > 0.0] / length[length > 0.0, None]
    return triangles, normals, (triangles[:, 0] * normals).sum(axis=1)


def _to_coal_points(points: Array) -> Any:
    given = coal.StdVec_Vec3s()
    for point in points:
        given.append(point)
    return given


def _hull_with_few_neighbours(points: Array) -> Any:
    """The hull with lids in strips of triangles, and without vertices that even so have too many neighbours."""
    faces = _split_in_strips(points, scipy.spatial.ConvexHull(points))
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    corners, count = np.unique(edges, return_counts=True)
    if (many := corners[count > _MAX_NEIGHBOURS]).size:
        kept = [points[corners[count <= _MAX_NEIGHBOURS]]]
        for corner in many:
            there = edges[(edges == corner).any(axis=1)]
            to = points[there[there != corner]] - points[corner]
            axis = to.mean(axis=0)
            kept.append(points[corner] + _VERTEX_CUT_SHARE * to[_order_around(to, axis)][::_NEIGHBOURS_PER_CUT])
        points = np.concatenate(kept)
        faces = _split_in_strips(points, scipy.spatial.ConvexHull(points))
    used, faces = np.unique(faces, return_inverse=True)
    triangles = coal.StdVec_Triangle()
    for a, b, c in faces.reshape(-1, 3).tolist():
        triangles.append(coal.Triangle(a, b, c))
    return coal.Convex(_to_coal_points(points[used]), triangles)


def _split_in_strips(points: Array, found: Any) -> Ints:
    """(m, 3) triangles of a hull found by qhull, counterclockwise from outside; flat faces with more than one of them
    cut into strips, so that no corner of such a face has more than four neighbours there.
    """
    _, face, size = np.unique(found.equations, axis=0, return_inverse=True, return_counts=True)
    out = []
    for own in np.split(np.argsort(face.reshape(-1), kind="stable"), np.cumsum(size)[:-1]):
        corners = np.unique(found.simplices[own])
        middle = points[corners].mean(axis=0)
        corners = corners[_order_around(points[corners] - middle, found.equations[own[0], :3])]
        low, high = 0, len(corners) - 1
        while high - low > 1:
            out.append(corners[[low, low + 1, high]])
            low += 1
            if high - low > 1:
                out.append(corners[[low, high - 1, high]])
                high -= 1
    return np.array(out)


def _order_around(to: Array, axis: Array) -> Ints:
    """The order of directions (k, 3) counterclockwise about an axis (3,)."""
    x = np.eye(3)[int(np.argmin(abs(axis)))]
    x = x - axis * (axis @ x) / (axis @ axis)
    return np.argsort(np.arctan2(to @ np.cross(axis, x), to @ x * np.linalg.norm(axis)), kind="stable")


# ---------------------------------------------------------------- Points on the surfaces of links.

POINT_SPACING = 2e-3  # [m] between points: on a ball of 25 mm a depth is then seen to 0.03 mm
_MAX_EDGE_POINTS = 60  # points along the edge of a triangle, at most
_MERGE_DISTANCE = 1e-7  # [m] points that are nearer to each other are one
_MIN_RING_POINTS = 16  # points around a cylinder, at least

_KNOWN_SHAPES = (coal.Sphere, coal.Capsule, coal.Cylinder, coal.Box, coal.BVHModelBase, coal.ConvexBase)
_MESH_SHAPES = (coal.BVHModelBase, coal.ConvexBase)

_LONGITUDES, _LATITUDES = np.linspace(0.0, 2 * np.pi, 24, endpoint=False), np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)
_SPHERE_DIRECTIONS = np.array(
    [(np.cos(h) * np.cos(t), np.cos(h) * np.sin(t), np.sin(h)) for h in _LATITUDES for t in _LONGITUDES]
)


@dataclass(frozen=True, eq=False)
class LinkSurface:
    """The collision shapes of one link.

    frame : its number in Pinocchio's model. joint : of the joint that carries it. parts : coal's shapes, with rotation
    and position in the link's frame. reach [m] : no part is farther from the frame's origin.
    """

    name: str
    frame: int
    joint: int
    parts: tuple[tuple[Any, Array, Array], ...]
    reach: float

    @lazy_property
    def net(self) -> tuple[Array, Array]:
        """Points (m, 3) in the link's frame and radii (m,) : balls whose surfaces are, or lie on, the link's [m]."""
        nets = [(_shape_points(shape), R, p) for shape, R, p in self.parts]
        points = np.concatenate([x @ R.T + p for (x, _), R, p in nets])
        return read_only(points), read_only(np.concatenate([radii for (_, radii), _, _ in nets]))

    @lazy_property
    def ball(self) -> tuple[Array, float]:
        """Centre (3,) in the link's frame and radius [m] of a ball that holds the net."""
        points, radii = self.net
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return read_only(middle), float((np.linalg.norm(points - middle, axis=1) + radii).max())

    def __getstate__(self) -> dict[str, Any]:
        """With the net in place of the shapes, some of which cannot be pickled."""
        return self.__dict__ | {"net": self.net, "parts": ()}


def link_surfaces(description: RobotDescription) -> tuple[LinkSurface, ...]:
    """All links with collision geometry. Raises URDFError for meshes that are missing or cannot be read."""
    links = defaultdict[int, list[tuple[Any, Array, Array]]](list)
    for part in description.load_shapes(COLLISION):
        if isinstance(part.shape, _KNOWN_SHAPES):
            links[part.frame].append((part.shape, part.rotation, part.position))
    found = list[LinkSurface]()
    for frame, parts in sorted(links.items()):
        known = description.model.frames[frame]
        reach = max(float(np.linalg.norm(p)) + _bounding_radius(shape) for shape, _, p in parts)
        found.append(LinkSurface(known.name, frame, int(known.parentJoint), tuple(parts), reach))
    return tuple(found)


def _shape_triangles(shape: Any) -> Array:
    """(m, 3, 3) corners of a coal mesh's or hull's triangles."""
    return read_only(hull_planes(shape)[0]) if isinstance(shape, coal.ConvexBase) else mesh_triangles(shape)


def mesh_triangles(mesh: Any) -> Array:
    """(m, 3, 3) corners of a coal mesh's triangles."""
    corners = np.array(mesh.vertices(), dtype=float)
    faces = [[t[0], t[1], t[2]] for t in (mesh.tri_indices(i) for i in range(mesh.num_tris))]
    return read_only(corners[np.array(faces, dtype=int).reshape(-1, 3)])


def _bounding_radius(shape: Any) -> float:
    """Of a ball about the shape's origin that holds it [m]."""
    if isinstance(shape, _MESH_SHAPES):
        return float(np.linalg.norm(_shape_triangles(shape), axis=2).max())
    if isinstance(shape, coal.Box):
        return float(np.linalg.norm(shape.halfSide))
    return float(shape.radius + getattr(shape, "halfLength", 0.0))


def _shape_points(shape: Any) -> tuple[Array, Array]:
    """Points (m, 3) and radii (m,) of a shape, in its own frame."""
    if isinstance(shape, _MESH_SHAPES):
        points = _drop_duplicates(np.concatenate(list(_triangle_points(_shape_triangles(shape)))))
    elif isinstance(shape, coal.Box):
        points = _box_points(2 * np.array(shape.halfSide).reshape(3))
    elif isinstance(shape, coal.Cylinder):
        points = _cylinder_points(shape.radius, 2 * shape.halfLength)
    else:
        z = _line_points(2 * shape.halfLength) if isinstance(shape, coal.Capsule) else np.zeros(1)
        return np.outer(z, (0.0, 0.0, 1.0)), np.full(len(z), shape.radius)
    return points, np.zeros(len(points))


def _drop_duplicates(points: Array) -> Array:
    """Each of points (m, 3) once: triangles have corners and edges in common, half of a net or more."""
    places = np.round(points / _MERGE_DISTANCE)
    order = np.lexsort(places.T)
    new = np.append(True, (np.diff(places[order], axis=0) != 0.0).any(axis=1))
    return np.asarray(points[np.sort(order[new])])


def _line_points(length: float) -> Array:
    """Points from -length / 2 to length / 2."""
    return np.linspace(-0.5 * length, 0.5 * length, 2 + int(length / POINT_SPACING))


def _cylinder_points(radius: float, length: float) -> Array:
    """Rings on the side, and smaller ones on the ends."""
    turn = np.linspace(0.0, 2 * np.pi, max(_MIN_RING_POINTS, int(2 * np.pi * radius / POINT_SPACING)), endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    rings = [radius * circle + (0.0, 0.0, z) for z in _line_points(length)]
    for r in np.linspace(0.0, radius, 2 + int(radius / POINT_SPACING))[:-1]:
        rings += [r * circle + (0.0, 0.0, z) for z in (-0.5 * length, 0.5 * length)]
    return np.concatenate(rings)


def _box_points(size: Array) -> Array:
    """Grids on the six faces."""
    faces = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        a, b = (m.ravel() for m in np.meshgrid(_line_points(size[i]), _line_points(size[j])))
        for side in (-0.5, 0.5):
            face = np.empty((len(a), 3))
            face[:, i], face[:, j], face[:, k] = a, b, side * size[k]
            faces.append(face)
    return np.concatenate(faces)


def _triangle_points(triangles: Array) -> Iterator[Array]:
    """Their corners, and grids on those that are larger than the net."""
    yield triangles.reshape(-1, 3)
    edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    cuts = np.clip(np.ceil(edges / POINT_SPACING), 1, _MAX_EDGE_POINTS).astype(int)
    for n in np.unique(cuts[cuts > 1]):
        a, b = (m.ravel() for m in np.meshgrid(np.arange(n + 1), np.arange(n + 1)))
        inside = a + b <= n
        share = np.stack([n - a - b, a, b], axis=1)[inside] / n
        yield np.einsum("gk,mkx->mgx", share, triangles[cuts == n]).reshape(-1, 3)


def surface_points(parts: Iterable[tuple[Any, Array, Array]], corners: bool = False) -> Array | None:
    """(m, 3) points on shapes, each with its rotation and position; None without any that is known.

    corners : of meshes, their corners alone.
    """
    found = []
    for shape, R, p in parts:
        if corners and isinstance(shape, _MESH_SHAPES):
            found.append(_shape_triangles(shape).reshape(-1, 3) @ R.T + p)
            continue
        if isinstance(shape, _KNOWN_SHAPES):
            x, radius = _shape_points(shape)
            ways = _SPHERE_DIRECTIONS if radius.any() else np.zeros((1, 3))
            found.append((x + radius[:, None] * ways[:, None]).reshape(-1, 3) @ R.T + p)
    return np.concatenate(found) if found else None


# ----------------------------------------------------------------
# Convex parts of meshes that are not convex, by coacd, an optional package (pip install coacd).

_CONVEX_TOLERANCE = 0.05  # how far parts may stand off the mesh, as coacd counts it: of half the mesh's size


def has_coacd() -> bool:
    """Whether coacd is installed."""
    return find_spec("coacd") is not None


def convex_parts(triangles: Array) -> tuple[Any, ...]:
    """Hulls, coal's shapes, that together fill a closed mesh of triangles (m, 3, 3) [m], and stand off it by up to a
    twentieth of half its size. Always the same for the same mesh. Raises Unsupported without coacd.

    Source: Wei, Liu, Ling & Su, Approximate convex decomposition for 3D meshes with collision-aware concavity and tree
    search, ACM Trans. Graphics 41 (2022).
    """
    if not has_coacd():
        raise missing_library("convex parts of a mesh that is not convex need coacd", "coacd")
    import coacd  # type: ignore[import-untyped]

    coacd.set_log_level("error")
    corners, faces = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    parts = coacd.run_coacd(
        coacd.Mesh(corners, faces.reshape(-1, 3).astype(np.int32)), threshold=_CONVEX_TOLERANCE, seed=0
    )
    return tuple([made for points, _ in parts if (made := convex_hull(np.asarray(points, dtype=float))) is not None])
