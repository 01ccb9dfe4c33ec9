"""How forces and motions change with the load at one place of a path: friction opposes the rate of slip.

    0 ≤ γ ⟂ -a·ṙ ≥ 0,    b γ against the motion

is the law of a face that the force lies on (a = n on the tangents and -μ on the normal, b = n on the tangents), of a
contact that touches without a force (a = b = -1 on the normal), and of a limit that is just reached (a = b = its row).
All of them at once are a small complementarity problem (`pairs`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.pairs import (
    LIMIT,
    NONE,
    NORMAL,
    SOME,
    UNKNOWN,
    Solved,
    face_of_force,
    pairs_at,
    respond,
    solve_pairs,
)
from handlcp.grasp.limits.kernels.parts import CLOSED, OPEN, OPENS, Inverse, Parts, Place, update
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import MIN_SNAP_DISTANCE

_MOST = 6  # contacts that touch without force at one place, of which all choices are tried
_TURNS, _WHOLE, _TURNED = 100, 20, 1e-12
_TINY = 1e-9
_DRIVEN = 1e-9  # of the load: with more of it along a motion that nothing resists there is no balance


class Rates(NamedTuple):
    """By one unit of the load: r (m,), u (dof,), give (k,), gap (n,), slack (k,)."""

    r: Array
    u: Array
    give: Array
    gap: Array
    slack: Array


@kernel
def _rates(p: Parts, x: Array, give: Array) -> Rates:
    """From the response x, with the rates of limits that begin to give way in `give`."""
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    r, u = x[:m].copy(), x[m : m + dof].copy()
    s = x[m + dof :] + give
    slack = np.zeros(k)
    for q in range(k):
        for j in range(m):
            slack[q] -= p.rows[q, j] * r[j]
    gap = np.zeros(len(p.mu))
    for i in range(len(gap)):
        c = p.contacts[i, 0]
        if c >= 0:
            for j in range(m):
                gap[i] += p.E[c, j] * r[j]
            for a in range(dof):
                gap[i] += p.G[a, c] * u[a]
            for q in range(k):
                gap[i] += p.rows[q, c] * s[q]
    return Rates(r, u, s, gap, slack)


@kernel
def decide(p: Parts, s: Place, w: Array, known: Inverse) -> tuple[int, Rates]:
    """The rates under the load w (dof,), and what contacts and limits do, written into s; whether there are SOME, NONE
    or it is UNKNOWN.
    """
    n, k, m, dof = len(p.mu), len(p.rows), len(p.E), len(w)
    touching, many = np.empty(n, np.int64), 0
    for i in range(n):
        if s.closed[i] > CLOSED:
            touching[many] = i
            many += 1
    for j in range(len(p.owner)):
        if p.moving[j] == 1 and s.active[j] == 1 and s.closed[p.owner[j]] == CLOSED:
            face_of_force(p, j, s.r)
    given = np.zeros(k, np.int64)
    for q in range(k):
        given[q] = 1 if s.yields[q] == 1 else 0
    closed, none = s.closed.copy(), UNKNOWN if many > _MOST else NONE
    x, x0 = np.zeros(m + dof + k), np.zeros(m + dof + k)
    for choice in range(2 ** min(many, _MOST)):
        for t in range(many):
            i = touching[t]
            other = (choice >> min(t, _MOST - 1)) & 1
            closed[i] = OPEN if (s.closed[i] == OPENS) == (other == 0) else CLOSED
        update(p, closed, given, known)
        if _is_driven(known, w):
            continue
        x0[:] = 0.0
        for a in range(dof):
            if w[a] != 0.0:
                x0 -= w[a] * known.W[m + a]
        at = Solved(known.W, x0)
        kinds, index, basis = pairs_at(p, s, closed)
        gamma = np.zeros(len(kinds))
        some = _slips(p, s, at, kinds, index, basis, gamma, x)
        if some != SOME:
            none = some if many == 0 else none  # contacts without force bring many pairs; Lemke's is believed there
            continue
        give = np.zeros(k)
        for c in range(len(kinds)):
            if kinds[c] == LIMIT:
                give[index[c]] = gamma[c]
        found = _rates(p, x, give)
        if _penetrates(s, closed, found.gap):
            continue
        _settle(p, s, closed, kinds, index, gamma, found)
        return SOME, found
    return none, _rates(p, x, np.zeros(k))


@kernel
def _is_driven(known: Inverse, w: Array) -> bool:
    """Whether the load does work along a motion that no contact feels."""
    size, most = np.max(np.abs(w)), 0.0
    for c in range(known.loose[0]):
        total = 0.0
        for i in range(len(w)):
            total += known.Z[i, c] * w[i]
        most = max(most, abs(total))
    return bool(most > _DRIVEN * size)


@kernel
def _penetrates(s: Place, closed: Ints, gap: Array) -> bool:
    """Whether a contact that was chosen to open moves into the object."""
    largest = 0.0
    for g in gap:
        largest = max(largest, abs(g))
    inward = 0
    for i in range(len(closed)):
        if s.closed[i] > CLOSED and closed[i] == OPEN and gap[i] < -_TINY * largest:
            inward += 1
    return inward > 0


@kernel
def _slips(
    p: Parts, s: Place, at: Solved, kinds: Ints, index: Ints, basis: Ints, gamma: Array, x: Array
) -> int:  # fmt: skip
    """Write γ and the response x; whether there are: NONE, SOME or UNKNOWN. Moving faces of contacts that just touch
    are turned until they meet the force.
    """
    turning = False
    for c in range(len(kinds)):
        if kinds[c] >= 0 and p.moving[index[c]] == 1 and s.closed[kinds[c]] != CLOSED:
            turning = True
    if turning:
        for c in range(len(kinds)):
            if kinds[c] >= 0 and p.moving[index[c]] == 1 and s.closed[kinds[c]] != CLOSED:
                face_of_force(p, index[c], at.x0)
    for turn in range(_TURNS):
        X, M, q = respond(p, at, kinds, index)
        some = solve_pairs(M, q, basis, gamma)
        if some != SOME:
            return some
        x[:] = at.x0
        for c in range(len(kinds)):
            if gamma[c] != 0.0:
                x += gamma[c] * X[c]
        if not turning:
            return SOME
        change = 0.0
        for c in range(len(kinds)):
            if kinds[c] >= 0 and p.moving[index[c]] == 1 and s.closed[kinds[c]] != CLOSED and gamma[c] > 0.0:
                before = p.normals[index[c]].copy()
                face_of_force(p, index[c], x)
                change = max(change, np.max(np.abs(before - p.normals[index[c]])))
                if turn >= _WHOLE:  # after a full turn they may go back and forth between two places
                    mean = before + p.normals[index[c]]
                    size = np.sqrt(np.sum(mean * mean))
                    if size > 0.0:
                        p.normals[index[c]] = mean / size
        if change <= _TURNED:
            return SOME
    return UNKNOWN


@kernel
def _settle(p: Parts, s: Place, closed: Ints, kinds: Ints, index: Ints, gamma: Array, found: Rates) -> None:
    """Write what contacts and limits do from here on into s."""
    begins = s.closed.copy()
    opened = np.zeros(len(closed), np.int64)
    for c in range(len(kinds)):
        if kinds[c] == NORMAL and gamma[c] > 0.0:
            opened[index[c]] = 1
        elif kinds[c] == LIMIT:
            s.yields[index[c]] = 1 if gamma[c] > 0.0 else 0
    for i in range(len(closed)):
        s.closed[i] = OPEN if opened[i] == 1 else closed[i]
    largest = np.max(np.abs(found.r)) if len(found.r) else 0.0
    for j in range(len(s.active)):
        if s.closed[p.owner[j]] == OPEN:
            s.active[j] = s.slides[j] = 0
    for c in range(len(kinds)):
        if kinds[c] < 0 or s.closed[kinds[c]] == OPEN:
            continue
        j, i = index[c], kinds[c]
        s.slides[j] = 1 if gamma[c] > 0.0 else 0
        room = p.mu[i] * found.r[p.contacts[i, 0]]
        for a in range(3):
            t = p.contacts[i, a + 1]
            if t >= 0:
                room -= p.normals[j, a] * found.r[t]
        s.active[j] = 1 if s.slides[j] == 1 or room <= _TINY * largest else 0
        if begins[i] != CLOSED and p.moving[j] == 1 and s.slides[j] == 0:
            s.active[j] = 0


# ----------------------------------------------------------------
# Where on a path a contact that presses has slid as far as it may.

_PRESSES = 1e-9  # of the largest force
_CREEPS = 1e-7  # of how far a contact may slide, on a ray under as much load more: less is rounding


@kernel
def slides_at(p: Parts, per_slip: Array, slid: Array, path: Array, point: Array, endless: bool) -> bool:
    """Whether one has, and write where: a point as `path` (·, 1 + m + dof + k) has them. endless : whether a path goes
    on as it ends, without an end.

    per_slip (m,) : one over how far each contact may slide, by its tangential components, 0 by others. slid (n,) : how
    far contacts have slid before, as a share of that; it grows up to the point, or to the end of the path.
    """
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    v, more = np.zeros(m), np.zeros(len(slid))
    for a in range(1, len(path)):
        d, force, goes_on = path[a] - path[a - 1], 0.0, endless and a == len(path) - 1
        first = np.inf if goes_on else 1.0
        for i in range(m):
            v[i] = 0.0
            force = max(force, abs(path[a, 1 + i]))
            for j in range(m):
                v[i] += p.E[i, j] * d[1 + j]
            for c in range(dof):
                v[i] += p.G[c, i] * d[1 + m + c]
            for b in range(k):
                v[i] += p.rows[b, i] * d[1 + m + dof + b]
        for i in range(len(slid)):
            more[i], j = 0.0, p.contacts[i, 0]
            if j < 0 or max(path[a - 1, 1 + j], path[a, 1 + j]) <= _PRESSES * force:
                continue
            for b in range(1, 4):
                t = p.contacts[i, b]
                if t >= 0:
                    more[i] += (v[t] * per_slip[t]) ** 2
            more[i] = np.sqrt(more[i])
            if slid[i] + more[i] >= 1.0 or (goes_on and more[i] > _CREEPS):
                first = min(first, max((1.0 - slid[i]) / more[i], 0.0) if more[i] > 0.0 else 0.0)
        if first == np.inf:
            return False
        for i in range(len(slid)):
            slid[i] += first * more[i]
        if slid.max() >= 1.0 - _TINY:
            point[:] = path[a - 1] + first * d
            return True
    return False


_SAME_LOAD = 2e-6  # of the load: between two points with no more the load has hardly grown


@kernel
def points_before_jump(p: Parts, moves: Array, length: float, path: Array) -> int:
    """How many points of a path there are up to where the object jumps: to the next it moves far under a load that
    hardly grows. moves (6, dof) : the object's motion, SI, of natural unknowns; length [m] : of the contacts from their
    centre.
    """
    m, moved = len(p.E), np.zeros(6)
    for a in range(1, len(path)):
        if path[a, 0] - path[a - 1, 0] > _SAME_LOAD * path[a, 0]:
            continue
        moved[:] = 0.0
        for b in range(6):
            for c in range(len(p.G)):
                moved[b] += moves[b, c] * (path[a, 1 + m + c] - path[a - 1, 1 + m + c])
        far = np.sqrt((moved[:3] ** 2).sum()) / length + np.sqrt((moved[3:] ** 2).sum())
        if far > MIN_SNAP_DISTANCE:
            return a
    return len(path)
