"""The load limit by following the path: squeeze, weight, then a load that grows until something ends it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.doubled import doubled
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.cause.judge import (
    EQUILIBRIUM,
    OBJECT,
    SLIPS,
    UNDECIDED,
    Cause,
    Limits,
    binding,
    limits_of,
    over,
    slipping,
    used,
)
from handlcp.grasp.cause.wording import moves, why, why_given_up
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.result import Later, LimitEvent, LimitPath, LoadLimit, Reached, Rest
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.advance import Leg, Open, advance
from handlcp.grasp.path.follow import TOLERANCE, Loading, begun, geometry_of, loading_of, solution_of
from handlcp.grasp.path.state import STILL, Goal, Outcome, Run, Stage, State
from handlcp.grasp.path.step import Stepper
from handlcp.grasp.path.watch import margins, watch_of
from handlcp.tolerances import OVER

_ORDER = ("squeeze", Stage("weight", weight=1.0), "load")
_STEPS = 8  # of squeeze and weight
_FIRST = 0.1  # of the load that is as large as the forces before it: the first step
_RAY = 1e4  # times that load: nothing binds that has not bound by then
_AT = 1e-6  # relative: limits that are this near to being reached bind, too
_NEAR = 1e-3  # of the load: contacts that begin to slide this near to where the object slides through are the cause
_UNKNOWN: tuple[Cause, ...] = (Cause(UNDECIDED, OBJECT),)  # what gives out where a path was given up
_NAMED = ("slips", "sticks", "opens", "touches", "yields", "holds", "snaps", "slides through")


def followed_limit(
    spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float], geometry: str = "followed",
    finer: float = 1.0,
) -> LoadLimit:  # fmt: skip
    """Most : motion [m] and turn [rad] of the object that are allowed. finer : how many times as many steps."""
    return Before(spec, section, most, geometry, finer).limit(wrench)


class Before:
    """What comes before a load grows, followed once: squeeze, weight, and `beside` (6,), a load that is there already
    besides the weight. Other arguments as in `followed_limit`.
    """

    def __init__(
        self, spec: GraspSpec, section: Section, most: tuple[float, float], geometry: str = "followed",
        finer: float = 1.0, beside: Array = STILL,
    ) -> None:  # fmt: skip
        self._body, self._most = geometry_of(spec, geometry), most
        self._spec, self._section, self._geometry, self._finer, self._beside = spec, section, geometry, finer, beside
        path = np.stack([beside, beside]) if beside.any() else STILL
        first, self._goals, self._stepper = begun(spec, section, self._body, TOLERANCE, _ORDER, path)
        self._watch, count = watch_of(spec, self._body), max(int(np.ceil(finer * _STEPS)), 1)
        self._run = advance(self._stepper, self._watch, first, self._goals[:-1], count)

    @property
    def held(self) -> bool:
        """Whether the object is held by then, and has not begun to slide through."""
        return self._run.outcome is Outcome.END and self._run.slides is None

    def limit(self, wrench: Array, until: float = np.inf) -> LoadLimit:
        """Of a load (6,) that grows, up to this factor: none is found that is larger."""
        spec, section, before, stepper = self._spec, self._section, self._run, self._stepper
        if before.outcome is not Outcome.END:
            loading = loading_of(before, self._goals[:-1], stepper, section)
            return _nothing(spec, wrench, before, self._geometry, loading)
        start, finer, follows = before.states[-1], self._finer, self._body.follows
        size = _as_large(stepper, start, wrench)
        at = stepper.geometry.displacement(start.where.pose)
        limits = limits_of(spec, motion=self._most, ranges=follows, nominal=start.where.q if follows else None)

        # What is at its limit already before the load comes ends the path only where it goes beyond the limit
        stands_at = _used(stepper, limits, at, start) > 1.0 - OVER

        def beyond(state: State) -> float:
            share = _used(stepper, limits, at, state) - 1.0
            return float(np.nanmax(np.where(stands_at & (share <= OVER), -1.0, share), initial=-1.0))

        run = Run([start], [0], [0.0])
        goal = Goal(self._goals[-1].name, self._goals[-1].end._replace(load=self._beside + wrench))
        grows = Open(_FIRST * size / finer, min(_RAY * size, until), beyond, 1.0 / finer)
        leg = Leg(stepper, self._watch, run, 0, goal, 1.0, grows)
        leg.through(pause=True)
        slid = None if before.slides is None else (before.slides.share, _kinds_near(before, before.slides.number))
        return _answer(_Followed(spec, section, wrench, run, leg, stepper, limits, at, self._geometry, slid))


def accurate_limit(
    spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float], geometry: str, accuracy: float | None
) -> LoadLimit:
    """With twice as many steps until the factor changes by no more than `accuracy`, relative, or no more are tried; its
    `accuracy` is the last change. None: with as many steps as usual.
    """
    if accuracy is None:
        return followed_limit(spec, section, wrench, most, geometry)

    def apart(last: LoadLimit, found: LoadLimit) -> float:
        if found.factor == last.factor:  # such as infinite, or 0
            return 0.0
        return abs(found.factor - last.factor) / max(found.factor, last.factor)

    def answer(times: int) -> LoadLimit:
        return followed_limit(spec, section, wrench, most, geometry, float(times))

    found, off = doubled(answer, apart, sliding, accuracy)
    return replace(found, accuracy=off)


def sliding(found: LoadLimit) -> int:
    """How many steps there are from the first slip on: before it a step is exact, however long."""
    return 0 if found.first_slip is None else int((found.path.factors > found.first_slip).sum())


def _as_large(stepper: Stepper, start: State, wrench: Array) -> float:
    """The factor with which the load is as large as the forces before it; where there are none, with which it moves a
    finger by a hundredth of the contacts' distances.
    """
    load = float(np.sqrt(wrench[:3] @ wrench[:3] + wrench[3:] @ wrench[3:] / stepper.length**2))
    forces = float(np.linalg.norm(start.read.forces, axis=1).sum())
    return (forces or 0.01 * stepper.stiffness * stepper.length) / load


def _used(stepper: Stepper, limits: Limits, at: Array, state: State) -> Array:
    moved = stepper.geometry.displacement(state.where.pose) - at
    return used(limits, state.read.torque, state.where.q, moved)


class _Followed(NamedTuple):
    """A path whose load has grown: run, from `at` (6,), the object's motion before it. slid : the share of the weight
    at which the object slides through already, and what contacts do there; None: it does not.
    """

    spec: GraspSpec
    section: Section
    wrench: Array
    run: Run
    leg: Leg
    stepper: Stepper
    limits: Limits
    at: Array
    geometry: str
    slid: tuple[float, list[str]] | None

    def mark(self, factor: float) -> Reached:
        """How far the object has moved at a factor, between two states."""
        shares = np.array(self.run.shares)
        moved = np.array([self.stepper.geometry.displacement(s.where.pose) - self.at for s in self.run.states])
        there = np.array([np.interp(factor, shares, column) for column in moved.T])
        return Reached(factor, float(np.linalg.norm(there[:3])), float(np.linalg.norm(there[3:])))


def _answer(f: _Followed) -> LoadLimit:
    run, end = f.run, f.run.shares[-1]
    first = next((e.share for e in run.events if e.kind == "slips"), None)
    slides = None if run.slides is None else run.slides.share
    factor, number = np.inf if run.outcome is Outcome.UNBOUNDED else end, len(run.states) - 1
    binds: tuple[Cause, ...] = ()
    if run.outcome is Outcome.LIMIT:
        if over(f.limits, *_read(f, run.states[0])):  # before there is any load
            factor, number = 0.0, 0
        binds = binding(f.limits, *_read(f, run.states[number]), near=_AT)
        stood = [c for c in binding(f.limits, *_read(f, run.states[0]), near=_AT) if c.margin <= OVER]
        binds = (factor > 0.0 and tuple([c for c in binds if c not in stood])) or binds
    elif run.outcome is Outcome.LOST:
        before = run.states[-2].kinds if len(run.states) > 1 else None
        binds = slipping(f.spec.names, run.states[-1].kinds, before)
    if run.slides is not None:
        factor, number = run.slides.share, run.slides.number
        binds = slipping(f.spec.names, _kinds_near(run, number))
    if binds == (Cause(EQUILIBRIUM, OBJECT),):  # the last static state is short of where contacts begin to slide
        binds = _about_to_slip(f, run.states[number]) or binds
    if f.slid is not None:
        factor, number, slides, binds = 0.0, 0, 0.0, slipping(f.spec.names, f.slid[1])
    gave_up = run.outcome is Outcome.GAVE_UP
    if gave_up and run.slides is None:
        binds = _UNKNOWN

    def sentence() -> str:
        if f.slid is not None:
            return f"the weight alone is not held: the object slides through from {words.percent(f.slid[0])} of it on"
        if gave_up:
            assert run.failure is not None
            return f"held up to {end:.4g} times the load, and undecided beyond: {why_given_up(run.failure.kind)}"
        return why(binds, factor, f.wrench, f.spec, _then(_through(f)))

    later = Later(
        sentence, lambda: _path(f, number), lambda: _solution(f, number, factor), lambda _: _through(f).shares[-1],
        lambda: _rest(f),
    )  # fmt: skip
    return LoadLimit(factor, f.wrench, binds, f.geometry, later, first, slides)


def _kinds_near(run: Run, number: int) -> list[str]:
    """What contacts do where the object slides through; those that stick for a moment there slide."""
    near = [s.kinds for s, x in zip(run.states, run.shares, strict=True) if x >= (1.0 - _NEAR) * run.shares[number]]
    last = run.states[min(number + 1, len(run.states) - 1)].kinds
    return ["sliding" if any(kinds[i] == "sliding" for kinds in near) else last[i] for i in range(len(last))]


def _about_to_slip(f: _Followed, state: State) -> tuple[Cause, ...]:
    """Contacts whose friction is all but used up."""
    left, normal = margins(f.stepper, state)[:, 0], state.read.forces[:, 2]
    pressed = normal > _AT * max(float(normal.max(initial=0.0)), 1e-300)
    near = pressed & (left <= _NEAR * f.stepper.friction * normal)
    return tuple([Cause(SLIPS, name) for name, slips in zip(f.spec.names, near.tolist(), strict=True) if slips])


def _then(run: Run) -> str:
    """What the object does at the limit, other than that it is lost; "" for nothing."""
    if run.slides is None:
        return ""
    there = [s for s in run.snaps if (s.stage, s.share) == (run.slides.stage, run.slides.share)]
    if not there:
        return "slides through"
    pushed = there[0].pushed
    by = f", as a small push{moves(np.array(pushed))} makes it where it is in balance" if pushed else ""
    if there[0].rests:
        return f"snaps to another place{by}"
    return f"leaves{by}" if pushed else ""


def _through(f: _Followed) -> Run:
    """The whole path, beyond where the object begins to slide through."""
    if f.run.outcome is Outcome.END and f.run.slides is not None:
        f.leg.through()
    return f.run


def _rest(f: _Followed) -> Rest:
    run = _through(f)
    lost = run.shares[-1] if run.outcome is Outcome.LOST else None
    first = next((e.share for e in run.events if e.kind == "slips"), None)
    slides = 0.0 if f.slid is not None else None if run.slides is None else run.slides.share
    marks = {
        name: f.mark(x) for name, x in (("first_slip", first), ("slides", slides), ("lost", lost)) if x is not None
    }
    if run.outcome in (Outcome.LIMIT, Outcome.GAVE_UP):
        marks["limit" if run.outcome is Outcome.LIMIT else "undecided"] = f.mark(run.shares[-1])
    events = [LimitEvent(e.kind, e.who, e.share) for e in run.events if e.kind in _NAMED]
    events += [LimitEvent("snaps", OBJECT, s.share, s.moved, s.turned, s.pushed) for s in run.snaps if s.rests]
    if slides is not None:
        events.append(LimitEvent("slides through", OBJECT, slides))
    return Rest(lost, marks, tuple(sorted(events, key=lambda e: e.factor)))


def _read(f: _Followed, state: State) -> tuple[Array, Array, Array]:
    moved = f.stepper.geometry.displacement(state.where.pose) - f.at
    return state.read.torque, state.where.q, moved


def _path(f: _Followed, number: int) -> LimitPath:
    """To the limit, whatever is known of the path beyond; number : of the last state."""
    states, displacement = f.run.states[: number + 1], f.stepper.geometry.displacement
    return LimitPath(
        read_only(np.array(f.run.shares[: number + 1])), read_only(np.array([s.read.forces for s in states])),
        read_only(np.array([s.read.torque for s in states])),
        read_only(np.array([displacement(s.where.pose) for s in states])),
    )  # fmt: skip


def _solution(f: _Followed, number: int, factor: float) -> GraspSolution:
    state = f.leg.seen(number, factor) if np.isfinite(factor) else f.run.states[number]
    return solution_of(f.stepper.grasp, state, f.section)


def _nothing(spec: GraspSpec, wrench: Array, run: Run, geometry: str, loading: Loading) -> LoadLimit:
    """Where squeeze or weight alone are not held, or nothing is known of it."""
    reason = loading.why.partition(": ")[2]
    if run.outcome is Outcome.GAVE_UP:
        binds, text = _UNKNOWN, f"undecided: the {loading.lost_stage} alone was not followed to its end: {reason}"
    else:
        binds = slipping(spec.names, run.states[-1].kinds) if run.states[-1].loaded else (Cause(EQUILIBRIUM, OBJECT),)
        text = f"the {loading.lost_stage} alone is not held: {reason}"
    none = np.zeros((0, spec.n, 3))
    nv = loading.steps.torques.shape[1]
    path = LimitPath(np.zeros(0), none, np.zeros((0, nv)), np.zeros((0, 6)))
    rest = Rest(0.0, {"lost": Reached(0.0, 0.0, 0.0)}, ())
    later = Later(lambda: text, lambda: path, lambda: loading.solution, lambda _: 0.0, lambda: rest)
    return LoadLimit(0.0, wrench, binds, geometry, later)
