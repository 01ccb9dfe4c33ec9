"""What ends a stretch of a path that bends, and where."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.happens import CONTINUES, LOST, REACHED, Watch, conditions, settle_at
from handlcp.grasp.limits.kernels.parts import Parts, Place
from handlcp.grasp.limits.kernels.rates import Rates
from handlcp.grasp.limits.kernels.slips import Solved
from handlcp.grasp.limits.kernels.turning import step_ahead
from handlcp.lcp.kernels.compile import kernel

__all__ = ["arrive", "violated", "write_place"]

_TIE = 1e-12
_ROOTS, _ROOT = 60, 3e-13
_NO_MORE = 1e-10  # load by length of the path: less is none, and what comes until it ends is less than that


@kernel
def write_place(p: Parts, s: Place, gap: Array, slack: Array, begun: Array, y: Array) -> None:
    """The place at y; gap and slack where the path began, at `begun`."""
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    s.r[:], s.u[:], s.give[:] = y[:m], y[m : m + dof], y[m + dof : m + dof + k]
    change = y - begun
    v = np.dot(p.E, change[:m]) + np.dot(change[m : m + dof], p.G)
    s.slack[:] = slack
    for q in range(k):
        v += p.rows[q] * change[m + dof + q]
        for j in range(m):
            s.slack[q] -= p.rows[q, j] * change[j]
    for i in range(len(gap)):
        j = p.contacts[i, 0]
        if j >= 0:
            s.gap[i] = gap[i] + v[j]


@kernel
def violated(
    p: Parts, s: Place, watch: Watch, gap: Array, slack: Array, begun: Array, y: Array, turned: Array,
    left: float, w: Array,
) -> int:  # fmt: skip
    """Which condition fails by most; -1: none. After those of `happens`: γ of each pair, the load's end, its rate."""
    values, sizes = _values(p, s, watch, gap, slack, begun, y, turned, left, w)
    worst, by = -1, -_TIE
    for c in range(len(values)):
        if values[c] < by * sizes[c]:
            worst, by = c, values[c] / sizes[c]
    return worst


@kernel
def _values(
    p: Parts, s: Place, watch: Watch, gap: Array, slack: Array, begun: Array, y: Array, turned: Array,
    left: float, w: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """(values, sizes) of all conditions; s is written."""
    write_place(p, s, gap, slack, begun, y)
    none = Rates(0.0 * s.r, 0.0 * s.u, 0.0 * s.give, 0.0 * s.gap, 0.0 * s.slack)
    values, _, _ = conditions(p, s, watch, none)
    n, f, count, more = len(p.mu), len(p.owner), len(values), len(turned)
    force = np.max(np.abs(s.r))
    out, sizes = np.empty(count + more + 1), np.empty(count + more + 1)
    out[:count] = values
    sizes[:] = force
    sizes[n : 2 * n] = max(np.max(np.abs(s.gap)), np.max(np.abs(s.u)))
    for j in range(f):
        sizes[2 * n + j] = force * force if p.moving[j] == 1 else force
    rows = len(watch.level)
    for h in range(rows):
        sizes[count - 2 - rows + h] = abs(watch.level[h]) + 1e-300
    for part in range(2):
        most = watch.motion if part == 0 else watch.turn
        sizes[count - 2 + part] = most * most
    out[count : count + more - 1] = turned[: more - 1]
    out[count + more - 1] = left - y[-1]
    out[count + more] = turned[more - 1] * np.max(np.abs(w)) - _NO_MORE
    largest = np.max(np.abs(turned))
    sizes[count : count + more - 1] = largest
    sizes[count + more - 1] = left if left < np.inf else 1.0
    sizes[count + more] = 1.0
    return out, sizes


@kernel
def arrive(
    p: Parts, s: Place, watch: Watch, at: Solved, w: Array, kinds: Ints, index: Ints,
    origin: tuple[Array, Array, Array], y: Array, h: float, tangent: Array, slopes: Array, which: int, left: float,
) -> tuple[int, float, int]:  # fmt: skip
    """Where in the step that begins at y condition `which`, or one that comes before it, fails."""
    gap, slack, begun = origin
    ahead, turned = y.copy(), tangent.copy()
    values, sizes = _values(p, s, watch, gap, slack, begun, y, tangent, left, w)
    first = values / sizes
    high = 1.0
    for _ in range(8):
        low, f_low, f_high, share = 0.0, max(first[which], 0.0), -1.0, high
        for turn in range(_ROOTS):
            step_ahead(p, at, w, kinds, index, y, share * h, tangent, slopes, ahead, turned)
            values, sizes = _values(p, s, watch, gap, slack, begun, ahead, turned, left, w)
            f = values[which] / sizes[which]
            if abs(f) <= _ROOT or high - low <= 1e-15:
                break
            if f < 0.0:
                high, f_high = share, f
                f_low = 0.5 * f_low if turn > 1 else f_low
            else:
                low, f_low = share, f
                f_high = 0.5 * f_high if turn > 1 else f_high
            share = low + (high - low) * f_low / (f_low - f_high) if turn % 4 != 3 else 0.5 * (low + high)
        other, by = -1, -_TIE
        for c in range(len(values)):
            if c != which and values[c] < by * sizes[c]:
                other, by = c, values[c] / sizes[c]
        high = share
        if other < 0:
            break
        which = other
    count = len(values) - len(turned) - 1
    if which == len(values) - 1:
        return LOST, ahead[-1], -1
    if which == len(values) - 2:
        return REACHED, left, -1
    if which >= count:
        j = index[which - count]
        s.slides[j], s.active[j] = 0, 1
        return CONTINUES, ahead[-1], -1
    return settle_at(p, s, watch, which, ahead[-1])
