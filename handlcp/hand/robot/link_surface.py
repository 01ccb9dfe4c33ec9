"""The collision geometry of a hand's links as points: where a link's surface is, close enough to see it in an object.

coal measures wrong depths between some shapes that overlap, and a link's mesh need not be convex. So a ball is its
centre with a radius, and every other shape a net of points on its surface, at most `NET` apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.hand.robot.source.description import COLLISION, Description
from handlcp.lazy import lazy

# ---------------------------------------------------------------- Convex hulls as coal's shapes.
#
# coal 3.0.3 refuses hulls with a vertex of 255 or more neighbours: the tip of a fine cone, and one corner of a lid with
# as many corners, which is cut into triangles like a fan. It crashes the process on points of one plane.

_MOST, _EACH = 250, 100  # neighbours that a vertex keeps, and how many those have that come in its place
_CUT = 1e-6  # of the edges' lengths: how much of such a vertex is cut off
_FLAT = 1e-9  # of its width: a hull that is thinner is flat


def hull(points: Array) -> Any | None:
    """The convex hull of points (k, 3) [m], a `coal.Convex`; None where they lie in a plane.

    A vertex with too many neighbours is cut off by a millionth of its edges, and several come in its place.
    """
    points = np.unique(points, axis=0)
    width = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1] if len(points) > 3 else np.zeros(3)
    if not width[2] > _FLAT * width[0]:
        return None
    try:
        return coal.Convex.convexHull(_vertices(points), True, "Qt")
    except RuntimeError:
        return _with_few_neighbours(points)


def planes(shape: Any) -> tuple[Array, Array, Array]:
    """The triangles (m, 3, 3) of a hull, their outward normals (m, 3) and offsets (m,): n · x = offset on each."""
    polygons = [shape.polygons(i) for i in range(shape.num_polygons)]
    triangles = np.array(shape.points(), dtype=float)[[[t[0], t[1], t[2]] for t in polygons]]
    if shape.num_normals_and_offsets == len(polygons):
        return triangles, np.array(shape.normals(), dtype=float), -np.array(shape.offsets(), dtype=float)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1)
    triangles, normals = triangles[length > 0.0], normals[length > 0.0] / length[length > 0.0, None]
    return triangles, normals, (triangles[:, 0] * normals).sum(axis=1)


def _vertices(points: Array) -> Any:
    given = coal.StdVec_Vec3s()
    for point in points:
        given.append(point)
    return given


def _with_few_neighbours(points: Array) -> Any:
    """The hull with lids in strips of triangles, and without vertices that even so have too many neighbours."""
    from scipy.spatial import ConvexHull  # a tenth of a second that few meshes should pay

    faces = _in_strips(points, ConvexHull(points))
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    corners, count = np.unique(edges, return_counts=True)
    if (many := corners[count > _MOST]).size:
        kept = [points[corners[count <= _MOST]]]
        for corner in many:
            there = edges[(edges == corner).any(axis=1)]
            to = points[there[there != corner]] - points[corner]
            axis = to.mean(axis=0)
            kept.append(points[corner] + _CUT * to[_round(to, axis)][::_EACH])
        points = np.concatenate(kept)
        faces = _in_strips(points, ConvexHull(points))
    used, faces = np.unique(faces, return_inverse=True)
    triangles = coal.StdVec_Triangle()
    for a, b, c in faces.reshape(-1, 3).tolist():
        triangles.append(coal.Triangle(a, b, c))
    return coal.Convex(_vertices(points[used]), triangles)


def _in_strips(points: Array, found: Any) -> Ints:
    """(m, 3) triangles of a hull found by qhull, counterclockwise from outside; flat faces with more than one of them
    cut into strips, so that no corner of such a face has more than four neighbours there.
    """
    _, face, size = np.unique(found.equations, axis=0, return_inverse=True, return_counts=True)
    out = []
    for own in np.split(np.argsort(face.reshape(-1), kind="stable"), np.cumsum(size)[:-1]):
        corners = np.unique(found.simplices[own])
        middle = points[corners].mean(axis=0)
        corners = corners[_round(points[corners] - middle, found.equations[own[0], :3])]
        low, high = 0, len(corners) - 1
        while high - low > 1:
            out.append(corners[[low, low + 1, high]])
            low += 1
            if high - low > 1:
                out.append(corners[[low, high - 1, high]])
                high -= 1
    return np.array(out)


def _round(to: Array, axis: Array) -> Ints:
    """The order of directions (k, 3) counterclockwise about an axis (3,)."""
    x = np.eye(3)[int(np.argmin(abs(axis)))]
    x = x - axis * (axis @ x) / (axis @ axis)
    return np.argsort(np.arctan2(to @ np.cross(axis, x), to @ x * np.linalg.norm(axis)), kind="stable")


# ----------------------------------------------------------------

NET = 2e-3  # [m] between points: on a ball of 25 mm a depth is then seen to 0.03 mm
_FINEST = 60  # points along the edge of a triangle, at most
_APART = 1e-7  # [m] points that are nearer to each other are one
_AROUND = 16  # points around a cylinder, at least

_SHAPES = (coal.Sphere, coal.Capsule, coal.Cylinder, coal.Box, coal.BVHModelBase, coal.ConvexBase)
_MESHES = (coal.BVHModelBase, coal.ConvexBase)

_TURNS, _HEIGHTS = np.linspace(0.0, 2 * np.pi, 24, endpoint=False), np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)
_ALL_WAYS = np.array([(np.cos(h) * np.cos(t), np.cos(h) * np.sin(t), np.sin(h)) for h in _HEIGHTS for t in _TURNS])

Points = tuple[Array, Array]  # (m, 3) positions, (m,) radii


@dataclass(frozen=True, eq=False)
class LinkSurface:
    """One link. frame : its number in Pinocchio's model. joint : of the joint that carries it. parts : coal's shapes,
    with rotation and position in the link's frame. reach : no part is farther from the frame's origin [m].
    """

    name: str
    frame: int
    joint: int
    parts: tuple[tuple[Any, Array, Array], ...]
    reach: float

    @lazy
    def net(self) -> Points:
        """Points (m, 3) in the link's frame and radii (m,) : balls whose surfaces are, or lie on, the link's [m]."""
        nets = [(x @ R.T + p, r) for shape, R, p in self.parts for x, r in _net(shape)]
        points, radii = (np.concatenate(both) for both in zip(*nets, strict=True))
        return read_only(points), read_only(radii)

    def __getstate__(self) -> dict[str, Any]:
        """With the net in place of the shapes, some of which cannot be pickled."""
        return self.__dict__ | {"net": self.net, "parts": ()}


def link_surfaces(description: Description) -> tuple[LinkSurface, ...]:
    """All links with collision geometry. Raises URDFError for meshes that are missing or cannot be read."""
    links: dict[int, list[tuple[Any, Array, Array]]] = {}
    for part in description.parts(COLLISION):
        if isinstance(part.shape, _SHAPES):
            links.setdefault(part.frame, []).append((part.shape, part.rotation, part.position))
    return tuple([_link(description.model, frame, parts) for frame, parts in sorted(links.items())])


def _link(model: Any, frame: int, parts: list[tuple[Any, Array, Array]]) -> LinkSurface:
    known = model.frames[frame]
    reach = max(float(np.linalg.norm(p)) + _radius(shape) for shape, _, p in parts)
    return LinkSurface(known.name, frame, int(known.parentJoint), tuple(parts), reach)


def _surface(shape: Any) -> Array:
    """(m, 3, 3) corners of a coal mesh's or hull's triangles."""
    return read_only(planes(shape)[0]) if isinstance(shape, coal.ConvexBase) else triangles_of(shape)


def triangles_of(mesh: Any) -> Array:
    """(m, 3, 3) corners of a coal mesh's triangles."""
    corners = np.array(mesh.vertices(), dtype=float)
    faces = [[t[0], t[1], t[2]] for t in (mesh.tri_indices(i) for i in range(mesh.num_tris))]
    return read_only(corners[np.array(faces, dtype=int).reshape(-1, 3)])


def _radius(shape: Any) -> float:
    """Of a ball about the shape's origin that holds it [m]."""
    if isinstance(shape, _MESHES):
        return float(np.linalg.norm(_surface(shape), axis=2).max())
    if isinstance(shape, coal.Box):
        return float(np.linalg.norm(shape.halfSide))
    return float(shape.radius + getattr(shape, "halfLength", 0.0))


def _net(shape: Any) -> Iterator[Points]:
    """Of a shape, in its own frame."""
    if isinstance(shape, _MESHES):
        yield _bare(_once(np.concatenate(list(_triangles(_surface(shape))))))
    elif isinstance(shape, coal.Box):
        yield _bare(_box(2 * np.array(shape.halfSide).reshape(3)))
    elif isinstance(shape, coal.Cylinder):
        yield _bare(_cylinder(shape.radius, 2 * shape.halfLength))
    elif isinstance(shape, coal.Capsule):
        z = _along(2 * shape.halfLength)
        yield np.outer(z, (0.0, 0.0, 1.0)), np.full(len(z), shape.radius)
    else:
        yield np.zeros((1, 3)), np.array([shape.radius])


def _once(points: Array) -> Array:
    """Each of points (m, 3) once: triangles have corners and edges in common, half of a net or more."""
    places = np.round(points / _APART)
    order = np.lexsort(places.T)
    new = np.append(True, (np.diff(places[order], axis=0) != 0.0).any(axis=1))
    return np.asarray(points[np.sort(order[new])])


def _bare(points: Array) -> Points:
    return points, np.zeros(len(points))


def _along(length: float) -> Array:
    """Points from -length / 2 to length / 2."""
    return np.linspace(-0.5 * length, 0.5 * length, 2 + int(length / NET))


def _cylinder(radius: float, length: float) -> Array:
    """Rings on the side, and smaller ones on the ends."""
    turn = np.linspace(0.0, 2 * np.pi, max(_AROUND, int(2 * np.pi * radius / NET)), endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    rings = [radius * circle + (0.0, 0.0, z) for z in _along(length)]
    for r in np.linspace(0.0, radius, 2 + int(radius / NET))[:-1]:
        rings += [r * circle + (0.0, 0.0, z) for z in (-0.5 * length, 0.5 * length)]
    return np.concatenate(rings)


def _box(size: Array) -> Array:
    """Grids on the six faces."""
    faces = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        a, b = (m.ravel() for m in np.meshgrid(_along(size[i]), _along(size[j])))
        for side in (-0.5, 0.5):
            face = np.empty((len(a), 3))
            face[:, i], face[:, j], face[:, k] = a, b, side * size[k]
            faces.append(face)
    return np.concatenate(faces)


def _triangles(triangles: Array) -> Iterator[Array]:
    """Their corners, and grids on those that are larger than the net."""
    yield triangles.reshape(-1, 3)
    edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    cuts = np.clip(np.ceil(edges / NET), 1, _FINEST).astype(int)
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
        if corners and isinstance(shape, _MESHES):
            found.append(_surface(shape).reshape(-1, 3) @ R.T + p)
            continue
        for x, radius in _net(shape) if isinstance(shape, _SHAPES) else ():
            ways = _ALL_WAYS if radius.any() else np.zeros((1, 3))
            found.append((x + radius[:, None] * ways[:, None]).reshape(-1, 3) @ R.T + p)
    return np.concatenate(found) if found else None
