"""A hand and an object as points and distances, many placements at once: rough, and fast enough for a search."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array, Bools
from handlcp.hand.objects.inside import distances
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Mesh
from handlcp.hand.robot.link_surface import planes, surface_points
from handlcp.hand.robot.model import HandModel
from handlcp.hand.sites.touchers import ALL, Toucher, touchers

_POINTS, _OF_PALM = 28, 60  # of a link, and of all links that no finger's joint moves
_FACES, _ALIKE = 80, 0.98  # planes of a mesh, at most; cosine from which two are one


class Skin:
    """Points on all that may touch.

    links : as `touchers` gives them. of (m,) : the link of each point. moves (links, nv) : whether a joint moves a
    link. palm (links,) : whether a link is the palm's, which the joints of all fingers move alike, or none.
    """

    def __init__(self, hand: HandModel) -> None:
        self._hand = hand
        self.links: tuple[Toucher, ...] = touchers(hand, ALL)
        self.moves: Bools = hand.kinematics.moved_by(np.array([t.support[0] for t in self.links]))
        shared = hand.moves.all(axis=0)
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

    def _points(self, link: Toucher, palm: bool) -> Array:
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


def rough_distances(obj: Object) -> Callable[[Array], Array]:
    """Of points (…, 3) in the object's frame [m]: as `distances`; of a convex mesh by its largest faces alone."""
    if not isinstance(obj, Mesh):
        return lambda x: distances(x.reshape(-1, 3), obj).reshape(x.shape[:-1])
    triangles, normals, offsets = planes(obj.geometry)
    a, b, c = triangles.transpose(1, 0, 2)
    largest = np.argsort(-np.linalg.norm(np.cross(b - a, c - a), axis=1), kind="stable")
    kept = list[int]()
    for k in largest:
        if len(kept) < _FACES and (not kept or (normals[kept] @ normals[k]).max() < _ALIKE):
            kept.append(int(k))
    n, d = normals[kept], offsets[kept]
    return lambda x: np.asarray((x @ n.T - d).max(axis=-1))
