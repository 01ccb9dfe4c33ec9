"""One equilibrium found, or none proved within bounds, by a mixed-integer search over contact modes (`modes`)."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

from handlcp.check import Array
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.catalogue import asked_for
from handlcp.grasp.certify import judge
from handlcp.grasp.effects import Effect
from handlcp.grasp.modes import Program
from handlcp.grasp.pyramid import Pyramid, Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_form import GraspBalls, chain_form
from handlcp.lcp.search import Outcome
from handlcp.lcp.solvers.balls import ball_stages
from handlcp.lcp.solvers.nsngrk import NSNGRK

__all__ = ["Believer", "EquilibriumSearch", "applicable", "find_equilibrium", "widest"]

_NARROW, _WIDE = 10.0, 1e3  # boxes, times 1 + max|d̂|
_COARSE = 4  # faces of the pyramid that is searched before one of more than _FEW, or the cone
_FEW = 6
_CUTS = 8  # choices of modes cut off before the search gives up


@dataclass(frozen=True, slots=True)
class EquilibriumSearch:
    """What a search established.

    outcome : "solution" (certified), "none" (proved within the bounds) or "unknown" (time or cuts spent).
    candidate : the certified answer, or None.
    force_bound [N], motion_bound [m] : "none" is said of normal forces up to the one; of gaps, slips (along each face
        that is slid against) and what limits give way (angles times their levers) up to the other.
    seconds : wall time. cuts : choices of modes that the certifier refused.
    """

    outcome: Outcome
    candidate: Candidate | None
    force_bound: float
    motion_bound: float
    seconds: float
    cuts: int


def applicable(effects: tuple[Effect, ...]) -> bool:
    """Whether contact modes describe the scene: no effect moves the contacts but by limits that give way."""
    return all(type(e).opening is Effect.opening for e in effects)


def widest(scene: Scene, offset: Array | None = None) -> float:
    """Largest force and motion that a "none" speaks of, natural units: 1000 (1 + max|d̂|)."""
    d = scene.offset / scene.units.motion if offset is None else offset
    return _WIDE * (1.0 + float(abs(d).max(initial=0.0)))


def find_equilibrium(
    scene: Scene,
    effects: tuple[Effect, ...],
    section: Section,
    seconds: float = 10.0,
    bound: float | None = None,
) -> EquilibriumSearch:
    """Search with forces and motions up to `bound` natural units; None: up to 1000 (1 + max|d̂|), and where that comes
    to nothing once more in a hundredth of it, where solutions are found more easily but none cannot be proved. Instead
    of that, a fine pyramid, or the cone, is searched after a coarse one, whose equilibria are found sooner and are
    often near enough.

    effects : of the scene, as stamped; they must be `applicable` (ValueError otherwise). What the search finds is
    solved exactly for its modes, then by Newton's method from there (for the exact cone that is needed), and believed
    only when the certifier passes it.
    """
    if not applicable(effects):
        raise ValueError("an effect moves the contacts by no limit; search the assembled problem: handlcp.lcp.search")
    start, program = time.monotonic(), Program(scene, effects, section)
    believed = Believer(scene, effects, section)
    wide = widest(scene, program.offset) if bound is None else float(bound)
    runs = [(program, wide, 1.0)]
    if bound is None:
        runs = [(program, wide, 0.8), (program, _NARROW / _WIDE * wide, 1.0)]
        if scene.soft:
            runs = [(program, wide, 1.0)]
        elif section.faces == 0 or section.faces > _FEW:
            runs = [(Program(scene, effects, Pyramid(_COARSE)), wide, 0.4), (program, wide, 1.0)]
    outcome: Outcome = "unknown"
    candidate, cuts, b = None, 0, wide
    for which, b, share in runs:
        before = cuts
        for points in which.visit(b, start + share * seconds, _CUTS):
            candidate = believed(points)
            if candidate is not None:
                outcome = "solution"
                break
            cuts += 1
        if outcome == "unknown" and cuts == before and which is program and b == wide and program.exhausted:
            outcome = "none"
        if outcome != "unknown":
            break
    units = scene.units
    return EquilibriumSearch(outcome, candidate, b * units.force, b * units.motion, time.monotonic() - start, cuts)


class Believer:
    """Called with candidates: the first that the certifier passes, as it is or after Newton's method from there."""

    def __init__(self, scene: Scene, effects: tuple[Effect, ...], section: Section) -> None:
        self.scene, self.effects, self.section = scene, effects, section
        self.problem = chain_form(scene, section, asked_for(effects))

    def __call__(self, candidates: Iterable[Candidate]) -> Candidate | None:
        for candidate in candidates:
            for c in (candidate, self._newton(candidate)):
                if judge(self.scene, self.effects, self.section, c).residuals.passes:
                    return c
        return None

    def _newton(self, c: Candidate) -> Candidate:
        start = self.problem.natural(c)
        if isinstance(self.problem, GraspBalls):
            return self.problem.candidate(next(ball_stages(self.problem, 0, start))[1].z)
        return self.problem.candidate(NSNGRK(max_iterations=0).propose_contact(self.problem, start).z)
