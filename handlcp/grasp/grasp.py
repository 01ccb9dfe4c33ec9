"""The grasp: contacts, load and flexibility in; certified forces, slips and motions out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, Self, overload

import numpy as np

from handlcp.check import Array, read_only, sealed
from handlcp.errors import InputError
from handlcp.grasp import arguments
from handlcp.grasp.accuracy import solve_to
from handlcp.grasp.assemble import GraspContact, GraspProblem
from handlcp.grasp.changed import changed
from handlcp.grasp.conclude import conclude, conclude_first
from handlcp.grasp.contact import Contact
from handlcp.grasp.coordinates import in_axes, law_of, padded
from handlcp.grasp.effects import Effect, FingerFlexibility, PrescribedForce, softened, stamped
from handlcp.grasp.environment import beside, environment_line, joined, offset_beside
from handlcp.grasp.explain import EffectLine, Explanation, explain
from handlcp.grasp.first import Found
from handlcp.grasp.others import Equilibria, equilibria
from handlcp.grasp.pyramid import Pyramid, Section, as_section
from handlcp.grasp.required import Required, required_friction, required_preload
from handlcp.grasp.scene import Scene, cross_rows
from handlcp.grasp.share import measured, without
from handlcp.grasp.soft_form import GraspBalls, assembled, chain_form
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.solving import solve, stage_line, stages
from handlcp.grasp.suggest import Suggestion, Suggestions, left_out, suggest
from handlcp.lcp import Auto, ContactSolver, Solver

__all__ = ["Grasp"]

_NOBODY: frozenset[int] = frozenset()


class Grasp:
    """Fingers on an object under a load. Immutable.

    Parameters
    ----------
    contacts : sequence of `Contact`, n of them; all made of 3-vectors, or all of 2-vectors (a planar scene in xy).
    wrench : (6,) force [N] and torque [N·m] about `reference` that the world applies to the object, gravity
        included; None: none. A planar scene in xy also takes (Fx, Fy, M).
    flexibility : E [m/N] in contact axes (x, y tangents, z normal): a number, a (3,) diagonal for every contact,
        (n, 3, 3) blocks or the full coupled (3n, 3n) matrix; symmetric positive semidefinite, 0 for rigid fingers.
    preload : squeeze of each normal [m], a number or (n,); short for offset[:, 2] = -preload.
    offset : (n, 3) motion of the object relative to the tips before anything is loaded [m], contact axes; along the
        normal > 0 a gap, < 0 a preload.
    reference : (3,) point [m] that wrench and object motion refer to.
    effects : effects asked for by name, such as `TotalForceBound(50.0)`; the others follow from the data. Compliances
        (`ContactCompliance`, `SoftWrist`) become part of the scene's flexibility.
    plane : (3,) unit normal of the plane of a planar scene given by 3-vectors; None: a spatial scene.
    environment : an `Environment`, or several: what the object touches besides the fingers. Its contacts come last;
        flexibility, preload and offset above are the fingers', n of them, and effects act on fingers alone where their
        docstrings say so.

    Attributes: contacts (the environment's last), effects, reference, and

    frames (n, 3, 3), offset (n, 3) : contact axes in columns, and offsets along them [m]. The `scene` is in the
        coordinates of the friction laws, which are the same axes unless a law is anisotropic.
    flexibility : (3n, 3n) E [m/N] of fingers and environment, n counting the contacts of both; that of `scene` has the
        compliances among the effects added.
    stamped : the effects without those. general : whether a solve takes the general path, because effects have rows of
        their own or contacts are soft.

    Raises InputError for anything that is not as described.
    """

    contacts: tuple[Contact, ...]
    effects: tuple[Effect, ...]
    stamped: tuple[Effect, ...]
    general: bool
    flexibility: Array
    frames: Array
    offset: Array
    reference: Array
    scene: Scene
    _spin: Array | None = None  # as `_spun`, where it is given

    def __init__(
        self,
        contacts: Iterable[Contact],
        wrench: Any = None,
        *,
        flexibility: Any = 0.0,
        preload: Any = 0.0,
        offset: Any = None,
        reference: Any = (0.0, 0.0, 0.0),
        effects: Iterable[Effect] = (),
        plane: Any = None,
        environment: Any = None,
    ) -> None:
        cs = arguments.contacts(contacts)
        k, around = len(cs), None if environment is None else joined(environment)
        if around is not None:
            cs = arguments.contacts((*cs, *around.contacts))
        positions, frames, normal = arguments.placed(plane, cs)
        point, fingers = arguments.reference(reference, normal, positions), None if around is None else k
        E, d = arguments.flexibility(flexibility, k, normal is not None), arguments.offset(offset, preload, k)
        if around is not None:
            E, d = beside(E, around.flexibility), read_only(np.concatenate([d, around.offset]))
        self._place(
            cs,
            positions,
            frames,
            arguments.wrench(wrench, normal, arguments.lift(positions, point, normal)),
            point,
            E,
            d,
            arguments.effects(effects, len(cs), None, fingers),
            normal,
            fingers,
        )

    def _place(
        self,
        contacts: tuple[Contact, ...],
        positions: Array,
        frames: Array,
        wrench: Array,
        reference: Array,
        flexibility: Array,
        offset: Array,
        effects: tuple[Effect, ...],
        plane: Array | None,
        fingers: int | None = None,
    ) -> None:
        """Take over arrays that are known to be sound (a hand's are, by construction)."""
        self.contacts, self.effects, self.reference = contacts, effects, reference
        self.flexibility, self.stamped = flexibility, stamped(effects) if effects else ()
        self.frames, self.offset = read_only(frames), offset
        prescribed = {e.contact for e in effects if isinstance(e, PrescribedForce)} if effects else _NOBODY
        governed = tuple([i not in prescribed for i in range(len(contacts))])
        moment = read_only(wrench[3:] + cross_rows(reference, wrench[:3]))
        plain = all([c.plain for c in contacts])
        law = None if plain else law_of(contacts, frames, governed, plane is not None)
        soft, E = () if law is None else law.soft, flexibility
        if soft:
            E = self._turning_too(padded(E, contacts, soft), soft, frames)
        if effects:
            E = softened(E, effects, positions, frames, plane is not None, soft)
        mu = read_only(np.array([c.mu for c in contacts]))
        self.general = bool(self.stamped or soft)
        self.scene = Scene(
            read_only(positions), self.frames, mu, E, offset, wrench[:3], moment, plane, governed, fingers
        )
        if law is not None:
            spin = None if not soft else self._spun() if self._spin is None else self._spin
            self.scene = law.applied(self.scene, spin)

    @property
    def names(self) -> tuple[str, ...]:
        """(n,) finger names: the contacts' own, or "finger 1", "finger 2", …; then the environment's."""
        return tuple(c.name or f"finger {i + 1}" for i, c in enumerate(self.contacts))

    @overload
    def problem(self, faces: int | Pyramid = 8) -> GraspProblem: ...
    @overload
    def problem(self, faces: str) -> GraspProblem | GraspContact | GraspBalls: ...
    def problem(self, faces: int | str | Pyramid = 8) -> GraspProblem | GraspContact | GraspBalls:
        """The assembled complementarity problem: look at it, or hand it to `solve_lcp`.

        faces : of the friction pyramids, ≥ 3 (inscribed), or a `Pyramid`: a (mixed) LCP with a multiplier a face; a
        planar scene is exact and ignores them. "cone": the exact cone, whose size doesn't depend on any faces.
        Raises InputError for anything else.
        """
        problem = assembled(self.scene, self._section(faces), self.effects)
        problem.complete()
        return problem

    def explain(self, faces: int | str | Pyramid = 8, measure: bool = False) -> Explanation:
        """Which effects are on and off, why, and what each costs in unknowns.

        measure : also in time: each one's share of a solve, from half a second of solves with it and without it.
        `handlcp.grasp.share` says how. No shares where the grasp has no answer; an effect that no scene is without has
        none.
        """
        section = self._section(faces)
        e = self._explained(explain(self.scene, assembled(self.scene, section, self.effects)))
        e = replace(e, effects=tuple(sorted(e.effects, key=lambda line: not line.on)))  # what is on comes first
        if not measure:
            return e
        return measured(self, e, section, self.solve(faces, Auto(search_seconds=0), throw=False))

    def solve(
        self,
        faces: int | str | Pyramid | None = None,
        solver: Solver | ContactSolver | Auto | None = None,
        throw: bool = True,
        accuracy: float | None = None,
        start: GraspSolution | None = None,
    ) -> GraspSolution:
        """Grasp forces, slips and object motion, certified.

        faces : see `problem`; None: 8, or what `accuracy` takes. solver : `Auto()` when None. accuracy : the largest
        error of the forces that will do, beside those on the exact cone, as a share of the largest force; the cheapest
        setting that keeps it is taken, and the solution's `accuracy` says which and what error it estimates.
        start : the solution of a nearby grasp of as many contacts; from there it takes one or two Newton steps. Where
        friction allows several equilibria, it also says which one to look for.
        Raises NoSolutionFound (with problem and solution) unless SOLVED, or returns what came when `throw` is False;
        InputError for bad arguments, faces and accuracy both among them.
        """
        where = arguments.start(start, self.scene.n)
        if accuracy is not None:
            if faces is not None:
                raise InputError("accuracy", "no faces beside it: it chooses them", f"faces={faces!r}")
            return solve_to(self, accuracy, solver, throw, start)
        section = self._section(8 if faces is None else faces)
        return solve(self, section, solver, throw, where)

    def replace(self, *, wrench: Any = None, flexibility: Any = None, offset: Any = None, preload: Any = None) -> Self:
        """The same grasp with other numbers; None: as they are.

        wrench : the whole load about `reference`, weight included. flexibility : of the fingers; compliances among the
        effects stay. offset, preload : together they replace the offset, and a preload alone is that of tips without
        offset. All as in `Grasp`, the fingers'; an offset with a row for every contact also moves the environment.
        Raises InputError.
        """
        scene, n = self.scene, self.scene.n - self.scene.environment
        changes: dict[str, Array] = {}
        if wrench is not None:
            lift = arguments.lift(scene.positions, self.reference, scene.plane)
            changes["wrench"] = arguments.wrench(wrench, scene.plane, lift)
        if flexibility is not None:
            E = arguments.flexibility(flexibility, n, scene.plane is not None)
            changes["flexibility"] = beside(E, self.flexibility[3 * n :, 3 * n :]) if scene.environment else E
        if offset is not None or preload is not None:
            squeeze = 0.0 if preload is None else preload
            changes["offset"] = self._shifted(
                offset_beside(offset, squeeze, n, self.offset[n:])
                if scene.environment
                else arguments.offset(offset, squeeze, n)
            )
        return changed(self, **changes)

    def suggest(
        self, solution: GraspSolution | None = None, faces: int | str | Pyramid = 8, least: float = 0.05
    ) -> Suggestions:
        """Which effects that are left out would change the answer by more than `least` of its largest force: the exact
        cone, and of a hand its torque limits, its fingers' weight and geometric stiffness, each evaluated once.

        solution : of this grasp, solved with `faces`; None: solved now. Raises InputError, NoSolutionFound.
        """
        return suggest(self, solution, faces, least)

    def plan(self, faces: int | str | Pyramid = 8, chain: Auto | None = None) -> tuple[str, ...]:
        """The stages that `solve` would run, in order, until one answer is certified; see `Auto.plan`."""
        return (chain or Auto()).plan(chain_form(self.scene, self._section(faces), self.effects))

    def required_preload(self, faces: int | str | Pyramid = 8, tolerance: float = 1e-3) -> Required:
        """The smallest squeeze [m], added to every finger, with which the grasp holds, to a relative tolerance."""
        return required_preload(self, self._section(faces), tolerance, check=self._test(faces))

    def required_friction(self, faces: int | str | Pyramid = 8, tolerance: float = 1e-3) -> Required:
        """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds."""
        return required_friction(self, self._section(faces), tolerance, check=self._test(faces))

    def equilibria(self, faces: int | str | Pyramid = 8, seconds: float = 2.0) -> Equilibria:
        """All equilibria that `seconds` are enough for, certified, and whether it is proven that there are no more.

        faces : see `problem`. Friction can hold an object in several ways under one load; `solve` returns one of them.
        """
        return equilibria(self, faces, seconds)

    def _section(self, faces: int | str | Pyramid) -> Section:
        return as_section(faces, planar=self.scene.plane is not None)

    def _solution(self, *parts: Any) -> GraspSolution:
        return self._complete(conclude(self.scene, self.reference, self.names, *parts))

    def _answered(self, section: Section, found: Found) -> GraspSolution:
        """The solution from an answer of the first stage that passes."""
        trace = (stage_line("NSNGRK", found.proposal, found.residuals.worst),)
        if found.unique:
            return self._complete(conclude_first(self.scene, self.reference, self.names, found, trace))
        effects = found.kind.design.effects
        return self._solution(effects, section, found.candidate, found.verdict, found.iterations, trace)

    def _left_out(self, solution: GraspSolution, faces: int | str | Pyramid) -> Iterator[Suggestion]:
        """What could be suggested."""
        return left_out(self, solution, faces)

    def _spun(self) -> Array | None:
        """(k,) how far the object has turned on the soft fingertips before any load [rad]; None: not at all."""
        return None

    def _turning_too(self, flexibility: Array, soft: tuple[int, ...], frames: Array) -> Array:
        """(c, c) with what turns the fingertips of soft contacts besides their pads: nothing here."""
        return flexibility

    def _in_stages(
        self, section: Section, solver: Solver | ContactSolver | Auto | None, throw: bool, start: Array
    ) -> GraspSolution:
        """What `solve` does with effects asked for by name."""
        return stages(self, section, solver, throw, start)

    def _answering(self, solution: GraspSolution) -> Grasp:
        """The grasp whose numbers a solution of this one answers, where they depend on it."""
        return self

    def _test(self, faces: int | str | Pyramid) -> Callable[[Grasp], bool] | None:
        """Whether such a grasp holds, where one problem doesn't say it."""
        return None

    def _shifted(self, offset: Array) -> Array:
        """The scene's offset from one that was asked for: what a hand adds to it is nothing here."""
        return offset

    def _explained(self, explanation: Explanation) -> Explanation:
        """With the environment; a hand adds its own."""
        own = (self._own_flexibility(line) for line in explanation.effects)
        around = environment_line(self.scene, self.names, self.flexibility)
        return replace(explanation, effects=(*own, around))

    def _own_flexibility(self, line: EffectLine) -> EffectLine:
        """That of fingers is told apart from what compliances asked for add to E."""
        if line.title != FingerFlexibility.title or not line.on:
            return line
        k = 3 * (self.scene.n - self.scene.environment)
        own = self.flexibility[:k, :k]
        if not own.any():
            return replace(line, on=False, why="E of the fingers is zero: rigid fingers", unknowns=())
        return replace(line, why=f"E is not zero (mean {own.trace() / k:.3g} m/N)")

    def _without(self) -> list[tuple[str, Grasp]]:
        """(title, the grasp without it) for each effect that can be left out."""
        return list(without(self))

    def _fingers_alone(self) -> Self:
        """Without the environment."""
        s, k = self.scene, self.scene.n - self.scene.environment
        parts = {"contacts": self.contacts[:k], "positions": s.positions[:k], "frames": self.frames[:k]}
        E = read_only(self.flexibility[: 3 * k, : 3 * k].copy())
        return changed(self, **parts, flexibility=E, offset=self.offset[:k], fingers=None)

    def _placed(self) -> Self:
        """Made anew from its numbers."""
        return changed(self)

    def _complete(self, solution: GraspSolution) -> GraspSolution:
        """In contact axes; and what a hand adds to it: nothing here."""
        return solution if self.scene.scale is None else in_axes(solution)

    def __copy__(self) -> Self:
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__)
        return made

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(sealed(state))

    def __repr__(self) -> str:
        s = self.scene
        planar = ", planar" if s.plane is not None else ""
        planar += f", {s.environment} of the environment" if s.environment else ""
        return f"{type(self).__name__}({s.n} contacts, {len(s.rough) + len(s.soft)} with friction{planar})"
