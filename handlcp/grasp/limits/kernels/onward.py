"""A path to its end: exact from event to event, then a walk in steps, and an end that is certified.

The exact path ends where forces cannot change so as to balance more load. That is the limit if the state there obeys
the laws, and no step leads to a state under more load, neither from there nor from contacts that all stick. Otherwise,
and where a force turns on its cone, the path goes on as a walk.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.happens import GIVES_UP, JUMPS, LOST, RAY, WATCHED, Watch, room_of
from handlcp.grasp.limits.kernels.pairs import face_of_force
from handlcp.grasp.limits.kernels.parts import CLOSED, OPEN, OPENS, Inverse, Parts, Place
from handlcp.grasp.limits.kernels.rates import points_before_jump, slides_at
from handlcp.grasp.limits.kernels.still import FREE, SLIDES, Still, still_of
from handlcp.grasp.limits.kernels.still_walk import BOUNDED, LOST as ENDS, UNBOUNDED, Bounds, Log, goes_on, walk
from handlcp.grasp.limits.kernels.trace import EVENTS, kinds_of, logged, trace
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import CERTIFY_TOLERANCE

# ----------------------------------------------------------------
# Whether a place obeys the laws: balance, no pull, and friction within its bounds.


@kernel
def is_sound(p: Parts, s: Place, load: Array, allowed: float) -> bool:
    """Whether forces balance load (dof,), press and stay within friction, to a share of the largest of all these."""
    size, off = 1e-300, 0.0
    for x in s.r:
        if not np.isfinite(x):
            return False
        size = max(size, abs(x))
    for x in load:
        size = max(size, abs(x))
    for a in range(len(load)):
        total = load[a]
        for j in range(len(s.r)):
            total += p.G[a, j] * s.r[j]
        off = max(off, abs(total))
    for i in range(len(p.mu)):
        j = p.contacts[i, 0]
        if j >= 0:
            off = max(off, -s.r[j])
    for f in range(len(p.owner)):
        if s.closed[p.owner[f]] == CLOSED:
            off = max(off, -room_of(p, s.r, f))
    return bool(off <= allowed * size)


@kernel
def faces_reached(p: Parts, r: Array, closed: Ints, active: Ints, near: float) -> None:
    """Write into `active` (f,) which faces the forces of closed contacts lie on. A round set has one face, which is
    turned to the force.
    """
    for f in range(len(p.owner)):
        active[f] = 0
        if closed[p.owner[f]] == CLOSED:
            if p.moving[f] == 1:
                face_of_force(p, f, r)
            if room_of(p, r, f) <= near:
                active[f] = 1


# ----------------------------------------------------------------

_ON = 1e-6  # of the largest force: a contact this close to its friction is at it, where a walk ends


class Sets(NamedTuple):
    """Of friction, as in `projection`: faces, normals (f, 3). round (n,) : 1 where a contact's set is."""

    faces: int
    normals: Array
    round: Ints


@kernel
def onward(
    p: Parts, s: Place, w: Array, carried: Array, watch: Watch, sets: Sets, known: Inverse, log: Array, path: Array
) -> tuple[int, float, int, int, int]:  # fmt: skip
    """As `trace`, under a load without end. carried (dof,) : the load at s."""
    begun = _copy(s)
    status, factor, which, events, points = trace(p, s, w, np.inf, watch, known, log, path)
    sound = is_sound(p, s, carried + path[points - 1, 0] * w, CERTIFY_TOLERANCE)
    if sound and (status in (WATCHED, RAY)):
        return status, factor, which, events, points
    if not sound:
        events, points = 0, 1
        s.r[:], s.u[:], s.gap[:], s.give[:], s.slack[:] = begun.r, begun.u, begun.gap, begun.give, begun.slack
        s.closed[:], s.yields[:], s.active[:], s.slides[:] = begun.closed, begun.yields, begun.active, begun.slides
    factor = path[points - 1, 0]
    g, x, z, kinds = _stands(p, s, w, factor, sets)
    before = kinds_of(p, s)
    if sound and status == LOST:
        more = goes_on(g, x, z, kinds, factor)
        if np.isnan(more):
            return LOST, factor, -1, events, points
        factor = more
    bounds = _bounds(watch, len(s.r), len(x))
    marks = Log(path[points:], np.empty((len(path) - points, len(kinds)), np.int64), np.zeros(1, np.int64))
    ends, factor, which = walk(g, x, z, kinds, factor, bounds, marks)
    for k in range(marks.length[0]):
        if events + len(kinds) < len(log):
            events = logged(before, marks.kinds[k], len(p.mu), marks.path[k, 0], log, events)
        before = marks.kinds[k].copy()
    points += marks.length[0]
    _put(p, s, g, x, kinds)
    if ends == ENDS:
        status = LOST
    elif ends == BOUNDED:
        status = WATCHED
    else:
        status = RAY if ends == UNBOUNDED else GIVES_UP
        path[points, 0] = np.nan  # where it goes on from there was not looked at
    return status, factor, which, events, points


@kernel
def onward_each(
    p: Parts, begun: Place, carried: Array, loads: Array, watch: Watch, sets: Sets, length: float, per_slip: Array,
    slid: Array,
    known: Inverse, answers: Array, ends: Ints, points: Array, slips: Array,
) -> None:  # fmt: skip
    """The paths under each of loads (m, dof), all from the same place. answers (m, 4) : its status, what was watched,
    its factor, how many events. ends (m, n + f) : `closed` and `active` there. points (m, ·) : where a contact has
    slid as far as it may, its first entry NaN where none does; slips (m, n) : how far all have slid by then;
    per_slip, slid : as in `slides_at`, length as in
    `points_before_jump`.
    """
    log = np.empty((EVENTS, 3))
    path = np.empty((EVENTS, 1 + len(begun.r) + len(begun.u) + len(begun.give)))
    n, first = len(begun.gap), known.W.copy()
    closed, yields, Z, loose = known.closed.copy(), known.yields.copy(), known.Z.copy(), known.loose[0]
    for a in range(len(loads)):
        known.W[:, :], known.Z[:, :], known.loose[0] = first, Z, loose
        known.closed[:], known.yields[:] = closed, yields
        s = _copy(begun)
        status, factor, which, events, count = onward(p, s, loads[a], carried, watch, sets, known, log, path)
        slips[a] = slid
        known_points = points_before_jump(p, watch.moves, length, path[:count])
        if known_points < count:
            status, count = JUMPS, known_points
        endless = status == RAY and known_points == count and not np.isnan(path[count, 0])
        last = count + 1 if endless else count
        if not slides_at(p, per_slip, slips[a], path[:last], points[a], endless):
            points[a, 0] = np.nan
        answers[a, 0], answers[a, 1], answers[a, 2], answers[a, 3] = status, which, factor, events
        ends[a, :n] = s.closed
        ends[a, n:] = s.active


@kernel
def _copy(s: Place) -> Place:
    return Place(
        s.r.copy(), s.u.copy(), s.gap.copy(), s.give.copy(), s.slack.copy(), s.closed.copy(), s.yields.copy(),
        s.active.copy(), s.slides.copy(),
    )  # fmt: skip


@kernel
def _stands(p: Parts, s: Place, w: Array, factor: float, sets: Sets) -> tuple[Still, Array, Array, Ints]:
    """What a walk starts from at a place under factor · w: (its problem, unknowns x, slips z, contact states kinds)."""
    m, dof, k, n = len(p.E), len(p.G), len(p.rows), len(p.mu)
    x = np.concatenate((s.r, s.u, s.give))
    v, room, load = np.zeros(m), s.slack.copy(), np.empty(dof)
    for i in range(m):
        for j in range(m):
            v[i] += p.E[i, j] * s.r[j]
        for a in range(dof):
            v[i] += p.G[a, i] * s.u[a]
        for b in range(k):
            v[i] += p.rows[b, i] * s.give[b]
            room[b] += p.rows[b, i] * s.r[i]
    for a in range(dof):
        load[a] = -factor * w[a]
        for j in range(m):
            load[a] -= p.G[a, j] * s.r[j]
    gap, z = np.zeros(m), v.copy()
    kinds = kinds_of(p, s)
    for i in range(n):
        j = p.contacts[i, 0]
        if j >= 0:
            gap[j] = (s.gap[i] if s.closed[i] == OPEN else 0.0) - v[j]
            z[j] = 0.0
            if not s.r[j] > 0.0:
                kinds[i] = FREE
        else:
            kinds[i] = FREE
    g = still_of(p.E, p.G, p.rows, p.contacts, sets.round, p.mu, sets.faces, sets.normals, gap, load, room, w)
    return g, x, z, kinds


@kernel
def _bounds(watch: Watch, m: int, size: int) -> Bounds:
    """What is watched, as bounds of a walk: its rows reach over all unknowns x."""
    rows, dof = np.zeros((len(watch.level), size)), watch.moves.shape[1]
    for h in range(len(watch.level)):
        for j in range(watch.rows.shape[1]):
            rows[h, j if j < m else j + dof] = watch.rows[h, j]
    return Bounds(rows, watch.level, watch.moves, watch.start, watch.motion, watch.turn)


@kernel
def _put(p: Parts, s: Place, g: Still, x: Array, kinds: Ints) -> None:
    """Write the end of a walk into a place."""
    m, dof, k, n = len(p.E), len(p.G), len(p.rows), len(p.mu)
    s.r[:], s.u[:], s.give[:] = x[:m], x[m : m + dof], x[m + dof :]
    force = np.max(np.abs(s.r))
    for i in range(n):
        j = p.contacts[i, 0]
        s.gap[i] = 0.0
        if j < 0:
            continue
        s.closed[i] = CLOSED if kinds[i] != FREE else OPEN
        if kinds[i] == FREE:
            s.gap[i] = g.base[j]
            for c in range(len(x)):
                s.gap[i] += g.problem.M[j, c] * x[c]
        elif s.r[j] <= _ON * force:
            s.closed[i] = OPENS
    for b in range(k):
        s.yields[b] = kinds[n + b]
        s.slack[b] = g.base[m + dof + b]
        for j in range(m):
            s.slack[b] -= p.rows[b, j] * s.r[j]
    faces_reached(p, s.r, s.closed, s.active, _ON * force)
    for f in range(len(p.owner)):
        s.slides[f] = 1 if s.active[f] == 1 and kinds[p.owner[f]] == SLIDES else 0
