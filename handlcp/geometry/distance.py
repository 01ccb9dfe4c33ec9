"""`signed_distance`: how far convex shapes of coal are apart or inside each other, confirmed by bounds on both sides.

    h(n) = max over x in the shape of n · x

They follow from the shapes' dimensions alone, so that they can judge the distances that coal computes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import coal
import numpy as np
import scipy

from handlcp.check import Array, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.model.contact import cross_rows
from handlcp.lcp.kernels.dense import kernel
from handlcp.robot.link_surface import hull_planes

_BOX, _SPHERE, _CAPSULE, _CYLINDER, _ELLIPSOID, _HULL = range(6)


class ConvexSolid(NamedTuple):
    """A convex solid in its own axes.

    kind : of shape.
    sizes (3,) [m] : half the sides of a box, the radius and half the length of what is round about z, the radii of an
        ellipsoid.
    points (m, 3), normals, offsets : of a hull, its points and the planes n · x = offset of its faces.
    """

    kind: int
    sizes: Array
    points: Array
    normals: Array
    offsets: Array


_SUPPORTED_SHAPES = (coal.Box, coal.Sphere, coal.Capsule, coal.Cylinder, coal.Ellipsoid, coal.Convex)


def has_support_function(geometry: Any) -> bool:
    """Whether this shape of coal has a support function here."""
    return isinstance(geometry, _SUPPORTED_SHAPES) and geometry.getSweptSphereRadius() == 0.0


@lru_cache(maxsize=1024)  # shapes of a hand and of what it holds: they are asked for at every distance
def make_convex_solid(geometry: Any) -> ConvexSolid:
    """Of a shape of coal that is `known`."""
    match geometry:
        case coal.Box():
            return _make_round_solid(_BOX, *geometry.halfSide)
        case coal.Sphere():
            return _make_round_solid(_SPHERE, geometry.radius)
        case coal.Capsule():
            return _make_round_solid(_CAPSULE, geometry.radius, geometry.halfLength)
        case coal.Cylinder():
            return _make_round_solid(_CYLINDER, geometry.radius, geometry.halfLength)
        case coal.Ellipsoid():
            return _make_round_solid(_ELLIPSOID, *geometry.radii)
        case _:
            _, normals, offsets = hull_planes(geometry)
            return ConvexSolid(_HULL, np.zeros(3), *map(np.ascontiguousarray, (geometry.points(), normals, offsets)))


def _make_round_solid(kind: int, *sizes: float) -> ConvexSolid:
    three = np.zeros(3)
    three[: len(sizes)] = sizes
    return ConvexSolid(kind, three, np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1))


@kernel
def write_support_point(s: ConvexSolid, n: Array, x: Array) -> None:
    """Write the furthest point (3,) along n (3,), a unit vector, in the shape's own axes."""
    if s.kind == _HULL:
        k = np.argmax(s.points[:, 0] * n[0] + s.points[:, 1] * n[1] + s.points[:, 2] * n[2])
        x[:] = s.points[k]
        return
    across = np.sqrt(n[0] * n[0] + n[1] * n[1])
    stretched = np.sqrt((s.sizes[0] * n[0]) ** 2 + (s.sizes[1] * n[1]) ** 2 + (s.sizes[2] * n[2]) ** 2)
    for a in range(3):
        if s.kind == _BOX:
            x[a] = np.copysign(s.sizes[a], n[a])
        elif s.kind == _ELLIPSOID:
            x[a] = s.sizes[a] * s.sizes[a] * n[a] / stretched
        elif s.kind == _CYLINDER:
            x[a] = s.sizes[0] * n[a] / max(across, 1e-300) if a < 2 else np.copysign(s.sizes[1], n[2])
        else:
            x[a] = s.sizes[0] * n[a]
            if s.kind == _CAPSULE and a == 2:
                x[a] += np.copysign(s.sizes[1], n[2])


@kernel
def distance_outside(s: ConvexSolid, x: Array) -> float:
    """By how much the point x (3,), in the shape's axes, lies outside the shape [m]; 0 or less inside."""
    if s.kind == _HULL:
        return float(np.max(s.normals[:, 0] * x[0] + s.normals[:, 1] * x[1] + s.normals[:, 2] * x[2] - s.offsets))
    if s.kind == _BOX:
        return float(max(abs(x[0]) - s.sizes[0], abs(x[1]) - s.sizes[1], abs(x[2]) - s.sizes[2]))
    if s.kind == _CYLINDER:
        return float(max(np.sqrt(x[0] * x[0] + x[1] * x[1]) - s.sizes[0], abs(x[2]) - s.sizes[1]))
    if s.kind == _ELLIPSOID:
        a, b, c = s.sizes
        return float((np.sqrt((x[0] / a) ** 2 + (x[1] / b) ** 2 + (x[2] / c) ** 2) - 1.0) * min(a, b, c))
    off = max(abs(x[2]) - s.sizes[1], 0.0) if s.kind == _CAPSULE else x[2]
    return float(np.sqrt(x[0] * x[0] + x[1] * x[1] + off * off) - s.sizes[0])


@kernel
def write_support_points(s: ConvexSolid, at: Array, ways: Array, sign: float, out: Array) -> None:
    """Write the furthest points (k, 3) of a shape along ways (k, 3), or against them by the sign; at (4, 3) : the
    shape's rotation, and in the last row its place.
    """
    n, x = np.empty(3), np.empty(3)
    for k in range(len(ways)):
        for a in range(3):
            n[a] = sign * (ways[k, 0] * at[0, a] + ways[k, 1] * at[1, a] + ways[k, 2] * at[2, a])
        write_support_point(s, n, x)
        for a in range(3):
            out[k, a] = at[a, 0] * x[0] + at[a, 1] * x[1] + at[a, 2] * x[2] + at[3, a]


_IDENTITY_FRAME = np.vstack([np.eye(3), np.zeros(3)])


def support_points(geometry: Any, n: Array) -> Array:
    """(k, 3) furthest points of the shape along n (k, 3), unit vectors; the shape's own axes."""
    out = np.empty((len(n), 3))
    write_support_points(make_convex_solid(geometry), _IDENTITY_FRAME, np.ascontiguousarray(n), 1.0, out)
    return out


def shape_distance_outside(geometry: Any, x: Array) -> float:
    """As `distance_outside`, of a shape of coal."""
    return distance_outside(make_convex_solid(geometry), x)


@lru_cache(maxsize=1024)
def shape_size(geometry: Any) -> float:
    """A length of the shape [m]: the largest distance of its surface from the origin of its axes, along an axis."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    return float(abs(support_points(geometry, axes)).max())


# ----------------------------------------------------------------
# Boxes and balls that hold coal's shapes, whether they are convex or not.


@lru_cache(maxsize=1024)
def bounding_box(geometry: Any) -> tuple[Array, Array]:
    """(3,) and (3,) the lowest and the highest corner of the box that holds the shape, along its own axes [m]."""
    geometry.computeLocalAABB()  # coal keeps it with the shape
    box = geometry.aabb_local
    return read_only(np.array(box.min_)), read_only(np.array(box.max_))


def bounding_balls(placed: Sequence[tuple[Any, Array, Array]]) -> tuple[Array, Array]:
    """Middles (m, 3) and radii (m,) of balls that hold m shapes [m]; placed : each shape, and its rotation (3, 3) and
    position (3,) [m] in the axes in which the middles are said.
    """
    boxes = [bounding_box(shape) for shape, _, _ in placed]
    middles = [R @ (0.5 * (low + high)) + p for (low, high), (_, R, p) in zip(boxes, placed, strict=True)]
    return np.array(middles), np.array([0.5 * float(np.linalg.norm(high - low)) for low, high in boxes])


# ----------------------------------------------------------------
# How deep two convex shapes overlap, or how far they are apart, from their support functions, between bounds that
# prove it.
#
# With D all differences a - b of points a of the first shape and b of the second, n · x ≤ h(n) = h_A(n) + h_B(-n) in D:
#
#     depth = min over unit n of h(n)
#
# Any n bounds the depth from above. The hull of some points of D lies within D, and the face of it that is nearest to
# the origin bounds the depth from below. Each step adds the furthest points along the normals of the nearest faces,
# until the bounds meet (van den Bergen, Game Developers Conference 2001: EPA, here with hulls by qhull).
#
# Apart, the same points of D bound the distance from above by the one of their hull that is nearest to the origin, and
# any n from below by -h(n); each step adds the furthest point towards the origin (Gilbert, Johnson & Keerthi 1988: GJK,
# here with all points kept and the nearest one by non-negative least squares).


SupportPairs = Callable[[Array], tuple[Array, Array]]

_START_DIRECTIONS, _PROOF_DIRECTIONS = 60, 12  # directions to begin with, and where a depth is only to be proven
_MAX_OVERLAP_STEPS, _FACES_PER_STEP = 60, 6  # steps, and faces looked at in each
_SAME_NORMAL_TOLERANCE = 1e-9  # normals this near to each other are one
_NORMAL_TILTS = (1e-4, 1e-2)  # [rad] of those around the normal that is known
_RING = np.array([(np.cos(a), np.sin(a)) for a in 2 * np.pi * np.arange(3) / 3])


class Overlap(NamedTuple):
    """How deep two solids are inside each other.

    least, most [m] : bounds on the depth.
    normal (3,) : from the first shape into the second, the direction of `most`.
    first, second (3,) [m] : the points of each that are deepest in the other.
    """

    least: float
    most: float
    normal: Array
    first: Array
    second: Array


def find_overlap(furthest: SupportPairs, near: Array, close: float, enough: float = np.inf) -> Overlap | None:
    """None where a plane parts the shapes. After too many steps the bounds may be further apart than `close` [m].

    furthest : from directions (k, 3), unit, the furthest points (k, 3) of the first shape along them, and of the second
    against them. near (3,) : a unit normal to begin with, beside those of a grid. enough [m] : a depth which, proven to
    be the least, ends the search; the points are then only those that are furthest along the normal.
    """
    count = _START_DIRECTIONS if np.isinf(enough) else _PROOF_DIRECTIONS
    n = np.concatenate([_nearby_directions(near), spread_directions(count)])
    first, second = furthest(n)
    h = np.einsum("ij,ij->i", n, first - second)
    for step in range(_MAX_OVERLAP_STEPS):
        if not h.min() >= 0.0:  # or a position is no number
            return None
        hull = scipy.spatial.ConvexHull(first - second)
        inside = -hull.equations[:, 3]
        order = np.argsort(inside, kind="stable")
        n = hull.equations[order[:_FACES_PER_STEP], :3]
        a, b = furthest(n)
        h, least = np.einsum("ij,ij->i", n, a - b), float(inside[order[0]])
        if least >= enough:
            return Overlap(least, float(h[0]), n[0], a[0], b[0])
        if h[0] - least <= close or step == _MAX_OVERLAP_STEPS - 1:
            # Where several faces lie in the nearest plane, the origin's foot lies in one of them
            same = (inside <= least + close) & (hull.equations[:, :3] @ n[0] > 1.0 - _SAME_NORMAL_TOLERANCE)
            faces = hull.simplices[same]
            points = _deepest_points(first[faces], second[faces], least * n[0])
            break
        first, second = np.concatenate([first, a]), np.concatenate([second, b])
    return Overlap(least, float(h[0]), n[0], *points)


def find_separation(furthest: SupportPairs, near: Array, close: float) -> Overlap | None:
    """The distance as an overlap below zero, bounds no further apart than `close` [m]; None where they do not meet, as
    of shapes that touch. furthest, near : as in `find_overlap`.
    """
    first, second = furthest(np.concatenate([_nearby_directions(near), spread_directions(_START_DIRECTIONS)]))
    for _ in range(_MAX_OVERLAP_STEPS):
        D = (second - first).T
        if not np.isfinite(D).all():
            return None
        size = max(float(np.sqrt((D**2).sum(axis=0)).min()), close)
        share, _ = scipy.optimize.nnls(np.vstack([D / size, np.ones(D.shape[1])]), np.array([0.0, 0.0, 0.0, 1.0]))
        share /= share.sum()
        on, beside = share @ first, share @ second
        far = float(np.sqrt((beside - on) @ (beside - on)))
        if not far > close:
            return None
        n = (beside - on) / far
        a, b = furthest(n[None])
        least = float(n @ (b - a)[0])
        if far - least <= close:
            return Overlap(-far, -least, n, on, beside)
        first, second = np.concatenate([first, a]), np.concatenate([second, b])
    return None


def _deepest_points(first: Array, second: Array, at: Array) -> tuple[Array, Array]:
    """The points of both shapes whose difference is the point `at` (3,) of one of the faces: first and second (k, 3, 3)
    are the corners of the faces, in rows. Of the face that holds it best.
    """
    corners = np.concatenate([(first - second).transpose(0, 2, 1), np.ones((len(first), 1, 3))], axis=1)
    shares = np.linalg.pinv(corners) @ np.append(at, 1.0)
    k = int(np.argmax(shares.min(axis=1)))
    share = np.clip(shares[k], 0.0, 1.0)
    share /= share.sum()
    return share @ first[k], share @ second[k]


def spread_directions(k: int, first: float = 0.0) -> Array:
    """(k, 3) unit vectors in all directions, evenly: a spiral from pole to pole, `first` of a step further on."""
    i = np.arange(k)
    z, turn = 1.0 - (2.0 * i + 1.0) / k, np.pi * (3.0 - np.sqrt(5.0)) * (i + first)
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


def outermost_points(points: Array, ways: Array) -> Array:
    """Those of points (m, 3) that are furthest in directions (k, 3), each once."""
    return np.asarray(points[np.unique((points @ ways.T).argmax(axis=0))])


def _nearby_directions(n: Array) -> Array:
    """(1 + 3 k, 3) a direction and some close to it, which bound the depth from below where it is right."""
    x = np.eye(3)[int(np.argmin(abs(n)))]
    x = x - n * (n @ x)
    x /= np.sqrt(x @ x)
    ring = _RING @ np.stack([x, cross_rows(n, x)])
    every = np.concatenate([n[None], *[n + tilt * ring for tilt in _NORMAL_TILTS]])
    return np.asarray(every / np.sqrt((every * every).sum(axis=1, keepdims=True)))


# ----------------------------------------------------------------
# The signed distance of two convex shapes: coal's where their support functions confirm it, else computed from these.
#
# coal 3.0.3 returns -1.8e308, NaN, or a depth that is too large, for some overlaps of cylinders, ellipsoids and hulls.
# With the normal n from the first shape to the second and support functions h:
#
# gap ≥ s(n) = -h_B(-n) - h_A(n)    for any n: the slab between two supporting planes
# gap ≤ |x_A - x_B|                 for any points of the shapes, where they are apart
# gap ≤ -least                      where they overlap; `find_overlap` bounds the depth from below
#
# A distance is confirmed where both bounds agree with it.


Frame: TypeAlias = tuple[Array, Array]  # rotation (3, 3) and position (3,) [m]
Distance: TypeAlias = tuple[float, Array, Array, Array]

# Tolerance of GJK and EPA on the distance [m]: on ellipsoids 1e-10 gives distances to 1e-10 and points to 1e-6; 1e-14
# gives distances to 3e-7, and points no better.
_REQUEST = coal.DistanceRequest()  # coal only reads it
_REQUEST.enable_signed_distance = True
_REQUEST.gjk_tolerance = _REQUEST.epa_tolerance = 1e-10
_REQUEST.gjk_max_iterations = _REQUEST.epa_max_iterations = 1000

# Of the smaller shape's size: distances, points; what own ones aim for
_DISTANCE_TOLERANCE, _POINT_TOLERANCE, _OVERLAP_TOLERANCE = 1e-6, 1e-4, 1e-9
_SEPARATION_SHARES = 1e-5, 1e-4, 1e-3  # of the smaller shape's size: how far touching shapes are moved apart
_NORMAL_LENGTH_TOLERANCE = 1e-6  # how far from 1 the length of coal's normal may be
# [m] what a distance may always be wrong by: normals of shapes that nearly touch are no better
_MIN_DISTANCE_ERROR = 5e-7


def signed_distance(first: Any, at: Frame, second: Any, there: Frame, names: tuple[Any, Any]) -> Distance:
    """(gap [m], nearest point (3,) of the first shape and of the second, normal (3,) from the first into the second),
    world axes; overlapping, the deepest points.

    first, second : coal's shapes, convex. at, there : where they are. names : of both, for messages, by `str`.
    Raises Unsupported where no distance can be confirmed.
    """
    if not (has_support_function(first) and has_support_function(second)):
        kinds = " and ".join(type(g).__name__ for g in (first, second) if not has_support_function(g))
        raise Unsupported(f"no distance between {names[0]} and {names[1]}: no support function is known of a {kinds}")
    pair = _ShapePair(first, at, second, there)
    claimed = coal_distance(first, at, second, there)
    right = pair.is_confirmed(claimed)
    if right and claimed[0] >= -pair.allowed:
        return claimed
    start = claimed[3] if right else pair.way
    close, enough = _OVERLAP_TOLERANCE * pair.size, -claimed[0] - pair.allowed if right else np.inf
    found = find_overlap(pair.support_points, start, close, enough)
    if found is not None:
        if right and found.least >= enough:
            return claimed
        if found.most - found.least <= pair.allowed:
            return -found.most, found.first, found.second, found.normal
    touching = pair.touching_distance(claimed)
    if touching is not None:
        return touching
    parted = find_separation(pair.support_points, start, close)
    if parted is not None:
        return -parted.least, parted.first, parted.second, parted.normal
    raise Unsupported(f"no distance between {names[0]} and {names[1]} could be confirmed: coal says {claimed[0]:.3g} m")


def coal_distance(first: Any, at: Frame, second: Any, there: Frame) -> Distance:
    """As coal says it."""
    result = coal.DistanceResult()
    gap = float(coal.distance(first, coal.Transform3s(*at), second, coal.Transform3s(*there), _REQUEST, result))
    n = np.array(result.normal)
    length = float(np.sqrt(n @ n))
    # Of a capsule that is nearly touching it is off by 1e-8; where it is none it may be any number
    n = n / length if abs(length - 1.0) < _NORMAL_LENGTH_TOLERANCE else n
    return gap, np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2()), n


class _ShapePair:
    """Two shapes where they are. size [m] : of the smaller one. way (3,) : unit, between their origins."""

    def __init__(self, first: Any, at: Frame, second: Any, there: Frame) -> None:
        self._first, self._at, self._second, self._there = first, at, second, there
        self._solids = make_convex_solid(first), make_convex_solid(second)
        self._where = np.vstack(at), np.vstack(there)
        self.size = min(shape_size(first), shape_size(second))
        self.allowed = max(_DISTANCE_TOLERANCE * self.size, _MIN_DISTANCE_ERROR)
        way = there[1] - at[1]
        length = float(np.sqrt(way @ way))
        self.way = way / length if length > 0.0 else np.array([1.0, 0.0, 0.0])

    def support_points(self, n: Array) -> tuple[Array, Array]:
        """(k, 3) points of the first shape along n (k, 3), and of the second against n; world axes."""
        n, one, two = np.ascontiguousarray(n), np.empty((len(n), 3)), np.empty((len(n), 3))
        write_support_points(self._solids[0], self._where[0], n, 1.0, one)
        write_support_points(self._solids[1], self._where[1], n, -1.0, two)
        return one, two

    def is_confirmed(self, claimed: Distance) -> bool:
        """Whether numbers are finite, points belong to the shapes, and the slab across the normal has the gap."""
        (one, two), (at, there), (gap, a, b, n) = self._solids, self._where, claimed
        points = np.concatenate([a, b, n]).reshape(3, 3)
        return bool(
            _is_distance_confirmed(one, at, two, there, gap, points, _POINT_TOLERANCE * self.size, self.allowed)
        )

    def touching_distance(self, claimed: Distance) -> Distance | None:
        """The distance of shapes that just touch; None: it cannot be confirmed, or they do not.

        At a gap of 0 coal's normal is the direction of a vector of no length, and may be no number at all. Moved apart
        a little the shapes show it. The gap is then between the slab across it where they are, and the points moved
        back.
        """
        n = claimed[3]
        ways = (self.way, n) if abs(float(n @ n) - 1.0) < 1e-9 else (self.way,)
        tried = (self._distance_moved_apart(share * self.size, way) for way in ways for share in _SEPARATION_SHARES)
        return next((found for found in tried if found is not None), None)

    def _distance_moved_apart(self, far: float, way: Array) -> Distance | None:
        """As `touching`, from the shapes moved apart by `far` [m]: first along `way`, then along the normal there, and
        the points moved back are as near to each other as they can be.
        """
        for _ in range(2):
            step = far * way
            gap, a, b, n = coal_distance(self._first, self._at, self._second, (self._there[0], self._there[1] + step))
            if not (0.0 < gap < 2.0 * far + self.allowed and abs(float(n @ n) - 1.0) < 1e-9):
                return None
            one, two = self.support_points(n[None])
            across, back = float(n @ (two - one)[0]), b - step  # the slab between the supporting planes across n
            apart = float(np.sqrt((back - a) @ (back - a)))
            if max(abs(across), apart) <= 2.0 * self.allowed and self.is_confirmed((across, a, back, n)):
                return across, a, back, n
            way = n
        return None


@kernel
def _to_shape_axes(at: Array, point: Array, x: Array) -> None:
    """Write a point (3,) of the world as a shape's own axes have it; at (4, 3) : as in `write_support_points`."""
    for a in range(3):
        x[a] = 0.0
        for b in range(3):
            x[a] += at[b, a] * (point[b] - at[3, b])


@kernel
def _is_distance_confirmed(
    one: ConvexSolid,
    at: Array,
    two: ConvexSolid,
    there: Array,
    gap: float,
    claimed: Array,
    points: float,
    allowed: float,
) -> bool:
    """Whether the distance that was found is right, as `_ShapePair.is_confirmed` asks.

    at, there : as in `write_support_points`.
    claimed (3, 3) : the points of both and the normal.
    points, allowed [m] : how far off points, and the gap, may be.
    """
    n, x = claimed[2], np.empty(3)
    if not (abs(gap) < 1e100 and abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0) < 1e-9):
        return False  # the normal is not a number where any of it is not
    for a in range(3):
        if not abs(claimed[1, a] - claimed[0, a] - gap * n[a]) <= points:
            return False
    _to_shape_axes(at, claimed[0], x)
    if not distance_outside(one, x) <= points:
        return False
    _to_shape_axes(there, claimed[1], x)
    if not distance_outside(two, x) <= points:
        return False
    ends = np.empty((2, 1, 3))
    write_support_points(one, at, claimed[2:], 1.0, ends[0])
    write_support_points(two, there, claimed[2:], -1.0, ends[1])
    slab = 0.0
    for a in range(3):
        slab += n[a] * (ends[1, 0, a] - ends[0, 0, a])
    return bool(abs(slab - gap) <= allowed)
