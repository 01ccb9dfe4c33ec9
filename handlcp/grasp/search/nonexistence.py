"""Where the solvers fail on a grasp that could be held: an exact search, for an answer or the proof of none.

limits on the forces   a linear program (`verify.limit_load`): no forces within friction and limits balance the load
pyramids, a plane      every choice of contact modes (`mode_walk`) where they are few enough
the cone               every choice of modes on a pyramid of four faces, whose equilibria are places to start from
then                   the mixed-integer program over contact modes (`lcp.mode_program`), on polyhedra over the active
sets of the LCP with a multiplier a face (`lcp.search`)
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from handlcp.check import Array
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.assembly.problem import GraspProblem
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.search.mode_table import PER_SECOND, coarse, mode_table
from handlcp.grasp.search.nearby import first_certified, only_limits_move, passes
from handlcp.grasp.verify.holdable import jammed, least_total
from handlcp.grasp.verify.limit_load import overload
from handlcp.lcp.mode_program import ModeProgram
from handlcp.lcp.search import search
from handlcp.tolerances import ACTIVE

__all__ = ["Outcome", "over_modes", "search_equilibrium"]

_COARSE = 4  # faces of the pyramid that is searched before the cone
_WIDE = 1e3  # of the box in which nothing is proven to exist, times 1 + max|d̂|
_CUTS = 8  # choices of modes that the certifier refuses before the search gives up


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


def search_equilibrium(problem: GraspContactProblem, seconds: float) -> Outcome:
    """Search for an equilibrium of a grasp that could be held. May take 1.5 times the seconds."""
    scene, effects, section = problem.scene, problem.effects, problem.section
    if not only_limits_move(problem):
        return Outcome("impossible, an effect moves the contacts by more than limits that give way")
    if (proof := overload(scene, section, effects)) is not None:
        return _overloaded(scene, section, effects, proof)
    found = _on_cone(problem, seconds) if not section.faces else _on_faces(problem, seconds)
    if found.bounds is not None and not any(e.present(scene) for e in effects) and jammed(scene):
        return Outcome(found.words, bounds=found.bounds, cause="rigid fingers cannot give way to the squeeze")
    return found


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


def _on_faces(problem: GraspContactProblem, seconds: float) -> Outcome:
    """By all choices of contact modes where they are few and leave no doubt, else by the active sets of the LCP."""
    table, end = mode_table(problem), time.monotonic() + seconds
    if table is not None and table.choices <= PER_SECOND * seconds:
        candidates, every = table.visit()
        # The walk counts by its choices, not by the clock: it may have been compiled first
        end = time.monotonic() + seconds - table.choices / PER_SECOND
        words, doubtful = f"all {table.choices:,.0f} choices of contact modes,", not every
        for c in candidates:
            if c is not None:
                if (candidate := first_certified(problem, [c])) is not None:
                    return Outcome(f"{words} solution", candidate)
                doubtful = True
            if time.monotonic() > end:
                doubtful = True
                break
        if not doubtful:
            return Outcome(f"{words} none", bounds=_wide(problem.scene))
    return over_modes(problem, max(end, time.monotonic() + 0.5 * seconds))


def _on_active_sets(problem: GraspContactProblem, seconds: float) -> Outcome:
    """By the active sets of the LCP with a multiplier a face."""
    lcp = GraspProblem(problem)
    result = search(lcp, seconds=seconds, accept=lambda z: passes(problem, lcp.candidate(z)))
    words = f"over active sets, {result.outcome}"
    if result.z is not None:
        return Outcome(words, lcp.candidate(result.z))
    size = float(result.bound_z[~lcp.free].max(initial=0.0))
    return Outcome(words, bounds=_si(problem.scene, size) if result.none_exists else None)


def _on_cone(problem: GraspContactProblem, seconds: float) -> Outcome:
    """From all equilibria of a coarse pyramid, then by the mixed-integer program."""
    end = time.monotonic() + seconds
    near = (c for c in coarse(problem, _COARSE, 0.5 * seconds) if c is not None)
    if (candidate := first_certified(problem, near)) is not None:
        return Outcome(f"from the pyramid of {_COARSE} faces, solution", candidate)
    return over_modes(problem, max(end, time.monotonic() + 0.5 * seconds))


def over_modes(problem: GraspContactProblem, end: float, bound: float | None = None) -> Outcome:
    """By the mixed-integer program over contact modes; end : of `time.monotonic`.

    bound : of normal forces, gaps and slips in natural units, as far as "none" is claimed; None: a thousand.
    """
    if problem.faces and problem.scene.soft:  # it knows no polyhedra
        return _on_active_sets(problem, max(end - time.monotonic(), 1e-9))
    bounds, none = _wide(problem.scene) if bound is None else _si(problem.scene, bound), True
    b = bounds[0] / problem.scene.units.force
    most_x, most_y = np.full((2, problem.n), b)
    most_y[problem.limited] = _slack(problem, b)
    program = ModeProgram(problem, most_x, most_y)
    for points in program.visit(end, _CUTS):
        if (candidate := first_certified(problem, (problem.candidate(x) for x in points))) is not None:
            return Outcome("over contact modes, solution", candidate)
        none = False
    none = none and program.exhausted
    return Outcome(f"over contact modes, {'none' if none else 'unknown'}", bounds=bounds if none else None)


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
