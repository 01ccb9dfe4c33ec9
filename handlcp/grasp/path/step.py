"""One step of a path: contacts detected anew, the consistent tangent about them, one warm solve; repeated until the
contacts were looked at where the step ends.

That is Newton's method on the laws at the end of the step. v_T is the slip of the step, which friction opposes: history
is carried by the joints, the pads and the object's pose alone. A small damper on object and joints, of stiffness D / h,
gives loose and undetermined motions an answer; with h ≤ 1e8 it changes no other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import ContactStatus, PathStatus, shown_statuses
from handlcp.grasp.path.geometry import Geometry, Iterate, Where, between, length_of
from handlcp.grasp.path.joints import Joints
from handlcp.grasp.path.newton.answer import Reached
from handlcp.grasp.path.newton.linear_solve import Rules
from handlcp.grasp.path.newton.numbers import Damping, Loads, Read, Situation, softness_of
from handlcp.grasp.path.pull import NO_PULL, Pull, Task
from handlcp.grasp.path.solve_step import (
    CLOSE,
    GOES_ON,
    KEPT,
    MAX_ITERATES,
    PRESSED,
    SETTLED,
    Sizes,
    StateRow,
    StepModel,
    StepOptions,
    answer_iterate,
    is_pushed_ahead,
    judge_iterate,
    load_change,
    relax_share,
    solve_once,
    solve_step,
)
from handlcp.grasp.path.state import OPEN, Controls, Failure, Guess, State
from handlcp.grasp.path.step_grasp import StepGrasp, StepLaws, Under
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lazy_property import lazy_property
from handlcp.lcp import Auto

# h of a quasi-static step: its damper takes 1e-8 of the forces that such a motion would need, so that a state passes
# the certifier; less where the posture stays, so that closed forms are met to nine digits
_SLOW, _SLOW_STILL = 1e8, 1e9
_ALL = Auto(search_seconds=0.0)
_CLOSE_BY = 1e-3  # [rad, m] from where a path ends to where a tendon crosses: it ends for that reason
_NOWHERE = np.zeros(0)
_NO_PAST = np.zeros((0, 3))


class StepState(State):
    """A state that was computed in one call. row : its numbers, as `StateRow` has them. stepper : of the step. What
    else a `State` holds is made of the row when it is first asked for.
    """

    row: Array
    stepper: Stepper

    def __init__(self, row: Array, controls: Controls, stepper: Stepper) -> None:
        still, own = stepper.still, self.__dict__
        own.update(row=row, stepper=stepper, controls=controls, yielded=still, gives=_NOWHERE, rubs=still, pull=NO_PULL)

    def _read(self, name: str) -> Array:
        """A part of the row."""
        return self.stepper.layout.read(self.row, name)

    def __reduce__(self) -> tuple[Any, ...]:
        return State, tuple([getattr(self, f.name) for f in fields(State)])

    @lazy_property
    def where(self) -> Where:
        """As in `State`, and so is all below."""
        return self.stepper.geometry.where_of(self._read("where"))

    @lazy_property
    def iterate(self) -> Iterate:
        """The contacts, looked at once more."""
        geometry = self.stepper.geometry
        return geometry.iterate_again(geometry.where_of(self._read("at")), self._read("frames"))

    @lazy_property
    def loads(self) -> Loads:
        """Those of the step."""
        iterate, under = self.iterate, self.stepper.grasp.under(self.controls, self.controls)
        at = iterate.at
        return Loads(
            self._read("base"), self._read("since"), at.give, at.turn, under.commanded - at.q, under.load,
            iterate.reference, under.weight, iterate.reference + iterate.weight_arm,
        )  # fmt: skip

    @lazy_property
    def slip_memory(self) -> Array:
        """Slip between iterate and end."""
        return self._read("slip_memory")

    @lazy_property
    def slid(self) -> Array:
        """Slip of the step."""
        return np.column_stack([self._read("motion")[:, :2], self._read("spin")])

    @lazy_property
    def read(self) -> Read:
        """Forces, motions and torques."""
        springs, torque = self.stepper.spring_torque(self.where.q), self._read("torque")
        return Read(
            self._read("forces"), self._read("motion"), self._read("torsion"), self._read("spin"),
            torque if springs is self.stepper.still else torque + springs, self._read("deflection"), springs,
        )  # fmt: skip

    @lazy_property
    def kinds(self) -> tuple[ContactStatus, ...]:
        """Contact states."""
        return shown_statuses(self._read("kinds").astype(np.int64).tolist())

    @lazy_property
    def start(self) -> Array:
        """Where the next solve begins; empty where nothing was solved."""
        return self._read("start") if self._read("tally")[2] else _NOWHERE

    @lazy_property
    def iterates(self) -> int:
        """How many the step took."""
        return int(self._read("tally")[0])

    @lazy_property
    def met(self) -> Array:
        """What a small push meets."""
        return self._read("met") if self._read("tally")[1] else np.zeros((0, 0))


class _Asked(NamedTuple):
    """What is asked of the solves of an iterate. slipped (n, 3) : since the step began. gives (k,) : motions of limits
    that they start from. near : an answer that is no farther from the iterate than this is measured for its stability.
    task : of the joints. begun : what `Joints` assumes of them first.
    """

    iterate: Iterate
    loads: Loads
    slipped: Array
    damping: Damping
    gives: Array
    near: float
    task: Task
    begun: Pull


class Stepper:
    """Steps of one grasp. tolerance : how far the end of a step may be from where its contacts were looked at, as a
    share of the contacts' radii. weight (3,) : of the object [N].
    """

    def __init__(self, spec: GraspSpec, geometry: Geometry, section: Section, weight: Array, tolerance: float) -> None:
        self.geometry, self.tolerance, self.section = geometry, max(tolerance, geometry.noise), section
        self.slow = _SLOW if geometry.follows else _SLOW_STILL
        self.first = geometry.iterate(geometry.start, None)
        self.grasp = StepGrasp(spec, geometry, self.first, weight)
        self.laws = StepLaws(self.grasp, section, self.first)
        softness = softness_of(self.first.elastic)
        self.length = length_of(self.first.positions)
        self.stiffness = 1.0 / float(softness.mean()) if softness.any() else 1.0
        self.damper = self.stiffness * np.array([1.0] * 3 + [self.length**2] * 3)
        self.sizes = Sizes(self.length, self.stiffness, self.tolerance, self.slow)
        laws = [c.friction for c in spec.contacts]
        self.friction, self.still = self.laws.friction_coefficients, read_only(np.zeros(len(self.first.at.q)))
        self.joints = _joints(spec, geometry, self.first.elastic.compliance_factor)
        at_rest = self.spring_torque(np.zeros(len(self.still)))
        rate = self.spring_torque(np.ones(len(self.still))) - at_rest
        self.springs = np.array([at_rest, rate])  # torque of springs beside drives at q = 0, and how fast it grows
        self.lever = np.array([1.0 / law.lever if law.lever > 0.0 else 0.0 for law in laws])
        pose, dof = len(geometry.pose_row(geometry.start.pose)), self.laws.pattern.dof
        tendons = 0 if self.joints is None else len(self.joints.cables.names)
        self.layout = StateRow(spec.n, len(self.still), len(self.laws.laws.scale), dof, pose, tendons)
        self.compiled = self._step_model(weight)

    def _step_model(self, weight: Array) -> StepModel | None:
        """All that the steps have in common, as compiled code reads it; None: a step needs Python for what the grasp's
        user brings, for effects with limits that give way, or for joints with friction and tendons.
        """
        arrays, laws = self.geometry.arrays, self.laws
        if arrays is None or self.grasp.general or self.joints is not None:
            return None
        no_extra, giving = laws.nothing_added
        rules = Rules(laws.laws, laws.friction_coefficients, no_extra, giving, laws.yields, laws.pattern)
        return StepModel(
            arrays, rules, self.grasp.preloads, np.array(self.grasp.posture), np.array(weight), self.damper,
            self.sizes, laws.by_contact, self.layout.starts, laws.answer.starts,
        )  # fmt: skip

    def beginning(self, controls: Controls) -> State:
        """Before anything is done: nothing is loaded, and the joints stand in the grasp's posture."""
        first, none = self.first, np.zeros((self.grasp.spec.n, 3))
        under = self.grasp.under(controls, controls)
        loads, still, pull = self.grasp.loads(first, none, under), self.still, NO_PULL
        if self.joints is not None:
            none_yet = self.joints.still
            task = Task(under.commanded, first.at.q, None)
            pull = self.joints.at(first.at.q).pull(none_yet.modes, none_yet.post_friction, task, first.at.q)
        springs = self.spring_torque(first.at.q)
        read = Read(none, none, none[:, 0], none[:, 0], springs, still, springs)
        return self._unloaded(first, loads, read, controls, still, pull)

    def _unloaded(
        self, iterate: Iterate, loads: Loads, read: Read, controls: Controls, rubs: Array, pull: Pull
    ) -> State:
        """A state in which no contact carries anything."""
        n, nv = self.grasp.spec.n, len(iterate.at.q)
        slid = np.column_stack([read.motion[:, :2], read.spin])
        return State(
            iterate.at, iterate, loads, np.zeros((n, 3)), slid, read, (OPEN,) * n, read_only(np.zeros(nv)), controls,
            _NOWHERE, np.zeros(self.laws.given), 0, np.zeros((0, 0)), rubs, pull,
        )  # fmt: skip

    def step(
        self, state: State, controls: Controls, guess: Guess | None = None, h: float | None = None, rough: float = 1.0,
        past: Array | None = None, slow_pads: bool = False,
    ) -> State | Failure:  # fmt: skip
        """The state under other controls. guess : what is expected of it. h : of the damper, less for a viscous step.
        rough : times the tolerance. past (n, 3) : slip that is left out of what friction opposes; None: none.
        slow_pads : whether pads are damped as joints are, or follow at once.
        """
        asked = StepOptions(self.slow if h is None else h, rough, _NO_PAST if past is None else past, slow_pads)
        if self.compiled is None:
            return self.step_in_python(state, controls, guess or state.same, asked)
        before, row = self.row_of(state), np.empty(self.layout.size)
        if guess is None:
            expected, start = self.layout.read(before, "where"), state.start
        else:
            expected, start = self.geometry.where_row(guess.where), guess.start
        status = solve_step(self.compiled, before, controls_row(controls), expected, start, asked, row)
        return StepState(row, controls, self) if status == SETTLED else Failure(PathStatus(status))

    def row_of(self, state: State) -> Array:
        """A state's numbers, as `StateRow` has them."""
        known: Array | None = state.__dict__.get("row")
        if known is not None:
            return known
        row, geometry, read, iterate = np.zeros(self.layout.size), self.geometry, state.read, state.iterate
        placed = geometry.placed(iterate)
        parts: dict[str, Any] = {
            "where": geometry.where_row(state.where), "at": geometry.where_row(iterate.at),
            "base": state.loads.base, "since": state.loads.spin, "slip_memory": state.slip_memory,
            "forces": read.forces, "motion": read.motion, "torsion": read.torsion, "spin": read.spin,
            "torque": read.torque - read.springs, "deflection": read.deflection, "kinds": state.kinds,
            "controls": controls_row(state.controls), "yielded": state.yielded,
            "tally": (state.iterates, float(len(state.met) > 0), float(len(state.start) > 0), 0.0),
        } | placed._asdict()  # fmt: skip
        for name in ("start", "met"):
            if len(value := getattr(state, name)):
                parts[name] = value
        if len(state.pull.tension):
            parts |= {"tension": state.pull.tension, "slack": state.pull.slack}
        for name, value in parts.items():
            self.layout.read(row, name)[...] = value
        state.__dict__["row"] = row
        return row

    def step_in_python(
        self, state: State, controls: Controls, guess: Guess, asked: StepOptions
    ) -> State | Failure:  # fmt: skip
        """The same as `solve_step`, of geometries, effects and joints that it does not know."""
        geometry, follows, h, past = self.geometry, self.geometry.follows, asked.h, asked.past
        iterate, start, gives = geometry.iterate(guess.where, state.iterate), guess.start, guess.gives
        begun = state.pull
        task = _task(state, controls, under := self.grasp.under(controls, state.controls))
        last, swing, near = np.inf, np.zeros(8), asked.rough * self.tolerance
        damper, most = self.damper / h, near if follows else -1.0
        pads = 1.0 / h if asked.slow_pads else 0.0
        if controls.kept:
            damper = KEPT * self.damper
        free, more = not (under.load.any() or under.weight.any()), 0.0
        if h >= self.slow:
            more = load_change(self.sizes, self.grasp.weight, controls_row(state.controls), controls_row(controls))
        for count in range(1, MAX_ITERATES + 1):
            slipped = geometry.slipped(state.iterate, iterate, state.slip_memory)
            if len(past):
                slipped -= past
            loads = self.grasp.loads(iterate, slipped, under)
            done = self.geometry.between(state.where.pose, iterate.at.pose)
            was, now = state.where, iterate.at
            damping = Damping(1.0 / h, pads, damper, done, was.q - now.q, was.give - now.give, was.turn - now.turn)
            reached = self._answer(_Asked(iterate, loads, slipped, damping, gives, most, task, begun), start, state)
            if reached is None:
                return Failure(PathStatus.NO_FORCES)
            end = Where(
                iterate.at.q + reached.change,
                reached.give,
                reached.turn,
                geometry.moved(iterate.at.pose, reached.twist, reached.centre),
            )
            start, gives, miss, begun = reached.start, reached.gives, reached.miss, reached.pull
            moved = self.geometry.between(state.where.pose, end.pose)
            judged = judge_iterate(
                self.sizes, self.damper, follows, miss, near, last, count, moved, reached.forces, free, more
            )
            if judged == SETTLED:
                return self._state_at(state, controls, asked, task, under, (reached, iterate, loads, end, count))
            if judged != GOES_ON:
                return Failure(PathStatus(judged))
            share = relax_share(swing, geometry.displacement(end.pose) - geometry.displacement(iterate.at.pose))
            last = miss if share == 1.0 else max(miss, last)
            iterate = geometry.iterate(end if share == 1.0 else between(geometry, iterate.at, end, share), iterate)
        return Failure(PathStatus.RUNS_AWAY)

    def _state_at(
        self, state: State, controls: Controls, asked: StepOptions, task: Task, under: Under,
        found: tuple[Reached, Iterate, Loads, Where, int],
    ) -> State:  # fmt: skip
        """The state at the end of a step from another. found : its last answer, and the iterate, loads, end and number
        of that.
        """
        reached, iterate, loads, end, count = found
        motion, spin, past = reached.motion, reached.spin, asked.past
        if len(past):
            motion[:, :2] += past[:, :2]
            spin += past[:, 2]
        slid = motion.copy()
        slid[:, 2] = spin
        yielded = self.laws.yields @ reached.gives if len(reached.gives) else np.zeros(len(end.q))
        springs, deflection = self.spring_torque(end.q), under.commanded - end.q - yielded
        torque = reached.torque if springs is self.still else reached.torque + springs
        read = Read(reached.forces, motion, reached.torsion, spin, torque, deflection, springs)
        rubs, pull = self.still, reached.pull
        if self.joints is not None:
            joints = self.joints.at(iterate.at.q)
            stands = task._replace(commanded=under.commanded - yielded)
            left = self._left(reached, iterate)
            rubs = joints.taken(joints.rubbing(pull, stands, end.q, left))
            # as if there were springs alone
            loads = loads._replace(command=end.q + yielded - iterate.at.q + joints.C @ left)
        kinds = shown_statuses(reached.kinds)
        free = controls.kept or not (under.load.any() or under.weight.any())
        if free and is_pushed_ahead(self.sizes, reached.forces):
            kinds = (OPEN,) * len(kinds)  # pushed ahead, and held by nobody
        return State(
            end, iterate, loads, reached.slip_memory, slid, read, kinds, yielded, controls, reached.start,
            reached.gives, count, reached.met, rubs, pull,
        )  # fmt: skip

    def untouched(self, state: State, controls: Controls) -> State | Failure:
        """A step in which no contact carries anything and nothing pulls the object: fingers go where they are
        commanded, and the object stays. What overlaps by no more than just touches at the start presses nothing: the
        forces of so little would be those of rounding.
        """
        under, n = self.grasp.under(controls, state.controls), self.grasp.spec.n
        pulled = under.load.any() or (under.weight.any() and not controls.kept)
        if pulled or self.grasp.sags or not self.geometry.follows:
            return Failure(PathStatus.NO_FORCES)
        q, rubs, pull = under.commanded, self.still, NO_PULL
        if (joints := self.joints) is not None:
            task = _task(state, controls, under)
            q, pull = joints.ends(state.pull, task)
            rubs = joints.taken(joints.at(q).rubbing(pull, task, q, rubs))
        end = Where(q, np.zeros((n, 3)), np.zeros(n), state.where.pose)
        iterate = self.geometry.iterate(end, state.iterate)
        slipped = self.geometry.slipped(state.iterate, iterate, state.slip_memory)
        loads = self.grasp.loads(iterate, slipped, under)
        if loads.base[:, 2].min(initial=0.0) < -self.grasp.touches:
            return Failure(PathStatus.NO_FORCES)
        none, springs = np.zeros(n), self.spring_torque(q)
        torque = iterate.elastic.gravity + springs
        read = Read(np.zeros((n, 3)), loads.base, none, loads.spin, torque, under.commanded - q, springs)
        return self._unloaded(iterate, loads, read, controls, rubs, pull)

    def sought(self, state: State, controls: Controls) -> State | Failure | None:
        """A step solved by all methods that a single grasp is solved with, at the contacts where they are; None: these
        find no answer either. Other steps ask the first method alone.
        """
        if self.grasp.general:
            return None
        iterate = self.geometry.iterate(state.where, state.iterate)
        slipped = self.geometry.slipped(state.iterate, iterate, state.slip_memory)
        loads = self.grasp.loads(iterate, slipped, self.grasp.under(controls, state.controls))
        found = solve_spec(self.grasp.made(iterate, loads), self.section, _ALL)
        if not found.held:
            return None
        soft, forces = self.grasp.soft, found.forces.reshape(-1)
        own = forces if found.torsion is None else np.append(forces, found.torsion[soft])
        none_expected = np.zeros(len(own))
        start = np.concatenate([own / self.laws.laws.scale, found.object_displacement, found.reference, none_expected])
        return self.step(state, controls, Guess(state.where, start, state.gives))

    def crosses(self, states: Sequence[State], number: int, ends: bool) -> str:
        """What a tendon crosses from this one of the states on, as of `Cables`, or, where these end, crosses close by;
        "": nothing.
        """
        if self.joints is None or not self.joints.cables.wrapped_bodies:
            return ""
        q = [s.iterate.at.q for s in states[number - 1 if number else 0 :]]
        if ends and (size := float(abs(going := q[-1] - q[0]).max())) > 0.0:
            q += [q[-1] - _CLOSE_BY / size * going, q[-1] + _CLOSE_BY / size * going]
        return next((who for who in map(self.joints.cables.crossed_body, q, q[1:]) if who), "")

    def _answer(self, asked: _Asked, start: Array, state: State) -> Reached | None:
        """The answer that continues what is expected, as `answer_iterate` chooses it; where joints rub or tendons may
        go slack, each of those that it chooses from is found for every assumption of what these do.
        """
        if self.joints is None:
            situation, rules = self._situation(asked, 1.0)
            row, kinds = np.zeros(self.laws.answer.size), np.array(state.kinds, dtype=np.int64)
            found_one = answer_iterate(
                situation, rules, self.laws.by_contact, start, state.loaded, kinds, asked.near,
                self.laws.answer.starts, row,
            )  # fmt: skip
            return Reached(row, self.laws.answer.parts, NO_PULL) if found_one else None
        begun = start if state.loaded else _NOWHERE
        found = self._solved(asked, begun)
        if not state.loaded and (found is None or not found.kinds.any()):
            return self._pressed(asked._replace(near=-1.0)) or found
        if not len(begun) or (found is not None and shown_statuses(found.kinds) == state.kinds):
            return found
        c = len(self.laws.laws.scale)
        size = CLOSE * float(abs(start[:c]).max())
        if found is not None and float(abs(found.start[:c] - start[:c]).max()) <= size:
            return found
        other = self._solved(asked, begun, cold=True)
        if found is None or other is None:
            return found or other
        if shown_statuses(other.kinds) == state.kinds:
            return other
        off = [float(abs(a.start[:c] - start[:c]).max()) for a in (found, other)]
        return found if off[0] <= off[1] else other

    def _pressed(self, asked: _Asked) -> Reached | None:
        """The loaded answer nearest to contacts that all stick: friction starts high and comes down to what it is, each
        solve from the last. None where an answer opens all contacts on the way.
        """
        found, start = None, np.zeros(0)
        for times in PRESSED:
            found = self._solved(asked, start, times)
            if found is None or not found.kinds.any():
                return None
            start = found.start
        return found

    def _solved(self, asked: _Asked, start: Array, friction: float = 1.0, cold: bool = False) -> Reached | None:
        """One solve for each assumption of what joints and tendons do. friction : times what it is. cold : from
        contacts that all stick, not from the start.
        """
        assert self.joints is not None  # others are answered in one call
        loads, iterate = asked.loads, asked.iterate

        def once(factor: Array, command: Array, tensed: Array) -> tuple[Reached, Array, Array] | None:
            elastic = iterate.elastic._replace(compliance_factor=factor, tensed=tensed)
            made = asked._replace(iterate=iterate._replace(elastic=elastic), loads=loads._replace(command=command))
            found = self._solved_once(made, start, friction, cold)
            return None if found is None else (found, iterate.at.q + found.change, self._left(found, iterate))

        tried = self.joints.at(iterate.at.q).solved(asked.begun, asked.task, iterate.at.q, once)
        if tried is None:
            return None
        found: Reached = tried[0]
        found.pull = tried[1]
        return found

    def spring_torque(self, q: Array) -> Array:
        """(nv,) with which drives pull against springs beside them, with joints at q (nv,)."""
        mechanism = self.grasp.spec.mechanism
        held = None if mechanism is None else mechanism.parallel_spring_torque(q if self.geometry.follows else None)
        return self.still if held is None else held

    def _left(self, reached: Reached, iterate: Iterate) -> Array:
        """(nv,) what springs pull with for the contacts alone."""
        return reached.torque - (1.0 - self.laws.laws.sags) * iterate.elastic.gravity

    def _solved_once(self, asked: _Asked, start: Array, friction: float, cold: bool) -> Reached | None:
        situation, rules = self._situation(asked, friction)
        row = np.zeros(self.laws.answer.size)
        found = solve_once(situation, rules, self.laws.by_contact, start, not cold, asked.near, row)
        return Reached(row, self.laws.answer.parts, NO_PULL) if found else None

    def _situation(self, asked: _Asked, friction: float) -> tuple[Situation, Rules]:
        """What a solve of an iterate sees, and the rules of its answer; friction : times what it is."""
        laws, iterate = self.laws, asked.iterate
        extra, giving, loads = laws.added(iterate, asked.loads, asked.gives)
        coefficients = laws.friction_coefficients if friction == 1.0 else friction * laws.friction_coefficients
        situation = Situation(
            iterate.touch, iterate.frames, iterate.moving, iterate.elastic, loads, asked.slipped, iterate.radius,
            asked.damping,
        )  # fmt: skip
        return situation, Rules(laws.laws, coefficients, extra, giving, laws.yields, laws.pattern)


def controls_row(controls: Controls) -> Array:
    """Controls as `solve_step` reads them."""
    row = np.empty(9 + len(controls.command))
    row[:6], row[6], row[7], row[8] = controls.load, controls.weight, controls.preload, controls.kept
    row[9:] = controls.command
    return row


def controls_of(row: Array) -> Controls:
    """The controls that such a row stands for."""
    return Controls(row[:6], float(row[6]), float(row[7]), row[9:], bool(row[8]))


def _joints(spec: GraspSpec, geometry: Geometry, compliance_factor: Array) -> Joints | None:
    """Of joints with dry friction, or with tendons that may go slack or have a limit; None: springs alone."""
    mechanism = spec.mechanism
    if mechanism is None or not (mechanism.joint_model.dry_friction.any() or mechanism.joint_model.cables is not None):
        return None
    cables = mechanism.joint_model.cables
    if cables is not None and not geometry.follows:  # joints are measured from the posture, and arms are those there
        cables = cables._replace(shift=np.zeros(len(cables.names)), elasticity_at=None, arm_rates=None)
    return Joints(compliance_factor, mechanism.joint_model.dry_friction, cables, geometry.posture)


def _task(state: State, controls: Controls, under: Under) -> Task:
    """Of a step from a state."""
    driven = bool((controls.command != state.controls.command).any())
    return Task(under.commanded, state.where.q, None if driven else state.pull.drawn)
