"""A path under a growing load, from event to event: exact where friction has flat faces.

Between events the rates are constant. An event is where a contact's force reaches a face or leaves the normal, where a
gap closes, where a limit is reached or left. What is watched besides (joints' torques, ends of their ranges, the
object's motion) ends the path where it is reached first. Where a contact slides on a round cone its force turns, and
rates change: there the path is left to a walk (`onward`).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.happens import (
    CONTINUES,
    GIVES_UP,
    LOST,
    RAY,
    REACHED,
    TURNS,
    WATCHED,
    Watch,
    conditions,
    put,
    reached,
    settle_at,
)  # fmt: skip
from handlcp.grasp.limits.kernels.pairs import NONE, SOME
from handlcp.grasp.limits.kernels.parts import OPEN, Inverse, Parts, Place
from handlcp.grasp.limits.kernels.rates import Rates, decide
from handlcp.lcp.kernels.dense import kernel

# What happens on a path
SLIPS, STICKS, OPENED, TOUCHES, YIELDS, HOLDS = 0, 1, 2, 3, 4, 5
EVENTS = 400  # of one path; more than twice as many as were ever seen
_FAR = 1e10  # times the load that changes forces by their own size
_APEX = 1e-11  # of the largest force: a tangential force as small as that is none
_STUCK = 40  # events without a step between


@kernel
def trace(
    p: Parts, s: Place, w: Array, end: float, watch: Watch, known: Inverse, log: Array, path: Array
) -> tuple[int, float, int, int, int]:
    """(how it ends, load factor, what was watched, events, points): the path from s under the load factor · w (dof,).

    s is changed to where it ends, and so is `known`. log (EVENTS, 3) : factor, kind and number of each event. path
    (EVENTS, 1 + m + dof + k) : factor, r, u and give at each point; of a ray one more behind them, on it.
    """
    factor, events, points, idle = 0.0, 0, 0, 0
    before = kinds_of(p, s)
    points = _mark(path, points, factor, s)
    over = reached(s, watch)
    if over >= 0:
        return WATCHED, factor, over, events, points
    if end <= 0.0:
        return REACHED, factor, -1, events, points
    while points < EVENTS - 1 and events < EVENTS - len(before):
        found, rates = decide(p, s, w, known)
        if found != SOME:
            return (LOST if found == NONE else GIVES_UP), factor, -1, events, points
        now = kinds_of(p, s)
        events = logged(before, now, len(p.mu), factor, log, events)
        before = now
        if _slides_round(p, s):
            return TURNS, factor, -1, events, points
        status, step, which = _straight(p, s, rates, end - factor, watch)
        if status == RAY:
            _mark_ahead(path, points, factor, s, rates)
            return RAY, np.inf, -1, events, points
        factor += step
        idle = 0 if step > 0.0 else idle + 1
        if step > 0.0:
            points = _mark(path, points, factor, s)
        if status != CONTINUES:
            return status, factor, which, events, points
        if idle > _STUCK:
            break
    return GIVES_UP, factor, -1, events, points


@kernel
def _mark(path: Array, points: int, factor: float, s: Place) -> int:
    m, dof = len(s.r), len(s.u)
    path[points, 0] = factor
    path[points, 1 : 1 + m] = s.r
    path[points, 1 + m : 1 + m + dof] = s.u
    path[points, 1 + m + dof :] = s.give
    return points + 1


@kernel
def _mark_ahead(path: Array, points: int, factor: float, s: Place, rates: Rates) -> None:
    """Write, behind the last point, where a path without an end has come to with as much load more."""
    more, m, dof = max(factor, 1.0), len(s.r), len(s.u)
    path[points, 0] = factor + more
    path[points, 1 : 1 + m] = s.r + more * rates.r
    path[points, 1 + m : 1 + m + dof] = s.u + more * rates.u
    path[points, 1 + m + dof :] = s.give + more * rates.give


@kernel
def kinds_of(p: Parts, s: Place) -> Ints:
    """(n + k,) what contacts do: 0 open, 1 sticks, 2 slides; and limits: 1 where they give way."""
    n = len(p.mu)
    out = np.zeros(n + len(s.yields), np.int64)
    for i in range(n):
        out[i] = 0 if s.closed[i] == OPEN else 1
    for j in range(len(p.owner)):
        if s.slides[j] == 1:
            out[p.owner[j]] = 2
    for q in range(len(s.yields)):
        out[n + q] = 1 if s.yields[q] == 1 else 0
    return out


@kernel
def logged(before: Ints, now: Ints, n: int, factor: float, log: Array, events: int) -> int:
    for i in range(len(now)):
        a, b = before[i], now[i]
        if a == b:
            continue
        if i >= n:
            events = _put(log, events, factor, YIELDS if b == 1 else HOLDS, i - n)
            continue
        if b == 0:
            events = _put(log, events, factor, OPENED, i)
        elif a == 0:
            events = _put(log, events, factor, TOUCHES, i)
        if b == 2:
            events = _put(log, events, factor, SLIPS, i)
        elif b == 1 and a == 2:
            events = _put(log, events, factor, STICKS, i)
    return events


@kernel
def _put(log: Array, events: int, factor: float, kind: int, index: int) -> int:
    if events < len(log):
        log[events, 0], log[events, 1], log[events, 2] = factor, kind, index
    return events + 1


@kernel
def _slides_round(p: Parts, s: Place) -> bool:
    count = 0
    for j in range(len(p.owner)):
        count += p.moving[j] * s.slides[j]
    return bool(count > 0)


@kernel
def _straight(p: Parts, s: Place, rates: Rates, left: float, watch: Watch) -> tuple[int, float, int]:
    """(status, step, what was watched): to the next event, with constant rates."""
    step, which = left, -1
    rate = np.max(np.abs(rates.r))
    far = _FAR * max(np.max(np.abs(s.r)), 1.0) / rate if rate > 0.0 else np.inf  # rates that lead there are rounding
    values, slopes, bends = conditions(p, s, watch, rates)
    for c in range(len(values)):
        h = _first_zero(values[c], slopes[c], bends[c])
        if h < step and h < far:
            step, which = h, c
    if step == np.inf:
        return RAY, step, -1
    which, step = _at_apex(p, s, rates, which, step)
    put(s, rates, step)
    if which < 0:
        return REACHED, step, -1
    return settle_at(p, s, watch, which, step)


@kernel
def _at_apex(p: Parts, s: Place, rates: Rates, which: int, step: float) -> tuple[int, float]:
    """A force that shrinks to nothing along its contact's normal opens it. There its room on a round cone, a square,
    has a double root, which rounding finds too early.
    """
    j = which - 2 * len(p.mu)
    if j < 0 or j >= len(p.owner) or p.moving[j] == 0:
        return which, step
    i = p.owner[j]
    c = p.contacts[i, 0]
    if rates.r[c] >= 0.0:
        return which, step
    end, force = -s.r[c] / rates.r[c], np.max(np.abs(s.r))
    for a in range(3):
        t = p.contacts[i, a + 1]
        if t >= 0 and abs(s.r[t] + end * rates.r[t]) > _APEX * force:
            return which, step
    return i, end


@kernel
def _first_zero(value: float, slope: float, bend: float) -> float:
    """The first h ≥ 0 where value + slope h + bend h² falls below zero; value is not below but for rounding."""
    if bend == 0.0:
        return max(value, 0.0) / -slope if slope < 0.0 else float(np.inf)
    value = max(value, 0.0)
    inside = slope * slope - 4.0 * bend * value
    if inside < 0.0:
        return np.inf
    root = np.sqrt(inside)
    if slope < 0.0:
        return float(2.0 * value / (-slope + root))
    if bend > 0.0:
        return np.inf
    return float((slope + root) / (-2.0 * bend))
