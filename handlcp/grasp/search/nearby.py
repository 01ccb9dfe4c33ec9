"""From a candidate that a search found, not exact to the last digit, to one that the certifier passes."""

from __future__ import annotations

from collections.abc import Iterable

from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.verify.judge import judge
from handlcp.lcp import SemismoothNewton
from handlcp.lcp.solvers.auto import in_units_of_limits
from handlcp.lcp.solvers.contact_run import FINE
from handlcp.tolerances import CERTIFY

_NEWTON = SemismoothNewton(tol=FINE)
_ALMOST = 100.0  # of what the certifier allows


def first_certified(problem: GraspContactProblem, candidates: Iterable[Candidate]) -> Candidate | None:
    """The first that the certifier passes, as it is or after Newton's method from there."""
    for candidate in candidates:
        if passes(problem, candidate):
            return candidate
        near = _NEWTON.propose_contact(problem, problem.natural(candidate)).z
        refined = problem.candidate(near)
        worst = _worst(problem, refined)
        if CERTIFY < worst <= _ALMOST * CERTIFY:  # stiff fingers: rounding may be less in other units
            refined = problem.candidate(in_units_of_limits(_NEWTON, problem, near).z)
            worst = _worst(problem, refined)
        if worst <= CERTIFY:
            return refined
    return None


def passes(problem: GraspContactProblem, candidate: Candidate) -> bool:
    """Whether the certifier calls it an answer."""
    return _worst(problem, candidate) <= CERTIFY


def _worst(problem: GraspContactProblem, candidate: Candidate) -> float:
    return judge(problem.scene, problem.effects, problem.section, candidate).residuals.worst


def only_limits_move(problem: GraspContactProblem) -> bool:
    """Whether contact modes describe the scene: no effect moves the contacts but by limits that give way."""
    return all(e.only_limits for e in problem.effects)
