"""A solve with advice: for a proven "no", the squeeze that would help, worked out when somebody asks."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from handlcp.check import Array
from handlcp.errors import NoSolutionFound
from handlcp.grasp.analysis.required import required_preload
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.problem import AnyProblem
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Status
from handlcp.lcp.solve import AnySolver

__all__ = ["advised", "no_solution", "solve_with_advice"]


def solve_with_advice(
    spec: GraspSpec, section: Section, solver: AnySolver = None, start: Array = NOWHERE, scene: Scene | None = None,
    proof: bool = True,
) -> GraspSolution:  # fmt: skip
    """As `solve_spec`; NO_EQUILIBRIUM can be asked for the `required_preload` that would hold."""
    return advised(solve_spec(spec, section, solver, start, scene, proof), spec, section)


def advised(solution: GraspSolution, spec: GraspSpec, section: Section) -> GraspSolution:
    """The solution that knows where to ask for the squeeze that would help."""
    if solution.status is not Status.NO_EQUILIBRIUM or solution.certificate is not None:  # no squeeze moves a limit
        return solution
    return replace(solution, advise=partial(_squeeze, spec, section))


def _squeeze(spec: GraspSpec, section: Section) -> float | None:
    return required_preload(spec, section).value


def no_solution(problem: AnyProblem, solution: GraspSolution) -> NoSolutionFound:
    """The error that carries them; its message, advice included, is made when somebody reads it."""
    return NoSolutionFound(partial(_told, solution), problem, solution)


def _told(solution: GraspSolution) -> str:
    lines, reached = [str(solution), *solution.trace], solution.accuracy
    if solution.held and reached is not None:
        advice = f"double precision shows no more here: ask for {2.0 * reached.error:.0e}"
        lines = [f"no setting is shown to keep what was asked for: {reached}", advice, *lines]
    return "\n  ".join(lines)
