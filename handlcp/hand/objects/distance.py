"""The signed distance of two convex shapes: coal's where their support functions confirm it, else computed from these.

coal 3.0.3 returns -1.8e308, NaN, or a depth that is too large, for some overlaps of cylinders, ellipsoids and hulls.
With the normal n from the first shape to the second and support functions h:

gap ≥ s(n) = -h_B(-n) - h_A(n)    for any n: the slab between two supporting planes
gap ≤ |x_A - x_B|                 for any points of the shapes, where they are apart
gap ≤ -least                      where they overlap; `overlap` bounds the depth from below

A distance is confirmed where both bounds agree with it.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.hand.objects.overlap import apart, overlap
from handlcp.hand.objects.solid import Solid, furthest_along, known, out_of, size_of, solid
from handlcp.lcp.kernels.dense import kernel

Frame: TypeAlias = tuple[Array, Array]  # rotation (3, 3) and position (3,) [m]
Distance: TypeAlias = tuple[float, Array, Array, Array]

# Tolerance of GJK and EPA on the distance [m]: on ellipsoids 1e-10 gives distances to 1e-10 and points to 1e-6; 1e-14
# gives distances to 3e-7, and points no better.
_REQUEST = coal.DistanceRequest()  # coal only reads it
_REQUEST.enable_signed_distance = True
_REQUEST.gjk_tolerance = _REQUEST.epa_tolerance = 1e-10
_REQUEST.gjk_max_iterations = _REQUEST.epa_max_iterations = 1000

_AGREES, _POINTS, _CLOSE = 1e-6, 1e-4, 1e-9  # of the smaller shape's size: distances, points; what own ones aim for
_MOVES = 1e-5, 1e-4, 1e-3  # of the smaller shape's size: how far touching shapes are moved apart
_LENGTH = 1e-6  # how far from 1 the length of coal's normal may be
_LEAST = 5e-7  # [m] what a distance may always be wrong by: normals of shapes that nearly touch are no better


def distance(first: Any, at: Frame, second: Any, there: Frame, names: tuple[Any, Any]) -> Distance:
    """(gap [m], nearest point (3,) of the first shape and of the second, normal (3,) from the first into the second),
    world axes; overlapping, the deepest points.

    first, second : coal's shapes, convex. at, there : where they are. names : of both, for messages, by `str`.
    Raises Unsupported where no distance can be confirmed.
    """
    if not (known(first) and known(second)):
        kinds = " and ".join(type(g).__name__ for g in (first, second) if not known(g))
        raise Unsupported(f"no distance between {names[0]} and {names[1]}: no support function is known of a {kinds}")
    pair = _Pair(first, at, second, there)
    claimed = by_coal(first, at, second, there)
    right = pair.agrees(claimed)
    if right and claimed[0] >= -pair.allowed:
        return claimed
    start = claimed[3] if right else pair.way
    found = overlap(pair.furthest, start, _CLOSE * pair.size, -claimed[0] - pair.allowed if right else np.inf)
    if found is not None:
        if right and found.least >= -claimed[0] - pair.allowed:
            return claimed
        if found.most - found.least <= pair.allowed:
            return -found.most, found.first, found.second, found.normal
    touching = pair.touching(claimed)
    if touching is not None:
        return touching
    parted = apart(pair.furthest, start, _CLOSE * pair.size)
    if parted is not None:
        return -parted.least, parted.first, parted.second, parted.normal
    raise Unsupported(f"no distance between {names[0]} and {names[1]} could be confirmed: coal says {claimed[0]:.3g} m")


def by_coal(first: Any, at: Frame, second: Any, there: Frame) -> Distance:
    """As coal says it."""
    result = coal.DistanceResult()
    gap = float(coal.distance(first, coal.Transform3s(*at), second, coal.Transform3s(*there), _REQUEST, result))
    n = np.array(result.normal)
    length = float(np.sqrt(n @ n))
    # Of a capsule that is nearly touching it is off by 1e-8; where it is none it may be any number
    n = n / length if abs(length - 1.0) < _LENGTH else n
    return gap, np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2()), n


class _Pair:
    """Two shapes where they are. size [m] : of the smaller one. way (3,) : from the first one's origin to the
    second's.
    """

    def __init__(self, first: Any, at: Frame, second: Any, there: Frame) -> None:
        self._first, self._at, self._second, self._there = first, at, second, there
        self._solids, self._where = (solid(first), solid(second)), (np.vstack(at), np.vstack(there))
        self.size = min(size_of(first), size_of(second))
        self.allowed = max(_AGREES * self.size, _LEAST)
        way = there[1] - at[1]
        length = float(np.sqrt(way @ way))
        self.way = way / length if length > 0.0 else np.array([1.0, 0.0, 0.0])

    def furthest(self, n: Array) -> tuple[Array, Array]:
        """(k, 3) points of the first shape along n (k, 3), and of the second against n; world axes."""
        n, one, two = np.ascontiguousarray(n), np.empty((len(n), 3)), np.empty((len(n), 3))
        furthest_along(self._solids[0], self._where[0], n, 1.0, one)
        furthest_along(self._solids[1], self._where[1], n, -1.0, two)
        return one, two

    def agrees(self, claimed: Distance) -> bool:
        """Whether the numbers are finite, the points belong to the shapes, and the slab across the normal is as wide as
        the gap.
        """
        (one, two), (at, there), (gap, a, b, n) = self._solids, self._where, claimed
        points = np.concatenate([a, b, n]).reshape(3, 3)
        return bool(_agrees(one, at, two, there, gap, points, _POINTS * self.size, self.allowed))

    def touching(self, claimed: Distance) -> Distance | None:
        """The distance of shapes that just touch; None: it cannot be confirmed, or they do not.

        At a gap of 0 coal's normal is the direction of a vector of no length, and may be no number at all. Moved apart
        a little the shapes show it. The gap is then between the slab across it where they are, and the points moved
        back.
        """
        n = claimed[3]
        ways = (self.way, n) if abs(float(n @ n) - 1.0) < 1e-9 else (self.way,)
        tried = (self._moved_back(share * self.size, way) for way in ways for share in _MOVES)
        return next((found for found in tried if found is not None), None)

    def _moved_back(self, far: float, way: Array) -> Distance | None:
        """As `touching`, from the shapes moved apart by `far` [m]: first along `way`, then along the normal there, and
        the points moved back are as near to each other as they can be.
        """
        for _ in range(2):
            step = far * way
            gap, a, b, n = by_coal(self._first, self._at, self._second, (self._there[0], self._there[1] + step))
            if not (0.0 < gap < 2.0 * far + self.allowed and abs(float(n @ n) - 1.0) < 1e-9):
                return None
            across, back = self._slab(n), b - step
            apart = float(np.sqrt((back - a) @ (back - a)))
            if max(abs(across), apart) <= 2.0 * self.allowed and self.agrees((across, a, back, n)):
                return across, a, back, n
            way = n
        return None

    def _slab(self, n: Array) -> float:
        """How wide the slab between the supporting planes across n is [m]: no more than the gap."""
        one, two = self.furthest(n[None])
        return float(n @ (two - one)[0])


@kernel
def _seen_from(at: Array, point: Array, x: Array) -> None:
    """Write a point (3,) of the world as a shape's own axes have it; at (4, 3) : as in `furthest_along`."""
    for a in range(3):
        x[a] = 0.0
        for b in range(3):
            x[a] += at[b, a] * (point[b] - at[3, b])


@kernel
def _agrees(
    one: Solid, at: Array, two: Solid, there: Array, gap: float, claimed: Array, points: float, allowed: float
) -> bool:  # fmt: skip
    """See `_Pair.agrees`. at, there : as in `furthest_along`. claimed (3, 3) : the points of both and the normal.
    points, allowed [m] : how far off points, and the gap, may be.
    """
    n, x = claimed[2], np.empty(3)
    if not (abs(gap) < 1e100 and abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0) < 1e-9):
        return False  # the normal is not a number where any of it is not
    for a in range(3):
        if not abs(claimed[1, a] - claimed[0, a] - gap * n[a]) <= points:
            return False
    _seen_from(at, claimed[0], x)
    if not out_of(one, x) <= points:
        return False
    _seen_from(there, claimed[1], x)
    if not out_of(two, x) <= points:
        return False
    ends = np.empty((2, 1, 3))
    furthest_along(one, at, claimed[2:], 1.0, ends[0])
    furthest_along(two, there, claimed[2:], -1.0, ends[1])
    slab = 0.0
    for a in range(3):
        slab += n[a] * (ends[1, 0, a] - ends[0, 0, a])
    return bool(abs(slab - gap) <= allowed)
