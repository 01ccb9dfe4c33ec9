"""The one way from a specification to its solution."""

from __future__ import annotations

from handlcp.check import Array
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE
from handlcp.grasp.solve.force_iteration import force_dependent, solve_again
from handlcp.grasp.solve.stages import solve_built
from handlcp.lcp.solve import AnySolver


def solve_spec(
    spec: GraspSpec, section: Section, solver: AnySolver = None, start: Array = NOWHERE, scene: Scene | None = None,
    proof: bool = True,
) -> GraspSolution:  # fmt: skip
    """The certified solution; its status says what it is worth, and nothing is raised for want of one.

    start : as in `compiled_answer.start_from`. scene : `build(spec)`, where that is known. proof : as in `Grasp.solve`.
    """
    run = solve_again if spec.effects and force_dependent(spec) else solve_built
    return run(spec, build(spec) if scene is None else scene, section, solver, start, proof)
