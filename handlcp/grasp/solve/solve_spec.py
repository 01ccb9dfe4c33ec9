"""The one way from a specification to its solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlcp.check import Array
from handlcp.grasp.answer.make_solution import without_numbers
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE, start_from
from handlcp.grasp.solve.stages import solve_built
from handlcp.lcp import Status
from handlcp.lcp.solve import AnySolver
from handlcp.tolerances import FIXED_POINT

# ----------------------------------------------------------------
# Grasps whose effects depend on the forces of the answer: solved again until the forces stay.
#
# f ← forces of the grasp with E(f) and d(f)
#
# Every solve is certified for its E, and the last one for the E of its own forces: that is what SOLVED means here.
# Where an effect has none under the forces (fingers buckle), where the forces keep changing, or where the changed grasp
# has no answer, nothing is claimed.

_MOST = 100  # solves


def force_dependent(spec: GraspSpec) -> bool:
    """Whether any effect depends on the forces of the answer."""
    return any(e.depends_on_forces for e in spec.effects)


def under_forces(spec: GraspSpec, forces: Array) -> GraspSpec | str:
    """The specification as it is under forces (n, 3) [N], contact axes; or, in words, why there is none."""
    effects = []
    for e in spec.effects:
        made = e.under(spec, forces, spec.effects) if e.depends_on_forces else e
        if isinstance(made, str):
            return made
        effects.append(made)
    return spec.replace(effects=tuple(effects), asked=spec.asked)


def solve_again(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver = None, start: Array = NOWHERE,
    proof: bool = True,
) -> GraspSolution:  # fmt: skip
    """As `stages.solve_built`; scene : of the unloaded fingers. The trace ends with how the iteration went. What is
    said of uniqueness holds for the last E.
    """
    forces, solution, where = np.zeros((scene.n, 3)), None, start
    if len(start):
        forces = scene.physical(start[:-9])[: 3 * scene.n].reshape(-1, 3)
    words = f"the forces still change after {_MOST} solves"
    for count in range(1, _MOST + 1):
        loaded = under_forces(spec, forces)
        if isinstance(loaded, str):
            words = loaded
            break
        now = build(loaded)
        solution = solve_built(loaded, now, section, solver, where, proof)
        if not solution.held:
            words = f"no answer with the flexibility under these forces, in solve {count}: {solution.status.name}"
            break
        change, forces = _relative(solution.forces - forces, solution.forces), solution.forces
        where = start_from(solution, now)
        if change <= FIXED_POINT or count == _MOST:
            made = _certified(spec, now, solution, f"{count} solves, forces change by {change:.1e}")
            if not isinstance(made, str):
                return made
            words = made if change <= FIXED_POINT else words
    if len(start) and (solution is None or (count == 1 and not solution.held)):  # the start led nowhere
        return solve_again(spec, scene, section, solver, proof=proof)
    assert solution is not None  # unloaded fingers always have an E
    trace = (*solution.trace, f"geometric stiffness: {words}")
    if solution.status is Status.NOT_HOLDABLE:  # whatever gives way, no force within friction balances the load
        return replace(solution, trace=trace)
    # What was proven of one E is not proven of all
    return without_numbers(spec, scene, section, solution.residuals, solution.iterations, trace)


def _certified(spec: GraspSpec, now: Scene, solution: GraspSolution, words: str) -> GraspSolution | str:
    """The solution with the effects' own law among its residuals, or why not."""
    miss = missed(spec, now, solution.forces, solution.residuals.motion_scale)
    if isinstance(miss, str):
        return miss
    residuals = replace(solution.residuals, effects=max(solution.residuals.effects, miss))
    words = f"{words}, E(f) by {miss:.1e}"
    if not residuals.passes:
        return words
    return replace(solution, residuals=residuals, trace=(*solution.trace, f"geometric stiffness: {words}"))


def missed(spec: GraspSpec, scene: Scene, forces: Array, motion_size: float) -> float | str:
    """How far E and the offsets of a scene are from those of the specification under these forces (n, 3) [N], relative;
    or, in words, why there are none. motion_size [m] : what offsets are measured by.
    """
    own = under_forces(spec, forces)
    if isinstance(own, str):
        return own
    there = build(own)
    off = float(abs(there.offset - scene.offset).max(initial=0.0)) / motion_size
    return max(_relative(there.flexibility - scene.flexibility, scene.flexibility), off)


def _relative(difference: Array, of: Array) -> float:
    """The largest entry of a difference beside the largest of what differs."""
    size = float(abs(of).max(initial=0.0))
    return float(abs(difference).max(initial=0.0)) / size if size > 0.0 else 0.0


# ----------------------------------------------------------------


def solve_spec(
    spec: GraspSpec, section: Section, solver: AnySolver = None, start: Array = NOWHERE, scene: Scene | None = None,
    proof: bool = True,
) -> GraspSolution:  # fmt: skip
    """The certified solution; its status says what it is worth, and nothing is raised for want of one.

    start : as in `compiled_answer.start_from`. scene : `build(spec)`, where that is known. proof : as in `Grasp.solve`.
    """
    run = solve_again if spec.effects and force_dependent(spec) else solve_built
    return run(spec, build(spec) if scene is None else scene, section, solver, start, proof)
