"""Asking for an accuracy instead of settings: the exact cone, whose force error is shown to keep the request.

Pyramids of 4 to 64 faces would take 5 or 6 % longer (median of 340 scenes), and an answer on one says nothing of its
error. What is left of an error on the cone is the solver's and rounding's (`force_error`). A plane's interval, and
contacts without friction, are exact whatever the solver.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp.analysis.advice import solve_with_advice
from handlcp.grasp.analysis.force_error import force_error
from handlcp.grasp.answer.accuracy import Accuracy
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.assembly.contact_form import GraspContactProblem, stamped
from handlcp.grasp.friction import Cone, Interval, Pyramid, Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import start_from
from handlcp.lcp import Auto, ContactSolver, SemismoothNewton, Solver, Status, as_chain
from handlcp.lcp.solve import AnySolver

_STARTS = (4, 8, 16, 32)  # faces of the pyramids whose answers may lead to the cone's
_NEWTON = SemismoothNewton()
_FINEST = SemismoothNewton(tol=1e-13)  # as far as rounding lets Newton's method go


def solve_to_accuracy(
    spec: GraspSpec, accuracy: float, solver: AnySolver, start: Array, proof: bool = True
) -> GraspSolution:  # fmt: skip
    """The solution on the exact section with its `Accuracy`, and more Newton steps where the request needs them.

    A proof that nothing holds the object, or that there is no equilibrium, is a final answer and passes unchanged.
    proof : as in `Grasp.solve`.
    Raises Unsupported for soft fingers, and for a solver that knows no cones where there is one.
    """
    begun, scene = time.perf_counter(), build(spec)
    if scene.soft:
        raise Unsupported("accuracy= knows no soft fingers: solve(faces) and solve('cone') do")
    section, words = _exact(scene, solver)
    solution, solves = solve_with_advice(spec, section, solver, start, scene, proof), 1
    if proof and solution.status is Status.UNDECIDED and isinstance(section, Cone):
        solution, solves, words = _through_pyramids(spec, scene, solver, solution)
    error = _error(spec, scene, solution)
    if solution.held and not error <= accuracy and scene.frictional:
        finer, solves = solve_with_advice(spec, _true(scene), _FINEST, start_from(solution, scene), scene), solves + 1
        if (better := _error(spec, scene, finer)) < error:
            solution, error, words = finer, better, f"{words}, more Newton steps"
    reached = Accuracy(accuracy, error, words, solves, time.perf_counter() - begun)
    return replace(solution, accuracy=reached, trace=(*solution.trace, f"accuracy: {reached}"))


def _exact(scene: Scene, solver: AnySolver) -> tuple[Section, str]:
    """The section that stands for the exact one with this solver, and its name."""
    # A class, or anything that is no solver, is refused where it is used
    plain = not isinstance(solver, (Auto, ContactSolver, type)) and isinstance(solver, Solver)
    exact = _true(scene)
    if not scene.frictional:
        return Pyramid(4) if plain and not scene.kind.planar else exact, "exact, no friction"
    if plain and not scene.kind.planar:
        known = f"{type(solver).__name__} knows no cones, and pyramids seldom get below 1e-3"
        raise Unsupported(f"{known}: leave the solver to accuracy=, or ask for faces")
    return exact, exact.name


def _true(scene: Scene) -> Section:
    """Friction as it is."""
    return Interval() if scene.kind.planar else Cone()


def _through_pyramids(
    spec: GraspSpec, scene: Scene, solver: AnySolver, best: GraspSolution
) -> tuple[GraspSolution, int, str]:
    """(solution, solves, words): Newton's method on the cone from the answers of pyramids."""
    method = replace(as_chain(solver) or Auto(), search_seconds=0.0)
    for k, faces in enumerate(_STARTS):
        near = solve_with_advice(spec, Pyramid(faces), method, scene=scene)
        if near.held:
            cone = solve_with_advice(spec, Cone(), _NEWTON, start_from(near, scene), scene)
            if cone.held:
                return cone, 2 * k + 3, f"{Cone().name}, from the {Pyramid(faces).name}"
    return best, 1 + 2 * len(_STARTS), Cone().name


def _error(spec: GraspSpec, scene: Scene, solution: GraspSolution) -> float:
    """Of an answer on the exact section; NaN without one."""
    if not solution.held:
        return math.nan
    return force_error(GraspContactProblem(scene, _true(scene), stamped(spec.effects)), solution)
