"""What the first stage leaves: each grasp through the later stages by itself, here or in another process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from handlcp.check import Array
from handlcp.grasp.analysis.advice import advised
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import build
from handlcp.grasp.batch.batch import Batch
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import CompiledAnswer, compiled_kind
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.solve.stages import solve_built
from handlcp.lcp.compiler.when import at_once
from handlcp.lcp.solve import AnySolver


@dataclass(frozen=True, slots=True)
class Left:
    """Grasps as they travel, in one pickle: what they share, such as their hand, is in it once, and a grasp made by
    `replace(wrench=...)` adds some 350 bytes and the row of its first stage. Scenes stay at home.
    """

    specs: tuple[GraspSpec, ...]
    sections: tuple[Section, ...]
    rows: tuple[Array | None, ...]
    solver: AnySolver
    proof: bool


def solve_one(batch: Batch, k: int, row: Array | None) -> GraspSolution:
    """The solution of grasp k. row : what its first stage came to, where that is known."""
    g = batch.grasps[k]
    scene = replace(g.scene)  # a solve hangs matrices on its scene: on one that goes, so that no batch piles them up
    return at_home(batch, k, _solved(g.spec, scene, batch.section(k), batch.solver, batch.proof, row))


def left_of(batch: Batch, at: Sequence[int], rows: dict[int, Array]) -> Left:
    """These grasps as they travel, with their rows, which are taken out."""
    specs, sections = tuple([batch.grasps[k].spec for k in at]), tuple([batch.section(k) for k in at])
    return Left(specs, sections, tuple([rows.pop(k, None) for k in at]), batch.solver, batch.proof)


@at_once()
def solve_left(left: Left) -> list[GraspSolution]:
    """The solutions, without their scenes, wherever the grasps were sent."""
    every = zip(left.specs, left.sections, left.rows, strict=True)
    return [replace(_solved(s, build(s), own, left.solver, left.proof, row), scene=None) for s, own, row in every]


def at_home(batch: Batch, k: int, solution: GraspSolution) -> GraspSolution:
    """A solution with the scene of its grasp, and advice that is worked out when it is asked for."""
    g = batch.grasps[k]
    return advised(replace(solution, scene=g.scene), g.spec, batch.section(k))


def _solved(
    spec: GraspSpec, scene: Scene, section: Section, solver: AnySolver, proof: bool, row: Array | None
) -> GraspSolution:
    if row is None:
        return solve_spec(spec, section, solver, scene=scene, proof=proof)
    first = CompiledAnswer(compiled_kind(scene, section), row)
    return solve_built(spec, scene, section, solver, proof=proof, first=first)
