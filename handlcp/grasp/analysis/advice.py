"""A solve with advice: for a proven "no", the squeeze that would help, worked out when somebody asks."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from handlcp.check import Array
from handlcp.errors import NoSolutionFound
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.assembly.problem import AnyProblem
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Status
from handlcp.lcp.solve import AnySolver


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
    """The smallest squeeze that holds within the joints' torque limits, up to a fifth of the grasp's size [m]: of two
    digits, as it is said, where that holds, too.
    """
    from handlcp.grasp.analysis.required import required_preload
    from handlcp.grasp.parameter.squeeze import MOST

    least = required_preload(spec, section, limit=MOST * build(spec).units.length, test=_bears, sure=_bears).value
    if not least:
        return least
    step = 10.0 ** (math.floor(math.log10(least)) - 1)
    said = float(f"{math.ceil(least / step * (1 - 1e-12)) * step:.2g}")
    return said if _bears(spec.squeezed(said), section) else least


def _bears(spec: GraspSpec, section: Section) -> bool:
    """Whether an equilibrium is found, and no joint is over its torque limit there."""
    from handlcp.grasp.analysis.required import CHAIN

    found = solve_spec(spec, section, CHAIN)
    check = getattr(found, "torque_check", None)
    return found.held and (check is None or not check.over)


def no_solution(problem: AnyProblem, solution: GraspSolution) -> NoSolutionFound:
    """The error that carries them; its message, advice included, is made when somebody reads it."""
    return NoSolutionFound(partial(_told, solution), problem, solution)


def _told(solution: GraspSolution) -> str:
    lines, reached = [str(solution), *solution.trace], solution.accuracy
    if solution.held and reached is not None:
        advice = f"double precision shows no more here: ask for {2.0 * reached.error:.0e}"
        lines = [f"no setting is shown to keep what was asked for: {reached}", advice, *lines]
    return "\n  ".join(lines)
