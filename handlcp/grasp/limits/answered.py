"""What a path whose load has grown says of the load limit: how much is held, what gives out, and what happens after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.effects.joint_offset import describe_missing_squeeze
from handlcp.grasp.failure.failure_mode import (
    EQUILIBRIUM,
    OBJECT,
    SLIDES,
    SLIPS,
    UNDECIDED,
    FailureMode,
    StateLimits,
    find_binding,
    find_exceeded,
    find_slipping,
)
from handlcp.grasp.failure.failure_text import (
    describe_direction,
    describe_failures,
    describe_pad_depth,
    explain_giving_up,
    explain_limit,
)
from handlcp.grasp.limits.further import largest_held
from handlcp.grasp.limits.result import Later, LimitEvent, LimitPath, LoadLimit, Reached, Rest
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.advance import Leg
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.follow import Loading, solution_of
from handlcp.grasp.path.state import LET_GO, Jump, Run, State
from handlcp.grasp.path.step import Stepper
from handlcp.grasp.path.watch import is_at_max_slip
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

_AT = 1e-6  # relative: limits that are this near to being reached bind, too
_INSTANT = 1e-7  # of the load at which the object is lost: what happens so shortly before happens there
_NEAR = 1e-3  # of the load: contacts that begin to slide this near to where the object is lost are the cause
_UNKNOWN: tuple[FailureMode, ...] = (FailureMode(UNDECIDED, OBJECT),)  # what gives out beyond what is known of a path
_NAMED = ("slips", "sticks", "opens", "touches", "yields", "holds")
_LOOKED, _HALVED = 16, 10  # states of a path, and times a step, where a link comes into the object


class Followed(NamedTuple):
    """A path whose load has grown: run, from `at` (6,), the object's motion before it. slid : the share of the weight
    at which the object leaves its place already, and what gives out there; None: it does not. max_slip (n,) [m].
    """

    spec: GraspSpec
    section: Section
    wrench: Array
    run: Run
    leg: Leg
    stepper: Stepper
    limits: StateLimits
    at: Array
    geometry: str
    slid: tuple[float, tuple[FailureMode, ...]] | None
    max_slip: Array

    @property
    def jump(self) -> Jump | None:
        """Where the object jumps; in one posture nobody asks where it goes once nothing balances more load."""
        return None if self.geometry == "fixed" else self.run.jump

    @property
    def events(self) -> list[Event]:
        """What happens on the way; in one posture no contact's last instant, which only rounding puts in order."""
        rounding = self.geometry == "fixed" and self.run.status.is_lost
        return [e for e in self.run.events if not rounding or e.share <= (1.0 - _INSTANT) * self.run.shares[-1]]

    @property
    def first_slip(self) -> float | None:
        """The factor at which a contact begins to slide; None: none does."""
        return next((e.share for e in self.events if e.kind == "slips"), None)

    @property
    def number(self) -> int:
        """Of the last state."""
        return len(self.run.states) - 1

    def mark(self, factor: float) -> Reached:
        """How far the object has moved at a factor, between two states."""
        shares = np.array(self.run.shares)
        moved = np.array([self.stepper.geometry.displacement(s.where.pose) - self.at for s in self.run.states])
        there = np.array([np.interp(factor, shares, column) for column in moved.T])
        return Reached(factor, float(np.linalg.norm(there[:3])), float(np.linalg.norm(there[3:])))


# ----------------------------------------------------------------
# Contacts are where links were near when the hand had closed. A link that comes into the object later would press on
# it, and the path knows nothing of that: from there on it says nothing. Where fingertips alone may touch `check` looks
# at the end.


class _Ends(NamedTuple):
    """Where what is known of a path ends: factor, number of the last state before, and why."""

    factor: float
    number: int
    why: str


def _known(f: Followed) -> _Ends | None:
    """Where a link that was outside before the load grew comes into the object; None: nowhere that is looked at."""
    mechanism = f.spec.mechanism
    if f.geometry != "followed" or mechanism is None or not mechanism.report.links:
        return None

    def inside(state: State) -> tuple[set[str], str]:
        found: tuple[set[str], str] = mechanism.report.find_links_inside(state.where.q, state.where.pose)
        return found

    at_first, _ = inside(f.run.states[0])

    def comes(state: State) -> bool:
        return not inside(state)[0] <= at_first

    snapped = [int(np.searchsorted(f.run.shares, snap.until)) for snap in f.run.snaps]
    evenly = np.linspace(0, f.number, min(f.number, _LOOKED) + 1).astype(int)
    looked = np.unique(np.minimum([*evenly, *snapped], f.number)).tolist()
    high = next((k for k in looked if comes(f.run.states[k])), 0)
    if not high:
        return None
    low = looked[looked.index(high) - 1]
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if comes(f.run.states[middle]) else (middle, high)
    begin, end = f.run.shares[low], f.run.shares[high]
    for _ in range(_HALVED):
        factor = 0.5 * (begin + end)
        begin, end = (begin, factor) if comes(f.leg.seen(low, factor)) else (factor, end)
    return _Ends(begin, low, inside(f.run.states[high])[1])


# ----------------------------------------------------------------
# The limit.


def answer(f: Followed) -> LoadLimit:
    """The load limit."""
    run, end = f.run, f.run.shares[-1]
    first = f.first_slip
    slides = None if run.slides is None else run.slides.share
    factor, number = np.inf if run.status == PathStatus.UNBOUNDED else end, f.number
    if run.status.is_lost and end <= f.leg.shortest:
        factor, number = 0.0, 0
    binds: tuple[FailureMode, ...] = ()
    if run.status == PathStatus.LIMIT:
        if find_exceeded(f.limits, *_read(f, run.states[0])):  # before there is any load
            factor, number = 0.0, 0
        binds = find_binding(f.limits, *_read(f, run.states[number]), near=_AT)
        stood = [
            c for c in find_binding(f.limits, *_read(f, run.states[0]), near=_AT) if c.margin <= OVER_LIMIT_TOLERANCE
        ]
        binds = (factor > 0.0 and tuple([c for c in binds if c not in stood])) or binds
    elif run.status.is_lost:
        short = int(np.searchsorted(run.shares, (1.0 - _AT) * end)) - 1  # the last state that is truly short of the end
        binds = find_slipping(f.spec.names, run.states[-1].kinds, run.states[short].kinds if short >= 0 else None)
    if run.slides is not None:
        factor, number = run.slides.share, run.slides.number
        binds = slid_contacts(f.spec.names, run.slipped[number] / f.max_slip)
    if binds == (FailureMode(EQUILIBRIUM, OBJECT),):  # the last static state is short of where contacts begin to slide
        binds = _about_to_slip(f, run.states[number]) or binds
    if f.slid is not None:
        factor, number, slides, binds = 0.0, 0, 0.0, f.slid[1]
    gave_up, ends = run.status.is_given_up, _known(f)
    if gave_up and run.slides is None:
        binds = _UNKNOWN
    early = ends if ends is not None and ends.factor < factor else None
    if early is not None:
        factor, number, slides, binds = early.factor, early.number, None, _UNKNOWN
        first = first if first is not None and first <= factor else None

    def sentence() -> str:
        if f.slid is not None:
            rests = alone("weight" if f.spec.mechanism is not None else OWN_WRENCH)
            text = describe_failures(binds, f.spec)
            return f"{rests} is not held: {text} at {words.format_percent(f.slid[0])} of it"
        if early is not None:
            return f"held up to {factor:.4g} times the load, and undecided beyond: {early.why}"
        if gave_up:
            return (
                f"held up to {end:.4g} times the load, and undecided beyond: {explain_giving_up(run.status, run.who)}"
            )
        return explain_limit(binds, factor, f.wrench, f.spec, _then(f) if run.slides is None else "")

    later = Later(
        sentence, lambda: _path(f, number), lambda: _solution(f, number, factor),
        lambda bound: _largest(f, factor, bound), lambda: _rest(f, ends, number),
    )  # fmt: skip
    return LoadLimit(factor, f.wrench, binds, f.geometry, later, first, slides)


def slid_contacts(names: Sequence[str], shares: Array) -> tuple[FailureMode, ...]:
    """The contacts that have slid as far as they may where the first of them has. shares (n,) : of how far they may."""
    at = is_at_max_slip(shares, np.ones(len(shares)))
    return tuple([FailureMode(SLIDES, name) for name, slides in zip(names, at.tolist(), strict=True) if slides])


def _about_to_slip(f: Followed, state: State) -> tuple[FailureMode, ...]:
    """Contacts whose friction is all but used up."""
    left, normal = f.leg.margins(state)[:, 0], state.read.forces[:, 2]
    pressed = normal > _AT * max(float(normal.max(initial=0.0)), 1e-300)
    near = pressed & (left <= _NEAR * f.stepper.friction * normal)
    return tuple([FailureMode(SLIPS, name) for name, slips in zip(f.spec.names, near.tolist(), strict=True) if slips])


def _then(f: Followed) -> str:
    """What the object does at the end, other than that no more load is balanced; "" for nothing."""
    if f.jump is None:
        return ""
    last = f.run.snaps[-1] if f.run.snaps else None
    if last is None or not last.pushed:
        return "snaps to another place, or leaves"
    by = f", as a small push{describe_direction(np.array(last.pushed))} makes it where it is in balance"
    return f"{'snaps to another place' if last.rests else 'leaves'}{by}"


def _through(f: Followed) -> Run:
    """The whole path, beyond where a contact has slid as far as it may."""
    if f.run.status == PathStatus.REACHED and f.run.slides is not None:
        f.leg.through()
    return f.run


def _largest(f: Followed, factor: float, bound: float) -> float:
    """The largest factor up to `bound` for which there is any equilibrium: in one posture a solve finds one that no
    path leads to; where the geometry is followed, what a path has passed through.
    """
    if f.geometry == "fixed":
        return largest_held(f.spec, f.section, f.spec.resting_wrench, f.wrench, factor, bound)
    return _through(f).shares[-1]


def _rest(f: Followed, ends: _Ends | None, number: int) -> Rest:
    """What follows. ends : of what is known up to where a contact has slid too far. number : of the limit's state."""
    at, k = f.run.states[number], f.spec.of_hand
    asked = () if f.spec.mechanism is None else f.spec.mechanism.report.command_reasons(f.spec)
    doubts = [r.sentence for r in asked if r.code == "command_not_made"]
    if pressed := describe_pad_depth(at.where.give[:k], at.iterate.frames[:k, :, 2], f.spec.names):
        doubts.append(pressed)
    run = f.run if ends is not None else _through(f)
    ends = ends or _known(f)
    known = np.inf if ends is None else ends.factor
    lost = run.shares[-1] if run.status.is_lost and ends is None else None
    first = f.first_slip
    slides = 0.0 if f.slid is not None else None if run.slides is None else run.slides.share
    named = ("first_slip", first), ("slides", slides), ("lost", lost)
    marks = {name: f.mark(x) for name, x in named if x is not None and x <= known}
    if ends is not None or run.status.is_given_up:
        marks["undecided"] = f.mark(min(known, run.shares[-1]))
    elif run.status == PathStatus.LIMIT:
        marks["limit"] = f.mark(run.shares[-1])
    events = [LimitEvent(e.kind, e.who, e.share) for e in f.events if e.kind in _NAMED]
    if f.jump is not None:
        pushed = run.snaps[-1].pushed if run.snaps else ()
        events.append(LimitEvent("snaps", OBJECT, f.jump.share, pushed=pushed))
    if run.slides is not None:
        slid = slid_contacts(f.spec.names, run.slipped[run.slides.number] / f.max_slip)
        events += [LimitEvent(SLIDES, one.who, run.slides.share) for one in slid]
    said = "" if ends is None else ends.why
    if ends is None and run.status.is_given_up:
        said = explain_giving_up(run.status, run.who)
    told = tuple(sorted([e for e in events if e.factor <= known], key=lambda e: e.factor))
    return Rest(lost, marks, told, said, "; ".join(doubts))


def _read(f: Followed, state: State) -> tuple[Array, Array, Array]:
    moved = f.stepper.geometry.displacement(state.where.pose) - f.at
    return state.efforts, state.where.q, moved


def _path(f: Followed, number: int) -> LimitPath:
    """To the limit, whatever is known of the path beyond; number : of the last state."""
    states, displacement = f.run.states[: number + 1], f.stepper.geometry.displacement
    return LimitPath(
        read_only(np.array(f.run.shares[: number + 1])), read_only(np.array([s.read.forces for s in states])),
        read_only(np.array([s.read.torque for s in states])),
        read_only(np.array([displacement(s.where.pose) for s in states])),
    )  # fmt: skip


def _solution(f: Followed, number: int, factor: float) -> GraspSolution:
    state = f.leg.seen(number, factor) if np.isfinite(factor) else f.run.states[number]
    return solution_of(f.stepper.grasp, state, f.section)


OWN_WRENCH = "own wrench"  # the stage in which the wrench of contacts without a hand comes


def alone(stage: str) -> str:
    """What a stage brings, in words, where that is not even held without a load."""
    own = {LET_GO: "the closed hand, let go, alone", OWN_WRENCH: "its own wrench alone"}
    return own.get(stage, f"the {stage} alone")


def nothing(
    spec: GraspSpec,
    section: Section,
    wrench: Array,
    run: Run,
    geometry: str,
    loading: Loading,
    closing: tuple[FailureMode, ...] = (),
) -> LoadLimit:
    """Where squeeze or weight alone are not held, or nothing is known of it. closing : joints and tendons whose motors
    cannot close so hard.
    """
    reason = loading.why.partition(": ")[2]
    if closing:
        binds = closing
        text = (
            f"the hand cannot close so hard: {words.list_names([c.who for c in closing])} would need more than the peak"
        )
    elif run.status.is_given_up:
        binds, text = _UNKNOWN, f"undecided: the {loading.lost_stage} alone was not followed to its end: {reason}"
    else:
        binds = (
            find_slipping(spec.names, run.states[-1].kinds)
            if run.states[-1].loaded
            else (FailureMode(EQUILIBRIUM, OBJECT),)
        )
        first = f"{told}; " if (told := describe_missing_squeeze(spec)) else ""
        text = f"{first}{alone(str(loading.lost_stage))} is not held: {reason}"
    none, fixed = np.zeros((0, spec.n, 3)), geometry == "fixed"
    nv = loading.steps.torques.shape[1]
    path = LimitPath(np.zeros(0), none, np.zeros((0, nv)), np.zeros((0, 6)))
    rest = Rest(0.0, {"lost": Reached(0.0, 0.0, 0.0)}, ())

    def beyond(bound: float) -> float:
        return largest_held(spec, section, spec.resting_wrench, wrench, 0.0, bound) if fixed else 0.0

    later = Later(lambda: text, lambda: path, lambda: loading.solution, beyond, lambda: rest)
    return LoadLimit(0.0, wrench, binds, geometry, later)
