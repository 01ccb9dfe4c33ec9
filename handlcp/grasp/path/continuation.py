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

from handlcp.check import Array
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.find_step import ALONG, FINEST, find_part, find_step, is_same
from handlcp.grasp.path.flow import (
    CREEPS,
    GROWS,
    MOVES,
    REST,
    STUCK,
    flow,
    growing_motion,
    growth,
    is_measured,
)
from handlcp.grasp.path.locate_event import (
    BEGINS,
    STANDS,
    excess,
    excess_slip,
    first_change,
    first_crossing,
    locate_limit,
)
from handlcp.grasp.path.path_model import (
    PENDING,
    SLIPS,
    PathModel,
    PathReader,
    PathSteps,
    any_slides,
    carries,
    controls_between,
    distance,
    estimate_error,
    guess_between,
    largest_force,
    margins,
    model_kernel,
    motion,
    slip_lengths,
    steps_kernel,
    take_step,
    write_events,
)
from handlcp.grasp.path.solve_step import PARTS, SETTLED, StepOptions, largest_change, read_part
from handlcp.grasp.path.trace import StageArrays, Trace
from handlcp.lcp.compiler.borrow import borrowed
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import MIN_SNAP_DISTANCE, SNAP_RATIO

_ANEW = 2.0**-3  # times the usual step: the first after a change, which is of first order
_GROWS_FREE, _GROWS_SLIDING = 0.5, 0.15  # of the load: steps of an open stage where nothing slides, and where it does
_HALVED = 14  # times a step, where a push begins to grow
_PUSH = 1e-3  # of the forces
_SAME = 1e-3  # of the contacts' distances: the same place
_BENDS = 0.5  # of a step: how far from where it was expected it may end
_AFTER = 4.0  # times the step on which it snapped: the next, where another may follow at once
_CHAIN = 1.01  # steps between snaps that are one
_SAFETY, _LEAST_SHARE, _MOST_SHARE = 0.8, 0.1, 3.0  # of the step that the error of the last one suggests
_BEYOND = 2.0**-12  # of the unit: a step from just before an end that is known, which is none if that leads on
_OTHERWISE = 2.0**-20  # of the unit: such a step, in which contacts slip in other ways
_WAYS, _MOST_PASSED = 48, 16  # ways that are tried at an end, and ends that are passed so
_SPREAD = (0.6180339887498949, 0.7548776662466927)  # shares that spread evenly
_FASTER = 8.0  # times such a step: the next
_SHORT = 0.9  # of a step without a solution that led about to the first change: what is tried next
_NO_PUSH = np.zeros(0)

# How a call ends: the stage is over, and `leg.status` says how; a contact has slid as far as it may; there is no more
# room in the trace; Python is asked for a state (`seek_state`), or looks at what was found
OVER, PAUSED, FULL, ASKS, BREATHES = 0, 1, 2, 3, 4
_GOES, _ENDS = 0, 1  # of a try
_CLOSES = 2  # `leg.failed` where a step towards an end that is known, or the shortest of all, had no solution
_REACHED, _LIMIT, _UNBOUNDED = int(PathStatus.REACHED), int(PathStatus.LIMIT), int(PathStatus.UNBOUNDED)
_UNSTABLE, _PUSHED_OUT, _LOOSE = int(PathStatus.UNSTABLE), int(PathStatus.PUSHED_OUT), int(PathStatus.LOOSE)
_NO_FORCES, _TOO_FAR = int(PathStatus.NO_FORCES), int(PathStatus.TOO_FAR)
_LEAPS, _JUMPS = int(PathStatus.LEAPS), int(PathStatus.JUMPS)
_STUCK, _SNAPS = int(PathStatus.STUCK), int(PathStatus.SNAPS)
_TOO_MANY_STEPS = int(PathStatus.TOO_MANY_STEPS)


@model_kernel
def continue_stage(model: PathModel, g: StageArrays, t: Trace, pauses: bool) -> int:
    """Go on with a stage from where its trace is. pauses : stop where a contact has slid as far as it may, too."""
    model, g, t = borrowed(model), borrowed(g), borrowed(t)
    m = PathSteps(model.own, [model.step], model.read)
    leg = t.leg[0]
    while leg.share < g.last * (1.0 - 1e-12):
        if leg.number + 4 > len(t.rows) or leg.events + 128 > len(t.events) or leg.snaps + 2 > len(t.snaps.share):
            return FULL
        leg.count += 1
        if leg.count > g.tries:
            return _over(t, _TOO_MANY_STEPS)
        if leg.snaps > 0 and not g.goes_on_snapped:
            return _over(t, _SNAPS)
        leg.asked = 0
        goes = advance(m, g, t)
        if goes == PENDING:
            leg.count -= 1
            return ASKS
        leg.answered = 0
        if goes == _ENDS:
            return OVER
        if pauses and leg.slides_number >= 0:
            return PAUSED
        if leg.count % g.breath == 0:
            return BREATHES
    if not carries(m.read, t.rows[leg.number - 1]) and _pushed_out(m.read, g, t):
        return _over(t, _PUSHED_OUT)
    return _over(t, _UNBOUNDED if g.is_open else _REACHED)


@model_kernel
def part_of_step(model: PathModel, g: StageArrays, t: Trace, number: int, part: float, row: Array) -> int:
    """Write the state at a part of the step from this state of a trace to the next one, as a first step would find it.
    As `solve_step` returns it.
    """
    m, share = PathSteps(model.own, [model.step], model.read), t.shares[number]
    size = t.shares[number + 1] - share
    return find_part(m, g, 0.0, t.rows[number], t.rows[number + 1], share, size, part, row)


@kernel
def _over(t: Trace, status: int) -> int:
    t.leg[0].status = status
    return OVER


@steps_kernel
def advance(m: PathSteps, g: StageArrays, t: Trace) -> int:
    """One try of a step; whether the path goes on, or PENDING."""
    leg = t.leg[0]
    share, state, size = leg.share, t.rows[leg.number - 1], min(leg.step, g.last - leg.share)
    if share + size > g.last * (1.0 - 1e-9):
        size = g.last - share
    if not m.read.poses.follows and leg.ends - share <= 2.0 * g.exact * g.unit:
        if leg.failed == _CLOSES and not _leads_beyond(m, g, t, state):
            if m.read.friction.faces > 0 and leg.passed < _MOST_PASSED and _slip_otherwise(m, g, t, state):
                return _GOES
            return _continue_failed(m, g, t, state, _NO_FORCES, g.exact * g.unit)  # shorter steps obey laws by rounding
        leg.ends, leg.failed = np.inf, 0  # shorter steps lead on, or one from here does
    found = np.empty(len(state))
    status = find_step(m, g, t, state, share, size, found)
    if status == PENDING:
        return PENDING
    if status == SETTLED and _leaps(m, g, t, state, found, share, size):
        status = _LEAPS if m.read.poses.follows else _TOO_FAR  # a damper bears what is a little too much
    if status != SETTLED:
        return _continue_failed(m, g, t, state, status, size)
    if carries(m.read, state):
        part = first_change(m, g, t, state, found, share, size)
        if part < 0.0:
            leg.step, leg.failed = -part * size, 1
            return _GOES
        size *= part
    earlier, ratio = state, 0.0
    if leg.before > 0.0:
        earlier, ratio = t.rows[leg.number - 2], size / leg.before
    error = estimate_error(m.read, state, found, earlier, ratio) if carries(m.read, found) else 0.0
    if error > g.accuracy and size > FINEST * g.unit:
        leg.step = size * _suggested(g, error)
        return _GOES
    kinds = read_part(found, m.read.state, PARTS.kinds)
    if not is_same(kinds, t.calm) and growth(m.read, found) > GROWS:
        unstable = found.copy()
        size, breaks = _stable_step(m, g, t, state, found, share, size)
        if breaks == PENDING:
            return PENDING
        if breaks != 0:
            return _leave_balance(m, g, t, found, share + size, found if is_measured(m.read, found) else unstable)
    if g.is_open and excess(m, g, found) > 0.0:
        size = locate_limit(m, g, t, state, found, share, size, True)
        _add(m.read, g, t, found, share + size, error)
        leg.status = _LIMIT
        return _ENDS
    slides = g.loads and leg.slides_number == -1 and excess_slip(m.read, t, slip_lengths(m.read, state, found)) > 0.0
    if slides:
        size = locate_limit(m, g, t, state, found, share, size, False)
    leg.speed = distance(m.read, state, found) / size
    leg.share = share + size
    happens = _add(m.read, g, t, found, leg.share, error)
    if slides:
        leg.slides_share, leg.slides_number = leg.share, leg.number - 1
    kept = read_part(found, m.read.state, PARTS.controls)[8] != 0.0
    if carries(m.read, state) and not (carries(m.read, found) or kept):
        leg.status = _LOOSE
        return _ENDS
    leg.before = 0.0 if happens else size
    most = np.inf if happens else size * (1.0 if leg.failed != 0 else _suggested(g, error))
    leg.step = _next_step(m.read, g, t, found, most)
    leg.failed = 0 if leg.ends == np.inf else leg.failed
    return _GOES


@steps_kernel
def _leads_beyond(m: PathSteps, g: StageArrays, t: Trace, state: Array) -> bool:
    """Whether a step from just before the end has a solution. The end is known from a step that began farther away,
    from where Newton's method may find none among many contacts that are about to slide.
    """
    share, found = t.leg[0].share, np.empty(len(state))
    size = min(_BEYOND * g.unit, g.last - share)
    if find_step(m, g, t, state, share, size, found) != SETTLED:
        return False
    return not _leaps(m, g, t, state, found, share, size)


@steps_kernel
def _slip_otherwise(m: PathSteps, g: StageArrays, t: Trace, state: Array) -> bool:
    """A very short step in which contacts slip in other ways than Newton's method expects where friction comes to a
    corner of its faces; whether there is one, which is taken. Ways and sizes of slip are spread evenly (Kronecker's
    sequence), so that they are the same ones every time.
    """
    leg, c, n = t.leg[0], len(m.read.friction.scale), len(m.read.max_slip)
    size = min(_OTHERWISE * g.unit, g.last - leg.share)
    controls, found = controls_between(g.begin, g.end, leg.share + size), np.empty(len(state))
    where, known = read_part(state, m.read.state, PARTS.where), read_part(state, m.read.state, PARTS.start)
    forces, load = read_part(state, m.read.state, PARTS.forces), 0.0
    for a in range(3):
        load += (g.end[a] - g.begin[a]) ** 2 + ((g.end[3 + a] - g.begin[3 + a]) / m.read.sizes.length) ** 2
    little, start = size * load**0.5 / m.read.sizes.stiffness, known.copy()
    asked = StepOptions(m.read.sizes.slow, 1.0, np.zeros((0, 3)), False)
    for k in range(1, _WAYS + 1):
        for i in range(c):
            if i % 3 < 2 or i >= 3 * n:
                way, far = (k * _SPREAD[0] * (i + 1)) % 1.0, (k * _SPREAD[1] * (i + 1)) % 1.0
                start[c + 9 + i] = little * np.cos(2.0 * np.pi * way) * 10.0 ** (4.0 * far - 2.0)
        settled = take_step(m, state, controls, where, start, asked, found) == SETTLED
        now = read_part(found, m.read.state, PARTS.forces)
        if not settled or largest_change(now, forces) > g.accuracy * largest_force(m.read, state):
            continue
        if not _leaps(m, g, t, state, found, leg.share, size):
            leg.passed, leg.share = leg.passed + 1, leg.share + size
            leg.speed = distance(m.read, state, found) / size
            _add(m.read, g, t, found, leg.share, 0.0)
            leg.ends, leg.failed, leg.before, leg.step = np.inf, 0, size, _FASTER * size
            return True
    return False


@kernel
def _suggested(g: StageArrays, error: float) -> float:
    """The share of a step that makes its error what is allowed."""
    return float(min(max(_SAFETY * (g.accuracy / max(error, 1e-300)) ** 0.5, _LEAST_SHARE), _MOST_SHARE))


@kernel
def _next_step(m: PathReader, g: StageArrays, t: Trace, found: Array, most: float) -> float:
    """The step after this one. Of an open stage it grows with the load, the faster where nothing slides."""
    leg = t.leg[0]
    if leg.share >= leg.ends:
        leg.ends = np.inf
    if leg.ends < np.inf:
        return float(max(_step_to_end(m, t, found), g.exact * g.unit))
    slides = any_slides(m, found)
    step = g.base
    if g.is_open:
        step = max(step, (_GROWS_SLIDING if slides else _GROWS_FREE) * leg.share)
    if leg.before == 0.0 and slides:
        step *= _ANEW
    return min(step, most)


@kernel
def _add(m: PathReader, g: StageArrays, t: Trace, found: Array, share: float, error: float) -> bool:
    """Write the next state down. Whether anything happens on the way to it."""
    leg, out = t.leg[0], np.empty((64, 2))
    k = leg.number
    count = min(write_events(m, t.rows[k - 1], found, out), len(out))
    left, stands = margins(m, t.rows[k - 1]), STANDS * largest_force(m, t.rows[k - 1])
    for e in range(count):  # what stood at its limit slides from there
        slides = out[e, 0] == SLIPS and 0.0 <= left[int(out[e, 1]), 0] <= stands
        t.events[leg.events + e, 0] = k - 1 if slides else k
        t.events[leg.events + e, 1:] = out[e]
    leg.events += count
    t.rows[k], t.shares[k], t.errors[k], t.slipped[k] = found, share, error, t.slipped[k - 1]
    if g.loads:
        t.slipped[k] += slip_lengths(m, t.rows[k - 1], found)
    leg.number = k + 1
    return count > 0


@kernel
def _pushed_out(m: PathReader, g: StageArrays, t: Trace) -> bool:
    """Whether nothing is held at the end, and the object has been pushed away by fingers that close."""
    number, far = t.leg[0].number, False
    first = t.rows[min(1, number - 1)] if len(g.origin) == 0 else g.origin
    moved = motion(m, first, t.rows[number - 1])
    for a in range(3):
        far = far or abs(moved[a]) > m.near
    return far


@steps_kernel
def _leaps(
    m: PathSteps, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float
) -> bool:  # fmt: skip
    """Whether the step may have jumped over a snap: it ends much farther away than the last step did, or far from where
    the last two led. Without a last step: whether its half ends far from its middle.
    """
    leg, far = t.leg[0], distance(m.read, state, found)
    if not (m.read.poses.follows or carries(m.read, state)):
        return False  # nothing holds it yet: fingers that close push it along
    if leg.speed > 0.0 and far > no_snap(t, size):
        return True
    if far <= MIN_SNAP_DISTANCE:
        return False
    expected, ends = state.copy(), found
    if leg.before > 0.0:
        where, _ = guess_between(m.read, t.rows[leg.number - 2], state, 1.0 + min(size / leg.before, ALONG))
    elif size <= 2.0 * FINEST * g.unit:
        return False
    else:
        where, _ = guess_between(m.read, state, found, 0.5)
        ends = np.empty(len(found))
        if find_part(m, g, leg.before, state, found, share, size, 0.5, ends) != SETTLED:
            return True
        far *= 0.5
    read_part(expected, m.read.state, PARTS.where)[:] = where
    return distance(m.read, expected, ends) > MIN_SNAP_DISTANCE + _BENDS * far


@kernel
def no_snap(t: Trace, size: float) -> float:
    """How far the object may go in such a step without a snap, as a share of the contacts' distances."""
    return float(MIN_SNAP_DISTANCE + SNAP_RATIO * t.leg[0].speed * size)


# ----------------------------------------------------------------
# Where no step has a solution, or where a small push grows.


@steps_kernel
def _continue_failed(m: PathSteps, g: StageArrays, t: Trace, state: Array, why: int, size: float) -> int:
    """A step without a solution is halved; where the shortest has none, the object moves on in a viscous flow.
    Whether the path goes on, or PENDING.
    """
    leg = t.leg[0]
    share, known = leg.share, leg.ends < np.inf
    leg.failed = _CLOSES if known or size <= g.exact * g.unit else 1
    if size > (g.exact if known else FINEST) * g.unit:
        leg.ends = share + size if known else np.inf
        leg.step = _shorter(m, g, t, state, size)
        return _GOES
    if known and leg.then != STUCK and _jumps(m.read, g, t, state):
        leg.status = _JUMPS
        return _ENDS
    if known and leg.then != MOVES:
        return _stop(t, int(leg.then), why)
    until, near = leg.ends if known else share + size, np.inf
    if why == _TOO_FAR and g.is_open and not m.read.poses.follows:  # it would move on without more load
        leg.ends, leg.then, leg.step = until, MOVES, g.exact * g.unit
        return _GOES
    if not known and _may_jump(m.read, g, t, state):  # where it comes to rest is asked once the jump is located exactly
        near = no_snap(t, size)
    end = np.empty(len(state))
    how = flow(m, t, state, controls_between(g.begin, g.end, until), _NO_PUSH, near, end)
    if how == PENDING:
        return PENDING
    if how == STUCK and not m.read.poses.follows:  # all solvers were asked for this load, too
        how = CREEPS
    snapped = False
    if how != MOVES and how != STUCK:
        snapped = _snaps(m.read, g, t, state, end, share, until, how == REST, np.zeros(6))
    if how != REST:
        leg.ends, leg.then = until, how
        leg.step = size / 2.0 if m.read.poses.follows else g.exact * g.unit  # it may end here exactly
        return _stop(t, how, why) if known else _GOES
    if snapped and _jumps(m.read, g, t, state):
        leg.status = _JUMPS
        return _ENDS
    leg.share, leg.ends = until, np.inf
    leg.speed = 0.0 if snapped else distance(m.read, state, end) / (until - share)
    _add(m.read, g, t, end, until, 0.0)
    leg.step, leg.before = min(_AFTER * (FINEST * g.unit if snapped else size), g.base), 0.0
    return _GOES


@steps_kernel
def _shorter(m: PathSteps, g: StageArrays, t: Trace, state: Array, size: float) -> float:
    """The step to try where this one has no solution: half of it; where contacts stay where they are, up to where the
    first of them changes its state if it goes on as it begins, or towards an end that is known as in the last step,
    which is exact if none slides on a round law.
    """
    if m.read.poses.follows:
        return 0.5 * size
    if t.leg[0].ends < np.inf:
        change = _next_change(m.read, t, state) if m.read.friction.faces > 0 else np.inf
        return change if g.exact * g.unit < change < size else max(0.5 * size, g.exact * g.unit)
    begins = np.empty(len(state))
    if find_part(m, g, 0.0, state, state, t.leg[0].share, size, BEGINS, begins) != SETTLED:
        return BEGINS * size
    part = BEGINS * first_crossing(m.read, state, begins)
    return size * min(part, _SHORT) if part < 2.0 - _SHORT else 0.5 * size


@kernel
def _step_to_end(m: PathReader, t: Trace, found: Array) -> float:
    """The step after one towards an end that is known: to half of what is left, or up to where the first contact
    changes its state if all go on as in the last step, when that is farther.
    """
    left, change = t.leg[0].ends - t.leg[0].share, _next_change(m, t, found)
    return float(change if 0.5 * left < change < left and not m.poses.follows else 0.5 * left)


@kernel
def _next_change(m: PathReader, t: Trace, state: Array) -> float:
    """The step from the last state to where the first contact changes its state, if all go on as in the last step."""
    k = t.leg[0].number - 1
    if k == 0:
        return np.inf
    return float((first_crossing(m, t.rows[k - 1], state) - 1.0) * (t.shares[k] - t.shares[k - 1]))


@kernel
def _stop(t: Trace, how: int, why: int) -> int:
    """The path ends here, as a flow said."""
    t.leg[0].status = _STUCK if how == STUCK else why
    return _ENDS


@steps_kernel
def _stable_step(
    m: PathSteps, g: StageArrays, t: Trace, state: Array, found: Array, share: float, size: float
) -> tuple[float, int]:  # fmt: skip
    """(size, whether a small push grows): the step up to where a push begins to grow, and write the state there into
    `found`; the whole step where a push that seemed to grow comes to rest where the object was. PENDING in place of
    that word.
    """
    end, middle, whole = np.empty(len(found)), np.empty(len(found)), found.copy()
    controls, push = read_part(found, m.read.state, PARTS.controls), _push(m.read, found, growing_motion(m.read, found))
    how = flow(m, t, found, controls, push, np.inf, end)
    if how == PENDING:
        return size, PENDING
    if how == REST and distance(m.read, found, end) < _SAME:
        t.calm[:] = read_part(found, m.read.state, PARTS.kinds)
        return size, 0
    low, high = 0.0, 1.0
    found[:] = state
    for _ in range(_HALVED):
        part = 0.5 * (low + high)
        settled = find_part(m, g, t.leg[0].before, state, whole, share, size, part, middle) == SETTLED
        if not settled or growth(m.read, middle) > GROWS:
            high = part
        else:
            low = part
            found[:] = middle
    return low * size, 1


@steps_kernel
def _leave_balance(m: PathSteps, g: StageArrays, t: Trace, state: Array, share: float, grows: Array) -> int:
    """Whether the path goes on, or PENDING: the object, pushed a little under slightly more load, comes to rest
    elsewhere. It is pushed in the motion that grows in the state `grows`, in which that was measured.
    """
    leg = t.leg[0]
    more = min(share + 2.0**-_HALVED * g.unit, g.last)
    moves, near, end = growing_motion(m.read, grows), np.inf, np.empty(len(state))
    if _may_jump(m.read, g, t, state) and g.is_open:
        near = no_snap(t, more - share)
    how = flow(m, t, state, controls_between(g.begin, g.end, more), _push(m.read, state, moves), near, end)
    if how == PENDING:
        return PENDING
    if share > leg.share:
        _add(m.read, g, t, state, share, 0.0)
        leg.share = share
    snapped = how != STUCK and _snaps(m.read, g, t, state, end, share, more, how == REST, moves)
    if snapped and _jumps(m.read, g, t, state):
        leg.status = _JUMPS
        return _ENDS
    if how == REST:
        _add(m.read, g, t, end, more, 0.0)
        leg.share = more
    leg.step, leg.before = g.base, 0.0
    return _GOES if how == REST else _stop(t, how, _UNSTABLE)


@kernel
def _push(m: PathReader, state: Array, moves: Array) -> Array:
    """(6,) a small wrench along a motion."""
    size = 0.0
    for force in read_part(state, m.state, PARTS.forces):
        size += abs(force)
    push = _PUSH * size * moves
    push[3:] *= m.sizes.length
    return push


@kernel
def _snaps(
    m: PathReader, g: StageArrays, t: Trace, state: Array, end: Array, share: float, until: float, rests: bool,
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


@kernel
def _may_jump(m: PathReader, g: StageArrays, t: Trace, state: Array) -> bool:
    """Whether the object is loaded, and has not jumped yet."""
    return carries(m, state) and g.loads and t.leg[0].jump_number == -1


@kernel
def _jumps(m: PathReader, g: StageArrays, t: Trace, state: Array) -> bool:
    """Note that a loaded object jumps here; whether that ends the path, as it does one to a load limit."""
    leg = t.leg[0]
    if _may_jump(m, g, t, state):
        leg.jump_share, leg.jump_number = leg.share, leg.number - 1
    return g.is_open and leg.jump_number != -1
