"""From a candidate that a search found, not exact to the last digit, to one that the certifier passes."""

from __future__ import annotations

from collections.abc import Iterable

from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.verify.judge import judge
from handlcp.lcp import SemismoothNewton

__all__ = ["first_certified", "only_limits_move", "passes"]

_NEWTON = SemismoothNewton()


def first_certified(problem: GraspContactProblem, candidates: Iterable[Candidate]) -> Candidate | None:
    """The first that the certifier passes, as it is or after Newton's method from there."""
    for candidate in candidates:
        if passes(problem, candidate):
            return candidate
        refined = problem.candidate(_NEWTON.propose_contact(problem, problem.natural(candidate)).z)
        if passes(problem, refined):
            return refined
    return None


def passes(problem: GraspContactProblem, candidate: Candidate) -> bool:
    """Whether the certifier calls it an answer."""
    return judge(problem.scene, problem.effects, problem.section, candidate).residuals.passes


def only_limits_move(problem: GraspContactProblem) -> bool:
    """Whether contact modes describe the scene: no effect moves the contacts but by limits that give way."""
    return all(e.only_limits for e in problem.effects)
