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

from handlcp.check import Array, read_only
from handlcp.hand.robot.hull import planes
from handlcp.hand.robot.source.description import COLLISION, Description
from handlcp.lazy import lazy

NET = 2e-3  # [m] between points: on a ball of 25 mm a depth is then seen to 0.03 mm
_FINEST = 60  # points along the edge of a triangle, at most
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


def _surface(mesh: Any) -> Array:
    """(m, 3, 3) corners of a coal mesh's or hull's triangles."""
    if isinstance(mesh, coal.ConvexBase):
        return read_only(planes(mesh)[0])
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
        yield from (_bare(points) for points in _triangles(_surface(shape)))
    elif isinstance(shape, coal.Box):
        yield _bare(_box(2 * np.array(shape.halfSide).reshape(3)))
    elif isinstance(shape, coal.Cylinder):
        yield _bare(_cylinder(shape.radius, 2 * shape.halfLength))
    elif isinstance(shape, coal.Capsule):
        z = _along(2 * shape.halfLength)
        yield np.outer(z, (0.0, 0.0, 1.0)), np.full(len(z), shape.radius)
    else:
        yield np.zeros((1, 3)), np.array([shape.radius])


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
