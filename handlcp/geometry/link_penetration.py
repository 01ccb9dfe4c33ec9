"""`find_penetrating_links`: links that are inside the object, and how deep."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.errors import InputError
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.geometry.distance import bounding_box
from handlcp.geometry.object import Object
from handlcp.geometry.shape import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.lcp.kernels.dense import kernel
from handlcp.robot.fingertip import make_sphere_tip
from handlcp.robot.hand_model import HandPosture
from handlcp.robot.link_surface import LinkSurface

# ----------------------------------------------------------------
# Links inside an object: which, and how deep. The model knows contacts of fingertips alone.

_MAX_MEASURED_POINTS = 24  # points of a link that are measured one by one, where no formula measures all at once
_IDENTITY = np.eye(3)
_MAX_LINK_DEPTH = 1e-3  # [m] a link deeper in the object cannot be there
_MAX_TIP_LINK_DEPTH = 4e-3  # [m] the same of a link with a fingertip on the object, half the radius of a usual one


@dataclass(frozen=True, slots=True)
class LinkPenetration:
    """A link that is inside the object. depth : of its deepest point below the object's surface [m], beyond that of its
    fingertip where it carries one. tip : that fingertip, or None. left_out : of the links that may touch.
    """

    link: str
    depth: float
    tip: str | None
    left_out: bool

    @property
    def is_impossible(self) -> bool:
        """Whether it is so deep that the hand cannot be there."""
        return self.depth > (_MAX_LINK_DEPTH if self.tip is None else _MAX_TIP_LINK_DEPTH)


def find_penetrating_links(posture: HandPosture, obj: Object, tips: tuple[int, ...]) -> tuple[LinkPenetration, ...]:
    """The links inside the object, the deepest first; tips : numbers of the fingertips that are meant to touch it.

    A link that carries such a fingertip may be as deep as the fingertip is: that much its pad is compressed.
    Raises URDFError where the links' meshes cannot be read.
    """
    hand = posture.hand
    links = hand.link_surfaces
    if not links:
        return ()
    placements, _ = hand.kinematics.frames_at(posture.q, [link.frame for link in links])
    carried = dict[int, list[int]]()
    for i in tips:
        carried.setdefault(hand.tips.places[i].joint, []).append(i)
    found = []
    for k in np.flatnonzero(_may_reach(links, placements, obj)).tolist():
        link, R, p = links[k], placements[k][:3, :3], placements[k][:3, 3]
        depth = _largest_depth(*link.net, R, p, obj)
        own = carried.get(link.joint, ())
        if depth > 0.0 and own:
            deepest = 0.0
            for tip in own:
                with contextlib.suppress(InputError):  # nothing is known of its shape
                    at, turn = posture.tip_positions[tip], posture.tip_rotations[tip]
                    deepest = max(deepest, -nearest_proximity(hand.tip_shapes(tip), at, turn, obj).gap)
            depth -= deepest
        if depth > 0.0:
            left_out = hand.may_touch is not None and link.name not in hand.may_touch
            found.append(LinkPenetration(link.name, depth, hand.fingertips[own[0]] if own else None, left_out))
    return tuple(sorted(found, key=lambda one: -one.depth))


def _may_reach(links: tuple[LinkSurface, ...], placements: Array, obj: Object) -> Bools:
    """(l,) which links may come into the object, as balls around them tell. placements (l, 4, 4) : of their frames."""
    centre, around = bounding_ball(obj)
    reaches = np.array([link.reach for link in links])
    may = np.asarray(np.linalg.norm(placements[:, :3, 3] - centre, axis=1) <= reaches + around)
    near = np.flatnonzero(may)
    if not len(near):
        return may
    middles, radii = zip(*[links[k].ball for k in near.tolist()], strict=True)
    at = np.einsum("lij,lj->li", placements[near, :3, :3], np.array(middles)) + placements[near, :3, 3]
    Q, q = obj.frame
    x = (at - q) @ Q
    gaps = _exact_distances(x, obj)
    may[near] = (np.linalg.norm(at - centre, axis=1) - around if gaps is None else gaps) <= np.array(radii)
    return may


def _largest_depth(points: Array, radii: Array, R: Array, p: Array, obj: Object) -> float:
    """How deep the deepest of balls is in the object [m]; ≤ 0: none is. They have radii (m,), and are at points (m, 3)
    of a frame at p (3,) with rotation R (3, 3).
    """
    Q, q = obj.frame
    if isinstance(obj, Mesh):
        x, rough, of = np.empty_like(points), np.empty(len(points)), np.empty(len(points), np.int64)
        count = _select_in_box(points, radii, Q.T @ R, Q.T @ (p - q), *bounding_box(obj.geometry), x, rough, of)
        x, rough, radii = x[:count], rough[:count], radii[of[:count]]
    else:
        x = points @ (Q.T @ R).T + Q.T @ (p - q)
        if (known := _exact_distances(x, obj)) is not None:
            return float((radii - known).max())
        rough = _rough_distances(x, obj) - radii
    least = np.argsort(rough)[: np.count_nonzero(rough < 0.0)]
    if not len(least):
        return 0.0
    some = least[:: max(1, len(least) // _MAX_MEASURED_POINTS)]
    few = np.unique(np.concatenate([some, least[:_MAX_MEASURED_POINTS]]))
    at = x[few] @ Q.T + q
    if (nearby := obj.closest_all(at)) is not None:
        return float((radii[few] - nearby[0]).max())
    tiny = 1e-6  # a ball without any radius is none
    balls = [make_sphere_tip(float(r) + tiny) for r in radii[few]]
    return max(-(nearest_proximity(b, x, _IDENTITY, obj).gap + tiny) for b, x in zip(balls, at, strict=True))


@kernel
def _select_in_box(
    points: Array, radii: Array, R: Array, p: Array, low: Array, high: Array, x: Array, gaps: Array, of: Ints
) -> int:
    """How many of balls (m,) at points (m, 3) of a frame at p (3,) with rotation R (3, 3) reach into a box. Writes,
    from the first row on, where they are into x (m, 3), their signed distances from the box, and their numbers.
    """
    count = 0
    for i in range(len(points)):
        off2, most = 0.0, -np.inf
        for a in range(3):
            at = p[a] + R[a, 0] * points[i, 0] + R[a, 1] * points[i, 1] + R[a, 2] * points[i, 2]
            x[count, a] = at
            off = max(low[a] - at, at - high[a])
            most = max(most, off)
            off2 += max(off, 0.0) ** 2
        gaps[count] = np.sqrt(off2) + min(most, 0.0) - radii[i]
        if gaps[count] < 0.0:
            of[count] = i
            count += 1
    return count


def point_distances(x: Array, obj: Object, within: Array | float = np.inf) -> Array:
    """(m,) signed distances of points (m, 3) in the object's frame [m]: exact for a ball, a box and a cylinder. Of an
    ellipsoid rough; of a convex mesh, the largest distance to a face's plane: exact inside, at most too small outside.

    within (m,) : [m] points of a mesh which are farther from the box around it are not measured any closer.
    """
    known = _exact_distances(x, obj)
    if known is not None:
        return known
    rough = _rough_distances(x, obj)
    near = rough <= within
    if isinstance(obj, Mesh) and (beyond := obj.beyond(x[near])) is not None:
        rough[near] = beyond
    return rough


def _exact_distances(x: Array, obj: Object) -> Array | None:
    """(m,) signed distances of points in the object's frame, where a formula has them."""
    if isinstance(obj, Sphere):
        return np.asarray(np.linalg.norm(x, axis=1) - obj.radius)
    if isinstance(obj, Box):
        return _box_distances(abs(x) - 0.5 * obj.size)
    if isinstance(obj, Cylinder):
        away = np.hypot(x[:, 0], x[:, 1]) - obj.radius
        return _box_distances(np.stack([away, abs(x[:, 2]) - 0.5 * obj.length], axis=1))
    return None


def _box_distances(beyond: Array) -> Array:
    """(m,) signed distances from how far points lie beyond each pair of faces (m, k)."""
    return np.asarray(np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(beyond.max(axis=1), 0.0))


def _rough_distances(x: Array, obj: Object) -> Array:
    """(m,) what orders points by their depth, and is not above their signed distance by much."""
    if isinstance(obj, Ellipsoid):
        level = np.linalg.norm(x / obj.radii, axis=1)
        return np.asarray((level - 1.0) * float(obj.radii.min()))
    low, high = bounding_box(obj.geometry)  # around a mesh
    return _box_distances(abs(x - 0.5 * (low + high)) - 0.5 * (high - low))


def bounding_ball(obj: Object) -> tuple[Array, float]:
    """Centre (3,) and radius [m] of a ball that holds the object."""
    place = obj.placement
    if isinstance(obj, Sphere):
        return place.translation, obj.radius
    if isinstance(obj, Box):
        return place.translation, 0.5 * float(np.linalg.norm(obj.size))
    if isinstance(obj, Cylinder):
        return place.translation, float(np.hypot(obj.radius, 0.5 * obj.length))
    if isinstance(obj, Ellipsoid):
        return place.translation, float(obj.radii.max())
    points = obj.geometry.points() if obj.triangles is None else obj.triangles
    corners = np.array(points, dtype=float).reshape(-1, 3)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return place.act(middle), float(np.linalg.norm(corners - middle, axis=1).max())
