"""Where the solvers fail on a grasp that could be held: an exact search, for an answer or the proof of none.

limits on the forces   a linear program (`verify.limit_load`): no forces within friction and limits balance the load
contact modes          all of them at once (`lcp.modes`): pyramids and planes exactly, the cone by arcs that are
                       refined where they do not decide; on pyramids one by one (`mode_walk`) where that leaves doubt
moments, with faces    the active sets of the LCP with a multiplier a face (`lcp.search`)

Budgets count multiply-adds, so that what is proven depends on no clock.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field, replace

import numpy as np

from handlcp.check import Array
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.assembly.problem import GraspProblem
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.search.mode_table import mode_table
from handlcp.grasp.search.mode_walk import first_certified, only_limits_move, passes
from handlcp.grasp.verify.capacity import overload
from handlcp.grasp.verify.holdable import jammed, least_total
from handlcp.lcp.modes.search import ModeSearch
from handlcp.lcp.search import search
from handlcp.tolerances import ACTIVE

_EACH = 200.0  # multiply-adds that one choice takes
_MOST_CANDIDATES = 100  # of those one by one; a few are usual
_WIDE = 1e3  # of the box in which nothing is proven to exist, times 1 + max|d̂|


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a search established; words : for the trace.

    candidate : a certified one, or None. bounds : forces [N] and motions [m] up to which there is proven to be none, or
    None; cause : of that, where it is known. escape (dof,), yielding : where limits on the forces are the cause, the
    motion in natural units and by how much each limit gives way, by name, SI.
    """

    words: str
    candidate: Candidate | None = None
    bounds: tuple[float, float] | None = None
    cause: str = ""
    escape: Array | None = None
    yielding: dict[str, Array] = field(default_factory=dict)


class EquilibriumSearch:
    """The search of one grasp that could be held. It can be paused: `run` goes on where it stopped."""

    def __init__(self, problem: GraspContactProblem) -> None:
        self.problem, self._at_once = problem, _at_once(problem)
        self._modes = None if self._at_once is not None or _moments_with_faces(problem) else OverModes(problem)

    def run(self, work: float, end: float = math.inf) -> Outcome:
        """What is known after so many multiply-adds in all; end : of `time.monotonic`, if earlier."""
        if self._at_once is not None:
            return self._at_once
        problem, scene = self.problem, self.problem.scene
        found = _on_active_sets(problem, work, end) if self._modes is None else self._modes.run(work, end)
        if self._modes is not None and self._modes.doubtful and found.candidate is None:
            found = _one_by_one(problem, work, found)
        if found.bounds is not None and not any(e.present(scene) for e in problem.effects) and jammed(scene):
            return replace(found, cause="rigid fingers cannot give way to the squeeze")
        return found

    @property
    def brief(self) -> bool:
        """Whether a small budget may decide: a search over active sets begins anew each time, and what is impossible
        stays so.
        """
        return self._modes is not None or (self._at_once is not None and self._at_once.bounds is not None)


def _at_once(problem: GraspContactProblem) -> Outcome | None:
    """What is known without a search."""
    scene, effects, section = problem.scene, problem.effects, problem.section
    if not only_limits_move(problem):
        return Outcome("impossible, an effect moves the contacts by more than limits that give way")
    proof = overload(scene, section, effects)
    return None if proof is None else _overloaded(scene, section, effects, proof)


def _moments_with_faces(problem: GraspContactProblem) -> bool:
    """Whether some contact has a polyhedron, whose faces the modes do not know."""
    return bool(problem.faces and problem.scene.soft)


class OverModes:
    """The search over contact modes."""

    def __init__(self, problem: GraspContactProblem) -> None:
        self.problem, self._bounds = problem, _wide(problem.scene)
        b = self._bounds[0] / problem.scene.units.force
        most_x, most_y = np.full((2, problem.n), b)
        most_y[problem.limited] = _slack(problem, b)
        self._search = ModeSearch(problem, most_x, most_y)

    def run(self, work: float, end: float = math.inf) -> Outcome:
        """As `EquilibriumSearch.run`."""
        for x in self._search.candidates(work, end):
            if (candidate := first_certified(self.problem, [self.problem.candidate(x)])) is not None:
                return Outcome(f"{self._words} solution", candidate)
        if self._search.none:
            return Outcome(f"{self._words} none", bounds=self._bounds)
        return Outcome(f"{self._words} unknown")

    @property
    def doubtful(self) -> bool:
        """Whether the search is over, and something that might have been an answer was refused."""
        return self._search.ended and not self._search.none

    @property
    def _words(self) -> str:
        return f"{self._search.nodes:,} choices of contact modes,"


def _wide(scene: Scene) -> tuple[float, float]:
    """The largest forces [N] and motions [m] for which proofs claim that there is no equilibrium. Some hold without
    bounds, and state these, too.
    """
    return _si(scene, _WIDE * (1.0 + float(abs(scene.offset).max(initial=0.0)) / scene.units.motion))


def _si(scene: Scene, size: float) -> tuple[float, float]:
    """So many natural units of force [N] and of motion [m]."""
    return size * scene.units.force, size * scene.units.motion


def _overloaded(scene: Scene, section: Section, effects: tuple[Effect, ...], proof: Array) -> Outcome:
    """Which limits stand in the way of any equilibrium, and how the object escapes while they give way."""
    t, moves = np.split(proof, [scene.dof])
    yielding, parts, at, least = {}, [], 0, None
    for e in effects:
        taking_part = False
        for limit in e.present(scene):
            own = moves[at : at + len(limit.room)]
            at += len(own)
            taking_part |= bool((own > ACTIVE * moves.max(initial=0.0)).any())
            yielding[limit.name] = own * limit.unknown.sizes(scene)[0]
        if taking_part:
            parts.append(e.called)
            least = e.shortfall(least_total(scene, section)) or least
    verb = "together leave" if len(parts) > 1 else "leave" if parts[0].endswith("s") else "leaves"
    cause = least or f"the {' and the '.join(parts)} {verb} no force that balances it"
    return Outcome("limits on the forces, none", None, _wide(scene), cause, t, yielding)


def _one_by_one(problem: GraspContactProblem, work: float, unknown: Outcome) -> Outcome:
    """By every choice of contact modes on its own, each solved to the last digit, where they are few enough."""
    table = mode_table(problem)
    if table is None or table.choices * _EACH > work:
        return unknown
    candidates, every = table.visit()
    words, doubtful = f"all {table.choices:,.0f} choices of contact modes one by one,", not every
    for c in itertools.islice(candidates, _MOST_CANDIDATES):
        candidate = None if c is None else first_certified(problem, [c])
        if candidate is not None:
            return Outcome(f"{words} solution", candidate)
        doubtful |= c is not None
    doubtful |= next(candidates, None) is not None
    return unknown if doubtful else Outcome(f"{words} none", bounds=_wide(problem.scene))


def _on_active_sets(problem: GraspContactProblem, work: float, end: float) -> Outcome:
    """By the active sets of the LCP with a multiplier a face."""
    lcp = GraspProblem(problem)
    result = search(lcp, work=work, end=end, accept=lambda z: passes(problem, lcp.candidate(z)))
    words = f"over active sets, {result.outcome}"
    if result.z is not None:
        return Outcome(words, lcp.candidate(result.z))
    size = float(result.bound_z[~lcp.free].max(initial=0.0))
    return Outcome(words, bounds=_si(problem.scene, size) if result.none_exists else None)


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
