"""Where the solvers fail on a grasp that could be held: an exact search, for an answer or the proof of none.

limits on the forces   a linear program (`verify.limit_load`): no forces within friction and limits balance the load
contact modes          all of them at once (`over_modes`): pyramids and planes exactly, the cone by arcs that are
                       refined where they do not decide
moments, with faces    the active sets of the LCP with a multiplier a face (`lcp.search`)

Budgets count multiply-adds, so that what is proven depends on no clock.
"""

from __future__ import annotations

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
from handlcp.grasp.search.over_modes import OverModes, only_limits_move, passes, si, wide
from handlcp.grasp.verify.capacity import overload
from handlcp.grasp.verify.holdable import jammed, least_total
from handlcp.lcp.search import search
from handlcp.tolerances import ACTIVE


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
        found = _on_active_sets(problem, work, end) if self._modes is None else over_modes(self._modes, work, end)
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
    return Outcome("limits on the forces, none", None, wide(scene), cause, t, yielding)


def over_modes(search: OverModes, work: float, end: float = math.inf) -> Outcome:
    """By the contact modes; `search` goes on where it stopped."""
    candidate, modes = search.first(work, end), search.search
    words = f"{modes.nodes:,} choices of contact modes,"
    if candidate is not None:
        return Outcome(f"{words} solution", candidate)
    return Outcome(f"{words} none", bounds=search.bounds) if modes.none else Outcome(f"{words} unknown")


def _on_active_sets(problem: GraspContactProblem, work: float, end: float) -> Outcome:
    """By the active sets of the LCP with a multiplier a face."""
    lcp = GraspProblem(problem)
    result = search(lcp, work=work, end=end, accept=lambda z: passes(problem, lcp.candidate(z)))
    words = f"over active sets, {result.outcome}"
    if result.z is not None:
        return Outcome(words, lcp.candidate(result.z))
    size = float(result.bound_z[~lcp.free].max(initial=0.0))
    return Outcome(words, bounds=si(problem.scene, size) if result.none_exists else None)
