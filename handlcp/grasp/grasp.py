"""The grasp: contacts, load and flexibility in; certified forces, slips and motions out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import NoSolutionFound
from handlcp.grasp import arguments
from handlcp.grasp.assemble import Candidate, GraspProblem, assemble
from handlcp.grasp.catalogue import called_for
from handlcp.grasp.certify import Verdict, judge
from handlcp.grasp.contact import Contact
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.explain import Explanation, explain
from handlcp.grasp.holdable import escaping_twist
from handlcp.grasp.pyramid import Pyramid, as_pyramid
from handlcp.grasp.scene import Scene, cross_rows
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.states import classify
from handlcp.grasp.tangent import free_branches
from handlcp.grasp.uniqueness import Uniqueness, describe, minimum_norm
from handlcp.lcp import Auto, Solver, Status, proposals

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
        point = array("reference", reference, (3,), *(() if normal is None else ((2,),)))
        point = point if point.shape == (3,) else read_only(np.append(point, 0.0))
        self._place(
            cs,
            positions,
            frames,
            arguments.wrench(wrench, normal),
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

    def problem(self, faces: int | str | Pyramid = 8) -> GraspProblem:
        """The assembled complementarity problem: look at it, or hand it to `solve_lcp`.

        faces : of the friction pyramids, ≥ 3 (inscribed), or a `Pyramid`; a planar scene is exact and ignores them.
        Raises InputError for fewer faces, Unsupported for the exact cone.
        """
        return assemble(self.scene, called_for(self.scene, as_pyramid(faces), self.effects))

    def explain(self, faces: int | str | Pyramid = 8) -> Explanation:
        """Which effects are on and off, why, and what each costs in unknowns."""
        return explain(self.scene, self.problem(faces), self.effects)

    def solve(
        self, faces: int | str | Pyramid = 8, solver: Solver | Auto | None = None, throw: bool = True
    ) -> GraspSolution:
        """Grasp forces, slips and object motion, certified.

        faces : see `problem`. solver : `Auto()` when None. Raises NoSolutionFound (with problem and solution) unless
        SOLVED, or returns what came when `throw` is False; InputError for bad arguments.
        """
        pyramid = as_pyramid(faces)
        problem = assemble(self.scene, called_for(self.scene, pyramid, self.effects))
        trace: list[str] = []
        best: tuple[Candidate, Verdict, int] | None = None
        for name, proposal in proposals(problem, solver):
            candidate = problem.candidate(proposal.z)
            verdict = judge(self.scene, problem.effects, pyramid, candidate)
            worst = verdict.residuals.worst
            trace.append(f"{name}: {proposal.outcome}, {proposal.iterations} iterations, residual {worst:.1e}")
            if best is None or worst < best[1].residuals.worst:
                best = candidate, verdict, proposal.iterations
            if verdict.residuals.passes:
                break
        assert best is not None  # every solver proposes something
        solution = self._solution(problem, pyramid, *best, tuple(trace))
        if throw and not solution.held:
            raise NoSolutionFound("\n  ".join((str(solution), *trace)), problem, solution)
        return solution

    def _solution(
        self,
        problem: GraspProblem,
        pyramid: Pyramid,
        candidate: Candidate,
        verdict: Verdict,
        iterations: int,
        trace: tuple[str, ...],
    ) -> GraspSolution:
        scene = self.scene
        shift = _shift(self.reference - scene.units.centre)
        uniqueness: Uniqueness | None = None
        certificate: Array | None = None
        if verdict.residuals.passes:
            status = Status.SOLVED
            states = classify(scene, pyramid, candidate.forces, verdict.motion, verdict.residuals)
            free = free_branches(scene, problem.effects, pyramid, states, candidate)
            if free:
                smallest = minimum_norm(scene, pyramid, states, candidate, verdict.motion, free)
                if (checked := judge(scene, problem.effects, pyramid, smallest)).residuals.passes:
                    candidate, verdict = smallest, checked
                    states = classify(scene, pyramid, candidate.forces, verdict.motion, verdict.residuals)
            uniqueness = describe(scene, free, shift)
            names = states.names
        else:
            status, names = Status.UNDECIDED, ("unknown",) * scene.n
            if (twist := escaping_twist(scene, pyramid, _load(problem, scene))) is not None:
                status, certificate = Status.NOT_HOLDABLE, read_only(shift @ twist)
                nothing = np.full((scene.n, 3), np.nan)  # so that nobody uses them by accident
                candidate = Candidate(nothing, np.full(6, np.nan), {})
                verdict = Verdict(nothing, verdict.residuals)
        forces = candidate.forces
        # A finger under force control follows the object: no law makes it keep a gap or a slip
        motion = np.where(scene.governed_mask[:, None], verdict.motion, 0.0)
        return GraspSolution(
            status,
            self.names,
            read_only(forces),
            read_only((scene.frames @ forces[:, :, None])[:, :, 0]),
            read_only(motion[:, 2]),
            read_only(motion[:, :2]),
            read_only(shift @ candidate.twist),
            names,
            verdict.residuals,
            uniqueness,
            certificate,
            iterations,
            trace,
            candidate.extra,
        )

    def __repr__(self) -> str:
        s = self.scene
        planar = ", planar" if s.plane is not None else ""
        return f"{type(self).__name__}({s.n} contacts, {len(s.rough)} with friction{planar})"


def _load(problem: GraspProblem, scene: Scene) -> Array:
    """(dof,) natural wrench that the governed contacts must balance: the load and prescribed forces."""
    load = scene.natural.w.copy()
    for e in problem.effects:
        if isinstance(e, PrescribedForce):
            load += scene.natural.every[:, 3 * e.contact : 3 * e.contact + 3] @ (e.force / scene.units.force)
    return load


def _shift(arm: Array) -> Array:
    """(6, 6) that moves a small twist to a point `arm` away: u' = u + ω × arm."""
    x, y, z = arm.tolist()
    return np.array(
        [
            [1, 0, 0, 0, z, -y],
            [0, 1, 0, -z, 0, x],
            [0, 0, 1, y, -x, 0],
            [0, 0, 0, 1, 0, 0],
            [0, 0, 0, 0, 1, 0],
            [0, 0, 0, 0, 0, 1],
        ],
        dtype=float,
    )
