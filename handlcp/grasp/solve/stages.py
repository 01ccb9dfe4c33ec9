"""A grasp through the stages of its solver, until the certifier is content."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.make_solution import (
    Judged,
    certificate_of,
    make_solution,
    not_holdable,
    solution_of,
    without_numbers,
)
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.uniqueness import describe
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem, stamped
from handlcp.grasp.assembly.problem import AnyProblem, assemble
from handlcp.grasp.friction import Section
from handlcp.grasp.model.kind import MANY, shifted
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE, CompiledAnswer, solve_scene
from handlcp.grasp.verify.contact_laws import in_world
from handlcp.grasp.verify.judge import Verdict, judge
from handlcp.lcp import BRIEFLY, FIRST_STAGE, LONGER, SOON, Auto, Proposal, Status, as_chain, proposals, stage_line
from handlcp.lcp.solve import AnySolver

if TYPE_CHECKING:
    from handlcp.grasp.search.nonexistence import EquilibriumSearch, Outcome


# ----------------------------------------------------------------
# The solution that a row of numbers stands for, its fields made when they are asked for.


def lazy_solution(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """SOLVED, from an answer that passes and leaves nothing free, of a scene without soft or anisotropic contacts."""
    kind: type[GraspSolution] = GraspSolution if spec.mechanism is None else spec.mechanism.solution
    return kind.deferred(
        _Fields(spec, scene, found), status=Status.SOLVED, certificate=None, extra={}, yielding={}, scene=scene,
        reference=spec.reference, spec=spec, section=section,
    )  # fmt: skip


def trace_of(found: CompiledAnswer) -> tuple[str, ...]:
    """The one line of the one stage."""
    return (stage_line(FIRST_STAGE, found.outcome, found.iterations, found.residuals.worst),)


class _Fields:
    """Makes fields of a solution by name."""

    __slots__ = ("found", "scene", "spec")

    def __init__(self, spec: GraspSpec, scene: Scene, found: CompiledAnswer) -> None:
        self.spec, self.scene, self.found = spec, scene, found

    def __call__(self, name: str) -> dict[str, Any]:
        made = _MADE.get(name)
        return self.joints(name) if made is None else {name: made(self)}

    @property
    def forces(self) -> Array:
        """(n, 3)."""
        return self.found.components.reshape(-1, 3)

    @property
    def arm(self) -> Array:
        """(3,) from the point that the answer's twist refers to to the grasp's reference [m]."""
        return self.spec.reference - self.found.centre

    def joints(self, name: str) -> dict[str, Any]:
        """What the mechanism adds; torques are asked for most, and often alone."""
        mechanism, effects = self.spec.mechanism, self.spec.effects
        assert mechanism is not None  # only its solutions have more fields
        if name == "torques" and not effects:
            return {name: mechanism.torques(self.scene, self.forces)}
        return mechanism.read(self.scene, effects, self.forces, None, {})


_MADE: dict[str, Callable[[_Fields], Any]] = {
    "names": lambda f: f.spec.names,
    "forces": lambda f: f.forces,
    "forces_world": lambda f: read_only(in_world(f.scene.frames, f.found.components)),
    "gap": lambda f: f.found.motion[2::3],
    "slip": lambda f: f.found.motion.reshape(-1, 3)[:, :2],
    "object_displacement": lambda f: read_only(shifted(f.found.twist, f.arm)),
    "contact_state": lambda f: f.found.states,
    "residuals": lambda f: f.found.residuals,
    "uniqueness": lambda f: describe(f.scene, (), f.arm),
    "iterations": lambda f: f.found.iterations,
    "trace": lambda f: trace_of(f.found),
}


# ----------------------------------------------------------------

# Multiply-adds of the first search, milliseconds, and of the second one, hundredths of a second. What the first leaves
# open is more often an answer that Lemke's method finds at once than one that is not there
BRIEF, _LONG = 1e6, 2e7
_PROOF, _NO_PROOF = "nothing holds it", "no proof that nothing holds it"


def solve_built(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver = None, start: Array = NOWHERE,
    proof: bool = True, first: CompiledAnswer | None = None,
) -> GraspSolution:  # fmt: skip
    """Forces, slips and motion of `build(spec)`; start as in `compiled_answer.start_from`, proof as in `Grasp.solve`.

    first : what the compiled first stage came to, where that is known.

    The first stage of a scene whose effects follow from its data is one compiled call, and for most scenes there is no
    other.
    """
    chain, asked = as_chain(solver), stamped(spec.effects) if spec.effects else ()
    if chain is None or asked:
        return _in_stages(spec, scene, section, solver, start, None, proof)
    found = solve_scene(scene, section, chain.seed, start) if first is None else first
    if found.passes or found.escape is not None or not proof:
        return answered(spec, scene, section, found)
    return _in_stages(spec, scene, section, solver, start, found.proposal, proof)


def answered(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """The solution that the first stage comes to by itself: what it found, or the proof that nothing holds."""
    if not found.passes:
        return _refused(spec, scene, section, found)
    if found.unique and scene.scale is None and scene.prescribed is None and not scene.soft:
        return lazy_solution(spec, scene, section, found)
    judged = Judged(found.candidate, Verdict(found.motion, found.residuals), found.iterations)
    if not found.unique:
        return make_solution(spec, scene, section, found.kind.design.effects, judged, trace_of(found))
    arm = spec.reference - found.centre
    return solution_of(spec, scene, section, judged, found.states, describe(scene, (), arm), trace_of(found), arm)


def _refused(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """NOT_HOLDABLE where that is proven, else UNDECIDED."""
    from handlcp.grasp.verify.holdable import escape_of

    escape = found.escape
    trace = (*trace_of(found), f"holdability: {_NO_PROOF if escape is None else _PROOF}")
    made = without_numbers(spec, scene, section, found.residuals, found.iterations, trace)
    return made if escape is None else not_holdable(made, spec, scene, escape_of(scene, escape))


def _in_stages(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver, start: Array, first: Proposal | None,
    proof: bool,
) -> GraspSolution:  # fmt: skip
    """One stage after the other; `first` is the first one's proposal, where that is known."""
    from handlcp.grasp.search.nonexistence import EquilibriumSearch

    chain = as_chain(solver)
    # The chain works on friction as a set, whatever the section: pyramids cost no more than the cone
    problem = (assemble if chain is None else GraspContactProblem)(scene, section, stamped(spec.effects))
    begin: Array | None = None
    if len(start):
        twist = shifted(start[-9:-3], scene.units.centre - start[-3:])
        begin = problem.natural(Candidate(start[:-9], twist, {}, len(scene.soft)))
    run = _Run(spec, problem)
    stages = proposals(problem, solver, begin, first)
    if run.solved(itertools.islice(stages, 1)) or run.escapes() or chain is None or not proof:
        return run.solution()
    assert isinstance(problem, GraspContactProblem)  # chains work on friction as a set
    if not chain.searches:
        run.solved(stages)
        return run.solution()
    search = EquilibriumSearch(problem)
    # Each search goes on where the one before it stopped; then come so many of the stages that look for an answer
    for name, work, then in ((BRIEFLY, BRIEF, SOON), (LONGER, _LONG, None), (chain.search_stage, np.inf, 0)):
        begun = search.brief or name == chain.search_stage
        if begun and run.searched(search, chain, min(work, chain.search_work * _larger(scene)), name):
            break
        if run.solved(itertools.islice(stages, then)):
            break
    return run.solution()


def _larger(scene: Scene) -> float:
    """How much more work a search may take with many contacts: one fit of all of them grows with their cube."""
    return (scene.n / MANY) ** 3 if scene.kind.many else 1.0


def certified(spec: GraspSpec, scene: Scene, section: Section, candidate: Candidate, name: str) -> GraspSolution:
    """The solution that a known answer is, if the certifier agrees, with its own forces and motion where others satisfy
    the same conditions, too. name : of where it is from, for the trace.
    """
    problem = GraspContactProblem(scene, section, stamped(spec.effects))
    run = _Run(spec, problem)
    run.solved([(name, Proposal(problem.natural(candidate), 0, "known"))])
    return run.solution(smallest=False)


class _Run:
    """The stages of one solve so far: what they found, what is proven, and a line of each."""

    def __init__(self, spec: GraspSpec, problem: AnyProblem) -> None:
        self.spec, self.problem, self.scene = spec, problem, problem.scene
        self.trace: list[str] = []
        self.best: Judged | None = None
        self.escape: Array | None = None
        self.proof: Outcome | None = None

    def solved(self, stages: Iterable[tuple[str, Proposal]]) -> bool:
        """Whether one of these stages leads to an answer."""
        for name, proposal in stages:
            judged = self._judged(self.problem.candidate(proposal.z), proposal.iterations)
            worst = judged.verdict.residuals.worst
            self.trace.append(stage_line(name, proposal.outcome, proposal.iterations, worst))
            if self.best is None or worst < self.best.verdict.residuals.worst:
                self.best = judged
            if judged.verdict.residuals.passes:
                return True
        return False

    def escapes(self) -> bool:
        """Whether it is proven that nothing holds the object."""
        from handlcp.grasp.verify.holdable import escaping_twist

        self.escape = escaping_twist(self.scene, self.problem.section)
        self.trace.append(f"holdability: {_NO_PROOF if self.escape is None else _PROOF}")
        return self.escape is not None

    def searched(self, search: EquilibriumSearch, chain: Auto, work: float, name: str) -> bool:
        """Whether the search decides within its budget."""
        found = search.run(work, chain.search_end())
        self.trace.append(f"{name}: {found.words}")
        if found.candidate is not None:
            self.best = self._judged(found.candidate, 0 if self.best is None else self.best.iterations)
        elif found.bounds is not None:
            self.proof = found
        return found.candidate is not None or found.bounds is not None

    def _judged(self, candidate: Candidate, iterations: int) -> Judged:
        verdict = judge(self.scene, self.problem.effects, self.problem.section, candidate)
        return Judged(candidate, verdict, iterations)

    def solution(self, smallest: bool = True) -> GraspSolution:
        """What all this comes to. smallest : as in `make_solution`."""
        assert self.best is not None  # every solver proposes something
        spec, scene, trace, residuals = self.spec, self.scene, tuple(self.trace), self.best.verdict.residuals
        if residuals.passes:
            return make_solution(spec, scene, self.problem.section, self.problem.effects, self.best, trace, smallest)
        made = without_numbers(spec, scene, self.problem.section, residuals, self.best.iterations, trace)
        if self.escape is not None:
            return not_holdable(made, spec, scene, self.escape)
        if (found := self.proof) is None:
            return made
        certificate = None if found.escape is None else certificate_of(spec, scene, scene.twist(found.escape))
        return replace(
            made, status=Status.NO_EQUILIBRIUM, bounds=found.bounds, cause=found.cause, certificate=certificate,
            yielding=found.yielding,
        )  # fmt: skip
