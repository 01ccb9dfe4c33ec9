"""A grasp driven through its program, stage by stage: what `continue_stage` is told of it, and what it says."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, check_number
from handlcp.contact.friction import limit_set
from handlcp.grasp.failure.failure_mode import StateLimits
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.continuation import ASKS, BREATHES, FULL, OVER, PAUSED, continue_stage, part_of_step
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.path_model import FrictionArrays, LimitArrays, PathModel, PathReader, limit_shares, margins
from handlcp.grasp.path.solve_step import SETTLED, StepOptions
from handlcp.grasp.path.state import Controls, Failure, Goal, Guess, Jump, Run, Slides, Snap, State
from handlcp.grasp.path.step import Stepper, StepState, controls_of, controls_row
from handlcp.grasp.path.trace import StageArrays, Trace, new_trace, with_more_room
from handlcp.grasp.path.watch import Watch
from handlcp.progress import report_progress
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

ACCURACY = 1e-3  # of the largest force: the error of a step, unless something else is asked
_BREATH = 256  # tries of compiled code between two looks at it
# `exact` and `close` of `StageArrays`; where the posture stays forces are exact, and so is a limit of the load there
_EXACT, _EXACT_STILL, _EXACT_LIMIT = 2.0**-18, 2.0**-21, 2.0**-33
_CLOSE, _CLOSE_STILL = 1e-3, 1e-10
_STAGE_UNIT = 2.0**-3  # of a stage that has an end: in this unit the shortest steps are counted
_NO_LIMITS = LimitArrays(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), np.full(2, np.inf))


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


class PathLimits(NamedTuple):
    """Limits that end a path. limits : of torques, tensions, ranges and motion. at (6,) : the object's motion before
    the load grows. What is at its limit already then, in the state `start`, ends the path only where it goes beyond.
    """

    limits: StateLimits
    at: Array
    start: State


class Open(NamedTuple):
    """A last stage that goes on beyond its end until something ends it. first : its first step, as a share. most : the
    share at which it is given up: nothing will end it. until : the limits that end it, or of a state how far it is
    beyond another one that was set, as a share of that.
    """

    first: float
    most: float
    until: PathLimits | Callable[[State], float]


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
        if not Leg(stepper, watch, run, k, goal, 1.0 / steps, None, accuracy, patience).through():
            break
    return run


class Leg:
    """One stage of a run, from its last state on. base : its longest step, as a share. beyond : for a stage without an
    end. accuracy, patience : as in `advance`.
    """

    def __init__(
        self, stepper: Stepper, watch: Watch, run: Run, number: int, goal: Goal, base: float,
        beyond: Open | None = None, accuracy: float = ACCURACY, patience: Patience = PATIENT,
    ) -> None:  # fmt: skip
        self.stepper, self.run, self.number, self.goal, self.watch = stepper, run, number, goal, watch
        self.begin, self.first = run.states[-1].controls, len(run.states) - 1
        self._own = _OwnSteps(stepper, goal.name, beyond)
        self.model = path_model(stepper, watch, self._own.functions)
        begin, end = controls_row(self.begin), controls_row(goal.end)
        loads = bool((begin[:6] != end[:6]).any()) or bool(begin[6] != end[6])
        limits, stands, at = _NO_LIMITS, np.zeros(2, dtype=bool), np.zeros(6)
        state = self._own.row_of(run.states[-1])
        if beyond is not None and isinstance(beyond.until, PathLimits):
            limits, at = limit_arrays(beyond.until.limits), np.array(beyond.until.at)
            stands = self._shares(limits, at, beyond.until.start) > 1.0 - OVER_LIMIT_TOLERANCE
        origin = np.zeros(0) if number else self._own.row_of(run.states[0])
        base = base if beyond is None else beyond.first
        tries = patience.tries * max(1.0, (ACCURACY / accuracy) ** 0.5)
        breath = 1 if stepper.compiled is None or stepper.may_cross else _BREATH
        near = _EXACT, _CLOSE
        if not stepper.geometry.follows:
            near = _EXACT_STILL if beyond is None else _EXACT_LIMIT, _CLOSE_STILL
        self.stage = StageArrays(
            begin, end, base, _STAGE_UNIT if beyond is None else beyond.first, 1.0 if beyond is None else beyond.most,
            beyond is not None, limits, stands, at, loads, accuracy, tries, patience.snaps, *near, breath, origin,
        )  # fmt: skip
        slides, jump = [-1 if one is None else -2 for one in (run.slides, run.jump)]
        self.trace = new_trace(state, len(begin), run.slipped[-1], base, slides, jump)
        self._known, self._events, self._snaps = 1, 0, 0  # of the trace, what the run has
        run.under_way = number

    @property
    def shortest(self) -> float:
        """The shortest step, as a share: what is no farther is nowhere."""
        return self.stage.unit * max(2.0 * self.stage.exact, 1e-8)

    def _shares(self, limits: LimitArrays, at: Array, state: State) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(limit_shares(self.model.read, limits, at, self._own.row_of(state)))

    def through(self, pause: bool = False) -> bool:
        """Whether the end of the stage is reached. pause : stop where a contact has slid as far as it may, too; called
        again it goes on from there.
        """
        while True:
            leg = self.trace.leg[0]
            self._own.report(leg.share)
            known, events, snaps = int(leg.number), int(leg.events), int(leg.snaps)
            with np.errstate(all="ignore"):  # as compiled code
                how = continue_stage(self.model, self.stage, self.trace, pause)
            if self._own.crosses(self.trace, known):
                leg.number, leg.events, leg.snaps, leg.status = known, events, snaps, int(PathStatus.CROSSES)
                how = OVER
            if how == FULL:
                self.trace = with_more_room(self.trace)
            elif how == ASKS:
                self._answer()
            elif how != BREATHES:
                break
        self._write_run()
        if how == PAUSED:
            return True
        status = PathStatus(int(self.trace.leg[0].status))
        return status == PathStatus.REACHED or self.run.ends(status, self._own.crossed)

    def _answer(self) -> None:
        """Search the state that is asked for by all methods."""
        t, size = self.trace, self.trace.rows.shape[1]
        state, controls = self._own.state_of(t.question[:size].copy()), controls_of(t.question[size:].copy())
        found = self.stepper.sought(state, controls)
        k = int(t.leg[0].answered)
        t.answers[k, 0] = -1.0 if found is None else float(found.status) if isinstance(found, Failure) else SETTLED
        if isinstance(found, State):
            t.answers[k, 1:] = self._own.row_of(found)
        t.leg[0].answered = k + 1

    def _write_run(self) -> None:
        """Take what the trace has more into the run."""
        run, t, leg = self.run, self.trace, self.trace.leg[0]
        for k in range(self._known, int(leg.number)):
            state = self._own.state_of(t.rows[k].copy())
            run.add(state, self.number, float(t.shares[k]), t.slipped[k].copy(), float(t.errors[k]))
        named = self.watch.names
        for number, code, who in t.events[self._events : leg.events].astype(int).tolist():
            kind, name = named(code, who)
            run.events.append(Event(kind, name, self.goal.name, float(t.shares[number]), self.number))
        if self._snaps:  # the last one may have grown
            run.snaps.pop()
        s = t.snaps
        for k in range(max(self._snaps - 1, 0), int(leg.snaps)):
            pushed = tuple(s.pushed[k].tolist()) if s.pushed[k].any() else ()
            share, until, moved, turned = [float(a[k]) for a in (s.share, s.until, s.moved, s.turned)]
            run.snaps.append(Snap(self.number, share, until, moved, turned, bool(s.rests[k]), pushed))
        if leg.slides_number >= 0 and run.slides is None:
            run.slides = Slides(self.number, float(leg.slides_share), self.first + int(leg.slides_number))
        if leg.jump_number >= 0 and run.jump is None:
            run.jump = Jump(self.number, float(leg.jump_share), self.first + int(leg.jump_number))
        self._known, self._events, self._snaps = int(leg.number), int(leg.events), int(leg.snaps)

    def margins(self, state: State) -> Array:
        """(n, 2) how far each contact is from sliding and from opening [N]."""
        return np.asarray(margins(self.model.read, self._own.row_of(state)))

    def seen(self, number: int, share: float) -> State:
        """The state at a share of this stage that lies between a state of the run and the next one."""
        run, t, k = self.run, self.trace, number - self.first
        state, begin = run.states[number], run.shares[number] if k else 0.0
        if share <= begin or number + 1 >= len(run.states):
            return state
        size, row = run.shares[number + 1] - begin, np.empty(t.rows.shape[1])
        with np.errstate(all="ignore"):
            status = part_of_step(self.model, self.stage, t, k, (share - begin) / size, row)
        return self._own.state_of(row) if status == SETTLED else state


class _OwnSteps:
    """What the path of a grasp leaves to Python, and the states that Python knows by number. beyond : of its stage."""

    def __init__(self, stepper: Stepper, name: str, beyond: Open | None) -> None:
        self._stepper, self._name, self._open = stepper, name, beyond is not None
        self._states, self.crossed, self._told = list[State](), "", ""
        own: dict[str, Callable[..., Any]] = {}
        if stepper.compiled is None:
            own = {"take_step": self._take_step, "move_unloaded": self._move_unloaded}
        if beyond is not None and not isinstance(until := beyond.until, PathLimits):
            own["excess"] = lambda g, row: until(self.state_of(row))
        self.functions = SimpleNamespace(**own) if own else None

    def row_of(self, state: State) -> Array:
        """The row of a state, with the number that it is known by."""
        if self._stepper.compiled is not None:
            return self._stepper.row_of(state)
        self._states.append(state)
        row = self._stepper.row_of(state).copy()
        self._stepper.layout.read(row, "tally")[3] = len(self._states)
        return row

    def state_of(self, row: Array) -> State:
        """The state of a row."""
        layout = self._stepper.layout
        if self._stepper.compiled is not None:
            return StepState(row, controls_of(layout.read(row, "controls")), self._stepper)
        state = self._states[int(layout.read(row, "tally")[3]) - 1]
        kinds = layout.read(row, "kinds").astype(int).tolist()
        return state if kinds == list(state.kinds) else state.with_kinds(tuple(map(type(state.kinds[0]), kinds)))

    def report(self, share: float) -> None:
        """Say how far the stage is."""
        at = f"{share:.3g} times the load" if self._open else words.format_percent(share)
        self._told = f"stage {self._name!r} at {at}"
        report_progress(self._told)

    def _take_step(
        self, before: Array, controls: Array, guess: Array, start: Array, asked: StepOptions, row: Array
    ) -> int:
        report_progress(self._told)
        state, where = self.state_of(before), self._stepper.geometry.where_of(guess.copy())
        made = Guess(where, start.copy(), state.gives)
        return self._written(self._stepper.step_in_python(state, controls_of(controls.copy()), made, asked), row)

    def _move_unloaded(self, before: Array, controls: Array, row: Array) -> int:
        return self._written(self._stepper.untouched(self.state_of(before), controls_of(controls.copy())), row)

    def _written(self, found: State | Failure, row: Array) -> int:
        if isinstance(found, Failure):
            return int(found.status)
        row[:] = self.row_of(found)
        return SETTLED

    def crosses(self, trace: Trace, known: int) -> bool:
        """Whether a tendon crosses a body on the way to the states of a trace beyond so many, or close by, where they
        end.
        """
        leg = trace.leg[0]
        ends = leg.status >= PathStatus.RUNS_AWAY
        self.crossed = self._stepper.crosses(trace.rows[max(known - 2, 0) : leg.number], bool(ends))
        return bool(self.crossed)


def path_model(stepper: Stepper, watch: Watch, own: Any) -> PathModel:
    """What a path reads of a grasp. own : as in `PathModel`."""
    laws, geometry = stepper.laws, stepper.geometry
    faces = stepper.section.faces
    flat = np.ascontiguousarray(limit_set(stepper.section, 2).normals.T) if faces else np.zeros((0, 2))
    friction = FrictionArrays(
        stepper.friction, stepper.lever, laws.laws.soft, laws.laws.scale, faces, flat, laws.pattern.normals
    )  # fmt: skip
    read = PathReader(
        geometry.poses, stepper.layout.starts, stepper.sizes, stepper.damper, friction, laws.laws.freedom,
        limit_arrays(watch.limits), watch.near, watch.max_slip, stepper.springs, geometry.noise,
    )  # fmt: skip
    return PathModel(own, stepper.compiled, read)


def limit_arrays(limits: StateLimits) -> LimitArrays:
    """Limits as compiled code reads them."""
    named = len(limits.joints)  # joints that a flexibility alone knows have no names, and no limits
    return LimitArrays(
        np.array(limits.inverse_efforts), np.array(limits.lower[:named]), np.array(limits.upper[:named]),
        np.array(limits.inverse_spans[:named]), np.array(limits.motion),
    )  # fmt: skip
