"""A grasp driven through its program: quasi-static steps where there are any, a viscous flow where there are none.

A step is predicted from the last two. Where a contact changes its state inside a step, the step ends there: the change
is located on the contact's margin, by regula falsi. A step without an end is halved; where the shortest has none, or
where a small push grows, the object moves on at constant load against a vanishing viscosity (`flow`): it comes to rest
elsewhere, which is one event, or it leaves, and the path ends at the last load with a static state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.model.status import ContactStatus, PathStatus
from handlcp.grasp.path.geometry import between
from handlcp.grasp.path.stability import GROWS, MOVES, REST, STUCK, flow, growing, growth, measured
from handlcp.grasp.path.state import SLIDES, STICKS, Controls, Failure, Goal, Guess, Run, Slides, Snap, State
from handlcp.grasp.path.step import Stepper
from handlcp.grasp.path.watch import Rate, Watch, first_change, reached
from handlcp.progress import report_progress
from handlcp.tolerances import MIN_SNAP_DISTANCE, SLIDE_THROUGH_DISTANCE, SNAP_RATIO

FINEST = 2.0**-9  # of a step: where one as short as this has no solution, there is none
_EXACT = 2.0**-16  # of a step: how closely a snap or the last static state is located once there is known to be one
_ALONG = 2.0  # a path is not continued further than this many times its last step
_TELLS = FINEST  # of a step: shorter ones tell nothing of how fast the object gives way
_ANEW = 2.0**-3  # times the usual step: the first after a change, which is of first order
_BEHIND = 0.98  # of a step up to a change: short of it
_ALONE = 2.0**-4  # of a step: a shorter one without a solution is also tried without a prediction
_GROWS = (0.35, 0.05)  # of the load: steps of an open stage where nothing slides, and where something does
_HALVED = 14  # times a step, where a push begins to grow and where a limit is reached
_ON = 1e-9  # of a limit: this near to it is at it
_PUSH = 1e-3  # of the forces
_SAME = 1e-3  # of the contacts' distances: the same place
_BENDS = 0.5  # of a step: how far from where it was expected it may end
_AFTER = 4.0  # times the step on which it snapped: the next, where another may follow at once
_CHAIN = 1.01  # steps between snaps that are one


class Patience(NamedTuple):
    """When a path is given up. tries : of steps of a stage; paths of use take 10 to 150, hard ones a thousand. snaps :
    whether it goes on after the object has snapped elsewhere.
    """

    tries: int = 2500
    snaps: bool = True


PATIENT = Patience()


class Open(NamedTuple):
    """A last stage that goes on beyond its end until something ends it. first : its first step, as a share. most : the
    share at which it is given up: nothing will end it. over : of a state, how far it is beyond a limit that was set, as
    a share of that limit. coarse : how many times as long as usual later steps are.
    """

    first: float
    most: float
    over: Callable[[State], float]
    coarse: float = 1.0


def advance(
    stepper: Stepper, watch: Watch, first: Controls, goals: list[Goal], steps: int, patience: Patience = PATIENT
) -> Run:  # fmt: skip
    """Follow every stage in about so many steps, until the end or until the object is lost. first : the controls before
    anything is done.
    """
    state = stepper.beginning(first)
    run = Run([state], [0], [0.0])
    if stepper.grasp.sags:  # gaps open where fingers give way to their own weight
        settled = stepper.step(state, first)
        if isinstance(settled, Failure):
            run.ends(*settled)
            return run
        run.states[0] = settled
    for k, goal in enumerate(goals):
        leg = Leg(stepper, watch, run, k, goal, 1.0 / steps)
        leg.patience = patience
        if not leg.through():
            break
    return run


class Leg:
    """One stage of a run, from its last state on. base : its step, as a share. beyond : for a stage without an end."""

    def __init__(
        self, stepper: Stepper, watch: Watch, run: Run, number: int, goal: Goal, base: float, beyond: Open | None = None
    ) -> None:
        self.stepper, self.watch, self.run, self.number, self.goal, self.base = stepper, watch, run, number, goal, base
        self.beyond, self.last, self.patience = beyond, 1.0 if beyond is None else beyond.most, PATIENT
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
        self.rate = Rate(_TELLS * self.base, bool(load.any()) or weight)

    def through(self, pause: bool = False) -> bool:
        """Whether the end of the stage is reached. pause : stop where the object begins to slide through, too; called
        again it goes on from there.
        """
        run = self.run
        while self.share < self.last * (1.0 - 1e-12):
            self.count += 1
            if self.count > self.patience.tries:
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
        if found.kinds != self.calm and growth(found) > GROWS:
            unstable = found
            size, found, breaks = self._stable(state, found, share, size)
            if breaks:
                return self._breaks(found, share + size, found if measured(found) else unstable)
        if self.beyond is not None and self.beyond.over(found) > 0.0:
            size, found = self._limit(state, found, share, size)
            self._add(found, share + size)
            return run.ends(PathStatus.LIMIT)
        self._slides(state, found, share, size)
        self.share = share = share + size
        happens = self._add(found, share)
        if state.loaded and not found.loaded and not found.controls.kept:
            return run.ends(PathStatus.LOOSE)
        self.before = None if happens else (state, size)
        self.step = self._following(share, found, np.inf if happens else size * (1.0 if self.failed else 2.0), size)
        self.failed = False
        return True

    def _following(self, share: float, found: State, most: float, size: float) -> float:
        """The step after one of this size. Of an open stage it grows with the load, the faster where nothing slides."""
        if share >= self.ends:
            self.ends = np.inf
        if self.ends < np.inf:
            return max(0.5 * size, _EXACT * self.base)
        grows = 0.0 if self.beyond is None else self.beyond.coarse * _GROWS[found.slides]
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
        if size > (_EXACT if known else FINEST) * self.base:
            self.step = size / 2.0
            return True
        if known and self.then != STUCK and self._gives_way(state):
            return True  # `through` may pause where the object slides through
        if known and self.then != MOVES:
            return self._over(self.then, why)
        until, near = self.ends if known else share + size, np.inf
        if not known and self._may_slide(state):  # where it comes to rest is asked once the snap is located exactly
            near = max(self._no_snap(size), SLIDE_THROUGH_DISTANCE - self.rate.beyond)
        end, how = flow(self.stepper, state, self.controls(until), None, near)
        snapped = how not in (MOVES, STUCK) and self._snapped(state, end, share, until, how == REST, ())
        if how != REST:
            self.ends, self.then, self.step = until, how, size / 2.0
            return not known or self._over(how, why)
        self.share, self.ends = until, np.inf
        self._add(end, until)
        self.step, self.before = min(_AFTER * FINEST * self.base, self.base), None
        far = self.stepper.far(state.where.pose, end.where.pose)
        if snapped:
            self.rate.snaps(far)
        else:
            self.rate.last = far / (until - share)
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
        last, far = self.rate.last, self.stepper.far(state.where.pose, found.where.pose)
        if last > 0.0 and far > self._no_snap(size):
            return True
        if far <= MIN_SNAP_DISTANCE:
            return False
        if self.before is not None:
            expected = _further(self.stepper, self.before[0], state, min(size / self.before[1], _ALONG))
        elif size <= 2.0 * FINEST * self.base:
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
        found = self._second(state, controls, guess, size) or self.stepper.step(state, controls, guess)
        if isinstance(found, Failure) and guess is not None and size < _ALONE * self.base:
            found = self.stepper.step(state, controls)
        if isinstance(found, Failure) and not state.loaded:
            found = self.stepper.untouched(state, controls)
            if isinstance(found, Failure):
                found = self.stepper.pushed(state, controls, guess)
        if isinstance(found, Failure) and self._last_resort(size):
            found = self.stepper.sought(state, controls) or found
        return found

    def _last_resort(self, size: float) -> bool:
        """Whether all solvers are asked for a step that Newton's method does not solve: where contacts stay where they
        are it is one solve however long the step is, elsewhere only once no shorter step has a solution.
        """
        return self.ends == np.inf and (size <= FINEST * self.base or not self.stepper.geometry.follows)

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

    def _at(self, state: State, found: State, share: float, size: float, part: float) -> State | Failure:
        """The state at a part of a step that is known to have a solution."""
        controls, guess = self.controls(share + part * size), _part(self.stepper, state, found, part)
        return self._second(state, controls, guess, part * size) or self.stepper.step(state, controls, guess)

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
        if share > self.share:
            self._add(state, share)
            self.share = share
        more = min(share + 2.0**-_HALVED * self.base, self.last)
        motion, near = self._growing(grows), np.inf
        if self._may_slide(state):
            near = max(self._no_snap(more - share), SLIDE_THROUGH_DISTANCE - self.rate.beyond)
        end, how = flow(self.stepper, state, self.controls(more), self._push(state, motion), near)
        if how != REST and self._gives_way(state):
            return True  # `through` may pause here; where it goes on, the object is followed on to wherever it comes
        if how != STUCK:
            self._snapped(state, end, share, more, how == REST, tuple(motion.tolist()))
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
        return MIN_SNAP_DISTANCE + SNAP_RATIO * self.rate.last * size

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
        if last is not None and last.stage == self.number and share - last.until <= _CHAIN * self.base:
            distance, turn, share = distance + last.moved, turn + last.turned, last.share
            pushed = last.pushed or pushed
            run.snaps.pop()
        run.snaps.append(Snap(self.number, share, until, distance, turn, rests, pushed))
        return True

    def _may_slide(self, state: State) -> bool:
        """Whether the object may begin to slide through, and has not yet."""
        return state.loaded and self.rate.loads and self.run.slides is None

    def _gives_way(self, state: State) -> bool:
        """Note that the object begins to slide through here, at the last state before a snap; whether it does."""
        may = self._may_slide(state)
        if may:
            self.run.slides = Slides(self.number, self.share, len(self.run.states) - 1)
        return may

    def _limit(self, state: State, found: State, share: float, size: float) -> tuple[float, State]:
        """The step up to a limit that was set, by regula falsi."""
        assert self.beyond is not None
        low, high, a, b, best = 0.0, 1.0, self.beyond.over(state), self.beyond.over(found), found
        for _ in range(_HALVED):
            part = low + (high - low) * min(max(-a / (b - a), 0.02), 0.98) if b > a else 0.5 * (low + high)
            at = self._at(state, found, share, size, part)
            if isinstance(at, Failure):
                break
            value = self.beyond.over(at)
            if value > 0.0:
                high, b = part, value
            else:
                low, a, best = part, value, at
            if abs(value) < _ON or high - low < 1e-9:
                best, low = at, part
                break
        return low * size, best

    def _slides(self, state: State, found: State, share: float, size: float) -> None:
        """Note how fast the object gives way in a step that begins at a share, and whether it begins to slide through
        in it.
        """
        rate, far = self.rate, self.stepper.far(state.where.pose, found.where.pose)
        at_rest = rate.last == 0.0  # where an object that snapped rests, everything sticks
        stuck, sticks = STICKS in state.kinds and not at_rest, STICKS in found.kinds
        rate.last = now = far / size
        if not rate.loads or not found.loaded or not state.loaded:
            return
        if (sticks and stuck) or rate.stuck == 0.0:
            rate.sticks(now, size)
        elif not sticks and self.run.slides is None and not (stuck and self._stays(state, found, share, size)):
            part = rate.runs(now, size)
            if part is not None:
                self.run.slides = Slides(self.number, share + part * size, len(self.run.states) - 1)

    def _stays(self, state: State, found: State, share: float, size: float) -> bool:
        """Whether something sticks during most of a step at whose end nothing does. Then the rate at which the object
        gives way there is noted.
        """
        middle, last = [self._at(state, found, share, size, part) for part in (0.5, _BEHIND)]
        if isinstance(last, Failure) or STICKS not in last.kinds:
            return False
        if isinstance(middle, State):
            far = self.stepper.far
            first = far(state.where.pose, middle.where.pose) / (0.5 * size)
            second = far(middle.where.pose, last.where.pose) / ((_BEHIND - 0.5) * size)
            self.rate.sticks(reached(first, second, 0.25, 0.5 * (0.5 + _BEHIND)), size)
        return True

    def _add(self, found: State, share: float) -> bool:
        """Whether anything happens on the way to this state."""
        run = self.run
        events = self.watch.events(run.states[-1], found, self.goal.name, self.number, share)
        run.events += events
        run.add(found, self.number, share)
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
