"""`continue_stage`: a grasp driven through one stage, in quasi-static steps where there are any, in a viscous flow
where there are none.

A step is predicted from the last two and corrected by Newton's method (`take_step`). Its size follows an estimate of
its error. While nothing slides a step is exact, however long: forces depend on where things are alone. Where contacts
slide, friction opposes the slip at the end of the step, which is known to first order from the step alone, and to
second order from the last two (BDF2); the estimate is the difference between the direction that was found and the one
that the order of the step predicts.

Where a contact changes its state inside a step, the step ends there: the change is located on the contact's margin, by
regula falsi. A step without an end is halved; where the shortest has none, or where a small push grows, the object
moves on at constant load against a vanishing viscosity (`flow`): it comes to rest elsewhere, which is one event, or it
leaves, and the path ends at the last load with a static state.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.flow import (
    GROWS,
    MOVES,
    REST,
    STUCK,
    flow,
    growing_motion,
    growth,
    is_measured,
    seek_state,
)
from handlcp.grasp.path.path_model import (
    OPEN,
    PENDING,
    SLIDES,
    STICKS,
    PathModel,
    any_slides,
    carries,
    controls_between,
    distance,
    estimate_error,
    friction_shares,
    guess_between,
    largest_force,
    limit_shares,
    margins,
    model_kernel,
    motion,
    move_unloaded,
    on_same_face,
    slip_lengths,
    slip_toward,
    take_step,
    write_events,
)
from handlcp.grasp.path.solve_step import NO_FORCE, SETTLED, StepOptions, read_state
from handlcp.grasp.path.trace import StageArrays, Trace
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import MIN_SNAP_DISTANCE, OVER_LIMIT_TOLERANCE, SNAP_RATIO

FINEST = 2.0**-9  # of a stage's unit: where a step as short as this has no solution, there is none
_EXACT = 2.0**-18  # of it: how closely a jump or the last static state is located once there is known to be one
_ALONG = 2.0  # a path is not continued further than this many times its last step
_ANEW = 2.0**-3  # times the usual step: the first after a change, which is of first order
_ALONE = 2.0**-4  # of the unit: a shorter step without a solution is also tried without a prediction
_GROWS_FREE, _GROWS_SLIDING = 0.5, 0.15  # of the load: steps of an open stage where nothing slides, and where it does
_HALVED = 14  # times a step, where a push begins to grow and where a limit is reached
_ON = 1e-9  # of a limit: this near to it is at it
_PUSH = 1e-3  # of the forces
_SAME = 1e-3  # of the contacts' distances: the same place
_BENDS = 0.5  # of a step: how far from where it was expected it may end
_AFTER = 4.0  # times the step on which it snapped: the next, where another may follow at once
_CHAIN = 1.01  # steps between snaps that are one
_AT_FRICTION = 0.02  # of a contact's friction: with no more left it may slide in the next short step
_MOST_BRANCHES = 16  # choices of what sticks that are tried
_GOES_ON = 0.02  # of the forces: how much a short step changes
_SAFETY, _LEAST_SHARE, _MOST_SHARE = 0.8, 0.1, 3.0  # of the step that the error of the last one suggests
_CLOSE = 1e-3  # of a step: a change this close is where it is looked for
_LOOKS = 8  # for a change
_FREE = 1e4  # h of a step that pushes an object which nothing holds
_LITTLE = 1e-4  # of the contacts' distances: a slip that is expected, and not known
_NO_PAST, _NO_PUSH = np.zeros((0, 3)), np.zeros(0)

# How a call ends: the stage is over, and `leg.status` says how; a contact has slid as far as it may; there is no more
# room in the trace; Python is asked for a state (`seek_state`), or for a word that the path goes on
OVER, PAUSED, FULL, ASKS, BREATHES = 0, 1, 2, 3, 4
_GOES, _ENDS = 0, 1  # of a try
_BREATH = 256  # tries
_REACHED, _LIMIT, _UNBOUNDED = int(PathStatus.REACHED), int(PathStatus.LIMIT), int(PathStatus.UNBOUNDED)
_UNSTABLE, _PUSHED_OUT, _LOOSE = int(PathStatus.UNSTABLE), int(PathStatus.PUSHED_OUT), int(PathStatus.LOOSE)
_NO_FORCES, _LEAPS, _JUMPS = int(PathStatus.NO_FORCES), int(PathStatus.LEAPS), int(PathStatus.JUMPS)
_STUCK, _CROSSES, _SNAPS = int(PathStatus.STUCK), int(PathStatus.CROSSES), int(PathStatus.SNAPS)
_TOO_MANY_STEPS, _FIRST_LOST = int(PathStatus.TOO_MANY_STEPS), int(PathStatus.RUNS_AWAY)


@model_kernel
def continue_stage(m: PathModel, g: StageArrays, t: Trace, pauses: bool) -> int:
    """Go on with a stage from where its trace is. pauses : stop where a contact has slid as far as it may, too."""
    leg = t.leg[0]
    while leg.share < g.last * (1.0 - 1e-12):
        if leg.number + 4 > len(t.rows) or leg.events + 128 > len(t.events) or leg.snaps + 2 > len(t.snaps.share):
            return FULL
        leg.count += 1
        if leg.count > g.tries:
            return _over(t, _TOO_MANY_STEPS)
        if leg.snaps > 0 and not g.goes_on_snapped:
            return _over(t, _SNAPS)
        known, events, snaps = leg.number, leg.events, leg.snaps
        note_share(m, leg.share)
        leg.asked = 0
        goes = advance(m, g, t)
        if goes == PENDING:
            leg.count -= 1
            return ASKS
        leg.answered = 0
        if crosses(m, t.rows[: leg.number], known - 1, goes == _ENDS and leg.status >= _FIRST_LOST):
            leg.number, leg.events, leg.snaps = known, events, snaps
            return _over(t, _CROSSES)
        if goes == _ENDS:
            return OVER
        if pauses and leg.slides_number >= 0:
            return PAUSED
        if leg.count % _BREATH == 0:
            return BREATHES
    if not carries(m, t.rows[leg.number - 1]) and _pushed_out(m, g, t):
        return _over(t, _PUSHED_OUT)
    return _over(t, _UNBOUNDED if g.is_open else _REACHED)


@model_kernel
def note_share(m: PathModel, share: float) -> None:
    """Say how far the stage is, where somebody watches."""


@model_kernel
def crosses(m: PathModel, rows: Array, number: int, ends: bool) -> bool:
    """Whether a tendon crosses a body from this one of the states on; where the path ends, close by, too."""
    return False


@kernel
def _over(t: Trace, status: int) -> int:
    t.leg[0].status = status
    return OVER


@model_kernel
def advance(m: PathModel, g: StageArrays, t: Trace) -> int:
    """One try of a step; whether the path goes on, or PENDING."""
    leg = t.leg[0]
    share, state, size = leg.share, t.rows[leg.number - 1], min(leg.step, g.last - leg.share)
    if share + size > g.last * (1.0 - 1e-9):
        size = g.last - share
    found = np.empty(len(state))
    status = find_step(m, g, t, state, share, size, found)
    if status == PENDING:
        return PENDING
    if status == SETTLED and _leaps(m, g, t, state, found, share, size):
        status = _LEAPS
    if status != SETTLED:
        return _continue_failed(m, g, t, state, status, size)
    if carries(m, state):
        size *= _first_change(m, g, t, state, found, share, size)
    earlier, ratio = state, 0.0
    if leg.before > 0.0:
        earlier, ratio = t.rows[leg.number - 2], size / leg.before
    error = estimate_error(m, state, found, earlier, ratio) if carries(m, found) else 0.0
    if error > g.accuracy and size > FINEST * g.unit:
        leg.step = size * _suggested(g, error)
        return _GOES
    kinds = read_state(found, m.state).kinds
    if not _same(kinds, t.calm) and growth(m, found) > GROWS:
        unstable = found.copy()
        size, breaks = _stable_step(m, g, t, state, found, share, size)
        if breaks == PENDING:
            return PENDING
        if breaks != 0:
            return _leave_balance(m, g, t, found, share + size, found if is_measured(m, found) else unstable)
    if g.is_open and excess(m, g, found) > 0.0:
        size = _locate(m, g, t, state, found, share, size, True)
        _add(m, g, t, found, share + size, error)
        leg.status = _LIMIT
        return _ENDS
    slides = g.loads and leg.slides_number == -1 and excess_slip(m, t, found) > 0.0
    if slides:
        size = _locate(m, g, t, state, found, share, size, False)
    leg.speed = distance(m, state, found) / size
    leg.share = share + size
    happens = _add(m, g, t, found, leg.share, error)
    if slides:
        leg.slides_share, leg.slides_number = leg.share, leg.number - 1
    if carries(m, state) and not carries(m, found) and read_state(found, m.state).controls[8] == 0.0:
        leg.status = _LOOSE
        return _ENDS
    leg.before = 0.0 if happens else size
    most = np.inf if happens else size * (1.0 if leg.failed != 0 else _suggested(g, error))
    leg.step = _next_step(m, g, t, found, most, size)
    leg.failed = 0
    return _GOES


@kernel
def _same(a: Array, b: Array) -> bool:
    same = True
    for i in range(len(a)):
        same = same and a[i] == b[i]
    return same


@kernel
def _suggested(g: StageArrays, error: float) -> float:
    """The share of a step that makes its error what is allowed."""
    return float(min(max(_SAFETY * (g.accuracy / max(error, 1e-300)) ** 0.5, _LEAST_SHARE), _MOST_SHARE))


@model_kernel
def _next_step(m: PathModel, g: StageArrays, t: Trace, found: Array, most: float, size: float) -> float:
    """The step after one of this size. Of an open stage it grows with the load, the faster where nothing slides."""
    leg = t.leg[0]
    if leg.share >= leg.ends:
        leg.ends = np.inf
    if leg.ends < np.inf:
        return max(0.5 * size, _EXACT * g.unit)
    slides = any_slides(m, found)
    step = g.base
    if g.is_open:
        step = max(step, (_GROWS_SLIDING if slides else _GROWS_FREE) * leg.share)
    if leg.before == 0.0 and slides:
        step *= _ANEW
    return min(step, most)


@model_kernel
def excess(m: PathModel, g: StageArrays, row: Array) -> float:
    """How far a state is beyond a limit that was set, as a share of it; of what stands at its limit before the load
    grows only what is truly beyond.
    """
    worst, shares = -1.0, limit_shares(m, g.limits, g.at, row)
    for k in range(len(shares)):
        if shares[k] - 1.0 > worst and not (g.stands_at[k] and shares[k] - 1.0 <= OVER_LIMIT_TOLERANCE):
            worst = shares[k] - 1.0
    return worst


@model_kernel
def excess_slip(m: PathModel, t: Trace, row: Array) -> float:
    """How much farther than it may a contact has slid at the end of a step to this state, as a share."""
    worst, slips, before = 0.0, slip_lengths(m, row), t.slipped[t.leg[0].number - 1]
    for i in range(len(slips)):
        worst = max(worst, (before[i] + slips[i]) / m.max_slip[i])
    return worst - 1.0


@model_kernel
def _add(m: PathModel, g: StageArrays, t: Trace, found: Array, share: float, error: float) -> bool:
    """Write the next state down. Whether anything happens on the way to it."""
    leg, out = t.leg[0], np.empty((64, 2))
    k = leg.number
    count = min(write_events(m, t.rows[k - 1], found, out), len(out))
    for e in range(count):
        t.events[leg.events + e, 0] = k
        t.events[leg.events + e, 1:] = out[e]
    leg.events += count
    t.rows[k], t.shares[k], t.errors[k], t.slipped[k] = found, share, error, t.slipped[k - 1]
    if g.loads:
        t.slipped[k] += slip_lengths(m, found)
    leg.number = k + 1
    return count > 0


@model_kernel
def _pushed_out(m: PathModel, g: StageArrays, t: Trace) -> bool:
    """Whether nothing is held at the end, and the object has been pushed away by fingers that close."""
    number, far = t.leg[0].number, False
    first = t.rows[min(1, number - 1)] if len(g.origin) == 0 else g.origin
    moved = motion(m, first, t.rows[number - 1])
    for a in range(3):
        far = far or abs(moved[a]) > m.near
    return far


# ----------------------------------------------------------------
# One step.


@model_kernel
def find_step(m: PathModel, g: StageArrays, t: Trace, state: Array, share: float, size: float, row: Array) -> int:
    """Write the end of one step, solved from where the last two led; where that has no solution, from the last
    state.
    """
    leg, controls, old = t.leg[0], controls_between(g.begin, g.end, share + size), read_state(state, m.state)
    where, start, loaded, predicted = old.where, old.start, carries(m, state), leg.before > 0.0
    if predicted:
        where, start = guess_between(m, t.rows[leg.number - 2], state, 1.0 + min(size / leg.before, _ALONG))
    if _second_order(m, leg.before, state, controls, where, start, size, row):
        return SETTLED
    status = _first_order(m, state, controls, where, start, row)
    if status != SETTLED and predicted and size < _ALONE * g.unit:
        status = take_step(m, state, controls, old.where, old.start, _asked(m), row)
    if status != SETTLED and not loaded:
        status = move_unloaded(m, state, controls, row)
        if status != SETTLED:
            status = _push_ahead(m, state, controls, where, start, row)
    if status != SETTLED and loaded and size <= _ALONE * g.unit and _branch(m, state, controls, row):
        status = SETTLED
    # All solvers are asked for a step that Newton's method does not solve: where contacts stay where they are it is one
    # solve however long the step is, elsewhere only once no shorter step has a solution
    if status != SETTLED and leg.ends == np.inf and (size <= FINEST * g.unit or not m.poses.follows):
        sought = seek_state(m, t, state, controls, row)
        if sought in (SETTLED, PENDING):
            status = sought
    return status


@model_kernel
def _asked(m: PathModel) -> StepOptions:
    """Of a quasi-static step."""
    return StepOptions(m.sizes.slow, 1.0, _NO_PAST, False)


@model_kernel
def _second_order(
    m: PathModel, before: float, state: Array, controls: Array, where: Array, start: Array, size: float, row: Array
) -> bool:  # fmt: skip
    """A step of second order: friction opposes the slip at its end, as a parabola through the last two steps has it
    (BDF2); before : the last of them. Whether there is one: not where a contact that slid sticks, which would stick to
    that parabola.
    """
    if before == 0.0 or not any_slides(m, state):
        return False
    old, ratio = read_state(state, m.state), size / before
    part, past = ratio**2 / (1.0 + 2.0 * ratio), np.zeros((len(old.kinds), 3))
    for i in range(len(past)):
        if old.kinds[i] == SLIDES:
            past[i, 0], past[i, 1] = part * old.motion[i, 0], part * old.motion[i, 1]
            past[i, 2] = part * old.spin[i]
    if take_step(m, state, controls, where, start, StepOptions(m.sizes.slow, 1.0, past, False), row) != SETTLED:
        return False
    kinds, fits = read_state(row, m.state).kinds, True
    for i in range(len(kinds)):
        fits = fits and not (old.kinds[i] == SLIDES and kinds[i] == STICKS)
    return fits


@model_kernel
def _first_order(m: PathModel, state: Array, controls: Array, where: Array, start: Array, row: Array) -> int:
    """A step after a change, where the last two say nothing. Friction is continuous there: slip begins along where
    friction pushes, and ends along where it pushes then; of both its way is the mean (trapezoidal rule).
    """
    status = take_step(m, state, controls, where, start, _asked(m), row)
    if status != SETTLED or not (any_slides(m, state) and any_slides(m, row)):
        return status
    push = friction_shares(m, state)
    if on_same_face(m, push, friction_shares(m, row)).all():
        return status
    old, end, past = read_state(state, m.state), read_state(row, m.state), slip_toward(m, -push, row)
    for i in range(len(past)):
        past[i] *= 0.5 if old.kinds[i] == SLIDES and end.kinds[i] == SLIDES else 0.0
    better = np.empty(len(row))
    asked = StepOptions(m.sizes.slow, 1.0, past, False)
    again = take_step(m, state, controls, end.where, end.start, asked, better)
    if again == SETTLED and _same(read_state(better, m.state).kinds, end.kinds):
        row[:] = better
    return status


@model_kernel
def _push_ahead(m: PathModel, state: Array, controls: Array, where: Array, start: Array, row: Array) -> int:
    """A step in which fingers may push ahead of them an object that nothing holds, against a damper that is large
    enough to compute with. The forces of that are none.
    """
    asked = StepOptions(_FREE, 1.0, _NO_PAST, False)
    status = take_step(m, state, controls, where, start, asked, row)
    if status != SETTLED:
        return status
    end, most = read_state(row, m.state), m.sizes.slow / _FREE * NO_FORCE * m.sizes.stiffness * m.sizes.length
    for i in range(len(end.kinds)):
        if end.forces[i, 2] > most:
            return _NO_FORCES
    end.kinds[:] = OPEN
    return SETTLED


@model_kernel
def _branch(m: PathModel, state: Array, controls: Array, row: Array) -> bool:
    """A short step in which other contacts stick and slide than Newton's method expects: those at the limit of their
    friction may do either. The one in which the fewest do otherwise and forces go on; whether there is one.
    """
    old, left, f = read_state(state, m.state), margins(m, state), m.friction.coefficients
    n, may, count = len(old.kinds), np.empty(len(old.kinds), np.int64), 0
    for i in range(n):
        limit = f[i] * old.forces[i, 2]
        near = old.kinds[i] == STICKS and left[i, 0] <= _AT_FRICTION * limit
        if limit > 0.0 and (old.kinds[i] == SLIDES or near):
            may[count] = i
            count += 1
    size, tried = largest_force(m, state), 0
    for flips in range(1, count + 1):
        chosen = np.arange(flips)
        while tried < _MOST_BRANCHES:
            tried += 1
            slides = old.kinds == SLIDES
            for k in chosen:
                slides[may[k]] = not slides[may[k]]
            start = _expecting(m, state, slides)
            settled = take_step(m, state, controls, old.where, start, _asked(m), row) == SETTLED
            if settled and _largest_change(read_state(row, m.state).forces, old.forces) <= _GOES_ON * size:
                return True
            if not _next_combination(chosen, count):
                break
    return False


@kernel
def _next_combination(chosen: Ints, count: int) -> bool:
    """Change `chosen`, ascending numbers below `count`, to what comes next; whether there is another."""
    k = len(chosen)
    for i in range(k - 1, -1, -1):
        if chosen[i] < count - k + i:
            chosen[i] += 1
            for j in range(i + 1, k):
                chosen[j] = chosen[j - 1] + 1
            return True
    return False


@kernel
def _largest_change(a: Array, b: Array) -> float:
    largest = 0.0
    for i in range(len(a)):
        for c in range(a.shape[1]):
            largest = max(largest, abs(a[i, c] - b[i, c]))
    return largest


@model_kernel
def _expecting(m: PathModel, state: Array, slides: Array) -> Array:
    """The start of a step from a state in which these contacts (n,) slide, and others that press stick."""
    old, shares, soft = read_state(state, m.state), friction_shares(m, state), m.friction.soft
    n, c = len(old.kinds), len(m.friction.scale)
    start, first = old.start.copy(), c + 9
    start[first:] = 0.0
    for i in range(n):
        little = -_LITTLE * m.sizes.length if slides[i] else 0.0
        start[first + 3 * i], start[first + 3 * i + 1] = little * shares[i, 0], little * shares[i, 1]
        if old.kinds[i] == OPEN:
            start[first + 3 * i + 2] = old.start[first + 3 * i + 2]
    for k in range(len(soft)):
        if slides[soft[k]]:
            start[first + 3 * n + k] = -_LITTLE * m.sizes.length * shares[soft[k], 2]
    return start


@model_kernel
def find_part(
    m: PathModel, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float, part: float,
    row: Array,
) -> int:  # fmt: skip
    """Write the state at a part of a step that is known to have a solution."""
    controls = controls_between(g.begin, g.end, share + part * size)
    where, start = guess_between(m, state, found, part)
    if _second_order(m, t.leg[0].before, state, controls, where, start, part * size, row):
        return SETTLED
    return _first_order(m, state, controls, where, start, row)


@model_kernel
def _leaps(
    m: PathModel, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float
) -> bool:  # fmt: skip
    """Whether the step may have jumped over a snap: it ends much farther away than the last step did, or far from where
    the last two led. Without a last step: whether its half ends far from its middle.
    """
    leg, far = t.leg[0], distance(m, state, found)
    if leg.speed > 0.0 and far > no_snap(t, size):
        return True
    if far <= MIN_SNAP_DISTANCE:
        return False
    expected, ends = state.copy(), found
    if leg.before > 0.0:
        where, _ = guess_between(m, t.rows[leg.number - 2], state, 1.0 + min(size / leg.before, _ALONG))
    elif size <= 2.0 * FINEST * g.unit:
        return False
    else:
        where, _ = guess_between(m, state, found, 0.5)
        ends = np.empty(len(found))
        if find_part(m, g, t, state, found, share, size, 0.5, ends) != SETTLED:
            return True
        far *= 0.5
    read_state(expected, m.state).where[:] = where
    return distance(m, expected, ends) > MIN_SNAP_DISTANCE + _BENDS * far


@kernel
def no_snap(t: Trace, size: float) -> float:
    """How far the object may go in such a step without a snap, as a share of the contacts' distances."""
    return float(MIN_SNAP_DISTANCE + SNAP_RATIO * t.leg[0].speed * size)


# ----------------------------------------------------------------
# Where inside a step something happens.


@model_kernel
def _first_change(
    m: PathModel, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float
) -> float:  # fmt: skip
    """The part of a step up to just behind the first change of a contact that held, and write the state there into
    `found`; 1 where none changes.
    """
    if _same(read_state(state, m.state).kinds, read_state(found, m.state).kinds):
        return 1.0
    whole, middle, low, high, a, b = found.copy(), np.empty(len(found)), 0.0, 1.0, margins(m, state), margins(m, found)
    falls = np.zeros((2, len(a), 2))  # how fast margins fall on each side of it, once two parts on that side are known
    for _ in range(_LOOKS):
        if not _any_changes(a, b) or high - low < _CLOSE:
            break
        part = _crossing(low, high, a, b, falls) + 0.2 * _CLOSE
        if high - part < _CLOSE:
            break
        if find_part(m, g, t, state, whole, share, size, part, middle) != SETTLED:
            break
        now = margins(m, middle)
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


@model_kernel
def _locate(
    m: PathModel, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float, limits: bool
) -> float:  # fmt: skip
    """The step up to where an excess, of limits or of slip, negative at its beginning and positive at its end `found`,
    is zero, by regula falsi, and write the state there into `found`; to just beyond it where no shorter step that is
    tried has a solution.
    """
    low, high, whole, best, middle = 0.0, 1.0, found.copy(), found.copy(), np.empty(len(found))
    a = excess(m, g, state) if limits else excess_of_nothing(m, t)
    a, b = min(a, -_ON), excess(m, g, found) if limits else excess_slip(m, t, found)
    for _ in range(_HALVED):
        part = low + (high - low) * min(max(-a / (b - a), 0.02), 0.98) if b > a else 0.5 * (low + high)
        if find_part(m, g, t, state, whole, share, size, part, middle) != SETTLED:
            break
        value = excess(m, g, middle) if limits else excess_slip(m, t, middle)
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


@model_kernel
def excess_of_nothing(m: PathModel, t: Trace) -> float:
    """That of slip before a step."""
    worst, before = 0.0, t.slipped[t.leg[0].number - 1]
    for i in range(len(before)):
        worst = max(worst, before[i] / m.max_slip[i])
    return worst - 1.0


# ----------------------------------------------------------------
# Where no step has a solution, or where a small push grows.


@model_kernel
def _continue_failed(m: PathModel, g: StageArrays, t: Trace, state: Array, why: int, size: float) -> int:
    """A step without a solution is halved; where the shortest has none, the object moves on in a viscous flow.
    Whether the path goes on, or PENDING.
    """
    leg = t.leg[0]
    share, known = leg.share, leg.ends < np.inf
    leg.failed = 1
    if size > (_EXACT if known else FINEST) * g.unit:
        leg.step = size / 2.0
        return _GOES
    if known and leg.then != STUCK and _jumps(m, g, t, state):
        leg.status = _JUMPS
        return _ENDS
    if known and leg.then != MOVES:
        return _stop(t, int(leg.then), why)
    until, near = leg.ends if known else share + size, np.inf
    if not known and _may_jump(m, g, t, state):  # where it comes to rest is asked once the jump is located exactly
        near = no_snap(t, size)
    end = np.empty(len(state))
    how = flow(m, t, state, controls_between(g.begin, g.end, until), _NO_PUSH, near, end)
    if how == PENDING:
        return PENDING
    snapped = False
    if how != MOVES and how != STUCK:
        snapped = _snaps(m, g, t, state, end, share, until, how == REST, np.zeros(6))
    if how != REST:
        leg.ends, leg.then, leg.step = until, how, size / 2.0
        return _stop(t, how, why) if known else _GOES
    if snapped and _jumps(m, g, t, state):
        leg.status = _JUMPS
        return _ENDS
    leg.share, leg.ends = until, np.inf
    leg.speed = 0.0 if snapped else distance(m, state, end) / (until - share)
    _add(m, g, t, end, until, 0.0)
    leg.step, leg.before = min(_AFTER * FINEST * g.unit, g.base), 0.0
    return _GOES


@kernel
def _stop(t: Trace, how: int, why: int) -> int:
    """The path ends here, as a flow said."""
    t.leg[0].status = _STUCK if how == STUCK else why
    return _ENDS


@model_kernel
def _stable_step(
    m: PathModel, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float
) -> tuple[float, int]:  # fmt: skip
    """(size, whether a small push grows): the step up to where a push begins to grow, and write the state there into
    `found`; the whole step where a push that seemed to grow comes to rest where the object was. PENDING in place of
    that word.
    """
    end, middle, whole = np.empty(len(found)), np.empty(len(found)), found.copy()
    how = flow(m, t, found, read_state(found, m.state).controls, _push(m, found, growing_motion(m, found)),
               np.inf, end)  # fmt: skip
    if how == PENDING:
        return size, PENDING
    if how == REST and distance(m, found, end) < _SAME:
        t.calm[:] = read_state(found, m.state).kinds
        return size, 0
    low, high = 0.0, 1.0
    found[:] = state
    for _ in range(_HALVED):
        part = 0.5 * (low + high)
        if find_part(m, g, t, state, whole, share, size, part, middle) != SETTLED or growth(m, middle) > GROWS:
            high = part
        else:
            low = part
            found[:] = middle
    return low * size, 1


@model_kernel
def _leave_balance(m: PathModel, g: StageArrays, t: Trace, state: Array, share: float, grows: Array) -> int:
    """Whether the path goes on, or PENDING: the object, pushed a little under slightly more load, comes to rest
    elsewhere. It is pushed in the motion that grows in the state `grows`, in which that was measured.
    """
    leg = t.leg[0]
    more = min(share + 2.0**-_HALVED * g.unit, g.last)
    moves, near, end = growing_motion(m, grows), np.inf, np.empty(len(state))
    if _may_jump(m, g, t, state) and g.is_open:
        near = no_snap(t, more - share)
    how = flow(m, t, state, controls_between(g.begin, g.end, more), _push(m, state, moves), near, end)
    if how == PENDING:
        return PENDING
    if share > leg.share:
        _add(m, g, t, state, share, 0.0)
        leg.share = share
    if how != STUCK and _snaps(m, g, t, state, end, share, more, how == REST, moves) and _jumps(m, g, t, state):
        leg.status = _JUMPS
        return _ENDS
    if how == REST:
        _add(m, g, t, end, more, 0.0)
        leg.share = more
    leg.step, leg.before = g.base, 0.0
    return _GOES if how == REST else _stop(t, how, _UNSTABLE)


@model_kernel
def _push(m: PathModel, state: Array, moves: Array) -> Array:
    """(6,) a small wrench along a motion."""
    size, forces = 0.0, read_state(state, m.state).forces
    for i in range(len(forces)):
        for a in range(3):
            size += abs(forces[i, a])
    push = _PUSH * size * moves
    push[3:] *= m.sizes.length
    return push


@model_kernel
def _snaps(
    m: PathModel, g: StageArrays, t: Trace, state: Array, end: Array, share: float, until: float, rests: bool,
    pushed: Array,
) -> bool:  # fmt: skip
    """Note that the object has moved from one state to another under a load that stays, unless it has moved on as
    before, and only Newton's method had found no solution; whether it has.
    """
    leg, moved, shift, turn = t.leg[0], motion(m, state, end), 0.0, 0.0
    for a in range(3):
        shift += moved[a] ** 2
        turn += moved[3 + a] ** 2
    shift, turn = shift**0.5, turn**0.5
    if rests and shift / m.sizes.length + turn < no_snap(t, until - share):
        return False
    s, k = t.snaps, leg.snaps
    if k > 0 and share - s.until[k - 1] <= _CHAIN * g.unit:
        k -= 1
        shift, turn, share = shift + s.moved[k], turn + s.turned[k], s.share[k]
        if s.pushed[k].any():
            pushed = s.pushed[k].copy()
    s.share[k], s.until[k], s.moved[k], s.turned[k], s.rests[k] = share, until, shift, turn, 1.0 if rests else 0.0
    s.pushed[k] = pushed
    leg.snaps = k + 1
    return True


@model_kernel
def _may_jump(m: PathModel, g: StageArrays, t: Trace, state: Array) -> bool:
    """Whether the object is loaded, and has not jumped yet."""
    return carries(m, state) and g.loads and t.leg[0].jump_number == -1


@model_kernel
def _jumps(m: PathModel, g: StageArrays, t: Trace, state: Array) -> bool:
    """Note that a loaded object jumps here; whether that ends the path, as it does one to a load limit."""
    leg = t.leg[0]
    if _may_jump(m, g, t, state):
        leg.jump_share, leg.jump_number = leg.share, leg.number - 1
    return g.is_open and leg.jump_number != -1
