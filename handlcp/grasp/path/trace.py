"""`Trace`: what one stage of a path writes down, and what it is told; arrays that compiled code and Python share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.path_model import LimitArrays

_ROOM = 64  # states, to begin with
_EVENTS, _SNAPS, _ANSWERS = 256, 16, 8

# Where a stage stands. share : of it, reached. step : the next one that is tried. ends : the share before which there
# is a snap or the last static state, once that is known, and `then` what a flow from there comes to. speed : of the
# object in the last step; 0 at the beginning and after a jump. before : the step from the state before the last to the
# last; 0 where that says nothing. failed : whether the last try had no solution; 2 since a try towards `ends` had none.
# count : tries. number, events, snaps : how many are written. slides_share, slides_number, jump_share, jump_number :
# where a contact has slid as far as it may, and where the loaded object jumps, by share and state; number -1: nowhere,
# -2: in an earlier stage. status : a `PathStatus`. asked, answered : searches of this try that were asked for, and that
# Python has answered. passed : ends that were passed by other ways of slipping.
LEG = np.dtype([
    *[(name, np.float64) for name in ("share", "step", "ends", "speed", "before", "slides_share", "jump_share")],
    *[(name, np.int64) for name in (
        "then", "failed", "count", "number", "events", "snaps", "slides_number", "jump_number", "status", "asked",
        "answered", "passed",
    )],
], align=True)  # fmt: skip


class Snaps(NamedTuple):
    """Of each snap, as in `Snap`. share, until, moved, turned, rests (k,); pushed (k, 6) : zeros where no state in
    balance is left.
    """

    share: Array
    until: Array
    moved: Array
    turned: Array
    rests: Array
    pushed: Array


class Trace(NamedTuple):
    """leg (1,) : of LEG. rows (k, ·) : states, the one before the stage first; shares (k,), slipped (k, n), errors (k,)
    of each, as in `Run`. events (k, 3) : number of the state, code and who, as `write_events` has them. calm (n,) :
    contact states for which a small push that seemed to grow died away. answers (k, 1 + ·), question : of
    `seek_state`: (status, row), and (row, controls).
    """

    leg: Array
    rows: Array
    shares: Array
    slipped: Array
    errors: Array
    events: Array
    snaps: Snaps
    calm: Array
    answers: Array
    question: Array


class StageArrays(NamedTuple):
    """What a stage is told. begin, end (9 + nv,) : controls. base : its longest step, as a share; unit : by which the
    shortest are counted; last : the share at which it ends or is given up. is_open : whether it goes on until something
    ends it: `limits`, where what stands_at its limit at the start counts only beyond it, and the object's motion from
    at (6,) on. loads : whether a load changes. accuracy : of a step. tries : after which it is given up.
    goes_on_snapped : whether it goes on after a snap. exact : of a unit, how closely a jump or the last static state is
    located once there is known to be one; close : of a step, how closely a contact's change is. breath : after so many
    tries Python looks at it. origin : the state from which an object that nothing holds is pushed out; empty: the first
    state of the stage.
    """

    begin: Array
    end: Array
    base: float
    unit: float
    last: float
    is_open: bool
    limits: LimitArrays
    stands_at: Array
    at: Array
    loads: bool
    accuracy: float
    tries: float
    goes_on_snapped: bool
    exact: float
    close: float
    breath: int
    origin: Array


def new_trace(state: Array, controls: int, slipped: Array, step: float, slides: int, jump: int) -> Trace:
    """A trace of a stage that begins with this state's row. controls : numbers of a row of them. step : the first.
    slides, jump : -2 where there was one in an earlier stage, else -1.
    """
    leg, n = np.zeros(1, LEG).view(np.recarray), len(slipped)
    leg["step"], leg["ends"], leg["number"] = step, np.inf, 1
    leg["slides_number"], leg["jump_number"] = slides, jump
    trace = Trace(
        leg, np.zeros((_ROOM, len(state))), np.zeros(_ROOM), np.zeros((_ROOM, n)), np.zeros(_ROOM),
        np.zeros((_EVENTS, 3)), _new_snaps(_SNAPS), np.full(n, -1.0), np.zeros((_ANSWERS, 1 + len(state))),
        np.zeros(len(state) + controls),
    )  # fmt: skip
    trace.rows[0], trace.slipped[0] = state, slipped
    return trace


def _new_snaps(k: int) -> Snaps:
    return Snaps(np.zeros(k), np.zeros(k), np.zeros(k), np.zeros(k), np.zeros(k), np.zeros((k, 6)))


def with_more_room(t: Trace) -> Trace:
    """The same with room for twice as much."""

    def twice(a: Array) -> Array:
        return np.concatenate([a, np.zeros_like(a)])

    return t._replace(
        rows=twice(t.rows), shares=twice(t.shares), slipped=twice(t.slipped), errors=twice(t.errors),
        events=twice(t.events), snaps=Snaps(*map(twice, t.snaps)), answers=twice(t.answers),
    )  # fmt: skip
