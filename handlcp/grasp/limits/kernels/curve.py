"""The path between two events where contacts slip on a round friction cone: their forces turn as they slip.

It is followed along its own length (`turning`), so that the place where the load can grow no more is a place like any
other: there the rate of the load passes through zero. A load that grows ever more slowly while contacts slip on and
on has no such place; it is at its end when it grows no more over twice the way.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.arrive import arrive, violated, write_place
from handlcp.grasp.limits.kernels.happens import GIVES_UP, LOST, RAY, Watch, settle_at
from handlcp.grasp.limits.kernels.parts import Parts, Place
from handlcp.grasp.limits.kernels.slips import Solved
from handlcp.grasp.limits.kernels.turning import onto_cones, slope_at, step_ahead
from handlcp.lcp.kernels.compile import kernel

__all__ = ["follow_curve"]

_MOST = 1500  # steps
_SHRINK, _GROW, _SAFE = 0.2, 6.0, 0.9
_FAR = 1e6  # times the forces it began with: a path without an end
_APEX = 1e-7  # of the largest force: a sliding force as small as that goes straight to zero
_ROUNDS, _NOTHING = 60, 1e-15
_SAME = 1e-8  # of the load: over twice the way, less is none


@kernel
def follow_curve(
    p: Parts, s: Place, w: Array, left: float, watch: Watch, at: Solved
) -> tuple[int, float, int]:  # fmt: skip
    """(status, load, what was watched): to the next event, or to where the load can grow no more; s is moved there."""
    kinds, index = _sliding(p, s)
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    size = m + dof + k
    y, tangent = np.zeros(size + 1), np.zeros(len(kinds) + 1)
    y[:m], y[m : m + dof], y[m + dof : size] = s.r, s.u, s.give
    tangent[-1] = 1.0
    slopes, turned = np.zeros((7, size + 1)), tangent.copy()
    if not slope_at(p, at, w, kinds, index, y, tangent, slopes[0], turned):
        return GIVES_UP, 0.0, -1
    tangent[:] = turned
    begun, gap, slack = y.copy(), s.gap.copy(), s.slack.copy()
    largest = np.max(np.abs(s.r)) + 1e-300
    h, ahead = 0.01 * largest, y.copy()
    gone, checked, before = 0.0, 0.0, 0.0
    for _ in range(_MOST):
        error = step_ahead(p, at, w, kinds, index, y, h, tangent, slopes, ahead, turned)
        if error > 1.0:
            h *= max(_SHRINK, _SAFE * error**-0.2)
            continue
        onto_cones(p, at, kinds, index, ahead, turned)
        which = violated(p, s, watch, gap, slack, begun, ahead, turned, left, w)
        if which >= 0 and _passes_apex(p, kinds, index, y, ahead):
            h *= 0.5  # toward the apex, where the direction of the force is lost
            continue
        if which >= 0:
            return arrive(p, s, watch, at, w, kinds, index, (gap, slack, begun), y, h, tangent, slopes, which, left)
        y[:], tangent[:], slopes[0] = ahead, turned, slopes[6]
        gone += h
        i = _near_apex(p, kinds, index, y, slopes[0])
        if i >= 0:
            y += (-y[p.contacts[i, 0]] / slopes[0][p.contacts[i, 0]]) * slopes[0]
            _let_go(p, at, i, y)
            write_place(p, s, gap, slack, begun, y)
            return settle_at(p, s, watch, i, y[-1])
        if gone > 2.0 * checked:
            if checked > largest and y[-1] - before <= _SAME * y[-1]:
                write_place(p, s, gap, slack, begun, y)
                return LOST, y[-1], -1
            checked, before = gone, y[-1]
        h *= min(_GROW, _SAFE * max(error, 1e-12) ** -0.2)
        if np.max(np.abs(y[:m])) > _FAR * largest or h > _FAR * largest:
            write_place(p, s, gap, slack, begun, begun)  # the last place that is a number
            return RAY, np.inf, -1
    return GIVES_UP, 0.0, -1


@kernel
def _sliding(p: Parts, s: Place) -> tuple[Ints, Ints]:
    """(kinds, index) of the faces that contacts slip against, as in `rates`; other faces are watched from here on."""
    f, count = len(p.owner), 0
    kinds, index = np.empty(f, np.int64), np.empty(f, np.int64)
    for j in range(f):
        if s.slides[j] == 1:
            kinds[count], index[count] = p.owner[j], j
            count += 1
        else:
            s.active[j] = 0
    return kinds[:count], index[:count]


@kernel
def _passes_apex(p: Parts, kinds: Ints, index: Ints, y: Array, ahead: Array) -> bool:
    """Whether a force that slips on a round cone, and is not small at y, has changed its sign ahead."""
    passing, least = 0, _APEX * np.max(np.abs(y[: len(p.E)]))
    for c in range(len(kinds)):
        j = p.contacts[kinds[c], 0]
        if p.moving[index[c]] == 1 and y[j] > least and ahead[j] < 0.0:
            passing += 1
    return passing > 0


@kernel
def _near_apex(p: Parts, kinds: Ints, index: Ints, y: Array, slope: Array) -> int:
    """A contact that slips on a round cone with a force that is small and falls; -1: none."""
    least = _APEX * np.max(np.abs(y[: len(p.E)]))
    for c in range(len(kinds)):
        j = p.contacts[kinds[c], 0]
        if p.moving[index[c]] == 1 and y[j] <= least and slope[j] < 0.0:
            return int(kinds[c])
    return -1


@kernel
def _let_go(p: Parts, at: Solved, i: int, y: Array) -> None:
    """Take what is left of a contact's force, and give it to the others as their springs share a load."""
    m, most = len(p.E), _NOTHING * np.max(np.abs(y[: len(p.E)]))
    for _ in range(_ROUNDS):
        left = 0.0
        load = np.zeros(len(p.G))
        for a in range(4):
            j = p.contacts[i, a]
            if j >= 0:
                left = max(left, abs(y[j]))
                load += y[j] * p.G[:, j]
                y[j] = 0.0
        if left <= most:
            return
        for b in range(len(load)):
            y[:-1] += load[b] * at.W[m + b]
