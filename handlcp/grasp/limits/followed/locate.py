"""Where exactly a walk ends: the largest load between its points, the event behind which nothing holds, or the level
that something watched reaches.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from handlcp.grasp.limits.followed.path import Point, PushedPath
from handlcp.grasp.limits.followed.walk import WATCHED, Walk
from handlcp.grasp.loading.state import Failure, State

__all__ = ["LOCATED", "located"]

LOCATED = 2e-5  # of the factor
_HALVINGS, _TRIES = 40, 10


def located(path: PushedPath, ended: Walk, beyond: Callable[[State], float]) -> tuple[Point, Point | None]:
    """The last point that is held, to a share `LOCATED` of the factor, and one beyond it, if there is any."""
    at, after = ended.at, ended.after
    if after is None:
        return at, None
    if after.snapped:
        return at, after
    if ended.how == WATCHED:
        return _level(path, at, after, beyond)
    if after.before is not at:  # it snapped, and never came to rest
        return at, after
    if after.factor >= at.factor:
        return _event(path, at, after)
    return _peak(path, at, after)


def _level(path: PushedPath, low: Point, high: Point, beyond: Callable[[State], float]) -> tuple[Point, Point]:
    """By regula falsi on what is watched (Illinois), from the point below the level."""
    base, a, b = low, 0.0, high.size
    fa, fb = beyond(low.state), beyond(high.state)
    for _ in range(_HALVINGS):
        if high.factor - low.factor <= LOCATED * abs(high.factor):
            break
        size = (a * fb - b * fa) / (fb - fa)
        size = min(max(size, a + 1e-3 * (b - a)), b - 1e-3 * (b - a))
        new = path.beyond(base, size)
        if isinstance(new, Failure):
            break
        value = beyond(new.state)
        if value > 0.0:
            high, b, fb, fa = new, size, value, 0.5 * fa
        else:
            low, a, fa, fb = new, size, value, 0.5 * fb
    return low, high


def _event(path: PushedPath, low: Point, high: Point) -> tuple[Point, Point]:
    """Between a point and one with contacts in other states: the last point before and the first one after, as near to
    each other as `LOCATED` of the step. Where forces lead to the event, it is foreseen.
    """
    base, a, b = low, 0.0, high.size
    for _ in range(2 * _TRIES):
        foreseen = float(path.foreseen(base, low, a, high).min())
        size = foreseen * (1.0 - 0.5 * LOCATED) if a < foreseen < b else 0.5 * (a + b)
        if size - a <= LOCATED * high.size:  # just before it
            size = min(a + 2.0 * LOCATED * high.size, 0.5 * (a + b))
        new = path.beyond(base, size)
        if isinstance(new, Failure) or new.kinds != base.kinds:
            b, high = size, high if isinstance(new, Failure) else new
        else:
            a, low = size, new
        if b - a <= 4.0 * LOCATED * high.size:
            break
    return low, high


def _peak(path: PushedPath, at: Point, after: Point) -> tuple[Point, Point]:
    """The largest load about the point at, which has a smaller one before it and after it."""
    first = at.before or at
    middle = 0.0 if first is at else at.size  # where along the way from `first` its two steps meet

    def beyond(place: float) -> Point | Failure:
        return path.beyond(first, place) if place < middle else path.beyond(at, place - middle)

    way = [(0.0, first), (middle, at), (middle + after.size, after)][0 if first is not at else 1 :]
    for (x, low), (_, high) in list(pairwise(way)):
        if low.kinds != high.kinds:
            way += [(x + p.size, p) for p in _event(path, low, high) if p is not low and p is not high]
    way.sort(key=lambda each: each[0])
    for _ in range(_TRIES):
        place = _between(way)
        new = None if place is None else beyond(place)
        if place is None or new is None or isinstance(new, Failure):
            break
        way.append((place, new))
        way.sort(key=lambda each: each[0])
    k = max(range(len(way)), key=lambda i: way[i][1].factor)
    return way[k][1], way[min(k + 1, len(way) - 1)][1]


def _between(way: list[tuple[float, Point]]) -> float | None:
    """Where on the way its largest load may be, by the parabola through three points; None: it is known well enough."""
    k = max(range(len(way)), key=lambda i: way[i][1].factor)
    if k == len(way) - 1:
        return None
    (xb, b), (xc, c) = way[k : k + 2]
    if k == 0:
        return 0.5 * (xb + xc)
    xa, a = way[k - 1]
    left, right = xb - xa, xc - xb
    if b.kinds != c.kinds and right <= 8.0 * LOCATED * way[-1][0]:
        return None  # a corner
    up, down = (b.factor - a.factor) / left, (b.factor - c.factor) / right
    if not up + down > 0.0:
        return None
    place = xb + 0.5 * (up * right - down * left) / (up + down)
    most = min(up, down) * max(left, right)  # by how much it may be larger: on a path with corners, and on a smooth one
    if a.kinds == c.kinds:
        most = min(most, (up + down) / (left + right) * (place - xb) ** 2 + 0.1 * LOCATED * b.factor)
    if most <= LOCATED * b.factor:
        return None
    near = 0.05 * (left + right)
    if abs(place - xb) < near:
        place = xb + near if right > left else xb - near
    return float(min(max(place, xa + 0.1 * left), xc - 0.1 * right))
