"""`first_change` and `locate_limit`: where inside a step a contact changes its state, and where a limit is reached."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.find_step import find_part, is_same
from handlcp.grasp.path.path_model import PathReader, PathSteps, limit_shares, margins, slip_lengths, steps_kernel
from handlcp.grasp.path.solve_step import SETTLED, read_state
from handlcp.grasp.path.trace import StageArrays, Trace
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

_ON = 1e-9  # of a limit: this near to it is at it
_CLOSE = 1e-3  # of a step: a change this close is where it is looked for
_LOOKS = 8  # for a change
_HALVED = 14  # times a step, at most, where a limit is reached


@steps_kernel
def excess(m: PathSteps, g: StageArrays, row: Array) -> float:
    """How far a state is beyond a limit that was set, as a share of it; of what stands at its limit before the load
    grows only what is truly beyond.
    """
    worst, shares = -1.0, limit_shares(m.read, g.limits, g.at, row)
    for k in range(len(shares)):
        if shares[k] - 1.0 > worst and not (g.stands_at[k] and shares[k] - 1.0 <= OVER_LIMIT_TOLERANCE):
            worst = shares[k] - 1.0
    return worst


@kernel
def excess_slip(m: PathReader, t: Trace, slips: Array) -> float:
    """How much farther than it may a contact has slid with a step in which they slide so far (n,) [m], as a share."""
    worst, before = 0.0, t.slipped[t.leg[0].number - 1]
    for i in range(len(slips)):
        worst = max(worst, (before[i] + slips[i]) / m.max_slip[i])
    return worst - 1.0


@steps_kernel
def first_change(
    m: PathSteps, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float
) -> float:  # fmt: skip
    """The part of a step up to just behind the first change of a contact that held, and write the state there into
    `found`; 1 where none changes.
    """
    if is_same(read_state(state, m.read.state).kinds, read_state(found, m.read.state).kinds):
        return 1.0
    a, b = margins(m.read, state), margins(m.read, found)
    whole, middle, low, high = found.copy(), np.empty(len(found)), 0.0, 1.0
    falls = np.zeros((2, len(a), 2))  # how fast margins fall on each side of it, once two parts on that side are known
    for _ in range(_LOOKS):
        if not _any_changes(a, b) or high - low < _CLOSE:
            break
        part = _crossing(low, high, a, b, falls) + 0.2 * _CLOSE
        if high - part < _CLOSE:
            break
        if find_part(m, g, t.leg[0].before, state, whole, share, size, part, middle) != SETTLED:
            break
        now = margins(m.read, middle)
        if _any_changes(a, now):
            falls[1], high, b = (b - now) / (part - high), part, now
            found[:] = middle
        else:
            falls[0], low, a = (a - now) / (part - low), part, now
    return high


@kernel
def _any_changes(a: Array, b: Array) -> bool:
    """Whether any margin (n, 2) that was positive is negative."""
    changes = False
    for i in range(len(a)):
        for c in range(2):
            changes = changes or (a[i, c] > 0.0 and b[i, c] < 0.0 and a[i, c] < np.inf)
    return changes


@kernel
def _crossing(low: float, high: float, a: Array, b: Array, falls: Array) -> float:
    """The part at which the first of the margins that change is zero, if each side goes on as it did; on a chord where
    neither side is known. Margins have a kink there: forces fall, then slips or gaps grow.
    """
    least, known = high, falls.any()
    for i in range(len(a)):
        for c in range(2):
            if not (a[i, c] > 0.0 and b[i, c] < 0.0 and a[i, c] < np.inf):
                continue
            if not known:
                least = min(least, low + (high - low) * a[i, c] / (a[i, c] - b[i, c]))
                continue
            for side in range(2):
                if not falls[side].any():
                    continue
                at, own, fall = (low, a[i, c], falls[side, i, c]) if side == 0 else (high, b[i, c], falls[side, i, c])
                least = min(least, at + own / fall if fall > 0.0 else low + 0.5 * (high - low))
    return max(least, low)


@steps_kernel
def locate_limit(
    m: PathSteps, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float, limits: bool
) -> float:  # fmt: skip
    """The step up to where an excess, of limits or of slip, negative at its beginning and positive at its end `found`,
    is zero, by regula falsi, and write the state there into `found`; to just beyond it where no shorter step that is
    tried has a solution.
    """
    low, high, whole, best, middle = 0.0, 1.0, found.copy(), found.copy(), np.empty(len(found))
    a = excess(m, g, state) if limits else excess_slip(m.read, t, np.zeros(len(m.read.max_slip)))
    a, b = min(a, -_ON), excess(m, g, found) if limits else excess_slip(m.read, t, slip_lengths(m.read, found))
    for _ in range(_HALVED):
        part = low + (high - low) * min(max(-a / (b - a), 0.02), 0.98) if b > a else 0.5 * (low + high)
        if find_part(m, g, t.leg[0].before, state, whole, share, size, part, middle) != SETTLED:
            break
        value = excess(m, g, middle) if limits else excess_slip(m.read, t, slip_lengths(m.read, middle))
        if value > 0.0:
            high, b = part, value
            found[:] = middle
        else:
            low, a = part, value
            best[:] = middle
        if abs(value) < _ON or high - low < 1e-9:
            low = part
            best[:] = middle
            break
    if low > 0.0:
        found[:] = best
        return low * size
    return high * size
