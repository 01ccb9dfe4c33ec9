"""`first_change` and `locate_limit`: where inside a step a contact changes its state, and where a limit is reached."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.find_step import FINEST, find_part
from handlcp.grasp.path.path_model import (
    OPEN,
    SLIDES,
    PathReader,
    PathSteps,
    corner_margins,
    largest_force,
    limit_shares,
    margins,
    slip_lengths,
    steps_kernel,
)
from handlcp.grasp.path.solve_step import PARTS, SETTLED, StateArrays, largest_change, read_part, read_state
from handlcp.grasp.path.trace import StageArrays, Trace
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

_ON = 1e-9  # of a limit: this near to it is at it
STANDS = 1e-8  # of the largest force: a contact this near to its limit stands at it
BEGINS = 2.0**-10  # of a step: here contacts do what they do from its beginning
_STEEP = 4.0  # times as fast as in the whole step forces may change before they jump
_LOOKS = 24  # for a change, or for where a limit is reached: about three find either


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
    """The part of a step up to the first change, which is of a contact that held, of one whose friction reaches a
    corner of its flat law, or of a joint that begins to yield; write the state there into `found`. 1 where nothing
    changes. A part below 0 has no solution where contacts stay: a shorter step is to be tried. Between two changes
    forces are linear in the load but for round laws: what sticks again, or leaves a corner, does so where another
    contact changes.
    """
    a, b = _distances(m.read, state, state), _distances(m.read, state, found)
    stands = STANDS * largest_force(m.read, state)
    for i in range(len(m.read.max_slip)):
        for c in range(3):
            if 0.0 < a[i, c] < stands:
                a[i, c] = 0.0
    whole, below, middle, low, high = found.copy(), state.copy(), np.empty(len(found)), 0.0, 1.0
    asks = t.leg[0].before == 0.0 and _stays_at_limit(a, b)  # it may hold before it slides
    if asks and find_part(m, g, 0.0, state, whole, share, size, BEGINS, middle) == SETTLED:
        now = _distances(m.read, state, middle)
        for i in range(len(a)):
            if a[i, 0] <= 0.0 and now[i, 0] > 0.0:
                a[i, 0] = now[i, 0]
    falls = np.zeros((2, len(a), 3))  # how fast distances fall on each side of it, once two parts there are known
    wide, slow = 1.0, 0  # looks since the first of them that did not halve what is looked at
    for _ in range(_LOOKS):
        if not _any_changes(a, b) or high - low < 1.5 * g.close:
            break
        part = _crossing(low, high, a, b, falls) + 0.2 * g.close if slow < 2 else 0.5 * (low + high)
        part = min(part, high - g.close)  # where it is expected at its end, it is not just before
        if find_part(m, g, t.leg[0].before, state, whole, share, size, part, middle) != SETTLED:
            if m.read.noise > 0.0 or size <= FINEST * g.unit:
                break
            return -part
        now = _distances(m.read, state, middle)
        if _any_changes(a, now):
            falls[1], high, b = (b - now) / (part - high), part, now
            found[:] = middle
        else:
            falls[0], low, a = (a - now) / (part - low), part, now
            below[:] = middle
        slow = 0 if high - low <= 0.5 * wide else slow + 1
        wide = high - low if slow == 0 else wide
    exact = m.read.noise == 0.0 and low > g.close and size > FINEST * g.unit  # on meshes contacts jump by themselves
    if exact and _forces_jump(m.read, g.accuracy, (state, below, found, whole), high - low):
        return -low
    if high < 1.0:
        _let_go(a, b, read_state(whole, m.read.state), read_state(found, m.read.state))
    return high


@kernel
def _forces_jump(m: PathReader, accuracy: float, rows: tuple[Array, Array, Array, Array], wide: float) -> bool:
    """Whether forces jump where a contact changes, between the second and the third of states along a step, `wide` of
    it apart: beyond it they are those of another solution of the step, in which the contact slides from the step's
    beginning on. A shorter step ends before that, and the next one goes on as it may.
    """
    begin, below = read_part(rows[0], m.state, PARTS.forces), read_part(rows[1], m.state, PARTS.forces)
    above, end = read_part(rows[2], m.state, PARTS.forces), read_part(rows[3], m.state, PARTS.forces)
    allowed = accuracy * largest_force(m, rows[2]) + _STEEP * wide * largest_change(end, begin)
    return largest_change(above, below) > allowed


@kernel
def first_crossing(m: PathReader, state: Array, found: Array) -> float:
    """How many steps such as that from `state` to `found` lead to the first change of a contact, if all go on as they
    do in it; inf: to none.
    """
    a, b, least = _distances(m, state, state), _distances(m, state, found), np.inf
    for i in range(len(a)):
        for c in range(3):
            if 0.0 < b[i, c] < a[i, c] < np.inf:
                least = min(least, a[i, c] / (a[i, c] - b[i, c]))
    return least


@kernel
def _distances(m: PathReader, state: Array, row: Array) -> Array:
    """(n + nv, 3) of each contact, at a part of a step from `state`: how far it is from sliding, from opening and from
    a corner of its law [N]; then of each joint how far it has yielded, as a number below 0.
    """
    n, yielded = len(m.max_slip), read_part(row, m.state, PARTS.yielded)
    out = np.full((n + len(yielded), 3), np.inf)
    out[:n, :2], out[:n, 2] = margins(m, row), corner_margins(m, state, row)
    for j in range(len(yielded)):
        out[n + j, 0] = -abs(yielded[j]) if yielded[j] != 0.0 else 1.0
    return out


@kernel
def _stays_at_limit(a: Array, b: Array) -> bool:
    """Whether any contact slides, or is about to, at the beginning of a step and slides at its end."""
    stays = False
    for i in range(len(a)):
        stays = stays or (a[i, 0] <= 0.0 and b[i, 0] < 0.0)
    return stays


@kernel
def _let_go(a: Array, b: Array, whole: StateArrays, end: StateArrays) -> None:
    """Contacts that are at their limit where they change slide or are open from there on, as after the whole step."""
    for i in range(len(end.kinds)):
        for c, kind in ((0, SLIDES), (1, OPEN)):
            if a[i, c] > 0.0 and b[i, c] <= 0.0 and whole.kinds[i] == kind:
                end.kinds[i] = kind


@kernel
def _any_changes(a: Array, b: Array) -> bool:
    """Whether any distance (·, 3) that was positive is so no more."""
    changes = False
    for i in range(len(a)):
        for c in range(3):
            changes = changes or (a[i, c] > 0.0 and b[i, c] <= 0.0 and a[i, c] < np.inf)
    return changes


@kernel
def _crossing(low: float, high: float, a: Array, b: Array, falls: Array) -> float:
    """The part at which the first of the distances that change is zero, if they go on as they did, below it or else
    above it; on a chord where neither side is known. Distances have a kink there: forces fall, then slips or gaps
    grow, or nothing does.
    """
    least, known = high, falls.any()
    for i in range(len(a)):
        for c in range(3):
            if not (a[i, c] > 0.0 and b[i, c] <= 0.0 and a[i, c] < np.inf):
                continue
            if falls[0, i, c] > 0.0:
                at = low + a[i, c] / falls[0, i, c]
            elif falls[1, i, c] > 0.0 and b[i, c] < 0.0:
                at = high + b[i, c] / falls[1, i, c]
            else:
                chord = not known and b[i, c] < 0.0
                at = low + (high - low) * (a[i, c] / (a[i, c] - b[i, c]) if chord else 0.5)
            least = min(least, at)
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
    a, b = min(a, -_ON), excess(m, g, found) if limits else excess_slip(m.read, t, slip_lengths(m.read, state, found))
    for _ in range(_LOOKS):
        part = low + (high - low) * min(max(-a / (b - a), 0.02), 0.98) if b > a else 0.5 * (low + high)
        if find_part(m, g, t.leg[0].before, state, whole, share, size, part, middle) != SETTLED:
            break
        value = excess(m, g, middle) if limits else excess_slip(m.read, t, slip_lengths(m.read, state, middle))
        if value > 0.0:
            high, b = part, value
            found[:] = middle
        else:
            low, a = part, value
            best[:] = middle
        if abs(value) < min(_ON, g.close) or high - low < 1e-9:
            low = part
            best[:] = middle
            break
    if low > 0.0:
        found[:] = best
        return low * size
    return high * size
