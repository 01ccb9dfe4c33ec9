"""A grasp through the stages of its solver, until the certifier is content: what `Grasp.solve` does."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from handlcp.check import Array
from handlcp.errors import NoSolutionFound
from handlcp.grasp.assemble import GraspContact, GraspProblem
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.certify import Verdict, judge
from handlcp.grasp.first import NOWHERE, find
from handlcp.grasp.last_resort import last_resort
from handlcp.grasp.pyramid import Section
from handlcp.grasp.required import required_preload
from handlcp.grasp.scene import shifted
from handlcp.grasp.soft_form import GraspBalls, assembled, chain_form
from handlcp.grasp.solution import GraspSolution
from handlcp.lcp import Auto, ContactSolver, Proposal, Solver, Status, as_chain, proposals

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["natural_start", "solve", "stage_line", "stages"]


def solve(
    grasp: Grasp,
    section: Section,
    solver: Solver | ContactSolver | Auto | None,
    throw: bool,
    start: Array = NOWHERE,
) -> GraspSolution:
    """Forces, slips and motion; start as in `first.start_at`. The first stage of a scene whose effects follow from its
    data is one compiled call, and for most scenes there is no other.
    """
    chain = as_chain(solver)
    if chain is None or grasp.general:
        return grasp._in_stages(section, solver, throw, start)
    found = find(grasp.scene, section, chain.seed, start)
    if not found.passes:
        return stages(grasp, section, solver, throw, start, found.proposal)
    return grasp._answered(section, found)


def stage_line(name: str, proposal: Proposal, worst: float) -> str:
    """One line of a trace."""
    return f"{name}: {proposal.outcome}, {proposal.iterations} iterations, residual {worst:.1e}"


def stages(
    grasp: Grasp,
    section: Section,
    solver: Solver | ContactSolver | Auto | None,
    throw: bool,
    start: Array,
    first: Proposal | None = None,
) -> GraspSolution:
    """One stage after the other; `first` is the first one's proposal, where that is known."""
    scene, chain = grasp.scene, as_chain(solver)
    # The chain works on friction as a set, whatever the section: pyramids cost no more than the cone
    make = assembled if chain is None else chain_form
    problem = make(scene, section, grasp.stamped)
    trace: list[str] = []
    best: tuple[Candidate, Verdict, int] | None = None
    for name, proposal in proposals(problem, solver, natural_start(problem, start), first):
        candidate = problem.candidate(proposal.z)
        verdict = judge(scene, problem.effects, section, candidate)
        trace.append(stage_line(name, proposal, verdict.residuals.worst))
        if best is None or verdict.residuals.worst < best[1].residuals.worst:
            best = candidate, verdict, proposal.iterations
        if verdict.residuals.passes:
            break
    assert best is not None  # every solver proposes something
    solution = grasp._solution(problem.effects, section, *best, tuple(trace))
    if not solution.held:
        escapes = "nothing holds it" if solution.certificate is not None else "no proof that nothing holds it"
        solution = replace(solution, trace=(*trace, f"holdability: {escapes}"))
    if solution.status is Status.UNDECIDED and chain is not None and chain.search_seconds > 0:
        solution = _search(grasp, problem, section, chain, solution, best[1])
    if throw and not solution.held:
        raise NoSolutionFound("\n  ".join((str(solution), *solution.trace)), problem, solution)
    return solution


def _search(
    grasp: Grasp,
    problem: GraspProblem | GraspContact | GraspBalls,
    section: Section,
    chain: Auto,
    solution: GraspSolution,
    verdict: Verdict,
) -> GraspSolution:
    """The chain's last stage: an exact search, and for a proven "no" the squeeze that would help."""
    candidate, bounds, words = last_resort(problem, section, chain.search_seconds)
    trace = (*solution.trace, f"{chain.search_stage}: {words}")
    if candidate is not None:
        verdict = judge(grasp.scene, problem.effects, section, candidate)
        return grasp._solution(problem.effects, section, candidate, verdict, solution.iterations, trace)
    if bounds is None:
        return replace(solution, trace=trace)
    squeeze = required_preload(grasp, section).value
    return replace(solution, status=Status.NO_EQUILIBRIUM, bounds=bounds, required_preload=squeeze, trace=trace)


def natural_start(problem: GraspProblem | GraspContact | GraspBalls, start: Array) -> Array | None:
    """The start as unknowns of this problem; None: there is none."""
    if not len(start):
        return None
    scene = problem.scene
    k = 3 * scene.n
    twist = shifted(start[k : k + 6], scene.units.centre - start[k + 6 :])
    return problem.natural(Candidate(scene.lawful(start[:k].reshape(-1, 3)), twist, {}))
