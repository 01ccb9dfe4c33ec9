"""A grasp through the stages of its solver, until the certifier is content."""

from __future__ import annotations

from dataclasses import replace

from handlcp.check import Array, read_only
from handlcp.grasp.answer.make_solution import Judged, make_solution, solution_of
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.uniqueness import describe
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem, stamped
from handlcp.grasp.assembly.problem import assemble
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import shifted
from handlcp.grasp.search.nonexistence import search_equilibrium
from handlcp.grasp.solve.compiled_answer import NOWHERE, CompiledAnswer, solve_scene
from handlcp.grasp.solve.lazy_solution import lazy_solution, trace_of
from handlcp.grasp.verify.judge import Verdict, judge
from handlcp.lcp import Auto, Proposal, Status, as_chain, proposals, stage_line
from handlcp.lcp.solve import AnySolver

__all__ = ["answered", "solve_built"]


def solve_built(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver = None, start: Array = NOWHERE
) -> GraspSolution:
    """Forces, slips and motion of `build(spec)`; start as in `compiled_answer.start_from`.

    The first stage of a scene whose effects follow from its data is one compiled call, and for most scenes there is no
    other.
    """
    chain, asked = as_chain(solver), stamped(spec.effects) if spec.effects else ()
    if chain is None or asked:
        return _in_stages(spec, scene, section, solver, start, None)
    found = solve_scene(scene, section, chain.seed, start)
    if not found.passes:
        return _in_stages(spec, scene, section, solver, start, found.proposal)
    return answered(spec, scene, section, found)


def answered(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """The solution from an answer of the first stage that passes."""
    if found.unique and scene.scale is None and scene.prescribed is None and not scene.soft:
        return lazy_solution(spec, scene, found)
    judged = Judged(found.candidate, Verdict(found.motion, found.residuals), found.iterations)
    if not found.unique:
        return make_solution(spec, scene, section, found.kind.design.effects, judged, trace_of(found))
    arm = spec.reference - found.centre
    return solution_of(spec, scene, judged, found.states, describe(scene, (), arm), trace_of(found), arm)


def _in_stages(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver, start: Array, first: Proposal | None
) -> GraspSolution:
    """One stage after the other; `first` is the first one's proposal, where that is known."""
    chain = as_chain(solver)
    # The chain works on friction as a set, whatever the section: pyramids cost no more than the cone
    problem = (assemble if chain is None else GraspContactProblem)(scene, section, stamped(spec.effects))
    trace: list[str] = []
    best: Judged | None = None
    begin: Array | None = None
    if len(start):
        twist = shifted(start[-9:-3], scene.units.centre - start[-3:])
        begin = problem.natural(Candidate(start[:-9], twist, {}, len(scene.soft)))
    for name, proposal in proposals(problem, solver, begin, first):
        candidate = problem.candidate(proposal.z)
        verdict = judge(scene, problem.effects, section, candidate)
        trace.append(stage_line(name, proposal.outcome, proposal.iterations, verdict.residuals.worst))
        if best is None or verdict.residuals.worst < best.verdict.residuals.worst:
            best = Judged(candidate, verdict, proposal.iterations)
        if verdict.residuals.passes:
            break
    assert best is not None  # every solver proposes something
    solution = make_solution(spec, scene, section, problem.effects, best, tuple(trace))
    if solution.held:
        return solution
    escapes = "nothing holds it" if solution.certificate is not None else "no proof that nothing holds it"
    solution = replace(solution, trace=(*trace, f"holdability: {escapes}"))
    if solution.status is Status.UNDECIDED and chain is not None and chain.search_seconds > 0:
        assert isinstance(problem, GraspContactProblem)  # chains work on friction as a set
        solution = _searched(spec, problem, chain, solution)
    return solution


def _searched(spec: GraspSpec, problem: GraspContactProblem, chain: Auto, solution: GraspSolution) -> GraspSolution:
    """The chain's last stage: an exact search, for an answer or for the proof that there is none."""
    scene, section = problem.scene, problem.section
    found = search_equilibrium(problem, chain.search_seconds)
    trace = (*solution.trace, f"{chain.search_stage}: {found.words}")
    if found.candidate is not None:
        judged = Judged(found.candidate, judge(scene, problem.effects, section, found.candidate), solution.iterations)
        return make_solution(spec, scene, section, problem.effects, judged, trace)
    if found.bounds is None:
        return replace(solution, trace=trace)
    certificate = None
    if found.escape is not None:
        certificate = read_only(shifted(scene.twist(found.escape), spec.reference - scene.units.centre))
    return replace(
        solution, status=Status.NO_EQUILIBRIUM, bounds=found.bounds, cause=found.cause, certificate=certificate,
        yielding=found.yielding, trace=trace,
    )  # fmt: skip
