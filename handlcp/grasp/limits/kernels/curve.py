"""The path between two events where contacts slip on a round friction cone: their forces turn as they slip.

With the direction of each sliding force known, the rates are those of one face a contact. So the path is an ordinary
differential equation in forces and motion. It is followed along its own length, by the formula of order five of
Dormand & Prince, J. Comp. Appl. Math. 6 (1980), so that the place where the load can grow no more is a place like
any other: there the rate of the load passes through zero.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.happens import CONTINUES, GIVES_UP, LOST, RAY, REACHED, Watch, conditions, settle_at
from handlcp.grasp.limits.kernels.pairs import solved
from handlcp.grasp.limits.kernels.parts import Parts, Place
from handlcp.grasp.limits.kernels.rates import Rates
from handlcp.grasp.limits.kernels.slips import Solved, face_of_force, respond
from handlcp.lcp.kernels.compile import kernel

__all__ = ["follow_curve"]

_ERROR = 1e-9  # of a step, relative to forces and motions
_MOST = 3000  # steps
_TIE = 1e-12
_ROOTS, _ROOT = 60, 3e-13
_NO_MORE = 1e-10  # load by length of the path: less is none, and what comes until it ends is less than that
_SHRINK, _GROW, _SAFE = 0.2, 6.0, 0.9
_FAR = 1e9  # times the forces it began with: a path without an end
_C = np.array([
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
    [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
    [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
])  # fmt: skip
_E = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


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
    if not _slope(p, at, w, kinds, index, y, tangent, slopes[0], turned):
        return GIVES_UP, 0.0, -1
    tangent[:] = turned
    begun, gap, slack = y.copy(), s.gap.copy(), s.slack.copy()
    largest = np.max(np.abs(s.r)) + 1e-300
    h, ahead = 0.01 * largest, y.copy()
    for _ in range(_MOST):
        error = _step(p, at, w, kinds, index, y, h, tangent, slopes, ahead, turned)
        if error > 1.0:
            h *= max(_SHRINK, _SAFE * error**-0.2)
            continue
        which = _violated(p, s, watch, gap, slack, begun, ahead, turned, left, w)
        if which >= 0:
            return _arrive(p, s, watch, at, w, kinds, index, (gap, slack, begun), y, h, tangent, slopes, which, left)
        y[:], tangent[:], slopes[0] = ahead, turned, slopes[6]
        h *= min(_GROW, _SAFE * max(error, 1e-12) ** -0.2)
        if np.max(np.abs(y[:m])) > _FAR * largest or h > _FAR * largest:
            _write(p, s, gap, slack, begun, begun)  # the last place that is a number
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
def _slope(
    p: Parts, at: Solved, w: Array, kinds: Ints, index: Ints, y: Array, before: Array, dy: Array, tangent: Array
) -> bool:  # fmt: skip
    """Write dy by the length of the path, and its direction in (γ, load), on the side of `before`."""
    count, m = len(kinds), len(p.E)
    for c in range(count):
        if p.moving[index[c]] == 1:
            face_of_force(p, index[c], y[:m])
    X, M, q = respond(p, at, kinds, index)
    A = np.zeros((count + 1, count + 1))
    A[:count, :count], A[:count, count], A[count] = M, q, before
    tangent[:] = 0.0
    tangent[count] = 1.0
    if not solved(A, tangent, 1e-15):
        return False
    dy[:-1] = tangent[count] * at.x0
    for c in range(count):
        dy[:-1] += tangent[c] * X[c]
    dy[-1] = tangent[count]
    length = np.sqrt(np.sum(dy[: m + len(w)] ** 2) + (dy[-1] * np.max(np.abs(w))) ** 2)
    dy /= length
    tangent /= length
    return bool(length > 0.0)


@kernel
def _step(
    p: Parts, at: Solved, w: Array, kinds: Ints, index: Ints, y: Array, h: float, tangent: Array, slopes: Array,
    ahead: Array, turned: Array,
) -> float:  # fmt: skip
    """Write the place one step ahead and the direction there; the error as a share of what is allowed."""
    size = len(y)
    for stage in range(6):
        ahead[:] = y
        for c in range(stage + 1):
            if _C[stage, c] != 0.0:
                ahead += (h * _C[stage, c]) * slopes[c]
        if not _slope(p, at, w, kinds, index, ahead, tangent, slopes[stage + 1], turned):
            return 1e10
    m, dof, worst = len(p.E), len(p.G), 0.0
    force, motion = np.max(np.abs(ahead[:m])), np.max(np.abs(ahead[m : m + dof])) + np.max(np.abs(ahead[:m]))
    for j in range(size - 1):
        off = 0.0
        for c in range(7):
            off += _E[c] * slopes[c, j]
        worst = max(worst, abs(h * off) / (force if j < m else motion))
    return worst / _ERROR


@kernel
def _write(p: Parts, s: Place, gap: Array, slack: Array, begun: Array, y: Array) -> None:
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
def _violated(
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
    _write(p, s, gap, slack, begun, y)
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
def _arrive(
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
            _step(p, at, w, kinds, index, y, share * h, tangent, slopes, ahead, turned)
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
