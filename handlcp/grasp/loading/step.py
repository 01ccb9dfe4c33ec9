"""One step of loading: contacts detected anew, one warm solve, and the configuration that follows from it.

About a configuration x̂ near the step's end, the step is an ordinary grasp (`step_grasp`):

    v = Gᵀ u - J (q - q̂) - (s - ŝ) + d̂,    q = q_c - K⁻¹ (Jᵀ f + g),    s = -P f

q_c are the commanded joints, s is how far pads give way, and v_T is the slip of the step, which friction opposes:
history is carried by q, s and the object's pose alone. Balance is written in the geometry of x̂. Where the end of the
step is too far from x̂, the end becomes x̂ and the step is solved again; at convergence every law holds in the geometry
at the end of the step. That iteration contracts where the grasp is stable: a force that turns with its contact
faster than the springs can follow drives it away.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.loading.geometry import Geometry, Look, Where, between
from handlcp.grasp.loading.numbers import Loads, Read, end_of_step
from handlcp.grasp.loading.stage import Controls
from handlcp.grasp.loading.state import SLIDES, Failure, Guess, State
from handlcp.grasp.loading.step_answer import Answer, Push, StepSolver
from handlcp.grasp.loading.step_grasp import StepGrasp
from handlcp.grasp.loading.watch import watch_of
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE

__all__ = ["Stepper"]

_MOST = 10  # looks at one step, before it counts as one that does not settle
_LEAST = 0.2  # of the way from a look to its end
_CONTRACTS = 0.7  # each look has to come nearer by this factor, or the step is shortened
_LARGEST = 0.1  # motion in one step, as a share of the contacts' radii
_CATCH, _CAUGHT = 30, 0.5  # looks and motion within which an object that snaps may come to rest again


class _Found(NamedTuple):
    """end : where a look leads. answer, controls, loads : of the solve. carry (n, 3) : slip from the look to the end;
    slid : of the step, as in `State`. miss : how far the end is from the look; leap : from the step's beginning, both
    as shares of the contacts' radii.
    """

    end: Where
    answer: Answer
    controls: Controls
    loads: Loads
    carry: Array
    slid: Array
    miss: float
    leap: float


class _Swing:
    """How far to go from a look to its end: all the way, or less where ends swing from one side to the other, as a
    contact that sticks on one side and slides on the other does. Aitken's relaxation.
    """

    def __init__(self) -> None:
        self.last: Array | None = None
        self.part = 1.0

    def share(self, moved: Array) -> float:
        """Moved (6,) : of the object from the look to its end."""
        if self.last is not None:
            change = self.last - moved
            size = float(change @ change)
            self.part = min(max(self.part * float(self.last @ change) / size, _LEAST), 1.0) if size > 0.0 else 1.0
        self.last = moved
        return self.part


class Stepper:
    """Steps of one grasp. tolerance : how far the end of a step may be from where its contacts were looked at, as a
    share of the contacts' radii. weight (3,) : of the object [N].
    """

    def __init__(self, spec: GraspSpec, geometry: Geometry, section: Section, weight: Array, tolerance: float) -> None:
        self.geometry, self.tolerance = geometry, tolerance
        self.first = geometry.look(geometry.start, None)
        self.grasp = StepGrasp(spec, geometry, self.first, weight)
        self.solver = StepSolver(self.grasp, self.first, section)
        self.watch, self._none = watch_of(spec, geometry), read_only(np.zeros((spec.n, 3)))

    def beginning(self, controls: Controls) -> State:
        """Before anything is done: nothing is loaded, and the joints stand in the grasp's posture."""
        first, n, still = self.first, self.grasp.spec.n, read_only(np.zeros(len(self.first.at.q)))
        none = read_only(np.zeros((n, 3)))
        read = Read(none, none, none[:, 0], none[:, 0], still, still)
        loads = self.grasp.loads(first, none, controls, controls)
        marks = self.watch.marks(first.at.q, still, still)
        return State(first.at, first, loads, none, none, read, ("separated",) * n, still, controls, NOWHERE, 0, marks)

    def step(self, state: State, controls: Controls, guess: Guess, patient: bool = False) -> State | Failure:
        """The state under other controls. guess : what is expected of it. patient : whether to search for an answer
        where the first stage of the solver finds none, and to go along with an object that snaps to another place.
        """

        def looked(look: Look) -> _Found | Failure:
            return self._looked(state, controls, look, guess, patient)

        return self._iterated(state, guess, looked, patient)

    def caught(self, state: State, controls: Controls) -> State | Failure:
        """The state under other controls, as far away as an object may snap; None of the solver's searches."""

        def looked(look: Look) -> _Found | Failure:
            return self._looked(state, controls, look, state.same, False)

        return self._iterated(state, state.same, looked, True)

    def pushed(self, state: State, push: Push, factor: float, guess: Guess) -> State | Failure:
        """The state in which the object has moved on as a push says, under as much of its load as that takes; the
        state's own load is a multiple of it. factor : about how much of it that will be.
        """
        there = self.geometry.displacement(state.where.pose)
        expected = state.controls._replace(load=factor * push.load)

        def looked(look: Look) -> _Found | Failure:
            gone = float(push.along @ (self.geometry.displacement(look.at.pose) - there))
            return self._pushed(state, expected, look, guess, push._replace(travel=push.travel - gone))

        return self._iterated(state, guess, looked, False)

    def _iterated(
        self, state: State, guess: Guess, looked: Callable[[Look], _Found | Failure], patient: bool
    ) -> State | Failure:
        """Look again where the last look led, until the end is near enough to it."""
        geometry = self.geometry
        look, last, swing = geometry.look(guess.where, state.look), np.inf, _Swing()
        most, furthest = (_CATCH, _CAUGHT) if patient else (_MOST, _LARGEST)
        for count in range(1, most + 1):
            found = looked(look)
            if isinstance(found, Failure):
                return found
            end = found.end
            if found.miss <= self.tolerance or not geometry.follows:
                if found.leap > furthest:
                    break
                answer = found.answer
                marks = self.watch.marks(end.q, answer.read.torque, answer.yielded)
                return State(
                    end, look, found.loads, found.carry, found.slid, answer.read, answer.kinds, answer.yielded,
                    found.controls, answer.start, count, marks,
                )  # fmt: skip
            share = swing.share(geometry.displacement(end.pose) - geometry.displacement(look.at.pose))
            if found.leap > furthest or (count > 2 and found.miss > _CONTRACTS * last and not patient):
                break
            last = found.miss if share == 1.0 else max(found.miss, last)
            look = geometry.look(end if share == 1.0 else between(geometry, look.at, end, share), look)
        moved = geometry.displacement(end.pose) - geometry.displacement(state.where.pose)
        return Failure("runs away", moved)

    def settled(self, state: State, where: Where) -> Where | None:
        """Where the state ends under its own controls, looked at from `where`; None: nowhere."""
        where_to = self.geometry.displacement(state.where.pose) - self.geometry.displacement(where.pose)
        look = self.geometry.look(where, state.look)
        found = self._looked(state, state.controls, look, Guess(where, state.start, where_to), False)
        return None if isinstance(found, Failure) else found.end

    def _looked(self, state: State, controls: Controls, look: Look, guess: Guess, patient: bool) -> _Found | Failure:
        """One solve, with the contacts of a look."""
        slipped = self.geometry.slipped(state.look, look, state.carry)
        loads = self.grasp.loads(look, slipped, controls, state.controls)
        answer = self.solver.continued(look, loads, guess.start, guess.motion, state.kinds, patient)
        if isinstance(answer, Failure):
            return answer
        return self._led(state, controls, look, loads, slipped, answer, self._none)

    def _pushed(self, state: State, expected: Controls, look: Look, guess: Guess, push: Push) -> _Found | Failure:
        """The same, pushed on."""
        slipped, lead = self.geometry.slipped(state.look, look, state.carry), push.lead
        plain, led = self.grasp.loads(look, slipped, expected, state.controls), bool(lead.any())
        while True:
            loads = _led_by(plain, lead)
            answer, more = self.solver.pushed(look, loads, push, guess.start, guess.motion, state.kinds)
            if isinstance(answer, Failure):
                return answer
            stuck = [i for i, kind in enumerate(answer.kinds) if kind != SLIDES and lead[i].any()] if led else []
            if not stuck:
                break
            lead = lead.copy()
            lead[stuck] = 0.0
        loads = self.grasp.more(loads, look, more * push.load)
        controls = expected._replace(load=expected.load + more * push.load)
        return self._led(state, controls, look, loads, slipped, answer, lead)

    def _led(
        self, state: State, controls: Controls, look: Look, loads: Loads, slipped: Array, answer: Answer, lead: Array
    ) -> _Found:
        """Where an answer leads."""
        read, here, el = answer.read, look.at, look.elastic
        q = self.grasp.posture + controls.command - read.deflection - answer.yielded
        give, turn, carry, miss = end_of_step(
            read.motion, read.spin, q - here.q, answer.twist, answer.centre, look.positions, look.frames, el.J,
            el.turning, loads.base, here.give, here.turn, slipped, self.grasp.soft, look.radius,
        )  # fmt: skip
        pose, leap = self.geometry.moved(here.pose, answer.twist, answer.centre, state.where.pose)
        slid = np.column_stack([read.motion[:, :2], read.spin]) - lead
        return _Found(Where(q, give, turn, pose), answer, controls, loads, carry, slid, miss, leap)


def _led_by(loads: Loads, lead: Array) -> Loads:
    """With the lead of contacts that go on sliding, as in `Push`."""
    if not lead.any():
        return loads
    base = loads.base.copy()
    base[:, :2] += lead[:, :2]
    return loads._replace(base=base, spin=loads.spin + lead[:, 2])
