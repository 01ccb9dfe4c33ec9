"""The grasp: contacts, load and flexibility in; certified forces, slips and motions out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, overload

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import NoSolutionFound
from handlcp.grasp import arguments
from handlcp.grasp.assemble import GraspContact, GraspProblem, assemble, assemble_contact
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.catalogue import called_for
from handlcp.grasp.certify import Verdict, judge
from handlcp.grasp.conclude import conclude
from handlcp.grasp.contact import Contact
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.explain import Explanation, explain
from handlcp.grasp.last_resort import last_resort
from handlcp.grasp.others import Equilibria, equilibria
from handlcp.grasp.pyramid import Cone, Pyramid, Section, as_section
from handlcp.grasp.required import Required, required_friction, required_preload
from handlcp.grasp.scene import Scene, cross_rows
from handlcp.grasp.solution import GraspSolution
from handlcp.lcp import Auto, ContactSolver, Solver, Status, as_chain, proposals

__all__ = ["Grasp"]


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
    effects : effects asked for by name, such as `TotalForceBound(50.0)`; the others follow from the data.
    plane : (3,) unit normal of the plane of a planar scene given by 3-vectors; None: a spatial scene.

    Raises InputError for anything that is not as described.
    """

    contacts: tuple[Contact, ...]
    effects: tuple[Effect, ...]
    reference: Array
    scene: Scene

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
    ) -> None:
        cs = arguments.contacts(contacts)
        positions = np.array([c.position for c in cs])
        frames = np.array([c.rotation for c in cs])
        normal = arguments.plane(plane, cs, positions, frames)
        if normal is not None:
            frames = arguments.in_plane(frames, normal)
        point = arguments.reference(reference, normal, positions)
        self._place(
            cs,
            positions,
            frames,
            arguments.wrench(wrench, normal, arguments.lift(positions, point, normal)),
            point,
            arguments.flexibility(flexibility, len(cs), normal is not None),
            arguments.offset(offset, preload, len(cs)),
            arguments.effects(effects, len(cs)),
            normal,
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
    ) -> None:
        """Take over arrays that are known to be sound (a hand's are, by construction)."""
        self.contacts, self.effects, self.reference = contacts, effects, reference
        prescribed = {e.contact for e in effects if isinstance(e, PrescribedForce)}
        moment = wrench[3:] + cross_rows(reference, wrench[:3])
        mu = np.array([c.mu for c in contacts])
        self.scene = Scene(
            read_only(positions),
            read_only(frames),
            mu,
            flexibility,
            offset,
            wrench[:3],
            moment,
            plane,
            tuple(i not in prescribed for i in range(len(contacts))),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """(n,) finger names: the contacts' own, or "finger 1", "finger 2", …"""
        return tuple(c.name or f"finger {i + 1}" for i, c in enumerate(self.contacts))

    @overload
    def problem(self, faces: int | Pyramid = 8) -> GraspProblem: ...
    @overload
    def problem(self, faces: str) -> GraspProblem | GraspContact: ...
    def problem(self, faces: int | str | Pyramid = 8) -> GraspProblem | GraspContact:
        """The assembled complementarity problem: look at it, or hand it to `solve_lcp`.

        faces : of the friction pyramids, ≥ 3 (inscribed), or a `Pyramid`: a (mixed) LCP with a multiplier a face; a
        planar scene is exact and ignores them. "cone": the exact cone, whose size doesn't depend on any faces.
        Raises InputError for anything else.
        """
        problem = self._problem(self._section(faces))
        problem.complete()
        return problem

    def _problem(self, section: Section) -> GraspProblem | GraspContact:
        if isinstance(section, Cone):
            return assemble_contact(self.scene, section, self.effects)
        return assemble(self.scene, called_for(self.scene, section, self.effects, multipliers=True))

    def explain(self, faces: int | str | Pyramid = 8) -> Explanation:
        """Which effects are on and off, why, and what each costs in unknowns."""
        return explain(self.scene, self._problem(self._section(faces)))

    def solve(
        self, faces: int | str | Pyramid = 8, solver: Solver | ContactSolver | Auto | None = None, throw: bool = True
    ) -> GraspSolution:
        """Grasp forces, slips and object motion, certified.

        faces : see `problem`. solver : `Auto()` when None. Raises NoSolutionFound (with problem and solution) unless
        SOLVED, or returns what came when `throw` is False; InputError for bad arguments.
        """
        section = self._section(faces)
        problem: GraspProblem | GraspContact
        if solver is None or isinstance(solver, Auto):
            # The chain works on friction as a set, whatever the section: pyramids cost no more than the cone
            problem = assemble_contact(self.scene, section, self.effects)
        else:
            problem = self._problem(section)
        trace: list[str] = []
        best: tuple[Candidate, Verdict, int] | None = None
        for name, proposal in proposals(problem, solver):
            candidate = problem.candidate(proposal.z)
            verdict = judge(self.scene, problem.effects, section, candidate)
            worst = verdict.residuals.worst
            trace.append(f"{name}: {proposal.outcome}, {proposal.iterations} iterations, residual {worst:.1e}")
            if best is None or worst < best[1].residuals.worst:
                best = candidate, verdict, proposal.iterations
            if verdict.residuals.passes:
                break
        assert best is not None  # every solver proposes something
        solution = self._solution(problem.effects, section, *best, tuple(trace))
        if not solution.held:
            escapes = "nothing holds it" if solution.certificate is not None else "no proof that nothing holds it"
            solution = replace(solution, trace=(*trace, f"holdability: {escapes}"))
        if solution.status is Status.UNDECIDED and (chain := as_chain(solver)) is not None and chain.search_seconds > 0:
            solution = self._search(problem, section, chain, solution, best[1])
        if throw and not solution.held:
            raise NoSolutionFound("\n  ".join((str(solution), *solution.trace)), problem, solution)
        return solution

    def _search(
        self,
        problem: GraspProblem | GraspContact,
        section: Section,
        chain: Auto,
        solution: GraspSolution,
        verdict: Verdict,
    ) -> GraspSolution:
        """The chain's last stage: an exact search, and for a proven "no" the squeeze that would help."""
        candidate, bounds, words = last_resort(problem, section, chain.search_seconds)
        trace = (*solution.trace, f"{chain.search_stage}: {words}")
        if candidate is not None:
            verdict = judge(self.scene, problem.effects, section, candidate)
            return self._solution(problem.effects, section, candidate, verdict, solution.iterations, trace)
        if bounds is None:
            return replace(solution, trace=trace)
        squeeze = required_preload(self, section).value
        return replace(solution, status=Status.NO_EQUILIBRIUM, bounds=bounds, required_preload=squeeze, trace=trace)

    def plan(self, faces: int | str | Pyramid = 8, chain: Auto | None = None) -> tuple[str, ...]:
        """The stages that `solve` would run, in order, until one answer is certified; see `Auto.plan`."""
        return (chain or Auto()).plan(assemble_contact(self.scene, self._section(faces), self.effects))

    def required_preload(self, faces: int | str | Pyramid = 8, tolerance: float = 1e-3) -> Required:
        """The smallest squeeze [m], added to every contact, with which the grasp holds, to a relative tolerance."""
        return required_preload(self, self._section(faces), tolerance)

    def required_friction(self, faces: int | str | Pyramid = 8, tolerance: float = 1e-3) -> Required:
        """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds."""
        return required_friction(self, self._section(faces), tolerance)

    def equilibria(self, faces: int | str | Pyramid = 8, seconds: float = 2.0) -> Equilibria:
        """All equilibria that `seconds` are enough for, certified, and whether it is proven that there are no more.

        faces : see `problem`. Friction can hold an object in several ways under one load; `solve` returns one of them.
        """
        return equilibria(self, faces, seconds)

    def _section(self, faces: int | str | Pyramid) -> Section:
        return as_section(faces, planar=self.scene.plane is not None)

    def _solution(self, *parts: Any) -> GraspSolution:
        return conclude(self.scene, self.reference, self.names, *parts)

    def __repr__(self) -> str:
        s = self.scene
        planar = ", planar" if s.plane is not None else ""
        return f"{type(self).__name__}({s.n} contacts, {len(s.rough)} with friction{planar})"
