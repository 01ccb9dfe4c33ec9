"""One step of a path: contacts detected anew, the consistent tangent about them, one warm solve; repeated until the
contacts were looked at where the step ends.

That is Newton's method on the laws at the end of the step. v_T is the slip of the step, which friction opposes: history
is carried by the joints, the pads and the object's pose alone. A small damper on object and joints, of stiffness D / h,
gives loose and undetermined motions an answer; with h ≤ 1e8 it changes no other.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import ContactStatus, PathStatus, shown_statuses
from handlcp.grasp.path.geometry import Geometry, Iterate, Where, between, length_of
from handlcp.grasp.path.joint_system import pack_joints
from handlcp.grasp.path.joints import NO_JOINTS, NO_TASK, Joints
from handlcp.grasp.path.newton.answer import Reached
from handlcp.grasp.path.newton.linear_solve import Rules
from handlcp.grasp.path.newton.numbers import Damping, Loads, Read, Situation, softness_of
from handlcp.grasp.path.pull import NO_PULL, Pull, Task
from handlcp.grasp.path.solve_step import (
    GOES_ON,
    KEPT,
    MAX_ITERATES,
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
        own = self.__dict__
        own.update(row=row, stepper=stepper, controls=controls, yielded=stepper.still, gives=_NOWHERE)

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
        iterate, stepper = self.iterate, self.stepper
        at, under = iterate.at, stepper.grasp.under(self.controls, self.controls)
        loads = Loads(
            self._read("base"), self._read("since"), at.give, at.turn, under.commanded - at.q, under.load,
            iterate.reference, under.weight, iterate.reference + iterate.weight_arm,
        )  # fmt: skip
        if stepper.joints is None or not self._read("tally")[2]:
            return loads
        return stepper.driven_by_springs(loads, iterate, self.where.q, self._read("torque"))

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
    def rubs(self) -> Array:
        """Dry friction at the joints."""
        return self.stepper.still if self.stepper.joints is None else self._read("rubs")

    @lazy_property
    def pull(self) -> Pull:
        """What joints, posts and tendons do."""
        if self.stepper.joints is None:
            return NO_PULL
        parts = [self._read(name) for name in ("post_friction", "drawn", "tension", "taut")]
        return Pull(self._read("modes").astype(np.int64), *parts)

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
        self.joints = _joints(spec, geometry, self.first.elastic.compliance_factor)
        counts = None if self.joints is None else self.joints.counts
        self.laws = StepLaws(self.grasp, section, self.first, counts)
        softness = softness_of(self.first.elastic)
        self.length = length_of(self.first.positions)
        self.stiffness = 1.0 / float(softness.mean()) if softness.any() else 1.0
        self.damper = self.stiffness * np.array([1.0] * 3 + [self.length**2] * 3)
        self.sizes = Sizes(self.length, self.stiffness, self.tolerance, self.slow)
        laws = [c.friction for c in spec.contacts]
        self.friction, self.still = self.laws.friction_coefficients, read_only(np.zeros(len(self.first.at.q)))
        at_rest = self.spring_torque(np.zeros(len(self.still)))
        rate = self.spring_torque(np.ones(len(self.still))) - at_rest
        self.springs = np.array([at_rest, rate])  # torque of springs beside drives at q = 0, and how fast it grows
        self.lever = np.array([1.0 / law.lever if law.lever > 0.0 else 0.0 for law in laws])
        pose, dof = len(geometry.pose_row(geometry.start.pose)), self.laws.pattern.dof
        self.layout = StateRow(spec.n, len(self.still), len(self.laws.laws.scale), dof, pose, counts)
        self.compiled = self._step_model(weight)

    def _step_model(self, weight: Array) -> StepModel | None:
        """All that the steps have in common, as compiled code reads it; None: a step needs Python for what the grasp's
        user brings, or for effects with limits that give way.
        """
        arrays, laws, joints = self.geometry.arrays, self.laws, self.joints
        if arrays is None or self.grasp.general:
            return None
        no_extra, giving = laws.nothing_added
        rules = Rules(laws.laws, laws.friction_coefficients, no_extra, giving, laws.yields, laws.pattern)
        return StepModel(
            arrays, rules, self.grasp.preloads, np.array(self.grasp.posture), np.array(weight), self.damper,
            self.sizes, laws.by_contact, joints is not None, *self._packed_joints(), self.layout.starts,
            laws.answer.starts,
        )  # fmt: skip

    def _packed_joints(self) -> tuple[Array, Ints]:
        """Joints that do more than give way, and routes of their tendons, as compiled code reads them."""
        if self.joints is None:
            return NO_JOINTS
        routed, arrays = self.joints.cables.elasticity_at is not None, self.geometry.arrays
        routes = self.geometry.tendon_routes if routed else None
        return pack_joints(self.joints.system, None if arrays is None else arrays.hand.tree, routes)

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
        if self.joints is not None:
            parts |= state.pull._asdict() | {"slack": state.pull.slack, "rubs": state.rubs}
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
            rubs = joints.taken(joints.rubbing(pull, stands, end.q, self._left(reached.torque, iterate)))
            loads = self.driven_by_springs(loads, iterate, end.q + yielded, reached.torque)
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

    @property
    def may_cross(self) -> bool:
        """Whether tendons pass round bodies that they may come to cross."""
        return self.joints is not None and bool(self.joints.cables.wrapped_bodies)

    def crosses(self, rows: Array, ends: bool) -> str:
        """What a tendon crosses from one of these states to the next, as of `Cables`, or, where the last of them is an
        end, crosses close by; "": nothing.
        """
        if self.joints is None or not self.may_cross:
            return ""
        q = [self.layout.read(row, "at")[: len(self.still)].copy() for row in rows]
        if ends and (size := float(abs(going := q[-1] - q[0]).max())) > 0.0:
            q += [q[-1] - _CLOSE_BY / size * going, q[-1] + _CLOSE_BY / size * going]
        return next((who for who in map(self.joints.cables.crossed_body, q, q[1:]) if who), "")

    def _answer(self, asked: _Asked, start: Array, state: State) -> Reached | None:
        """The answer that continues what is expected, as `answer_iterate` chooses it."""
        laws, iterate = self.laws, asked.iterate
        extra, giving, loads = laws.added(iterate, asked.loads, asked.gives)
        situation = Situation(
            iterate.touch, iterate.frames, iterate.moving, iterate.elastic, loads, asked.slipped, iterate.radius,
            asked.damping,
        )  # fmt: skip
        rules = Rules(laws.laws, laws.friction_coefficients, extra, giving, laws.yields, laws.pattern)
        task = NO_TASK if self.joints is None else self.joints.task(asked.begun, asked.task, iterate.at.q)
        row, kinds = np.zeros(laws.answer.size), np.array(state.kinds, dtype=np.int64)
        found = answer_iterate(
            situation, rules, laws.by_contact, task, start, state.loaded, kinds, asked.near, laws.answer.starts, row
        )  # fmt: skip
        return Reached(row, laws.answer.parts) if found else None

    def spring_torque(self, q: Array) -> Array:
        """(nv,) with which drives pull against springs beside them, with joints at q (nv,)."""
        mechanism = self.grasp.spec.mechanism
        held = None if mechanism is None else mechanism.parallel_spring_torque(q if self.geometry.follows else None)
        return self.still if held is None else held

    def _left(self, torque: Array, iterate: Iterate) -> Array:
        """(nv,) what springs pull with for the contacts alone, of torques (nv,) that hold the fingers' weight, too."""
        return torque - (1.0 - self.laws.laws.sags) * iterate.elastic.gravity

    def driven_by_springs(self, loads: Loads, iterate: Iterate, q: Array, torque: Array) -> Loads:
        """The same as if there were springs alone, with joints at q (nv,) that bear these torques (nv,)."""
        assert self.joints is not None
        command = q - iterate.at.q + self.joints.at(iterate.at.q).C @ self._left(torque, iterate)
        return loads._replace(command=command)


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
