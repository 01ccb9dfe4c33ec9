"""What the first stage leaves: each grasp through the later stages by itself, here or in another process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.batch.batch import Batch
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp.solve import AnySolver

__all__ = ["Left", "at_home", "left_of", "solve_left", "solve_one"]


@dataclass(frozen=True, slots=True)
class Left:
    """Grasps as they travel, in one pickle: what they share, such as their hand, is in it once, and a grasp made by
    `replace(wrench=...)` adds some 350 bytes. Scenes stay at home.
    """

    specs: tuple[GraspSpec, ...]
    sections: tuple[Section, ...]
    solver: AnySolver
    proof: bool


def solve_one(batch: Batch, k: int) -> GraspSolution:
    """The solution of grasp k, through all stages."""
    g = batch.grasps[k]
    return solve_spec(g.spec, batch.section(k), batch.solver, scene=g.scene, proof=batch.proof)


def left_of(batch: Batch, at: Sequence[int]) -> Left:
    """These grasps as they travel."""
    specs, sections = tuple([batch.grasps[k].spec for k in at]), tuple([batch.section(k) for k in at])
    return Left(specs, sections, batch.solver, batch.proof)


def solve_left(left: Left) -> list[GraspSolution]:
    """The solutions, without their scenes, wherever the grasps were sent."""
    pairs = zip(left.specs, left.sections, strict=True)
    return [replace(solve_spec(spec, own, left.solver, proof=left.proof), scene=None) for spec, own in pairs]


def at_home(batch: Batch, k: int, solution: GraspSolution) -> GraspSolution:
    """A solution that came back, with the scene of its grasp."""
    return replace(solution, scene=batch.grasps[k].scene)
