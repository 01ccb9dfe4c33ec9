"""Along a path until its load has had its largest value, or something that is watched is beyond its level.

A step grows where the path is smooth and shrinks where it bends. Where a contact changes what it does while the load
grows, the new state is asked whether it is also found when the load is given: what only an object that is led can do
is no equilibrium that a load reaches.

Behind the largest load of a path the object snaps. If it comes to rest again near there, as `path.CAUGHT` says, that is
an event, and the path goes on from that place; otherwise that load is the limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from handlcp.grasp.limits.followed.path import Point, PushedPath
from handlcp.grasp.loading.state import Failure, State

__all__ = ["GIVES_UP", "LOST", "PEAK", "RAY", "WATCHED", "Size", "Walk", "snapped", "walk"]

# How a walk ends: the load has had its largest value; no state follows; what is watched is beyond its level; the load
# is beyond any that matters; too many steps
PEAK, LOST, WATCHED, RAY, GIVES_UP = "peak", "lost", "watched", "ray", "gives up"

RAY_AT = 1e4  # times the forces before there is any load: nothing binds that has not bound by then
_FIRST, _MOST, _LEAST = 0.03, 0.5, 1e-4  # of the motion that the forces before make: steps
_MORE = (1e-4, 1e-3)  # of the load: where the path turns, states are searched under so much more of it
_STEPS = 300
_JUMP = 0.25  # of the forces there are: the load of a step, in the mean
_SMOOTH, _BENDS = 1, 4  # looks that a step takes where the path is smooth, and where it bends
_BRIEF = 0.02  # of the motion that the forces before make: so short a motion is no such jump
_FALLS = 0.9  # of the largest load: an object that snaps comes to rest again before no more than this is held


@dataclass(frozen=True, slots=True)
class Size:
    """What is large on a path: motion [m] of the object under the forces [N] that there are before the load."""

    motion: float
    force: float


@dataclass(slots=True)
class Walk:
    """how : it ends. at : the last point at which the load is held, as far as the walk knows; after : the point after
    it, which is beyond the limit; None: there is none.
    """

    how: str
    at: Point
    after: Point | None


def walk(path: PushedPath, first: Point, size: Size, beyond: Callable[[State], float]) -> Walk:
    """From a point until the walk ends. beyond : of a state, above 0 where something watched is beyond its level."""
    top, step = first, _FIRST * size.motion
    if first.before is not None and beyond(first.state) > 0.0:
        return Walk(WATCHED, first.before, first)
    for _ in range(_STEPS):
        new = _next(path, top, step, size)
        if isinstance(new, Failure):
            step /= 4
            if step >= _LEAST * size.motion:
                continue
            if (other := _another(path, top)) is None:
                return Walk(LOST, top, None)
            new = other
        known = new.kinds == top.kinds  # what no contact has changed is found as before
        if not (new.factor > top.factor and (known or path.stays(new))):
            return Walk(PEAK, top, new)
        if beyond(new.state) > 0.0:
            return Walk(WATCHED, top, new)
        if new.factor * path.strength > RAY_AT * size.force:
            return Walk(RAY, new, None)
        step, top = _step(path, top, new, size), new
    return Walk(GIVES_UP, top, None)


def snapped(path: PushedPath, at: Point, after: Point | None, size: Size) -> Point | None:
    """Where the object comes to rest under a little more load than the largest at a point; None: not near it. It is led
    on from the point after until the load has grown past that again; or the load is given.
    """
    last, step = after, 0.0 if after is None else after.size
    while last is not None and path.near(at, last) and last.factor >= _FALLS * at.factor and last.state.loaded:
        if last.factor > (1.0 + _MORE[1]) * at.factor:
            return last._replace(snapped=True)
        new = _next(path, last, step, size)
        if isinstance(new, Failure):
            step /= 4
            if step < _LEAST * size.motion:
                break
            continue
        step, last = _step(path, last, new, size), new
    return path.caught(at, (1.0 + _MORE[1]) * at.factor)


def _step(path: PushedPath, last: Point, new: Point, size: Size) -> float:
    """The next step [m], after one between these points."""
    jump = abs(new.factor - last.factor) * path.strength
    step = _sized(new, jump, _JUMP * max(size.force, new.factor * path.strength))
    return min(step, _MOST * size.motion)


def _next(path: PushedPath, last: Point, step: float, size: Size) -> Point | Failure:
    """The point after a step that is as long as asked for, or so short that neither load nor object jump."""
    while True:
        new = path.beyond(last, step)
        if isinstance(new, Failure):
            return new
        jump = abs(new.factor - last.factor) * path.strength
        most = 2.0 * _JUMP * max(size.force, last.factor * path.strength)
        if jump > 2.0 * most:
            step *= max(most / jump, 1e-3)
        elif not path.strays(new) or path.moved(last, new) <= _BRIEF * size.motion:
            return new
        elif step > _LEAST * size.motion:
            step /= 4
        else:
            return Failure("jumps")


def _another(path: PushedPath, last: Point) -> Point | None:
    """Where the path does not go on as it went: under a little more load."""
    for more in _MORE:
        if (found := path.under(last, last.factor * (1.0 + more))) is not None:
            return found
    return None


def _sized(new: Point, jump: float, most: float) -> float:
    """The next step [m], after one whose load has changed by `jump` [N], where `most` is enough."""
    looks = new.state.looks
    step = new.size * (2.0 if looks <= _SMOOTH else 1.4 if looks < _BENDS else 0.5)
    return min(step, new.size * max(most / jump, 0.25)) if jump > 0.0 else step
