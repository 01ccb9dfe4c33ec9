"""A hand and an object as points and distances, many placements at once: rough, and fast enough for a search."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy

from handlcp.check import Array, Bools
from handlcp.geometry.distance import bounding_box
from handlcp.geometry.link_contacts import ALL_LINKS, ContactBody, contact_bodies
from handlcp.geometry.link_penetration import point_distances
from handlcp.geometry.mesh import plane_distances
from handlcp.geometry.object import Object
from handlcp.geometry.shape import Mesh
from handlcp.robot.hand_model import HandModel
from handlcp.robot.link_surface import hull_planes, surface_points

_POINTS, _OF_PALM = 28, 60  # of a link, and of all links that no finger's joint moves
_CELLS, _AROUND = 64, 0.01  # points of a grid along each edge; [m] how far it goes beyond the object
_FACES, _ALIKE = 80, 0.98  # planes of a mesh, at most; cosine from which two are one


class Skin:
    """Points on all that may touch.

    links : as `contact_bodies` gives them. of (m,) : the link of each point. moves (links, nv) : whether a joint moves
    a link. palm (links,) : whether a link is the palm's, which the joints of all fingers move alike, or none.
    """

    def __init__(self, hand: HandModel) -> None:
        self._hand = hand
        self.links: tuple[ContactBody, ...] = contact_bodies(hand, ALL_LINKS)
        self.moves: Bools = hand.kinematics.find_moving_joints(np.array([t.support[0] for t in self.links]))
        shared = hand.moving_joints.all(axis=0)
        inner = ~(self.moves & ~shared).any(axis=1)
        carried = self.moves.sum(axis=1)
        self.palm: Bools = inner & (carried == carried[inner].max(initial=0))
        self._joints = [t.place.joint for t in self.links]
        found = [self._points(t, palm) for t, palm in zip(self.links, self.palm, strict=True)]
        self._local = np.concatenate(found)
        self.of = np.repeat(np.arange(len(found)), [len(points) for points in found])
        self.starts = np.cumsum([0, *map(len, found)])[:-1]

    def at(self, qs: Array) -> Array:
        """(k, m, 3) the points in postures (k, nv), world axes [m]."""
        out = np.empty((len(qs), *self._local.shape))
        for row, q in zip(out, qs, strict=True):
            at, _ = self._hand.kinematics.joints_at(q, self._joints)
            row[:] = np.einsum("mxy,my->mx", at[self.of, :3, :3], self._local) + at[self.of, :3, 3]
        return out

    def least(self, gaps: Array) -> Array:
        """(k, links) the smallest of each link's points (k, m)."""
        return np.asarray(np.minimum.reduceat(gaps, self.starts, axis=1))

    def _points(self, link: ContactBody, palm: bool) -> Array:
        """(k, 3) points of a link in the frame of its joint, far from each other."""
        found = surface_points([(s.geometry, s.rotation, s.translation) for s in link.shapes])
        assert found is not None  # all that may touch has a surface
        place = link.place.placement
        chosen = _spread(found, _OF_PALM if palm else _POINTS)
        return np.asarray(chosen @ place.rotation.T + place.translation)


def _spread(points: Array, most: int) -> Array:
    """Up to so many of points (m, 3), each the farthest from those before."""
    chosen = [int(np.argmax(((points - points.mean(axis=0)) ** 2).sum(axis=1)))]
    away = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(most, len(points)):
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
    return np.asarray(points[chosen])


Measure = Callable[[Array], Array]  # of points (…, 3) in the object's frame, signed distances (…) [m]


def rough_distances(obj: Object) -> Measure:
    """As `point_distances`; of a mesh by the largest faces of its convex parts alone."""
    if not isinstance(obj, Mesh):
        return lambda x: point_distances(x.reshape(-1, 3), obj).reshape(x.shape[:-1])
    parts = [_beyond_faces(part) for part in obj.parts]
    return parts[0] if len(parts) == 1 else _on_grid(parts, *bounding_box(obj.geometry))


def _beyond_faces(hull: Any) -> Measure:
    """How far points are beyond the face of a hull that they are furthest beyond."""
    triangles, normals, offsets = hull_planes(hull)
    a, b, c = triangles.transpose(1, 0, 2)
    largest = np.argsort(-np.linalg.norm(np.cross(b - a, c - a), axis=1), kind="stable")
    kept = list[int]()
    for k in largest:
        if len(kept) < _FACES and (not kept or (normals[kept] @ normals[k]).max() < _ALIKE):
            kept.append(int(k))
    n, d = normals[kept], offsets[kept]

    return lambda x: plane_distances(x.reshape(-1, 3), n, d).reshape(x.shape[:-1])


def _on_grid(parts: Sequence[Measure], low: Array, high: Array) -> Measure:
    """The least of what parts within this box measure, between the points of a grid: as quick for many as for one."""
    low, high = low - _AROUND, high + _AROUND
    step = (high - low) / (_CELLS - 1)
    ticks = low + step * np.arange(_CELLS)[:, None]
    points = np.stack(np.meshgrid(*ticks.T, indexing="ij"), axis=-1)
    known = np.min([part(points) for part in parts], axis=0)

    def between(x: Array) -> Array:
        points = x.reshape(-1, 3)
        within = np.clip(points, low, high)
        away = np.linalg.norm(points - within, axis=1)
        return np.asarray(scipy.ndimage.map_coordinates(known, ((within - low) / step).T, order=1) + away).reshape(
            x.shape[:-1]
        )

    return between
