"""A walk under a load that grows, in one posture, from change to change of contact states until no state follows.

Where nothing slides on a round cone, one step is exact however long it is. Elsewhere steps are extrapolated, and grow
while they are accurate. A change of contact states is located on margins. Where a step has no solution, the limit of
the load is looked for: the damper of a step beyond it says by how much the load is too large. The limit is accepted
once it is the same from two places, and no state under more load is found, also not from contacts that all stick.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.still import (
    SLIDES,
    STICKS,
    Still,
    along,
    euler,
    finer,
    kinds_of,
    lost_at,
    margins_of,
    slipped,
    viscous,
)  # fmt: skip
from handlcp.lcp.kernels.dense import kernel

LOST, BOUNDED, UNBOUNDED, GAVE_UP = 1, 2, 3, 4
_MOST = 600  # steps
_FIRST, _GROWS, _FAR = 0.1, 4.0, 1e4  # of the forces before: the first step, and what no limit is beyond
_LEAST, _PLACED = 1e-9, 1e-9  # of the load: the shortest step; how closely a change is located
_ACCURATE = 3e-7  # of the forces: a step
_AGREED = 1e-7  # of a limit: as seen from two places
_TRIES = 60
_PAST = 1e-6  # of a limit: where no state may be found
# Of a motion against a damper, in natural units: the first damper and the softest and stiffest one; its longest step;
# when the object is gone, times how far anything has moved; of the forces, what a damper takes of one at rest; steps
_DAMPED, _VANISHED, _STIFFEST, _STRIDE, _GONE, _CALM, _CREEPS = 1e-4, 1e-11, 1e4, 0.3, 10.0, 1e-6, 200
_EVEN = 1e-9  # of the forces: what changes by less does not


class Bounds(NamedTuple):
    """What ends a walk besides. rows (h, N), level (h,) : where rows · x reaches a level. moves (6, dof), start (6,) :
    motion and turn of the object are moves · u - start; motion, turn : most of them.
    """

    rows: Array
    level: Array
    moves: Array
    start: Array
    motion: float
    turn: float


class Log(NamedTuple):
    """Of a walk. path (·, 1 + N) : factor and x at each point. kinds (·, n + k) : from there on. length (1,)."""

    path: Array
    kinds: Ints
    length: Ints


@kernel
def goes_on(g: Still, x: Array, z: Array, kinds: Ints, factor: float) -> float:
    """A factor slightly above this one under which a state is found, to which x, z and kinds are changed; NaN if there
    is none. It is looked for from x, from contacts that all stick, and where the object comes to rest when it moves on
    against a damper.
    """
    more = factor + _PAST * max(abs(factor), 1e-3 * _size(g, x))
    out, slip = np.empty(len(x)), np.empty(len(x))
    held, _ = euler(g, x, z, x, more, False, out)
    if held != 2:
        held, _ = euler(g, x, z, x, more, True, out)
    if held == 2:
        along(g, x, out, z, slip)
        kinds_of(g, out, slip, kinds)
        slipped(g, slip, kinds, z)
        x[:] = out
        return more
    return more if _rests(g, x, z, kinds, more) else np.nan


@kernel
def _rests(g: Still, x: Array, z: Array, kinds: Ints, factor: float) -> bool:
    """Whether the object comes to rest under this load: steps against a damper that vanishes (see `flow`)."""
    at, slips, own = x.copy(), z.copy(), kinds.copy()
    out, slip, slow = np.empty(len(x)), np.empty(len(x)), _DAMPED
    m, tried, before, moved = g.m, 0, 0.0, 0.0
    gone = _GONE * _reach(g, x)
    while slow > _VANISHED and tried < _CREEPS:
        tried += 1
        held = viscous(g, at, slips, factor, slow, out)
        step = 0.0
        for a in range(m, m + g.dof):
            step = max(step, abs(out[a] - at[a]))
        most = _STRIDE * max(1.0, moved)
        if not held or step > most:
            slow *= 8.0
            if slow > _STIFFEST:
                return False
            continue
        along(g, at, out, slips, slip)
        kinds_of(g, out, slip, own)
        slipped(g, slip, own, slips)
        largest = np.max(np.abs(out[:m]))
        even = np.max(np.abs(out[:m] - at[:m])) <= _EVEN * largest
        at[:] = out
        moved = np.max(np.abs(at[m : m + g.dof] - x[m : m + g.dof]))
        if (even and step > 0.1 * _STRIDE) or moved > gone:
            return False  # it moves on without end, at the same forces
        if step * slow < _CALM * np.max(np.abs(at[:m])) and tried > 3:
            held_, _ = euler(g, at, slips, at, factor, False, out)
            if held_ == 2 and np.max(np.abs(out[m : m + g.dof] - at[m : m + g.dof])) < _STRIDE:
                along(g, at, out, slips, slip)
                kinds_of(g, out, slip, own)
                slipped(g, slip, own, slips)
                x[:], z[:], kinds[:] = out, slips, own
                return True
        if step < 2.0 * before or before == 0.0:  # else it speeds up, and with less of a damper there is no step
            slow *= 0.25
        before = step
    return False


@kernel
def _reach(g: Still, x: Array) -> float:
    """The largest motion of a place: of the object, or of what is between it and a contact that is open."""
    reach = 1.0
    for a in range(g.m, g.m + g.dof):
        reach = max(reach, abs(x[a]))
    for i in range(len(g.contacts)):
        j = g.contacts[i, 0]
        if j >= 0 and not x[j] > 0.0:
            gap = g.base[j]
            for c in range(len(x)):
                gap += g.problem.M[j, c] * x[c]
            reach = max(reach, gap)
    return reach


@kernel
def _size(g: Still, x: Array) -> float:
    """The factor whose load is as large as the largest force, or as the natural unit where there is none."""
    force = np.max(np.abs(x[: g.m]))
    return float((force if force > 0.0 else 1.0) / max(np.max(np.abs(g.load)), 1e-300))


@kernel
def walk(g: Still, x: Array, z: Array, kinds: Ints, factor: float, bounds: Bounds, log: Log) -> tuple[int, float, int]:
    """(how it ends, factor, which bound): from x (N,), slips z (m,), kinds (n + k,) under this factor of the load; all
    three are changed to those at its end.
    """
    N, m = len(x), g.m
    scale = _size(g, x)
    H, far, seen = _FIRST * scale, _FAR * scale + factor, np.nan
    out, slip, fine, slips = np.empty(N), np.empty(N), np.empty(N), np.empty(m)
    now, guess = kinds.copy(), x.copy()
    before, last = x.copy(), np.nan  # the place before, for a guess
    for _ in range(_MOST):
        if factor >= far:
            return UNBOUNDED, np.inf, -1
        if log.length[0] >= len(log.path) - 2:
            break
        least = _LEAST * max(abs(factor), scale)
        size, ends = H, np.nan
        guess[:] = x
        if factor > last:  # False where there is none
            guess += min(size / (factor - last), 2.0) * (x - before)
        held, too_much = euler(g, x, z, guess, factor + size, False, out)
        if held == 0:
            held, too_much = euler(g, x, z, x, factor + size, True, out)
        if held != 2:
            if held == 1 and too_much < size:
                ends = lost_at(g, x, z, factor, factor + size, too_much, out, fine)
            if not ends > factor + least:
                if size <= 2.0 * least:
                    more = goes_on(g, x, z, kinds, factor)
                    if more == more:
                        factor = more
                        _mark(log, factor, x, kinds)
                        H, last, seen = _FIRST * scale, np.nan, np.nan
                        continue
                    return LOST, factor, -1
                H = max(0.25 * size, least)
                continue
            size = ends - _LEAST * abs(ends) - factor
            out[:] = fine
        along(g, x, out, z, slip)
        kinds_of(g, out, slip, now)
        if _differ(kinds, now):
            size, until = _located(g, x, z, kinds, factor, size, out, slip, now)
            if _round_slides(g, kinds) and size > 1e3 * least:
                held, _ = euler(g, x, z, x + 0.0 * out, factor + size, False, fine)
                done, rows = _finer(g, x, z, kinds, factor, size, out, slips) if held == 2 else (-1, 0)
                if done != 1:
                    H = 0.5 * size
                    continue
                over = _over(g, bounds, out)
                if over >= 0:
                    return _bounded(g, x, z, kinds, factor, size, bounds, over, log)
                before[:], last = x, factor
                x[:], z[:] = out, slips
                factor += size
                _mark(log, factor, x, kinds)
                H = max(2.0 * (until - size), 8.0 * least)
                continue
            over = _over(g, bounds, out)
            if over >= 0:
                return _bounded(g, x, z, kinds, factor, until, bounds, over, log)
            slipped(g, slip, now, z)
            x[:], kinds[:] = out, now
            factor += until
            last, seen = np.nan, np.nan
            _mark(log, factor, x, kinds)
            H = max(0.25 * H, _FIRST * scale, 0.02 * factor)
            continue
        rows = 1
        if _round_slides(g, kinds):
            if ends == ends and abs(ends - seen) <= _AGREED * abs(ends):
                pass
            else:
                if ends == ends:
                    seen, size = ends, 0.5 * size
                done, rows = _finer(g, x, z, kinds, factor, size, out, slips)
                if done != 1:
                    if size > 1e4 * least:
                        H = 0.4 * size
                        continue
                    held, _ = euler(g, x, z, x, factor + size, False, out)
                    if held != 2:
                        H = 0.5 * size
                        continue
                    along(g, x, out, z, slip)
                    kinds_of(g, out, slip, now)
                    slips[:] = z
                    slipped(g, slip, now, slips)
                    kinds[:] = now
                over = _over(g, bounds, out)
                if over >= 0:
                    return _bounded(g, x, z, kinds, factor, size, bounds, over, log)
                before[:], last = x, factor
                x[:], z[:] = out, slips
                factor += size
                _mark(log, factor, x, kinds)
                H = size * (_GROWS / (1.0 + 0.5 * max(rows - 2, 0)))
                continue
        over = _over(g, bounds, out)
        if over >= 0:
            return _bounded(g, x, z, kinds, factor, size, bounds, over, log)
        before[:], last = x, factor
        slipped(g, slip, kinds, z)
        x[:] = out
        factor += size
        _mark(log, factor, x, kinds)
        if ends == ends:
            factor = ends
            log.path[log.length[0] - 1, 0] = ends
            more = goes_on(g, x, z, kinds, factor)
            if more == more:
                factor = more
                _mark(log, factor, x, kinds)
                H, last, seen = _FIRST * scale, np.nan, np.nan
                continue
            return LOST, factor, -1
        H = _GROWS * size
    return GAVE_UP, factor, -1


@kernel
def _finer(
    g: Still, x: Array, z: Array, kinds: Ints, factor: float, size: float, out: Array, slips: Array
) -> tuple[int, int]:  # fmt: skip
    first = np.empty(len(x))
    held, _ = euler(g, x, z, x, factor + size, False, first)
    if held != 2:
        return -1, 0
    return finer(g, x, z, factor, size, kinds, first, _ACCURATE, out, slips)


@kernel
def _differ(a: Ints, b: Ints) -> bool:
    return bool(np.any(a != b))


@kernel
def _round_slides(g: Still, kinds: Ints) -> bool:
    return bool(np.any((kinds[: len(g.round)] == SLIDES) & (g.round == 1)))


@kernel
def _mark(log: Log, factor: float, x: Array, kinds: Ints) -> None:
    at = log.length[0]
    log.path[at, 0] = factor
    log.path[at, 1:] = x
    log.kinds[at] = kinds
    log.length[0] = at + 1


@kernel
def _located(
    g: Still, x: Array, z: Array, kinds: Ints, factor: float, size: float, out: Array, slip: Array, now: Ints
) -> tuple[float, float]:  # fmt: skip
    """(a, b): the first change of states lies between these parts of a step; out, slip, now : at b, written anew."""
    low, high, count = 0.0, size, len(kinds)
    a, b, m, trial, between = np.empty(count), np.empty(count), np.empty(count), np.empty(len(x)), np.empty(len(x))
    own = now.copy()
    along(g, x, x, z, between)
    margins_of(g, kinds, x, between, a)
    margins_of(g, kinds, out, slip, b)
    close = _PLACED * max(abs(factor + size), 1e-3 * _size(g, x))
    for turn in range(_TRIES):
        if high - low <= close:
            break
        part, stops = high, False
        for i in range(count):
            if own[i] == kinds[i] and now[i] == kinds[i]:
                continue
            if kinds[i] == SLIDES and now[i] == STICKS:
                stops = True
            elif b[i] < 0.0 and a[i] > b[i]:
                part = min(part, low + (high - low) * max(a[i], 0.0) / (a[i] - b[i]))
        if stops or turn % 4 == 3:
            part = 0.5 * (low + high)
        part += 0.2 * close
        part = min(max(part, low + 0.01 * (high - low)), high - 0.01 * (high - low)) if turn % 3 == 2 else part
        part = min(max(part, low + 0.25 * close), high - 0.25 * close)
        held, _ = euler(g, x, z, x + part / size * (out - x) if turn == 0 else out, factor + part, False, trial)
        if held != 2:
            held, _ = euler(g, x, z, x, factor + part, True, trial)
        if held != 2:
            high = part  # not expected, as there is a state beyond
            continue
        along(g, x, trial, z, between)
        kinds_of(g, trial, between, own)
        margins_of(g, kinds, trial, between, m)
        if _differ(kinds, own):
            high = part
            out[:], slip[:], now[:], b[:] = trial, between, own, m
        else:
            low = part
            a[:] = m
        for i in range(count):
            own[i] = now[i]
    for i in range(count):
        if kinds[i] == SLIDES and now[i] == STICKS and low > 1e3 * close:
            return 0.5 * low, high  # it slides back from about there
    return low, high


@kernel
def _over(g: Still, bounds: Bounds, x: Array) -> int:
    """Which bound is passed by most; -1: none."""
    worst, by = -1, 0.0
    for h in range(len(bounds.level)):
        left = _left(g, bounds, x, h)
        if left < by:
            worst, by = h, left
    for part in range(2):
        most = bounds.motion if part == 0 else bounds.turn
        if most < np.inf and _left(g, bounds, x, len(bounds.level) + part) < 0.0:
            worst = len(bounds.level) + part
    return worst


@kernel
def _left(g: Still, bounds: Bounds, x: Array, h: int) -> float:
    rows = len(bounds.level)
    if h < rows:
        left = bounds.level[h]
        for j in range(len(x)):
            left -= bounds.rows[h, j] * x[j]
        return float(left + 1e-12 * abs(bounds.level[h]))
    square, first = 0.0, 3 * (h - rows)
    for a in range(first, first + 3):
        here = -bounds.start[a]
        for c in range(g.dof):
            here += bounds.moves[a, c] * x[g.m + c]
        square += here * here
    return float((bounds.motion if h == rows else bounds.turn) - np.sqrt(square))


@kernel
def _bounded(
    g: Still, x: Array, z: Array, kinds: Ints, factor: float, size: float, bounds: Bounds, over: int, log: Log
) -> tuple[int, float, int]:  # fmt: skip
    """Go to where a step meets a bound that its end is beyond."""
    low, high, side, out, slips = 0.0, size, 0, x.copy(), z.copy()
    a, b = _left(g, bounds, x, over), -1.0
    now, slip, own = x.copy(), np.empty(len(x)), kinds.copy()
    best, found = z.copy(), x.copy()
    at = 0.0
    for turn in range(_TRIES):
        part = low + (high - low) * (a / (a - b) if a > 0.0 and turn > 0 else 0.5)
        part = min(max(part, low + 1e-3 * (high - low)), high - 1e-3 * (high - low))
        done = 0
        if _round_slides(g, kinds):
            done, _ = _finer(g, x, z, kinds, factor, part, now, slips)
        if done != 1:
            held, _ = euler(g, x, z, x + part / size * (out - x), factor + part, False, now)
            if held != 2:
                high = part
                continue
            slips[:] = z
            along(g, x, now, z, slip)
            kinds_of(g, now, slip, own)
            slipped(g, slip, own, slips)
        worst = _over(g, bounds, now)
        if worst >= 0:
            over = worst
            high, b = part, _left(g, bounds, now, over)
            if side == 1:
                a *= 0.5
            side = 1
        else:
            low, a = part, _left(g, bounds, now, over)
            best[:], found[:], at = slips, now, part
            if side == 2:
                b *= 0.5
            side = 2
        if high - low <= 1e-11 * max(abs(factor + high), 1e-6 * _size(g, x)) or abs(_left(g, bounds, now, over)) == 0.0:
            break
    x[:], z[:] = found, best
    _mark(log, factor + at, x, kinds)
    return BOUNDED, factor + at, over
