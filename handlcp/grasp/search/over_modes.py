"""Everything that the contacts of a grasp can do at once: one equilibrium, the proof that there is none, or all.

One tree serves all three (`lcp.modes`), and cuts off what nothing fits. A walk through every choice, one small
elimination each, is faster where there are few: 4 ms instead of 24 ms for 10,000 choices (four contacts on pyramids of
4 faces). The tree is faster from about 100,000 on: 0.13 s instead of 0.95 s for 1.9 million (five contacts, 8 faces).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from handlcp.check import Array
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.friction import Pyramid
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.judge import judge
from handlcp.lcp import SemismoothNewton
from handlcp.lcp.modes.search import ModeSearch
from handlcp.lcp.solvers.auto import in_units_of_limits
from handlcp.tolerances import CERTIFY, FINE

# ----------------------------------------------------------------
# From a candidate that a search found, not exact to the last digit, to one that the certifier passes.

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


# ----------------------------------------------------------------
# The tree of contact modes of a grasp, and how far what it proves reaches.

PER_SECOND = 2e8  # multiply-adds in a second, a careful count
_WIDE = 1e3  # of the box in which nothing is proven to exist, times 1 + max|d̂|


class OverModes:
    """The search over contact modes of one grasp. It can be paused: `first` and `every` go on where they stopped."""

    def __init__(self, problem: GraspContactProblem) -> None:
        self.problem, self.bounds = problem, wide(problem.scene)
        b = self.bounds[0] / problem.scene.units.force
        most_x, most_y = np.full((2, problem.n), b)
        most_y[problem.limited] = _slack(problem, b)
        self.search = ModeSearch(problem, most_x, most_y)

    def first(self, work: float, end: float = math.inf) -> Candidate | None:
        """The first equilibrium that is certified within so many multiply-adds in all; end : of `time.monotonic`."""
        every = (self.problem.candidate(x) for x in self.search.candidates(work, end))
        return first_certified(self.problem, every)

    def every(self, work: float) -> Iterator[Candidate]:
        """What may be an equilibrium, one of each choice of modes: all of them where the search is `exhausted` within
        the work.
        """
        return (self.problem.candidate(x) for x in self.search.every(work))


def coarse(problem: GraspContactProblem, faces: int, seconds: float) -> Iterator[Candidate]:
    """As `OverModes.every` of the scene on a pyramid of so many faces, as many as the time allows."""
    return OverModes(GraspContactProblem(problem.scene, Pyramid(faces), problem.asked)).every(PER_SECOND * seconds)


def wide(scene: Scene) -> tuple[float, float]:
    """The largest forces [N] and motions [m] for which proofs claim that there is no equilibrium. Some hold without
    bounds, and state these, too.
    """
    return si(scene, _WIDE * (1.0 + float(abs(scene.offset).max(initial=0.0)) / scene.units.motion))


def si(scene: Scene, size: float) -> tuple[float, float]:
    """So many natural units of force [N] and of motion [m]."""
    return size * scene.units.force, size * scene.units.motion


def _slack(problem: GraspContactProblem, b: float) -> Array:
    """(m,) the most that normal forces up to b leave of each limit, the one the other way kept where there is one."""
    reach = np.zeros(problem.n)
    reach[problem.role == 1] = b
    for block, limit in zip(problem.blocks, problem.limits, strict=True):
        reach[block[1:][block[1:] >= 0]] = 2.0 * limit * b  # polygons' corners, and cells, lie beyond the limit
    A, room = problem.M[problem.limited], problem.q[problem.limited]
    against = (A[:, None] + A[None] == 0.0).all(axis=2)
    opposite = room + np.where(against, room, np.inf).min(axis=1, initial=np.inf)
    return np.asarray(np.clip(room + abs(A) @ reach, 0.0, np.maximum(opposite, 0.0)))
