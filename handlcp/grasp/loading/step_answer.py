"""The solve inside a step of loading: the first stage of the solver, started at what is expected.

A step whose effects follow from its data is a row of numbers for the compiled solve, and no object is made. A step with
effects that have rows or a flexibility of their own is a specification that takes the way of every grasp.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.assembly.build import build
from handlcp.grasp.friction import Section
from handlcp.grasp.loading.geometry import Look
from handlcp.grasp.loading.numbers import Laws, Loads, Read, read_answer, write_row
from handlcp.grasp.loading.state import OPEN, Failure
from handlcp.grasp.loading.step_grasp import StepGrasp, about_origin
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.solve.compiled_answer import NOWHERE, CompiledAnswer, compiled_kind, start_from
from handlcp.grasp.solve.compiled_solve import solve_scenes
from handlcp.grasp.solve.pushed_solve import push_scene
from handlcp.grasp.solve.stages import solve_built
from handlcp.lcp import Auto

__all__ = ["Answer", "Push", "StepSolver"]

_CHAIN = Auto(search_seconds=0.0)  # a "no" is not worth a proof
_FRICTION = (16.0, 8.0, 4.0, 3.0, 2.0, 1.7, 1.4, 1.2, 1.1, 1.0)  # times what it is


class Answer(NamedTuple):
    """read : forces, motions and torques. twist (6,) : of the object about centre (3,). kinds (n,) : of the contacts.
    yielded (nv,) : how far joints at their limit are driven back. start : where the next solve may begin.
    """

    read: Read
    twist: Array
    centre: Array
    kinds: tuple[str, ...]
    yielded: Array
    start: Array


class Push(NamedTuple):
    """How a step is led by the object's motion. load (6,) : the load that a factor of 1 stands for, about the look's
    reference. along (6,), travel : along · (the object's motion from the look, of its reference) = travel.
    lead (n, 3) : slip of contacts that go on sliding, as in `State.slid`, that is left out of what friction opposes.
    """

    load: Array
    along: Array
    travel: float
    lead: Array


class StepSolver:
    """Solves the steps of one grasp. section : of its friction cones."""

    def __init__(self, grasp: StepGrasp, first: Look, section: Section) -> None:
        self.grasp, self.section = grasp, section
        scene = build(grasp.spec)
        self._kind = compiled_kind(scene, section)
        c, soft, contacts = scene.components, scene.soft, grasp.spec.contacts
        self.laws = Laws(
            np.array(soft, dtype=np.int64), np.ones(c) if scene.scale is None else scene.scale,
            np.array([contacts[i].friction.pad_torsion for i in soft], dtype=float), scene.limits(section),
            scene.freedom, grasp.spec.mechanism is not None and bool(grasp.spec.flexibility.any()),
            1.0 if grasp.sags else 0.0,
        )  # fmt: skip
        self._scene = np.empty((1, self._kind.scene_width))
        self._still = read_only(np.zeros(first.elastic.J.shape[1]))

    def continued(
        self, look: Look, loads: Loads, start: Array, motion: Array, kinds: tuple[str, ...], patient: bool
    ) -> Answer | Failure:
        """The answer that continues what is expected.

        Where a contact changes its state, the answer that a solve finds from contacts that all stick is asked for, too.
        Of both, the one that changes no state is taken, else the one whose forces are nearer to those expected. An
        answer without forces may be one of several: a squeezed object stays between the fingers, or slips out. Then the
        one near fingers that press on a held object is taken, where there is one.

        start : as in `compiled_answer.start_from`; motion (6,) : of the object from the look to where it is expected,
        about the look's reference. kinds (n,) : the contacts' states before. patient : whether to search for an answer
        where the first stage finds none.
        """
        loaded = any(kind != OPEN for kind in kinds)
        start = self._restarted(start, look, motion) if loaded else NOWHERE
        found = self._solved(look, loads, start, patient)
        opened = isinstance(found, Failure) or all(kind == OPEN for kind in found.kinds)
        if opened and (not len(start) or isinstance(found, Answer)):
            other = self._pressed_answer(look, loads, self._pressed(look, loads), patient)
            if other is not None:
                return other
        if not len(start):
            return found
        if isinstance(found, Failure) or found.kinds == kinds:  # where it fails, contacts that stick were tried, too
            return found
        return _nearer(found, self._solved(look, loads, NOWHERE, patient), start, kinds)

    def margins(self, start: Array) -> tuple[Array, Array]:
        """(n,) normal force of each contact, and how far its friction is from its limit [N]; start : of an answer."""
        contacts, limits = self._kind.pattern.contacts, self.laws.limits
        forces = np.append(start[:-9], 0.0)
        normal = forces[contacts[:, 0]]
        return normal, limits * normal - np.sqrt((forces[contacts[:, 1:]] ** 2).sum(axis=1))

    def pushed(
        self, look: Look, loads: Loads, push: Push, start: Array, motion: Array, kinds: tuple[str, ...]
    ) -> tuple[Answer | Failure, float]:
        """The answer under these loads and a factor times the load of a push, that continues what is expected; and the
        factor. start, motion, kinds : as in `continued`.
        """
        start = self._restarted(start, look, motion)
        found, factor = self._pushed(look, loads, push, start)
        if isinstance(found, Answer) and found.kinds != kinds and len(start):
            again, other = self._pushed(look, loads, push, NOWHERE)
            if _nearer(found, again, start, kinds) is again:
                return again, other
        return found, factor

    def _pushed(self, look: Look, loads: Loads, push: Push, start: Array) -> tuple[Answer | Failure, float]:
        write_row(self._scene[0], look.positions, look.frames, look.elastic, loads, self.laws)
        row, reference = np.empty(self._kind.answer_width), look.reference
        load, along = about_origin(push.load, reference), about_origin(push.along, reference)
        factor = push_scene(self._scene[0], self._kind.pattern, load, along, push.travel, start, _CHAIN.seed, row)
        return self._read(row, look), factor

    def _restarted(self, start: Array, look: Look, motion: Array) -> Array:
        """Where a solve begins: the last forces, and the motion."""
        if not len(start):
            return NOWHERE
        out = start.copy()
        out[-9:-3] = motion
        out[-3:] = look.reference
        return read_only(out)

    def _pressed_answer(self, look: Look, loads: Loads, start: Array, patient: bool) -> Answer | None:
        """The loaded answer nearest to contacts that all stick: friction starts high and comes down to what it is, each
        solve from the last. None where an answer opens all contacts on the way.
        """
        found = None
        for times in _FRICTION:
            answer = self._solved(look, loads, start, patient, times * self.laws.limits)
            if isinstance(answer, Failure) or all(kind == OPEN for kind in answer.kinds):
                return None
            found, start = answer, answer.start
        return found

    def _pressed(self, look: Look, loads: Loads) -> Array:
        """A start with the normal forces with which each finger alone would press on an object that is held still."""
        start, give = np.zeros(len(self.laws.scale) + 9), look.elastic.E.diagonal()[2::3]
        told = (look.elastic.J @ loads.told)[2::3]
        pushed = (look.frames[:, :, 2] * loads.give).sum(axis=1)
        squeeze = np.maximum(told - loads.base[:, 2] - pushed, 0.0)
        start[2 : 3 * len(give) : 3] = np.where(give > 0.0, squeeze / np.where(give > 0.0, give, 1.0), 0.0)
        start[-3:] = look.positions.mean(axis=0)
        return read_only(start)

    def _solved(
        self, look: Look, loads: Loads, start: Array, patient: bool, limits: Array | None = None
    ) -> Answer | Failure:
        """One solve. limits (n,) : of friction, others than the grasp's own, where no effect has rows of its own."""
        if patient or self.grasp.general:
            return self._in_stages(look, loads, start, patient)
        laws = self.laws if limits is None else self.laws._replace(limits=limits)
        write_row(self._scene[0], look.positions, look.frames, look.elastic, loads, laws)
        rows = np.empty((1, self._kind.answer_width))
        solve_scenes(read_only(self._scene.view()), self._kind.pattern, start, _CHAIN.seed, rows)
        return self._read(rows[0], look)

    def _read(self, row: Array, look: Look) -> Answer | Failure:
        """What a row says, if it is an answer."""
        found = CompiledAnswer(self._kind, row)
        if not found.passes:
            return Failure("no answer" if found.escape is None else "no balance")
        read = Read(*read_answer(found.components, found.motion, look.elastic, self.laws))
        return Answer(read, found.twist, found.centre, found.states, self._still, found.start)

    def _in_stages(self, look: Look, loads: Loads, start: Array, patient: bool) -> Answer | Failure:
        """Of a grasp with effects of its own, or with the stages of the solver that search."""
        spec = self.grasp.made(look, loads)
        scene = build(spec)
        s = solve_built(spec, scene, self.section, _CHAIN, start, patient)
        if not s.held:
            return Failure("no answer" if s.certificate is None else "no balance")
        torsion = np.zeros(scene.n) if s.torsion is None else s.torsion
        spin = np.zeros(scene.n) if s.spin is None else s.spin
        still = self._still
        joints = JointReading(still, still, still)
        if spec.mechanism is not None:
            soft = torsion if scene.soft else None
            joints = spec.mechanism.joints(scene, spec.effects, s.forces, soft, s.extra)
        motion = np.column_stack([s.slip, s.gap])
        read = Read(s.forces, motion, torsion, spin, joints.torque, joints.deflection)
        twist, centre = s.object_displacement, spec.reference
        return Answer(read, twist, centre, s.contact_state, joints.yielded, start_from(s, scene))


def _nearer(found: Answer, again: Answer | Failure, start: Array, kinds: tuple[str, ...]) -> Answer:
    """The one that changes no contact's state, else the one whose forces are nearer to those expected."""
    if isinstance(again, Failure) or again.kinds == kinds:
        return found if isinstance(again, Failure) else again
    off = [float(abs(a.start[:-9] - start[:-9]).max()) for a in (found, again)]
    return found if off[0] <= off[1] else again
