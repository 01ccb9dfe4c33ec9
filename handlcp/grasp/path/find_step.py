"""`find_step`: one step of a stage, by all the ways that it may have a solution: of second order, of first order after
a change, with fingers that touch nothing, with other contacts that stick and slide, and by the solvers of a single
grasp.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.flow import seek_state
from handlcp.grasp.path.path_model import (
    OPEN,
    PENDING,
    SLIDES,
    STICKS,
    PathReader,
    PathSteps,
    any_slides,
    carries,
    controls_between,
    friction_shares,
    guess_between,
    has_plain_friction,
    largest_force,
    margins,
    move_unloaded,
    on_same_face,
    slip_toward,
    steps_kernel,
    take_step,
)
from handlcp.grasp.path.solve_step import (
    NO_FORCE,
    PARTS,
    SETTLED,
    StepOptions,
    largest_change,
    read_part,
    read_state,
)
from handlcp.grasp.path.trace import StageArrays, Trace
from handlcp.lcp.kernels.dense import kernel

FINEST = 2.0**-9  # of a stage's unit: where a step as short as this has no solution, there is none
ALONG = 2.0  # a path is not continued further than this many times its last step
_ALONE = 2.0**-4  # of the unit: a shorter step without a solution is also tried without a prediction
_AT_FRICTION = 0.02  # of a contact's friction: with no more left it may slide in the next short step
_MOST_BRANCHES = 16  # choices of what sticks that are tried
_GOES_ON = 0.02  # of the forces: how much a short step changes
_FREE = 1e4  # h of a step that pushes an object which nothing holds
_LITTLE = 1e-4  # of the contacts' distances: a slip that is expected, and not known
_NO_FORCES, _TOO_FAR = int(PathStatus.NO_FORCES), int(PathStatus.TOO_FAR)


@steps_kernel
def find_step(m: PathSteps, g: StageArrays, t: Trace, state: Array, share: float, size: float, row: Array) -> int:
    """Write the end of one step, solved from where the last two led; where that has no solution, from the last
    state.
    """
    leg, controls, loaded = t.leg[0], controls_between(g.begin, g.end, share + size), carries(m.read, state)
    stood, began = read_part(state, m.read.state, PARTS.where), read_part(state, m.read.state, PARTS.start)
    where, start, predicted = stood, began, leg.before > 0.0
    if predicted:
        where, start = guess_between(m.read, t.rows[leg.number - 2], state, 1.0 + min(size / leg.before, ALONG))
    if _second_order(m, leg.before, state, controls, where, start, size, row):
        return SETTLED
    status = _first_order(m, state, controls, where, start, row)
    if status != SETTLED and predicted and size < _ALONE * g.unit:
        status = take_step(m, state, controls, stood, began, _quasistatic(m.read.sizes.slow), row)
    if status != SETTLED and not loaded:
        status = move_unloaded(m, state, controls, row)
        if status != SETTLED:
            status = _push_ahead(m, state, controls, where, start, row)
    looks = loaded and size <= _ALONE * g.unit and (leg.ends == np.inf or m.read.poses.follows)
    if status != SETTLED and looks and _branch(m, state, controls, row):
        status = SETTLED
    # All solvers are asked for a step that Newton's method does not solve once no shorter step has a solution; in one
    # posture not where it solves it by a motion that needs no more load, unless forces may be others there, too
    asks = size <= FINEST * g.unit and (status != _TOO_FAR or m.read.poses.follows or not has_plain_friction(m.read))
    if status != SETTLED and leg.ends == np.inf and asks:
        sought = seek_state(t, state, controls, row)
        if sought in (SETTLED, PENDING):
            status = sought
    return status


@kernel
def _quasistatic(slow: float) -> StepOptions:
    """Of a step with this h of its damper."""
    return StepOptions(slow, 1.0, np.zeros((0, 3)), False)


@steps_kernel
def _second_order(
    m: PathSteps, before: float, state: Array, controls: Array, where: Array, start: Array, size: float, row: Array
) -> bool:  # fmt: skip
    """A step of second order: friction opposes the slip at its end, as a parabola through the last two steps has it
    (BDF2); before : the last of them. Whether there is one: not where a contact that slid sticks, which would stick to
    that parabola. On flat faces slip keeps to its face's normal, and a step of first order is exact.
    """
    if before == 0.0 or m.read.friction.faces > 0 or not any_slides(m.read, state):
        return False
    s, ratio = m.read.state, size / before
    old, spin = read_part(state, s, PARTS.kinds), read_part(state, s, PARTS.spin)
    motion = read_part(state, s, PARTS.motion)
    part, past = ratio**2 / (1.0 + 2.0 * ratio), np.zeros((len(old), 3))
    for i in range(len(past)):
        if old[i] == SLIDES:
            past[i, 0], past[i, 1] = part * motion[3 * i], part * motion[3 * i + 1]
            past[i, 2] = part * spin[i]
    if take_step(m, state, controls, where, start, StepOptions(m.read.sizes.slow, 1.0, past, False), row) != SETTLED:
        return False
    kinds, fits = read_part(row, m.read.state, PARTS.kinds), True
    for i in range(len(kinds)):
        fits = fits and not (old[i] == SLIDES and kinds[i] == STICKS)
    return fits


@steps_kernel
def _first_order(m: PathSteps, state: Array, controls: Array, where: Array, start: Array, row: Array) -> int:
    """A step after a change, where the last two say nothing. Friction is continuous there: on round sets slip begins
    along where friction pushes, and ends along where it pushes then; of both its way is the mean (trapezoidal rule).
    """
    status = take_step(m, state, controls, where, start, _quasistatic(m.read.sizes.slow), row)
    if status != SETTLED or m.read.friction.faces > 0 or not (any_slides(m.read, state) and any_slides(m.read, row)):
        return status
    push = friction_shares(m.read, state)
    if on_same_face(m.read, push, friction_shares(m.read, row)).all():
        return status
    old, end, past = read_state(state, m.read.state), read_state(row, m.read.state), slip_toward(m.read, -push, row)
    for i in range(len(past)):
        past[i] *= 0.5 if old.kinds[i] == SLIDES and end.kinds[i] == SLIDES else 0.0
    better = np.empty(len(row))
    asked = StepOptions(m.read.sizes.slow, 1.0, past, False)
    again = take_step(m, state, controls, end.where, end.start, asked, better)
    if again == SETTLED and is_same(read_part(better, m.read.state, PARTS.kinds), end.kinds):
        row[:] = better
    return status


@steps_kernel
def _push_ahead(m: PathSteps, state: Array, controls: Array, where: Array, start: Array, row: Array) -> int:
    """A step in which fingers may push ahead of them an object that nothing holds, against a damper that is large
    enough to compute with. The forces of that are none.
    """
    pulled = controls[:6].any() or controls[6] != 0.0
    if pulled and not m.read.poses.follows:
        return _NO_FORCES
    asked = StepOptions(_FREE, 1.0, np.zeros((0, 3)), False)
    status = take_step(m, state, controls, where, start, asked, row)
    if status != SETTLED:
        return status
    end, sizes = read_state(row, m.read.state), m.read.sizes
    most = sizes.slow / _FREE * NO_FORCE * sizes.stiffness * sizes.length
    for i in range(len(end.kinds)):
        if end.forces[i, 2] > most:
            return _NO_FORCES
    end.kinds[:] = OPEN
    return SETTLED


@steps_kernel
def _branch(m: PathSteps, state: Array, controls: Array, row: Array) -> bool:
    """A short step in which other contacts stick and slide than Newton's method expects: those at the limit of their
    friction may do either. The one in which the fewest do otherwise and forces go on; whether there is one.
    """
    old, left, f = read_state(state, m.read.state), margins(m.read, state), m.read.friction.coefficients
    n, may, count = len(old.kinds), np.empty(len(old.kinds), np.int64), 0
    for i in range(n):
        limit = f[i] * old.forces[i, 2]
        near = old.kinds[i] == STICKS and left[i, 0] <= _AT_FRICTION * limit
        if limit > 0.0 and (old.kinds[i] == SLIDES or near):
            may[count] = i
            count += 1
    size, tried = largest_force(m.read, state), 0
    for flips in range(1, count + 1):
        chosen = np.arange(flips)
        while tried < _MOST_BRANCHES:
            tried += 1
            slides = old.kinds == SLIDES
            for k in chosen:
                slides[may[k]] = not slides[may[k]]
            start = _expecting(m.read, state, slides)
            settled = take_step(m, state, controls, old.where, start, _quasistatic(m.read.sizes.slow), row) == SETTLED
            now = read_part(row, m.read.state, PARTS.forces)
            if settled and largest_change(now, old.forces.reshape(-1)) <= _GOES_ON * size:
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
def _expecting(m: PathReader, state: Array, slides: Array) -> Array:
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


@steps_kernel
def find_part(
    m: PathSteps, g: StageArrays, before: float, state: Array, found: Array, share: float, size: float, part: float,
    row: Array,
) -> int:  # fmt: skip
    """Write the state at a part of a step that is known to have a solution. before : as in `_second_order`."""
    controls = controls_between(g.begin, g.end, share + part * size)
    where, start = guess_between(m.read, state, found, part)
    if _second_order(m, before, state, controls, where, start, part * size, row):
        return SETTLED
    status = _first_order(m, state, controls, where, start, row)
    for known in (state, found):  # Newton's method may find none from between them, and one from either
        if status != SETTLED:
            where, start = read_part(known, m.read.state, PARTS.where), read_part(known, m.read.state, PARTS.start)
            status = _first_order(m, state, controls, where, start, row)
    return status


@kernel
def is_same(a: Array, b: Array) -> bool:
    """Whether two rows of numbers are equal."""
    same = True
    for i in range(len(a)):
        same = same and a[i] == b[i]
    return same
