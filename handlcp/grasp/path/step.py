"""One step of a path: contacts detected anew, the consistent tangent about them, one warm solve; repeated until the
contacts were looked at where the step ends.

That is Newton's method on the laws at the end of the step. v_T is the slip of the step, which friction opposes: history
is carried by the joints, the pads and the object's pose alone. A small damper on object and joints, of stiffness D / h,
gives loose and undetermined motions an answer; with h ≤ 1e8 it changes no other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import PathStatus, shown_statuses
from handlcp.grasp.path.geometry import Geometry, Iterate, Where, between, length_of
from handlcp.grasp.path.joints import Joints
from handlcp.grasp.path.newton.answer import Reached
from handlcp.grasp.path.newton.by_contact import iteration_by_contact
from handlcp.grasp.path.newton.iteration import one_iteration
from handlcp.grasp.path.newton.linear_solve import Rules
from handlcp.grasp.path.newton.numbers import Damping, Loads, Read, Situation, softness_of
from handlcp.grasp.path.pull import NO_PULL, Pull, Task
from handlcp.grasp.path.state import OPEN, Controls, Failure, Guess, State
from handlcp.grasp.path.step_grasp import StepGrasp, StepLaws, Under
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Auto

# h of a quasi-static step: its damper takes 1e-8 of the forces that such a motion would need, so that a state passes
# the certifier, and closed forms are met to nine digits
_SLOW = 1e8
_FREE = 1e4  # h of a step that pushes an object which nothing holds
_KEPT = 1e6  # 1 / h of the object alone, where something keeps it in place: it gives way by a millionth of the fingers
_HELD_BACK = 1e-6  # of the forces: where the damper takes more, it holds the object, and the contacts do not
_NOTHING = 3e-9  # of a force that moves a finger by the contacts' distance: a smaller one may come from the damper
_MOST = 9  # iterates of one step, after which it counts as one that does not settle
_CONTRACTS, _PARTS = 0.6, 1.5  # times the last miss: more ends the iterates from the fourth on, and any iterate
_LARGEST = 0.1  # motion in one step, as a share of the contacts' radii
_CLOSE = 1e-3  # of the forces: an answer this near to what was expected is the one that continues it
_LEAST = 0.2  # of the way from an iterate to its end
_SEED = Auto().seed
_ALL = Auto(search_seconds=0.0)
_CLOSE_BY = 1e-3  # [rad, m] from where a path ends to where a tendon crosses: it ends for that reason
_NOWHERE = np.zeros(0)
_PRESSED = (16.0, 8.0, 4.0, 3.0, 2.0, 1.7, 1.4, 1.2, 1.1, 1.0)  # times friction as it is


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
        self.slow = _SLOW
        self.first = geometry.iterate(geometry.start, None)
        self.grasp = StepGrasp(spec, geometry, self.first, weight)
        self.laws = StepLaws(self.grasp, section, self.first)
        softness = softness_of(self.first.elastic)
        self.length = length_of(self.first.positions)
        self.stiffness = 1.0 / float(softness.mean()) if softness.any() else 1.0
        self._damper = self.stiffness * np.array([1.0] * 3 + [self.length**2] * 3)
        laws = [c.friction for c in spec.contacts]
        self.friction, self._still = self.laws.limits, read_only(np.zeros(len(self.first.at.q)))
        self.iteration = iteration_by_contact if self.laws.by_contact else one_iteration
        self.joints = _joints(spec, geometry, self.first.elastic.root)
        self.lever = np.array([1.0 / law.lever if law.lever > 0.0 else 0.0 for law in laws])

    def beginning(self, controls: Controls) -> State:
        """Before anything is done: nothing is loaded, and the joints stand in the grasp's posture."""
        first, none = self.first, np.zeros((self.grasp.spec.n, 3))
        under = self.grasp.under(controls, controls)
        loads, still, pull = self.grasp.loads(first, none, under), self._still, NO_PULL
        if self.joints is not None:
            none_yet = self.joints.still
            task = Task(under.commanded, first.at.q, None)
            pull = self.joints.at(first.at.q).pull(none_yet.modes, none_yet.post_friction, task, first.at.q)
        springs = self._springs(first.at.q)
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
        h = self.slow if h is None else h
        guess = guess or state.same
        geometry, follows = self.geometry, self.geometry.follows
        iterate, start, gives = geometry.iterate(guess.where, state.iterate), guess.start, guess.gives
        begun = state.pull
        task = _task(state, controls, under := self.grasp.under(controls, state.controls))
        last, swing, near = np.inf, _Swing(), rough * self.tolerance
        damper, most, here = self._damper / h, near if follows else -1.0, None
        pads = 1.0 / h if slow_pads else 0.0
        if controls.kept:
            damper = _KEPT * self._damper
        for count in range(1, _MOST + 1):
            slipped = geometry.slipped(state.iterate, iterate, state.slip_memory)
            if past is not None:
                slipped -= past
            loads = self.grasp.loads(iterate, slipped, under)
            done = self.between(state.where.pose, iterate.at.pose)
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
            if miss <= near or not follows:
                if follows and self.far(state.where.pose, end.pose) > _LARGEST:
                    return Failure(PathStatus.TOO_FAR)
                ahead = reached.forces[:, 2].max(initial=0.0) <= _NOTHING * self.stiffness * self.length
                still = not follows and not (ahead and not loads.load.any() and not loads.weight.any())
                if still and self._held_back(state.where.pose, end.pose, reached.forces) > _HELD_BACK:
                    return Failure(PathStatus.NO_FORCES)
                motion, spin = reached.motion, reached.spin
                if past is not None:
                    motion[:, :2] += past[:, :2]
                    spin += past[:, 2]
                slid = motion.copy()
                slid[:, 2] = spin
                yielded = self.laws.yields @ gives if len(gives) else np.zeros(len(end.q))
                springs, deflection = self._springs(end.q), under.commanded - end.q - yielded
                torque = reached.torque if springs is self._still else reached.torque + springs
                read = Read(reached.forces, motion, reached.torsion, spin, torque, deflection, springs)
                rubs, pull = self._still, reached.pull
                if self.joints is not None:
                    joints = self.joints.at(iterate.at.q)
                    stands = task._replace(commanded=under.commanded - yielded)
                    left = self._left(reached, iterate)
                    rubs = joints.taken(joints.rubbing(pull, stands, end.q, left))
                    # as if there were springs alone
                    loads = loads._replace(command=end.q + yielded - iterate.at.q + joints.C @ left)
                kinds = shown_statuses(reached.kinds)
                if ahead:
                    kinds = (OPEN,) * len(kinds)  # pushed ahead, and held by nobody
                return State(
                    end,
                    iterate,
                    loads,
                    reached.slip_memory,
                    slid,
                    read,
                    kinds,
                    yielded,
                    controls,
                    start,
                    gives,
                    count,
                    reached.met,
                    rubs,
                    pull,
                )
            if (count > 3 and miss > _CONTRACTS * last) or miss > _PARTS * last:
                return Failure(PathStatus.RUNS_AWAY)
            if self.far(state.where.pose, end.pose) > 2.0 * _LARGEST:
                return Failure(PathStatus.TOO_FAR)
            there = geometry.displacement(end.pose)
            share = swing.share(there - (geometry.displacement(iterate.at.pose) if here is None else here))
            here = there if share == 1.0 else None
            last = miss if share == 1.0 else max(miss, last)
            iterate = geometry.iterate(end if share == 1.0 else between(geometry, iterate.at, end, share), iterate)
        return Failure(PathStatus.RUNS_AWAY)

    def untouched(self, state: State, controls: Controls) -> State | Failure:
        """A step in which no contact carries anything and nothing pulls the object: fingers go where they are
        commanded, and the object stays. What overlaps by no more than just touches at the start presses nothing: the
        forces of so little would be those of rounding.
        """
        under, n = self.grasp.under(controls, state.controls), self.grasp.spec.n
        pulled = under.load.any() or (under.weight.any() and not controls.kept)
        if pulled or self.grasp.sags or not self.geometry.follows:
            return Failure(PathStatus.NO_FORCES)
        q, rubs, pull = under.commanded, self._still, NO_PULL
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
        none, springs = np.zeros(n), self._springs(q)
        torque = iterate.elastic.gravity + springs
        read = Read(np.zeros((n, 3)), loads.base, none, loads.spin, torque, under.commanded - q, springs)
        return self._unloaded(iterate, loads, read, controls, rubs, pull)

    def pushed(self, state: State, controls: Controls, guess: Guess | None = None) -> State | Failure:
        """A step in which fingers may push ahead of them an object that nothing holds, against a damper that is large
        enough to compute with. The forces of that are none.
        """
        found = self.step(state, controls, guess, _FREE)
        if isinstance(found, Failure):
            return found
        most = self.slow / _FREE * _NOTHING * self.stiffness * self.length
        if found.read.forces[:, 2].max(initial=0.0) > most:
            return Failure(PathStatus.NO_FORCES)
        return found._replace(kinds=(OPEN,) * len(found.kinds))

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
        start = np.concatenate([own / self.laws.laws.scale, found.object_displacement, found.reference])
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

    def between(self, a: object, b: object) -> Array:
        """(6,) of the object from pose a to pose b: of its reference point [m], and turned [rad]."""
        return self.geometry.between(a, b)

    def resisted(self, a: State, b: State, h: float) -> float:
        """What the object's damper takes in a step with h, as a share of the normal forces."""
        return self.slow / h * self._held_back(a.where.pose, b.where.pose, b.read.forces)

    def _held_back(self, a: object, b: object, forces: Array) -> float:
        """The same of a quasi-static step from pose a to pose b, with these forces (n, 3) at its end."""
        x, y, z, p, q, r = (self._damper * self.between(a, b)).tolist()
        size = math.sqrt(x * x + y * y + z * z + (p * p + q * q + r * r) / self.length**2)
        return size / self.slow / max(float(forces[:, 2].sum()), 1e-9 * self.stiffness * self.length)

    def far(self, a: object, b: object) -> float:
        """How far the object has moved from pose a to b, as a share of the contacts' distances from their centre."""
        x, y, z, p, q, r = self.between(a, b).tolist()
        return math.sqrt(x * x + y * y + z * z) / self.length + math.sqrt(p * p + q * q + r * r)

    def _answer(self, asked: _Asked, start: Array, state: State) -> Reached | None:
        """The answer that continues what is expected. Where a contact changes its state, the answer found from
        contacts that all stick is asked for, too, and the one is taken that changes no state, else the nearer one.
        """
        begun = start if state.loaded else _NOWHERE
        found = self._solved(asked, begun)
        if not state.loaded and (found is None or not found.kinds.any()):
            return self._pressed(asked._replace(near=-1.0)) or found
        if not len(begun) or (found is not None and shown_statuses(found.kinds) == state.kinds):
            return found
        c = len(self.laws.laws.scale)
        size = _CLOSE * float(abs(start[:c]).max())
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
        for times in _PRESSED:
            found = self._solved(asked, start, times)
            if found is None or not found.kinds.any():
                return None
            start = found.start
        return found

    def _solved(self, asked: _Asked, start: Array, friction: float = 1.0, cold: bool = False) -> Reached | None:
        """One solve; friction : times what it is. cold : from contacts that all stick, not from the start. Where joints
        rub or tendons may go slack, one for each assumption of what they do.
        """
        loads, iterate = asked.loads, asked.iterate
        if self.joints is None:
            return self._solved_once(asked, start, friction, cold)

        def once(root: Array, command: Array, tensed: Array) -> tuple[Reached, Array, Array] | None:
            sprung = iterate._replace(elastic=iterate.elastic._replace(root=root, tensed=tensed))
            made = asked._replace(iterate=sprung, loads=loads._replace(command=command))
            found = self._solved_once(made, start, friction, cold)
            return None if found is None else (found, iterate.at.q + found.change, self._left(found, iterate))

        tried = self.joints.at(iterate.at.q).solved(asked.begun, asked.task, iterate.at.q, once)
        if tried is None:
            return None
        found: Reached = tried[0]
        found.pull = tried[1]
        return found

    def _springs(self, q: Array) -> Array:
        """(nv,) with which drives pull against springs beside them, with joints at q (nv,)."""
        mechanism = self.grasp.spec.mechanism
        held = None if mechanism is None else mechanism.parallel_spring_torque(q if self.geometry.follows else None)
        return self._still if held is None else held

    def _left(self, reached: Reached, iterate: Iterate) -> Array:
        """(nv,) what springs pull with for the contacts alone."""
        return reached.torque - (1.0 - self.laws.laws.sags) * iterate.elastic.gravity

    def _solved_once(self, asked: _Asked, start: Array, friction: float, cold: bool) -> Reached | None:
        laws, iterate = self.laws, asked.iterate
        extra, giving, loads = laws.added(iterate, asked.loads, asked.gives)
        limits = laws.limits if friction == 1.0 else friction * laws.limits
        situation = Situation(
            iterate.touch, iterate.frames, iterate.moving, iterate.elastic, loads, asked.slipped, iterate.radius,
            asked.damping,
        )  # fmt: skip
        rules = Rules(laws.laws, limits, extra, giving, laws.yields, laws.pattern)
        row = np.zeros(laws.answer.size)
        self.iteration(situation, rules, start, not cold, _SEED, asked.near, row)
        return Reached(row, laws.answer.parts, NO_PULL) if row[0] else None


def _joints(spec: GraspSpec, geometry: Geometry, root: Array) -> Joints | None:
    """Of joints with dry friction, or with tendons that may go slack or have a limit; None: springs alone."""
    mechanism = spec.mechanism
    if mechanism is None or not (mechanism.joint_model.dry_friction.any() or mechanism.joint_model.cables is not None):
        return None
    cables = mechanism.joint_model.cables
    if cables is not None and not geometry.follows:  # joints are measured from the posture, and arms are those there
        cables = cables._replace(shift=np.zeros(len(cables.names)), elasticity_at=None, arm_rates=None)
    return Joints(root, mechanism.joint_model.dry_friction, cables, geometry.posture)


def _task(state: State, controls: Controls, under: Under) -> Task:
    """Of a step from a state."""
    driven = bool((controls.command != state.controls.command).any())
    return Task(under.commanded, state.where.q, None if driven else state.pull.drawn)


class _Swing:
    """How far to go from an iterate to its end: all the way, or less where ends swing from one side to the other, as a
    contact that sticks on one side and slides on the other does. Aitken's relaxation.
    """

    def __init__(self) -> None:
        self.last: Array | None = None
        self.part = 1.0

    def share(self, moved: Array) -> float:
        """Moved (6,) : of the object from the iterate to its end."""
        if self.last is not None:
            change = self.last - moved
            size = float(change @ change)
            self.part = min(max(self.part * float(self.last @ change) / size, _LEAST), 1.0) if size > 0.0 else 1.0
        self.last = moved
        return self.part
