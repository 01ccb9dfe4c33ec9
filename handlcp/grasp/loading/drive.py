"""A grasp driven through its stages: steps that are halved where something happens, or where they do not settle.

The geometry of a step is taken where the last two steps lead: a step of a smooth path is second order in its length
and takes one solve. A step in which a contact or a joint changes its state is halved until it is short, so that the
change is located and the path has no corner inside a step. A step that does not settle is halved, too. Where that
does not help, the last steps are made again from where each stands: continuing a path can swing in directions that are
stiff, and a swing is no loss. The grasp is lost where that does not help either.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from handlcp.grasp.loading.events import Event
from handlcp.grasp.loading.geometry import between
from handlcp.grasp.loading.stability import last_stable
from handlcp.grasp.loading.stage import Controls, Goal
from handlcp.grasp.loading.state import STILL, Failure, Guess, State
from handlcp.grasp.loading.step import Stepper

__all__ = ["Run", "drive"]

FINEST = 2.0**-5  # of a step: events are located to this share, and what does not settle then is lost
_BRIEF = 0.01  # of a stage
_BACK = 8  # steps that are made again, from where each stands, before an object is lost
_ALONG = 2.0  # a path is not continued further than this many times its last step


@dataclass(slots=True)
class Run:
    """states, stages (number of the stage) and shares of all steps, the state before anything included; events;
    failure : why the stage with the number lost_stage was not finished, None where all were; lost_at : share of it that
    was reached.
    """

    states: list[State]
    stages: list[int]
    shares: list[float]
    events: list[Event] = field(default_factory=list)
    failure: Failure | None = None
    lost_at: float | None = None
    lost_stage: int = 0

    def add(self, state: State, stage: int, share: float, events: list[Event]) -> None:
        """One more step."""
        self.states.append(state)
        self.stages.append(stage)
        self.shares.append(share)
        self.events += events

    def cut(self, last: int) -> None:
        """Forget the steps after this one."""
        stage, share = self.stages[last], self.shares[last]
        del self.states[last + 1 :], self.stages[last + 1 :], self.shares[last + 1 :]
        self.events = [e for e in self.events if (e.number, e.share) <= (stage, share)]

    def back(self, begun: int, share: float) -> float:
        """Forget the steps behind a share of the last stage, which begins at state `begun`; the share kept."""
        last = len(self.states) - 1
        while last > begun and self.shares[last] > share:
            last -= 1
        self.cut(last)
        return self.shares[last] if last > begun else 0.0

    def lost(self, failure: Failure, stage: int, share: float) -> bool:
        """That a stage is not finished: False."""
        while self.events and self.events[-1].kind == "snaps" and self.events[-1].share > share - _BRIEF:
            self.events.pop()  # it never came to rest
        self.failure, self.lost_stage, self.lost_at = failure, stage, share
        return False


def drive(stepper: Stepper, first: Controls, goals: list[Goal], steps: int, finest: float) -> Run:
    """Every stage in about so many steps, until the end or until the object is lost. finest : as `FINEST`."""
    state = stepper.beginning(first)
    run = Run([state], [0], [0.0])
    if stepper.grasp.sags:  # gaps open where fingers give way to their own weight
        settled = stepper.step(state, first, state.same)
        if isinstance(settled, Failure):
            run.lost(settled, 0, 0.0)
            return run
        run.states[0] = settled
    for k, goal in enumerate(goals):
        begun = len(run.states) - 1
        through = _through(stepper, run, k, goal, 1.0 / steps, finest / steps)
        _cut(stepper, run, begun)
        if not through or run.failure is not None:
            break
    return run


def _cut(stepper: Stepper, run: Run, begun: int) -> None:
    """End the run at the last state of the stage that begins at `begun` that a small push would not drive away."""
    if not (found := last_stable(stepper, run.states[begun:])):
        return
    number, share, motion = found
    at, stage = begun + number, run.stages[-1]
    before = run.shares[at] if number else 0.0
    run.lost(Failure("unstable", motion), stage, before + share * (run.shares[at + 1] - before))
    run.cut(at)


def _through(stepper: Stepper, run: Run, stage: int, goal: Goal, base: float, least: float) -> bool:
    """One stage; whether its end is reached."""
    state, share, before = run.states[-1], 0.0, None
    begin, begun = state.controls, len(run.states) - 1
    step, failure, again = base, None, -1.0  # again : up to where steps begin from where they stand
    while share < 1.0 - 1e-12:
        size = min(step, 1.0 - share)
        controls = begin.toward(goal.end, share + size)
        found = _stepped(stepper, state, before, controls, size)
        if isinstance(found, Failure):
            failure, step = found, size / 2
            if step < least:
                if share > again:
                    again, share = share + base, run.back(begun, share - _BACK * base)
                    state, before, step = run.states[-1], None, base
                    continue
                last = _last_try(stepper, state, controls)
                if isinstance(last, Failure):
                    return run.lost(failure, stage, share)
                if failure.kind == "runs away":
                    run.events.append(Event("snaps", "the object", goal.name, share + size, stage))
                found, step = last, least
            else:
                continue
        happens = stepper.watch.changed(state, found)
        if happens and size > 1.5 * least:
            step = size / 2
            continue
        share += size
        events = stepper.watch.events(state, found, goal.name, stage, share) if happens else []
        run.add(found, stage, share, events)
        if state.loaded and not found.loaded:
            return run.lost(Failure("loose"), stage, share)
        before, state = (None if happens or share <= again else (state, size)), found
        step = min(2 * size, base) if not happens else base
    if not state.loaded and (first := _pushed_out(stepper, run, stage)) is not None:
        run.cut(first)
        return run.lost(Failure("pushed out"), stage, run.shares[-1])
    return True


def _pushed_out(stepper: Stepper, run: Run, stage: int) -> int | None:
    """The number of the first state of a stage, at whose end nothing is held, in which the object has been pushed away
    by fingers that close; None where it stays where it was.
    """
    first = run.stages.index(stage) if stage else 0
    begun = stepper.geometry.displacement(run.states[first].where.pose)
    for k in range(first + 1, len(run.states)):
        state = run.states[k]
        moved = stepper.geometry.displacement(state.where.pose) - begun
        if not state.loaded and float(abs(moved[:3]).max()) > stepper.watch.near:
            return k
    return None


def _stepped(
    stepper: Stepper, state: State, before: tuple[State, float] | None, controls: Controls, size: float
) -> State | Failure:
    """One step, from where the path leads."""
    guess = state.same
    if before is not None:
        earlier, length = before
        guess = _further(stepper, earlier, state, min(size / length, _ALONG))
    return stepper.step(state, controls, guess)


def _last_try(stepper: Stepper, state: State, controls: Controls) -> State | Failure:
    """From where it stands; then with all stages of the solver that look for an answer."""
    found = stepper.step(state, controls, state.same)
    return found if isinstance(found, State) else stepper.step(state, controls, state.same, patient=True)


def _further(stepper: Stepper, before: State, now: State, share: float) -> Guess:
    """What goes on from `before` to `now` by this share of the way between them."""
    where = between(stepper.geometry, before.where, now.where, 1.0 + share)
    if len(before.start) != len(now.start):
        return Guess(where, now.start, STILL)
    return Guess(where, now.start + share * (now.start - before.start), STILL)
