"""What binds at the end of a path with the geometry followed, and what happened on the way, by name."""

from __future__ import annotations

from itertools import pairwise

from handlcp.grasp.limits.followed.path import Point, PushedPath
from handlcp.grasp.limits.followed.walk import WATCHED
from handlcp.grasp.limits.followed.watched import Watched
from handlcp.grasp.limits.result import EQUILIBRIUM, OBJECT, OPENS, SLIPS, Bind, LimitEvent
from handlcp.grasp.loading.state import OPEN, SLIDES

__all__ = ["binds_of", "events_of", "way_to"]


def binds_of(how: str, at: Point, after: Point | None, watched: Watched, names: tuple[str, ...]) -> tuple[Bind, ...]:
    """What is at its level; or contacts that open there; or all that slide; or balance itself.

    after : the point after the limit, where it is an event: what happens at it counts. Where the load just turns, what
    slides there does.
    """
    if how == WATCHED:
        return watched.binds(at.state if after is None or not after.snapped else after.state)
    kinds = at.kinds if after is None else after.kinds
    opened = [n for n, a, b in zip(names, at.kinds, kinds, strict=True) if b == OPEN != a]
    if opened:
        return tuple([Bind(OPENS, name) for name in opened])
    sliding = [n for n, a, b in zip(names, at.kinds, kinds, strict=True) if SLIDES in (a, b)]
    return tuple([Bind(SLIPS, name) for name in sliding]) or (Bind(EQUILIBRIUM, OBJECT),)


def way_to(at: Point) -> list[Point]:
    """All points of the path, in order."""
    found: list[Point] = [at]
    while (before := found[-1].before) is not None:
        found.append(before)
    return found[::-1]


def events_of(path: PushedPath, at: Point) -> tuple[LimitEvent, ...]:
    """What happens up to a point. Where margins foresee when a contact slips or opens, that is the factor; else that
    of the step's end.
    """
    found, watch = list[LimitEvent](), path.stepper.watch
    names = {name: i for i, name in enumerate(path.stepper.grasp.spec.names)}
    way = way_to(at)
    for a, b in pairwise(way):
        sizes = path.foreseen(a, a, 0.0, b)
        for event in watch.events(a.state, b.state, "", 0, 0.0):
            factor = b.factor
            if event.kind in (SLIPS, OPENS) and event.who in names:
                factor = _foreseen(a, b, float(sizes[names[event.who]]))
            found.append(LimitEvent(event.kind, event.who, factor))
        if b.snapped:
            found.append(LimitEvent("snaps", OBJECT, b.factor))
    return tuple(sorted(found, key=lambda e: e.factor))


def _foreseen(a: Point, b: Point, size: float) -> float:
    """The factor `size` behind a, on the way to b. The load goes on there as it came to a: what happens bends it."""
    if a.before is None or not size < b.size:
        return b.factor
    low, high = sorted((a.factor, b.factor))
    return min(max(a.factor + max(size, 0.0) * (a.factor - a.before.factor) / a.size, low), high)
