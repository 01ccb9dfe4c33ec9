"""A grasp driven through its program: quasi-static steps where there are any, a viscous flow where there are none.

A step is predicted from the last two and corrected by Newton's method (`Stepper`). Its size follows an estimate of its
error. While nothing slides a step is exact, however long: forces depend on where things are alone. Where contacts
slide, friction opposes the slip at the end of the step, which is known to first order from the step alone, and to
second order from the last two (BDF2); the estimate is the difference between the direction that was found and the one
that the order of the step predicts.

Where a contact changes its state inside a step, the step ends there: the change is located on the contact's margin, by
regula falsi. A step without an end is halved; where the shortest has none, or where a small push grows, the object
moves on at constant load against a vanishing viscosity (`flow`): it comes to rest elsewhere, which is one event, or it
leaves, and the path ends at the last load with a static state.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, check_number
from handlcp.grasp.model.status import ContactStatus, PathStatus
from handlcp.grasp.path.geometry import between
from handlcp.grasp.path.stability import GROWS, MOVES, REST, STUCK, flow, growing, growth, measured
from handlcp.grasp.path.state import SLIDES, STICKS, Controls, Failure, Goal, Guess, Jump, Run, Slides, Snap, State
from handlcp.grasp.path.step import Stepper
from handlcp.grasp.path.watch import Watch, first_change, margins, slip_lengths
from handlcp.progress import report_progress
from handlcp.tolerances import MIN_SNAP_DISTANCE, SNAP_RATIO

ACCURACY = 1e-3  # of the largest force: the error of a step, unless something else is asked
_STAGE_UNIT = 2.0**-3  # of a stage that has an end: in this unit the shortest steps are counted
FINEST = 2.0**-9  # of that unit: where a step as short as this has no solution, there is none
_EXACT = 2.0**-18  # of it: how closely a jump or the last static state is located once there is known to be one
_ALONG = 2.0  # a path is not continued further than this many times its last step
_ANEW = 2.0**-3  # times the usual step: the first after a change, which is of first order
_ALONE = 2.0**-4  # of the unit: a shorter step without a solution is also tried without a prediction
_GROWS = (0.5, 0.15)  # of the load: steps of an open stage where nothing slides, and where something does
_HALVED = 14  # times a step, where a push begins to grow and where a limit is reached
_ON = 1e-9  # of a limit: this near to it is at it
_PUSH = 1e-3  # of the forces
_SAME = 1e-3  # of the contacts' distances: the same place
_BENDS = 0.5  # of a step: how far from where it was expected it may end
_AFTER = 4.0  # times the step on which it snapped: the next, where another may follow at once
_CHAIN = 1.01  # steps between snaps that are one
_AT_FRICTION = 0.02  # of a contact's friction: with no more left it may slide in the next short step
_MOST_BRANCHES, _GOES_ON = (
    16,
    0.02,
)  # choices of what sticks that are tried; of the forces: how much a short step changes
_SAFETY, _LEAST_SHARE, _MOST_SHARE = 0.8, 0.1, 3.0  # of the step that the error of the last one suggests


def read_accuracy(value: Any) -> float:
    """The error of a step that is allowed; None: ACCURACY. Raises InputError."""
    return ACCURACY if value is None else check_number("accuracy", value, above=0.0)


class Patience(NamedTuple):
    """When a path is given up. tries : of steps of a stage with the usual accuracy; paths of use take 10 to 150, hard
    ones a thousand. snaps : whether it goes on after the object has snapped elsewhere.
    """

    tries: int = 2500
    snaps: bool = True


PATIENT = Patience()


class Open(NamedTuple):
    """A last stage that goes on beyond its end until something ends it. first : its first step, as a share. most : the
    share at which it is given up: nothing will end it. over : of a state, how far it is beyond a limit that was set, as
    a share of that limit.
    """

    first: float
    most: float
    over: Callable[[State], float]


def advance(
    stepper: Stepper, watch: Watch, first: Controls, goals: list[Goal], steps: int, accuracy: float = ACCURACY,
    patience: Patience = PATIENT,
) -> Run:  # fmt: skip
    """Follow every stage in so many steps at least, until the end or until the object is lost. first : the controls
    before anything is done. accuracy : of a step, as a share of the largest force.
    """
    state = stepper.beginning(first)
    run = Run.beginning_at(state)
    if stepper.grasp.sags:  # gaps open where fingers give way to their own weight
        settled = stepper.step(state, first)
        if isinstance(settled, Failure):
            run.ends(*settled)
            return run
        run.states[0] = settled
    for k, goal in enumerate(goals):
        leg = Leg(stepper, watch, run, k, goal, 1.0 / steps, accuracy=accuracy)
        leg.patience = patience
        if not leg.through():
            break
    return run


class Leg:
    """One stage of a run, from its last state on. base : its longest step, as a share. beyond : for a stage without an
    end. accuracy : as in `advance`.
    """

    def __init__(
        self, stepper: Stepper, watch: Watch, run: Run, number: int, goal: Goal, base: float,
        beyond: Open | None = None, accuracy: float = ACCURACY,
    ) -> None:  # fmt: skip
        self.stepper, self.watch, self.run, self.number, self.goal, self.base = stepper, watch, run, number, goal, base
        self.beyond, self.last, self.patience = beyond, 1.0 if beyond is None else beyond.most, PATIENT
        self.accuracy, self.unit = accuracy, _STAGE_UNIT if beyond is None else beyond.first
        run.under_way = number
        if beyond is not None:
            self.base = beyond.first
        self.begin = run.states[-1].controls
        self.share, self.step, self.count = 0.0, self.base, 0
        self.ends = np.inf  # the share before which there is a snap or the last static state, once that is known
        self.then = MOVES  # what a flow from there comes to; that it goes on until it rests, has left or is stuck
        self.failed = False  # whether the last try had no solution
        self.before: tuple[State, float] | None = None  # the state before the last, and the step between them
        self.calm: tuple[ContactStatus, ...] = ()  # contact states for which a small push that seemed to grow died away
        load, weight = self.goal.end.load != self.begin.load, self.goal.end.weight != self.begin.weight
        self.loads = bool(load.any()) or weight  # whether a load changes in the stage
        self.speed = 0.0  # how fast the object moved in the last step; 0 at the beginning and after a jump

    def through(self, pause: bool = False) -> bool:
        """Whether the end of the stage is reached. pause : stop where a contact has slid as far as it may, too; called
        again it goes on from there.
        """
        run = self.run
        while self.share < self.last * (1.0 - 1e-12):
            self.count += 1
            if self.count > self.patience.tries * max(1.0, (ACCURACY / self.accuracy) ** 0.5):
                return run.ends(PathStatus.TOO_MANY_STEPS)
            if run.snaps and not self.patience.snaps:
                return run.ends(PathStatus.SNAPS)
            known = len(run.states)
            goes_on = self._advanced()
            ends = not goes_on and (run.status.is_lost or run.status.is_given_up)
            if who := self.stepper.crosses(run.states, known - 1, ends):
                run.back_to(known)
                return run.ends(PathStatus.CROSSES, who)
            if not goes_on:
                return False
            if pause and run.slides is not None:
                return True
        if not run.states[-1].loaded and self._pushed_out():
            return run.ends(PathStatus.PUSHED_OUT)
        return self.beyond is None or run.ends(PathStatus.UNBOUNDED)

    def _advanced(self) -> bool:
        """One try of a step; whether the path goes on."""
        run, share = self.run, self.share
        at = words.format_percent(share) if self.beyond is None else f"{share:.3g} times the load"
        report_progress(f"stage {self.goal.name!r} at {at}")
        state, size = run.states[-1], min(self.step, self.last - share)
        if share + size > self.last * (1.0 - 1e-9):
            size = self.last - share
        found = self._found(state, share, size)
        if isinstance(found, State) and self._leaps(state, found, share, size):
            found = Failure(PathStatus.LEAPS)
        if isinstance(found, Failure):
            return self._failed(state, found, size)
        size, found = self._located(state, found, share, size)
        error = self._error(state, found, size)
        if error > self.accuracy and size > FINEST * self.unit:
            self.step = size * self._suggested(error)
            return True
        if found.kinds != self.calm and growth(found) > GROWS:
            unstable = found
            size, found, breaks = self._stable(state, found, share, size)
            if breaks:
                return self._breaks(found, share + size, found if measured(found) else unstable)
        if self.beyond is not None and self.beyond.over(found) > 0.0:
            size, found = self.crossing(state, found, share, size, self.beyond.over)
            self._add(found, share + size, error)
            return run.ends(PathStatus.LIMIT)
        slides = self.loads and run.slides is None and self._slid_too_far(found) > 0.0
        if slides:
            size, found = self.crossing(state, found, share, size, self._slid_too_far)
        self.speed = self.stepper.far(state.where.pose, found.where.pose) / size
        self.share = share = share + size
        happens = self._add(found, share, error)
        if slides:
            run.slides = Slides(self.number, share, len(run.states) - 1)
        if state.loaded and not found.loaded and not found.controls.kept:
            return run.ends(PathStatus.LOOSE)
        self.before = None if happens else (state, size)
        most = np.inf if happens else size * (1.0 if self.failed else self._suggested(error))
        self.step = self._following(share, found, most, size)
        self.failed = False
        return True

    def _slid_too_far(self, state: State) -> float:
        """How much farther than it may a contact has slid at the end of a step to this state, as a share."""
        return float(((self.run.slipped[-1] + slip_lengths(state)) / self.watch.max_slip).max(initial=0.0)) - 1.0

    def _suggested(self, error: float) -> float:
        """The share of a step that makes its error what is allowed."""
        return float(min(max(_SAFETY * (self.accuracy / max(error, 1e-300)) ** 0.5, _LEAST_SHARE), _MOST_SHARE))

    def _error(self, state: State, found: State, size: float) -> float:
        """Estimated error of the forces at the end of a step, as a share of the largest: friction opposes the slip at
        the end, whose direction is known to second order.
        """
        if not found.slides or not found.loaded:
            return 0.0
        now, last = self.stepper.friction_shares(found), self.stepper.friction_shares(state)
        slid = np.array([a == SLIDES == b for a, b in zip(state.kinds, found.kinds, strict=True)])
        slid &= ~self.stepper.on_same_face(now, last)
        turned = now - last
        angle = np.sqrt((turned * turned).sum(axis=1))
        error = 0.5 * angle**2
        if self.before is not None:
            earlier, before = self.before
            bends = turned - size / before * (last - self.stepper.friction_shares(earlier))
            error = np.sqrt((bends * bends).sum(axis=1)) / 3.0 + angle**3 / 4.0
        weights = self.stepper.friction * found.read.forces[:, 2]
        size_of = float(abs(found.read.forces).max(initial=1e-300))
        return float((error * slid * weights).max(initial=0.0)) / size_of

    def _following(self, share: float, found: State, most: float, size: float) -> float:
        """The step after one of this size. Of an open stage it grows with the load, the faster where nothing slides."""
        if share >= self.ends:
            self.ends = np.inf
        if self.ends < np.inf:
            return max(0.5 * size, _EXACT * self.unit)
        grows = 0.0 if self.beyond is None else _GROWS[found.slides]
        step = max(self.base, grows * share)
        if self.before is None and found.slides:
            step *= _ANEW
        return min(step, most)

    def _failed(self, state: State, why: Failure, size: float) -> bool:
        """A step without a solution is halved; where the shortest has none, the object moves on in a viscous flow.
        Whether the path goes on.
        """
        share, known = self.share, self.ends < np.inf
        self.failed = True
        if size > (_EXACT if known else FINEST) * self.unit:
            self.step = size / 2.0
            return True
        if known and self.then != STUCK and self._jumps(state):
            return self.run.ends(PathStatus.JUMPS)
        if known and self.then != MOVES:
            return self._over(self.then, why)
        until, near = self.ends if known else share + size, np.inf
        if not known and self._may_jump(state):  # where it comes to rest is asked once the jump is located exactly
            near = self._no_snap(size)
        end, how = flow(self.stepper, state, self.controls(until), None, near)
        snapped = how not in (MOVES, STUCK) and self._snapped(state, end, share, until, how == REST, ())
        if how != REST:
            self.ends, self.then, self.step = until, how, size / 2.0
            return not known or self._over(how, why)
        if snapped and self._jumps(state):
            return self.run.ends(PathStatus.JUMPS)
        self.share, self.ends = until, np.inf
        self._add(end, until)
        self.step, self.before = min(_AFTER * FINEST * self.unit, self.base), None
        self.speed = 0.0 if snapped else self.stepper.far(state.where.pose, end.where.pose) / (until - share)
        return True

    def _over(self, how: str, why: Failure) -> bool:
        """The path ends here, as a flow said."""
        if how == STUCK:
            return self.run.ends(PathStatus.STUCK)
        return self.run.ends(*why)

    def _leaps(self, state: State, found: State, share: float, size: float) -> bool:
        """Whether the step may have jumped over a snap: it ends much farther away than the last step did, or far from
        where the last two led. Without a last step: whether its half ends far from its middle.
        """
        last, far = self.speed, self.stepper.far(state.where.pose, found.where.pose)
        if last > 0.0 and far > self._no_snap(size):
            return True
        if far <= MIN_SNAP_DISTANCE:
            return False
        if self.before is not None:
            expected = _further(self.stepper, self.before[0], state, min(size / self.before[1], _ALONG))
        elif size <= 2.0 * FINEST * self.unit:
            return False
        else:
            expected, half = _part(self.stepper, state, found, 0.5), self._at(state, found, share, size, 0.5)
            if isinstance(half, Failure):
                return True
            found, far = half, 0.5 * far
        return self.stepper.far(expected.where.pose, found.where.pose) > MIN_SNAP_DISTANCE + _BENDS * far

    def controls(self, share: float) -> Controls:
        """At a share of the stage."""
        return self.begin.toward(self.goal.end, share)

    def seen(self, number: int, share: float) -> State:
        """The state at a share of this stage that lies between a state of the run and the next one."""
        run = self.run
        state, begin = run.states[number], run.shares[number]
        if share <= begin or number + 1 >= len(run.states):
            return state
        size = run.shares[number + 1] - begin
        found = self._at(state, run.states[number + 1], begin, size, (share - begin) / size)
        return state if isinstance(found, Failure) else found

    def _found(self, state: State, share: float, size: float) -> State | Failure:
        """One step, solved from where the last two led; where that has no solution, from the last state."""
        controls, guess = self.controls(share + size), None
        if self.before is not None:
            guess = _further(self.stepper, self.before[0], state, min(size / self.before[1], _ALONG))
        found = self._second(state, controls, guess, size) or self._first(state, controls, guess)
        if isinstance(found, Failure) and guess is not None and size < _ALONE * self.unit:
            found = self.stepper.step(state, controls)
        if isinstance(found, Failure) and not state.loaded:
            found = self.stepper.untouched(state, controls)
            if isinstance(found, Failure):
                found = self.stepper.pushed(state, controls, guess)
        if isinstance(found, Failure) and state.loaded and size <= _ALONE * self.unit:
            found = self._branch(state, controls) or found
        if isinstance(found, Failure) and self._last_resort(size):
            found = self.stepper.sought(state, controls) or found
        return found

    def _branch(self, state: State, controls: Controls) -> State | None:
        """A short step in which other contacts stick and slide than Newton's method expects: those at the limit of
        their friction may do either. The one in which the fewest do otherwise and forces go on; None: there is none.
        """
        slides = np.array([kind == SLIDES for kind in state.kinds])
        sticks = np.array([kind == STICKS for kind in state.kinds])
        left, limit = margins(self.stepper, state)[:, 0], self.stepper.friction * state.read.forces[:, 2]
        may = np.flatnonzero((slides | (sticks & (left <= _AT_FRICTION * limit))) & (limit > 0.0))
        choices = [flips for count in range(1, len(may) + 1) for flips in combinations(may.tolist(), count)]
        size = float(abs(state.read.forces).max(initial=0.0))
        for flips in choices[:_MOST_BRANCHES]:
            other = slides.copy()
            other[list(flips)] ^= True
            found = self.stepper.step(state, controls, self.stepper.expecting(state, other))
            if isinstance(found, State) and abs(found.read.forces - state.read.forces).max() <= _GOES_ON * size:
                return found
        return None

    def _last_resort(self, size: float) -> bool:
        """Whether all solvers are asked for a step that Newton's method does not solve: where contacts stay where they
        are it is one solve however long the step is, elsewhere only once no shorter step has a solution.
        """
        return self.ends == np.inf and (size <= FINEST * self.unit or not self.stepper.geometry.follows)

    def _second(self, state: State, controls: Controls, guess: Guess | None, size: float) -> State | None:
        """A step of second order: friction opposes the slip at its end, as a parabola through the last two steps has it
        (BDF2). None where a contact that slid sticks: it would stick to that parabola.
        """
        if self.before is None or not state.slides:
            return None
        ratio = size / self.before[1]
        slides = np.array([kind == SLIDES for kind in state.kinds])
        past = ratio**2 / (1.0 + 2.0 * ratio) * state.slid * slides[:, None]
        found = self.stepper.step(state, controls, guess, None, 1.0, past)
        if isinstance(found, Failure) or (SLIDES, STICKS) in zip(state.kinds, found.kinds, strict=True):
            return None
        return found

    def _first(self, state: State, controls: Controls, guess: Guess | None) -> State | Failure:
        """A step after a change, where the last two say nothing. Friction is continuous there: slip begins along where
        friction pushes, and ends along where it pushes then; of both its way is the mean (trapezoidal rule).
        """
        found = self.stepper.step(state, controls, guess)
        if isinstance(found, Failure) or not (state.slides and found.slides) or self._keeps_direction(state, found):
            return found
        push = self.stepper.friction_shares(state)
        slides = np.array([a == SLIDES == b for a, b in zip(state.kinds, found.kinds, strict=True)])
        past = 0.5 * self.stepper.slip_toward(-push, found) * slides[:, None]
        better = self.stepper.step(state, controls, found.same, None, 1.0, past)
        return found if isinstance(better, Failure) or better.kinds != found.kinds else better

    def _keeps_direction(self, state: State, found: State) -> bool:
        """Whether no contact's direction of slip can turn in a step: friction sets have flat faces."""
        shares = self.stepper.friction_shares
        return bool(self.stepper.on_same_face(shares(state), shares(found)).all())

    def _at(self, state: State, found: State, share: float, size: float, part: float) -> State | Failure:
        """The state at a part of a step that is known to have a solution."""
        controls, guess = self.controls(share + part * size), _part(self.stepper, state, found, part)
        return self._second(state, controls, guess, part * size) or self._first(state, controls, guess)

    def _located(self, state: State, found: State, share: float, size: float) -> tuple[float, State]:
        """The step up to where the first contact changes its state in it, or all of it."""
        if not state.loaded:
            return size, found
        part, found = first_change(self.stepper, state, found, lambda part: self._at(state, found, share, size, part))
        return part * size, found

    def _stable(self, state: State, found: State, share: float, size: float) -> tuple[float, State, bool]:
        """(size, state, whether a small push grows): the step up to where a push begins to grow; the whole step where a
        push that seemed to grow comes to rest where the object was.
        """
        end, how = flow(self.stepper, found, found.controls, self._push(found, self._growing(found)))
        if how == REST and self.stepper.far(found.where.pose, end.where.pose) < _SAME:
            self.calm = found.kinds
            return size, found, False
        low, high, best = 0.0, 1.0, state
        for _ in range(_HALVED):
            middle = 0.5 * (low + high)
            at = self._at(state, found, share, size, middle)
            if isinstance(at, Failure) or growth(at) > GROWS:
                high = middle
            else:
                low, best = middle, at
        return low * size, best, True

    def _breaks(self, state: State, share: float, grows: State) -> bool:
        """Whether the path goes on: the object, pushed a little under slightly more load, comes to rest elsewhere. It
        is pushed in the motion that grows in the state `grows`, in which that was measured.
        """
        run = self.run
        if share > self.share:
            self._add(state, share)
            self.share = share
        more = min(share + 2.0**-_HALVED * self.unit, self.last)
        motion = self._growing(grows)
        near = self._no_snap(more - share) if self._may_jump(state) and self.beyond is not None else np.inf
        end, how = flow(self.stepper, state, self.controls(more), self._push(state, motion), near)
        pushed = tuple(motion.tolist())
        if how != STUCK and self._snapped(state, end, share, more, how == REST, pushed) and self._jumps(state):
            return run.ends(PathStatus.JUMPS)
        if how == REST:
            self._add(end, more)
            self.share = more
        self.step, self.before = self.base, None
        return how == REST or self._over(how, Failure(PathStatus.UNSTABLE))

    def _growing(self, state: State) -> Array:
        """(6,) the motion in which a small push grows, turns times the contacts' distance."""
        return growing(state, self.stepper.laws.laws.freedom, self.stepper.geometry.turned(state.where.pose))

    def _push(self, state: State, motion: Array) -> Array:
        """(6,) a small wrench along it."""
        size = _PUSH * float(abs(state.read.forces).sum())
        return np.asarray(size * motion * np.array([1.0] * 3 + [self.stepper.length] * 3))

    def _no_snap(self, size: float) -> float:
        """How far the object may go in such a step without a snap, as a share of the contacts' distances."""
        return MIN_SNAP_DISTANCE + SNAP_RATIO * self.speed * size

    def _snapped(
        self, state: State, end: State, share: float, until: float, rests: bool, pushed: tuple[float, ...]
    ) -> bool:  # fmt: skip
        """Note that the object has moved from one state to another under a load that stays, unless it has moved on as
        before, and only Newton's method had found no solution; whether it has.
        """
        run = self.run
        moved = self.stepper.between(state.where.pose, end.where.pose)
        distance, turn = float(np.linalg.norm(moved[:3])), float(np.linalg.norm(moved[3:]))
        if rests and distance / self.stepper.length + turn < self._no_snap(until - share):
            return False
        last = run.snaps[-1] if run.snaps else None
        if last is not None and last.stage == self.number and share - last.until <= _CHAIN * self.unit:
            distance, turn, share = distance + last.moved, turn + last.turned, last.share
            pushed = last.pushed or pushed
            run.snaps.pop()
        run.snaps.append(Snap(self.number, share, until, distance, turn, rests, pushed))
        return True

    def _may_jump(self, state: State) -> bool:
        """Whether the object is loaded, and has not jumped yet."""
        return state.loaded and self.loads and self.run.jump is None

    def _jumps(self, state: State) -> bool:
        """Note that a loaded object jumps here; whether that ends the path, as it does one to a load limit."""
        if self._may_jump(state):
            self.run.jump = Jump(self.number, self.share, len(self.run.states) - 1)
        return self.beyond is not None and self.run.jump is not None

    def crossing(
        self, state: State, found: State, share: float, size: float, over: Callable[[State], float]
    ) -> tuple[float, State]:
        """The step up to where a function of its end, negative at its beginning, is zero, by regula falsi; to just
        beyond it where no shorter step that is tried has a solution.
        """
        low, high, a, b, best, beyond = 0.0, 1.0, min(over(state), -_ON), over(found), found, found
        for _ in range(_HALVED):
            part = low + (high - low) * min(max(-a / (b - a), 0.02), 0.98) if b > a else 0.5 * (low + high)
            at = self._at(state, found, share, size, part)
            if isinstance(at, Failure):
                break
            value = over(at)
            if value > 0.0:
                high, b, beyond = part, value, at
            else:
                low, a, best = part, value, at
            if abs(value) < _ON or high - low < 1e-9:
                best, low = at, part
                break
        return (low * size, best) if low > 0.0 else (high * size, beyond)

    def _add(self, found: State, share: float, error: float = 0.0) -> bool:
        """Whether anything happens on the way to this state. error : of the step, estimated."""
        run = self.run
        events = self.watch.events(run.states[-1], found, self.goal.name, self.number, share)
        run.events += events
        slipped = run.slipped[-1] + slip_lengths(found) if self.loads else run.slipped[-1]
        run.add(found, self.number, share, slipped, error)
        return bool(events)

    def _pushed_out(self) -> bool:
        """Whether nothing is held at the end, and the object has been pushed away by fingers that close."""
        run, first = self.run, self.run.stages.index(self.number) if self.number else 0
        moved = self.stepper.between(run.states[first].where.pose, run.states[-1].where.pose)
        return float(abs(moved[:3]).max()) > self.watch.near


def _further(stepper: Stepper, before: State, now: State, share: float) -> Guess:
    """What goes on from `before` to `now` by this share of the way between them."""
    where = between(stepper.geometry, before.where, now.where, 1.0 + share)
    return Guess(where, _mixed(before.start, now.start, 1.0 + share), now.gives)


def _part(stepper: Stepper, state: State, found: State, part: float) -> Guess:
    """What is expected at this part of a step."""
    where = between(stepper.geometry, state.where, found.where, part)
    return Guess(where, _mixed(state.start, found.start, part), found.gives)


def _mixed(a: Array, b: Array, share: float) -> Array:
    return b if len(a) != len(b) else np.asarray(a + share * (b - a))
