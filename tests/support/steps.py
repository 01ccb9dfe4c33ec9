"""A solve step by step, for those who time its parts: the one call of the first stage, and the same from Python."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.check import read_only
from handlcp.grasp.analysis.explanation import measure_shares
from handlcp.grasp.assembly.problem import GraspContactProblem, GraspProblem, assemble, friction_sets, problem_design
from handlcp.grasp.effects.contact_mechanics import CoulombFriction, FingerFlexibility, ObjectBalance, UnilateralContact
from handlcp.grasp.model.equation_system import EquationSystem
from handlcp.grasp.solve import (
    compiled_answer as _first,  # its kernels are looked up there, where a clock may have been put around them
)
from handlcp.grasp.solve.compiled_solve import write_row
from handlcp.grasp.solve.solve_spec import CertifiedCandidate, conclude_first_stage, make_solution
from handlcp.lcp import NSNGRK, ContactProblem, Units, certify, proposals
from handlcp.lcp.certificate import certify_contact
from tests.support.grasp import arrays, contact_problem, judge_of, section_of


class OneCall:
    """The first stage of `grasp.solve`, part by part: a row of numbers in, a row of numbers out."""

    def __init__(self, grasp: hl.Grasp, faces: Any) -> None:
        """Effects and layout, known from an earlier scene of the kind."""
        self.grasp, self.section = grasp, section_of(grasp, faces)
        self.kind = _first.get_compiled_kind(grasp.scene, self.section)
        self.numbers, self.row = np.empty((1, self.kind.scene_width)), np.empty((1, self.kind.answer_width))
        self.given = read_only(self.numbers.view())

    @property
    def unknowns(self) -> int:
        """Of the problem that is solved."""
        return self.kind.design.layout.size

    def pack(self) -> None:
        """The scene as a row of numbers."""
        write_row(self.grasp.scene, self.section, self.numbers[0])

    def answer(self) -> None:
        """Units, stamps, solver, certificate, states: one compiled call."""
        _first.solve_scenes(self.given, self.kind.pattern, _first.NO_START, 0, self.row)

    def read(self) -> Any:
        """What came out, as a row that nobody writes to any more."""
        found = _first.CompiledAnswer(self.kind, self.row[0].copy())
        assert found.passes
        return found

    def conclude(self, found: Any) -> hl.GraspSolution:
        """The answer in SI, torques, limits."""
        return conclude_first_stage(self.grasp.spec, self.grasp.scene, self.section, found)


class ByHand:
    """The same from Python: every step leaves here what the next one takes."""

    def __init__(self, grasp: hl.Grasp, faces: Any) -> None:
        self.grasp, self.faces, self.section = grasp, faces, section_of(grasp, faces)

    def units(self) -> None:
        """Natural units and blocks of the scene, computed when first asked for."""
        arrays(self.grasp).units  # noqa: B018

    def assemble(self) -> None:
        """Effects stamped."""
        self.problem = contact_problem(self.grasp, self.faces, ())

    def scale(self) -> None:
        """Rows scaled."""
        self.problem.packed_arrays  # noqa: B018

    def solve(self, seed: int | None = None) -> Any:
        """What NSNGRK proposes; as the first stage does it where a seed is given, as the chain does it elsewhere."""
        if seed is None:
            _, self.proposal = next(proposals(self.problem))
        else:
            self.proposal = NSNGRK(max_iterations=self.problem.n, seed=seed).propose_contact(self.problem)
        return self.proposal

    def decode(self) -> Any:
        """Forces and motion."""
        self.candidate = self.problem.candidate(self.proposal.z)
        return self.candidate

    def certify(self) -> Any:
        """The certifier's verdict, from the physics."""
        self.verdict = judge_of(self.grasp, self.problem.effects, self.section, self.candidate)
        return self.verdict

    def conclude(self) -> hl.GraspSolution:
        """States, uniqueness, the answer in SI, without what a hand adds to it."""
        g = self.grasp
        return self._made(g.spec.replace(mechanism=None))

    def finish(self) -> hl.GraspSolution:
        """The same with what a hand adds."""
        return self._made(self.grasp.spec)

    def _made(self, spec: Any) -> hl.GraspSolution:
        judged = CertifiedCandidate(self.candidate, self.verdict, 1)
        return make_solution(spec, self.grasp.scene, self.section, self.problem.effects, judged, ())


def first_found(grasp: hl.Grasp, faces: Any, seed: int = 0) -> Any:
    """What the first stage finds: proposal, forces, twist, motion, residuals, states, passes, unique, outcome."""
    return told(_first.solve_scene(grasp.scene, section_of(grasp, faces), seed))


def told(found: Any) -> Any:
    """What a compiled answer says, by these names."""
    return SimpleNamespace(
        proposal=found.proposal, outcome=found.proposal.outcome, iterations=found.iterations,
        forces=found.candidate.forces, twist=found.twist, motion=found.motion, residuals=found.residuals,
        states=found.states, passes=found.passes, unique=found.is_unique, escape=found.escape,
    )  # fmt: skip


def newton_steps(line: str) -> int:
    """How many Newton steps a line of a trace tells of."""
    told = re.search(r"(\d+) Newton steps", line)
    return 0 if told is None else int(told[1])


# ---------------------------------------------------------------- assembly
def assembly(grasp: hl.Grasp, faces: Any) -> Any:
    """The problem of a grasp with the effects that its data call for."""
    return assemble(grasp.scene, section_of(grasp, faces), ())


class _FourEffects(GraspContactProblem):
    """The problem of a scene of hard fingers, its four effects listed here."""

    def __init__(self, scene: Any, section: Any) -> None:
        known = problem_design(scene, section, ())
        system = EquationSystem(known.layout)
        effects = (ObjectBalance(), UnilateralContact(), CoulombFriction(section), FingerFlexibility())
        for effect in effects:
            effect.stamp(scene, system)
        sets, units = friction_sets(scene, section), Units(*system.sizes(scene))
        ContactProblem.__init__(self, system.M, system.q, known.pattern, sets, units)
        self.scene, self.section, self.requested_effects, self.effects, self.system = (
            scene,
            section,
            (),
            effects,
            system,
        )


def assembly_by_hand(grasp: hl.Grasp, faces: Any) -> Any:
    """The same with the four effects that a scene of hard fingers needs listed: no catalogue, none asked for."""
    return GraspProblem(_FourEffects(grasp.scene, section_of(grasp, faces)))


def certificate(problem: Any, z: np.ndarray, proposed: np.ndarray | None = None) -> Any:
    """The certifier's word, from M and q: on z in SI, or on what was proposed for a problem with friction as a set."""
    return certify(problem, z) if proposed is None else certify_contact(problem, proposed)


# ---------------------------------------------------------------- shares of the time
def shares(grasp: hl.Grasp, faces: Any, solution: hl.GraspSolution, clock: Any) -> Any:
    """`grasp.explain(faces, measure=True)` with times from a clock."""
    return measure_shares(grasp.spec, section_of(grasp, faces), grasp.explain(faces), solution, clock)
