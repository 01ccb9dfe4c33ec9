"""`EquilibriumSearch`: all that contacts can do at once: one equilibrium, the proof of none, or all of them.

One tree serves all three (`lcp.modes`), and cuts off what nothing fits. A walk through every choice, one small
elimination each, is faster where there are few: 4 ms instead of 24 ms for 10,000 choices (four contacts on pyramids of
4 faces). The tree is faster from about 100,000 on: 0.13 s instead of 0.95 s for 1.9 million (five contacts, 8 faces).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from handlcp.check import Array
from handlcp.grasp.assembly.problem import GraspContactProblem, GraspProblem, SolverCandidate
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.certifier import Residuals, certify_candidate
from handlcp.grasp.verify.load_capacity import is_jammed, least_normal_sum, prove_overload
from handlcp.lcp import SemismoothNewton
from handlcp.lcp.certificate import search_active_sets
from handlcp.lcp.modes.mode_search import ModeSearch
from handlcp.lcp.solve import propose_in_limit_units
from handlcp.tolerances import ACTIVE_TOLERANCE, CERTIFY_TOLERANCE, FINE_SOLVE_TOLERANCE

# ----------------------------------------------------------------
# From a candidate that a search found, not exact to the last digit, to one that the certifier passes.

_FINE_NEWTON = SemismoothNewton(tol=FINE_SOLVE_TOLERANCE)
_NEAR_CERTIFIED = 100.0  # of what the certifier allows


def first_certified(problem: GraspContactProblem, candidates: Iterable[SolverCandidate]) -> SolverCandidate | None:
    """The first that the certifier passes, as it is or after Newton's method from there."""
    for candidate in candidates:
        if is_certified(problem, candidate):
            return candidate
        near = _FINE_NEWTON.propose_contact(problem, problem.natural(candidate)).z
        refined = problem.candidate(near)
        residuals = _residuals(problem, refined)
        if not residuals.passes and residuals.worst <= _NEAR_CERTIFIED * CERTIFY_TOLERANCE:
            # Stiff fingers: rounding may be less in other units
            refined = problem.candidate(propose_in_limit_units(_FINE_NEWTON, problem, near).z)
            residuals = _residuals(problem, refined)
        if residuals.passes:
            return refined
    return None


def is_certified(problem: GraspContactProblem, candidate: SolverCandidate) -> bool:
    """Whether the certifier calls it an answer."""
    return _residuals(problem, candidate).passes


def _residuals(problem: GraspContactProblem, candidate: SolverCandidate) -> Residuals:
    return certify_candidate(problem.scene, problem.effects, problem.section, candidate).residuals


def has_only_limits(problem: GraspContactProblem) -> bool:
    """Whether contact modes describe the scene: no effect moves the contacts but by limits that give way."""
    return all(e.only_limits for e in problem.effects)


# ----------------------------------------------------------------
# The tree of contact modes of a grasp, and how far what it proves reaches.

WORK_PER_SECOND = 2e8  # multiply-adds in a second, a careful count
_BOX_SIZE = 1e3  # of the box in which nothing is proven to exist, times 1 + max|d̂|


class ContactModeSearch:
    """The search over contact modes of one grasp. It can be paused: `find_first` and `each_choice` go on where they
    stopped.
    """

    def __init__(self, problem: GraspContactProblem) -> None:
        self.problem, self.bounds = problem, proof_bounds(problem.scene)
        b = self.bounds[0] / problem.scene.units.force_unit
        most_x, most_y = np.full((2, problem.n), b)
        most_y[problem.limit_unknowns] = _limit_slack(problem, b)
        self.search = ModeSearch(problem, most_x, most_y)

    def find_first(self, work: float, end: float = math.inf) -> SolverCandidate | None:
        """The first equilibrium that is certified within so many multiply-adds in all; end : of `time.monotonic`."""
        every = (self.problem.candidate(x) for x in self.search.candidates(work, end))
        return first_certified(self.problem, every)

    def each_choice(self, work: float) -> Iterator[SolverCandidate]:
        """What may be an equilibrium, one of each choice of modes: all of them where the search is `exhausted` within
        the work.
        """
        return (self.problem.candidate(x) for x in self.search.each_choice(work))


def proof_bounds(scene: Scene) -> tuple[float, float]:
    """The largest forces [N] and motions [m] for which proofs claim that there is no equilibrium. Some hold without
    bounds, and state these, too.
    """
    return bounds_in_si(scene, _BOX_SIZE * (1.0 + float(abs(scene.offset).max(initial=0.0)) / scene.units.motion_unit))


def bounds_in_si(scene: Scene, size: float) -> tuple[float, float]:
    """So many natural units of force [N] and of motion [m]."""
    return size * scene.units.force_unit, size * scene.units.motion_unit


def _limit_slack(problem: GraspContactProblem, b: float) -> Array:
    """(m,) the most that normal forces up to b leave of each limit, the one the other way kept where there is one."""
    reach = np.zeros(problem.n)
    reach[problem.role == 1] = b
    for block, limit in zip(problem.blocks, problem.limits, strict=True):
        reach[block[1:][block[1:] >= 0]] = 2.0 * limit * b  # polygons' corners, and cells, lie beyond the limit
    A, room = problem.M[problem.limit_unknowns], problem.q[problem.limit_unknowns]
    against = (A[:, None] + A[None] == 0.0).all(axis=2)
    opposite = room + np.where(against, room, np.inf).min(axis=1, initial=np.inf)
    return np.asarray(np.clip(room + abs(A) @ reach, 0.0, np.maximum(opposite, 0.0)))


# ----------------------------------------------------------------
# Where the solvers fail on a grasp that could be held: an exact search, for an answer or the proof of none.
#
# limits on the forces   a linear program (`prove_overload`): no forces within friction and limits balance the load
# contact modes          all of them at once (`search_modes`): pyramids and planes exactly, the cone by arcs that are
#                        refined where they do not decide
# moments, with faces    the active sets of the LCP with a multiplier a face (`search_active_sets`)
#
# Budgets count multiply-adds, so that what is proven depends on no clock.


@dataclass(frozen=True, slots=True)
class EquilibriumSearchResult:
    """What a search established; words : for the trace.

    candidate : a certified one, or None. bounds : forces [N] and motions [m] up to which there is proven to be none, or
    None; cause : of that, where it is known. escape (dof,), yielding : where limits on the forces are the cause, the
    motion in natural units and by how much each limit gives way, by name, SI.
    """

    words: str
    candidate: SolverCandidate | None = None
    bounds: tuple[float, float] | None = None
    cause: str = ""
    escape: Array | None = None
    yielding: dict[str, Array] = field(default_factory=dict)


class EquilibriumSearch:
    """The search of one grasp that could be held. It can be paused: `run` goes on where it stopped."""

    def __init__(self, problem: GraspContactProblem) -> None:
        self.problem, self._modes = problem, None
        self._known_result: EquilibriumSearchResult | None = None
        if not has_only_limits(problem):
            words = "impossible, an effect moves the contacts by more than limits that give way"
            self._known_result = EquilibriumSearchResult(words)
        elif (proof := prove_overload(problem.scene, problem.section, problem.effects)) is not None:
            self._known_result = _overload_result(problem, proof)
        elif not (problem.faces and problem.scene.soft):  # the faces of moments' polyhedra are unknown to modes
            self._modes = ContactModeSearch(problem)

    def run(self, work: float, end: float = math.inf) -> EquilibriumSearchResult:
        """What is known after so many multiply-adds in all; end : of `time.monotonic`, if earlier."""
        if self._known_result is not None:
            return self._known_result
        problem, scene = self.problem, self.problem.scene
        found = _search_active_sets(problem, work, end) if self._modes is None else search_modes(self._modes, work, end)
        if found.bounds is not None and not any(e.present(scene) for e in problem.effects) and is_jammed(scene):
            return replace(found, cause="rigid fingers cannot give way to the squeeze")
        return found

    @property
    def is_brief(self) -> bool:
        """Whether a small budget may decide: a search over active sets begins anew each time, and what is impossible
        stays so.
        """
        return self._modes is not None or (self._known_result is not None and self._known_result.bounds is not None)


def _overload_result(problem: GraspContactProblem, proof: Array) -> EquilibriumSearchResult:
    """Which limits stand in the way of any equilibrium, and how the object escapes while they give way."""
    scene = problem.scene
    t, moves = np.split(proof, [scene.dof])
    yielding, parts, at, least = {}, [], 0, None
    for e in problem.effects:
        taking_part = False
        for limit in e.present(scene):
            own = moves[at : at + len(limit.room)]
            at += len(own)
            taking_part |= bool((own > ACTIVE_TOLERANCE * moves.max(initial=0.0)).any())
            yielding[limit.name] = own * limit.unknown.sizes(scene)[0]
        if taking_part:
            parts.append(e.called)
            least = e.shortfall(least_normal_sum(scene, problem.section)) or least
    verb = "together leave" if len(parts) > 1 else "leave" if parts[0].endswith("s") else "leaves"
    cause = least or f"the {' and the '.join(parts)} {verb} no force that balances it"
    return EquilibriumSearchResult("limits on the forces, none", None, proof_bounds(scene), cause, t, yielding)


def search_modes(search: ContactModeSearch, work: float, end: float = math.inf) -> EquilibriumSearchResult:
    """By the contact modes; `search` goes on where it stopped."""
    candidate, modes = search.find_first(work, end), search.search
    words = f"{modes.node_count:,} choices of contact modes,"
    if candidate is not None:
        return EquilibriumSearchResult(f"{words} solution", candidate)
    if modes.is_none_proven:
        return EquilibriumSearchResult(f"{words} none", bounds=search.bounds)
    return EquilibriumSearchResult(f"{words} unknown")


def _search_active_sets(problem: GraspContactProblem, work: float, end: float) -> EquilibriumSearchResult:
    """By the active sets of the LCP with a multiplier a face."""
    lcp = GraspProblem(problem)
    result = search_active_sets(lcp, work=work, end=end, accept=lambda z: is_certified(problem, lcp.candidate(z)))
    words = f"over active sets, {result.outcome}"
    if result.z is not None:
        return EquilibriumSearchResult(words, lcp.candidate(result.z))
    size = float(result.bound_z[~lcp.free].max(initial=0.0))
    bounds = bounds_in_si(problem.scene, size) if result.outcome == "none" else None
    return EquilibriumSearchResult(words, bounds=bounds)
