"""Events that may come next on a path: for each a condition that is positive until the event, and the state after it.

The conditions, in this order: the normal force of each contact, its gap, the room of each face, the slack and the give
of each limit, what is watched, the motion and the turn. An event that cannot come next has `_NEVER`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.limits.kernels.parts import CLOSED, CLOSES, OPEN, OPENS, Parts, Place
from handlcp.grasp.limits.kernels.rates import Rates
from handlcp.lcp.kernels.dense import kernel

# The status of a path: how it ends, that it goes on, that a force turns on its round cone, or that the object jumps
REACHED, LOST, WATCHED, RAY, GIVES_UP, CONTINUES, TURNS, JUMPS = 0, 1, 2, 3, 4, 5, 6, 7
_TIE = 1e-11  # of the largest force, gap or motion: an event that is no farther away has come
_NEVER = 1e300


class Watch(NamedTuple):
    """rows (h, m + k) and level (h,): the path ends where rows · (r, give) reaches a level. moves (6, dof) : motion of
    the reference point and turn from u [m, rad]; start (6,) : where they are counted from. motion, turn : most.
    """

    rows: Array
    level: Array
    moves: Array
    start: Array
    motion: float
    turn: float


@kernel
def reached(s: Place, watch: Watch) -> int:
    """Which of what is watched is beyond its level already; -1: none."""
    worst, by = -1, 0.0
    for h in range(len(watch.level)):
        over = _watched(s, watch, h)
        if over < by - _TIE * abs(watch.level[h]):
            worst, by = h, over
    return worst


@kernel
def _watched(s: Place, watch: Watch, h: int) -> float:
    left, m = watch.level[h], len(s.r)
    for j in range(m):
        left -= watch.rows[h, j] * s.r[j]
    for q in range(len(s.give)):
        left -= watch.rows[h, m + q] * s.give[q]
    return float(left)


@kernel
def conditions(p: Parts, s: Place, watch: Watch, rates: Rates) -> tuple[Array, Array, Array]:
    """(value, slope, bend): each condition is value + slope h + bend h² after h of the load, at constant rates."""
    n, f, k, m, rows = len(p.mu), len(p.owner), len(p.rows), len(p.E), len(watch.level)
    count = 2 * n + f + 2 * k + rows + 2
    value, slope, bend = np.full(count, _NEVER), np.zeros(count), np.zeros(count)
    for i in range(n):
        j = p.contacts[i, 0]
        if j < 0:
            continue
        if s.closed[i] == CLOSED:
            value[i], slope[i] = s.r[j], rates.r[j]
        elif s.closed[i] == OPEN:
            value[n + i], slope[n + i] = s.gap[i], rates.gap[i]
    for j in range(f):
        i, c = p.owner[j], 2 * n + j
        if s.closed[i] != CLOSED or s.active[j] == 1:
            continue
        room, more = p.mu[i] * s.r[p.contacts[i, 0]], p.mu[i] * rates.r[p.contacts[i, 0]]
        if p.moving[j] == 1:  # μ² r_N² - |r_T|²
            value[c], slope[c], bend[c] = room * room, 2.0 * room * more, more * more
        else:
            value[c], slope[c] = room, more
        for a in range(3):
            t = p.contacts[i, a + 1]
            if t >= 0:
                if p.moving[j] == 1:
                    value[c] -= s.r[t] * s.r[t]
                    slope[c] -= 2.0 * s.r[t] * rates.r[t]
                    bend[c] -= rates.r[t] * rates.r[t]
                else:
                    value[c] -= p.normals[j, a] * s.r[t]
                    slope[c] -= p.normals[j, a] * rates.r[t]
    for q in range(k):
        c = 2 * n + f + q
        if s.yields[q] == 1:
            value[c + k], slope[c + k] = s.give[q], rates.give[q]
        else:
            value[c], slope[c] = s.slack[q], rates.slack[q]
    c = 2 * n + f + 2 * k
    for h in range(rows):
        value[c + h] = _watched(s, watch, h)
        for j in range(m):
            slope[c + h] -= watch.rows[h, j] * rates.r[j]
        for q in range(k):
            slope[c + h] -= watch.rows[h, m + q] * rates.give[q]
    _motions(watch, s, rates, value, slope, bend)
    return value, slope, bend


@kernel
def _motions(watch: Watch, s: Place, rates: Rates, value: Array, slope: Array, bend: Array) -> None:
    """The last two conditions: most² - |motion|²."""
    for part in range(2):
        most = watch.motion if part == 0 else watch.turn
        if most == np.inf:
            continue
        c = len(value) - 2 + part
        value[c] = most * most
        for a in range(3 * part, 3 * part + 3):
            here, more = -watch.start[a], 0.0
            for b in range(len(s.u)):
                here += watch.moves[a, b] * s.u[b]
                more += watch.moves[a, b] * rates.u[b]
            value[c] -= here * here
            slope[c] -= 2.0 * here * more
            bend[c] -= more * more


@kernel
def put(s: Place, rates: Rates, step: float) -> None:
    """Move on by this much of the load."""
    s.r[:] += step * rates.r
    s.u[:] += step * rates.u
    s.gap[:] += step * rates.gap
    s.give[:] += step * rates.give
    s.slack[:] += step * rates.slack


@kernel
def settle_at(p: Parts, s: Place, watch: Watch, which: int, step: float) -> tuple[int, float, int]:
    """(status, step, what was watched): write into s what contacts and limits do after event `which`, and after all
    events that come at the same load.
    """
    n, f, k = len(p.mu), len(p.owner), len(p.rows)
    first = 2 * n + f + 2 * k
    if which >= first:
        return WATCHED, step, which - first
    force, gap = np.max(np.abs(s.r)), np.max(np.abs(s.gap))
    for i in range(n):
        j = p.contacts[i, 0]
        if j < 0:
            continue
        if s.closed[i] == CLOSED and (which == i or s.r[j] <= _TIE * force):
            s.closed[i] = OPENS
            for a in range(4):
                if p.contacts[i, a] >= 0:
                    s.r[p.contacts[i, a]] = 0.0
            s.gap[i] = 0.0
        elif s.closed[i] == OPEN and (which == n + i or s.gap[i] <= _TIE * gap):
            s.closed[i] = CLOSES
            s.gap[i] = 0.0
    for j in range(f):
        i = p.owner[j]
        if s.closed[i] != CLOSED:
            s.active[j] = s.slides[j] = 0
        elif s.active[j] == 0 and (which == 2 * n + j or room_of(p, s.r, j) <= _TIE * force):
            s.active[j] = s.slides[j] = 1
    for q in range(k):
        c = 2 * n + f + q
        if s.yields[q] == 0 and (which == c or s.slack[q] <= _TIE * force):
            s.yields[q], s.slack[q] = 2, 0.0
        elif s.yields[q] == 1 and which == c + k:
            s.yields[q], s.give[q] = 2, 0.0
    return CONTINUES, step, -1


@kernel
def room_of(p: Parts, r: Array, j: int) -> float:
    """How far the force of a contact is from a face of its friction set."""
    i, used, size = p.owner[j], 0.0, 0.0
    for a in range(3):
        t = p.contacts[i, a + 1]
        if t >= 0:
            used += p.normals[j, a] * r[t]
            size += r[t] * r[t]
    return float(p.mu[i] * r[p.contacts[i, 0]] - (np.sqrt(size) if p.moving[j] == 1 else used))
