"""Where the solvers fail on a grasp that could be held: an exact search, for an answer or the proof of none."""

from __future__ import annotations

import time

from handlcp.check import Array
from handlcp.grasp.assemble import GraspContact, GraspProblem
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.certify import judge
from handlcp.grasp.diagnosis import Within
from handlcp.grasp.effects import Effect, KnownForce, TorqueSaturation, TotalForceBound
from handlcp.grasp.equilibria import Believer, applicable, find_equilibrium, widest
from handlcp.grasp.holdable import jammed, least_total, load_to_balance
from handlcp.grasp.mode_table import PER_SECOND, mode_table
from handlcp.grasp.overload import overload
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_form import GraspBalls
from handlcp.lcp.search import search
from handlcp.tolerances import ACTIVE

__all__ = ["Found", "last_resort"]

Found = tuple[Candidate | None, tuple[float, float] | None, str]


def last_resort(problem: GraspProblem | GraspContact | GraspBalls, section: Section, seconds: float) -> Found:
    """(candidate, bounds, words): a certified candidate; or the forces [N] and motions [m] within which there is none
    (with the cause, where one is known); or neither, when the time was too short. Of the seconds half as much again may
    pass.
    """
    scene, effects = problem.scene, problem.effects
    if not applicable(effects):
        return None, None, "impossible, an effect moves the contacts by more than limits that give way"
    if (proof := overload(scene, section, effects)) is not None:
        return None, Within(_wide(scene), _overloaded(scene, section, effects, proof)), "limits on the forces, none"
    candidate, bounds, words = _found(problem, section, seconds)
    if bounds is not None:
        stiff = not any(e.opens for e in effects) and jammed(scene)
        bounds = Within(bounds, "rigid fingers cannot give way to the squeeze" if stiff else "")
    return candidate, bounds, words


def _wide(scene: Scene) -> tuple[float, float]:
    """The bounds of a search [N, m], which are stated of a proof that has none."""
    size = widest(scene)
    return size * scene.units.force, size * scene.units.motion


def _overloaded(scene: Scene, section: Section, effects: tuple[Effect, ...], proof: Array) -> str:
    """Which limits stand in the way of any equilibrium."""
    for e in effects:
        if isinstance(e, TotalForceBound):
            least = least_total(scene, section, load_to_balance(scene, effects))
            if least is not None and least > 1.001 * e.limit:  # so that the two numbers differ in print
                return f"the total normal force is bounded to {e.limit:.4g} N, and balance needs {least:.4g} N"
    titles = _taking_part(scene, effects, proof[scene.dof :])
    verb = "together leave" if len(titles) > 1 else "leave" if titles[0].endswith("s") else "leaves"
    return f"the {' and the '.join(titles)} {verb} no force that balances it"


def _called(e: Effect) -> str:
    """An effect's limits, as a designer calls them."""
    if isinstance(e, KnownForce):
        return f"known force of contact {e.contact}"
    return "joints' torque limits" if isinstance(e, TorqueSaturation) else e.title


def _taking_part(scene: Scene, effects: tuple[Effect, ...], moves: Array) -> list[str]:
    """Titles of the effects whose limits give way in an overload, by the motions (m,) that prove it."""
    titles, at = [], 0
    for e in effects:
        end = at + sum(len(limit.room) for limit in e.present(scene))
        if (moves[at:end] > ACTIVE * moves.max(initial=0.0)).any():
            titles.append(_called(e))
        at = end
    return titles


def _found(problem: GraspProblem | GraspContact | GraspBalls, section: Section, seconds: float) -> Found:
    """By all choices of contact modes where they are few, else by search."""
    if isinstance(problem, GraspBalls) and section.faces:
        return _on_polyhedra(problem, section, seconds)
    quick, left = _every_mode(problem, section, seconds)
    if quick is not None:
        return quick
    found = find_equilibrium(problem.scene, problem.effects, section, left)
    words = f"over contact modes, {found.outcome}"
    return found.candidate, (found.force_bound, found.motion_bound) if found.outcome == "none" else None, words


def _on_polyhedra(problem: GraspBalls, section: Section, seconds: float) -> Found:
    """Soft fingers on polyhedra: by the active sets of the LCP with a multiplier a face."""
    plain, _ = problem.pyramid(section.faces)
    assert isinstance(plain, GraspProblem)
    scene, effects = problem.scene, problem.effects

    def passes(z: Array) -> bool:
        return judge(scene, effects, section, plain.candidate(z)).residuals.passes

    result = search(plain, seconds=seconds, accept=passes)
    words = f"over active sets, {result.outcome}"
    if result.z is not None:
        return plain.candidate(result.z), None, words
    size, units = float(result.bound_z[~plain.free].max(initial=0.0)), scene.units
    return None, (size * units.force, size * units.motion) if result.none_exists else None, words


def _every_mode(
    problem: GraspProblem | GraspContact | GraspBalls, section: Section, seconds: float
) -> tuple[Found | None, float]:
    """By solving every choice of contact modes, where that is affordable and leaves no doubt. This proof has no bounds;
    those of the mixed-integer search are stated, as far beyond them rounding could hide an answer. Also the seconds
    that are left after it, half of them at least.
    """
    contact = problem.contact if isinstance(problem, GraspProblem) else problem
    table = mode_table(contact) if section.faces and isinstance(contact, GraspContact) else None
    if table is None or table.choices > PER_SECOND * seconds:
        return None, seconds
    candidates, every = table.visit()
    # The walk counts by its choices, not by the clock: it may have been compiled first
    end = time.monotonic() + seconds - table.choices / PER_SECOND
    words = f"all {table.choices:,.0f} choices of contact modes,"
    believed, doubtful = Believer(problem.scene, problem.effects, section), False
    for c in candidates:
        if c is not None:
            if (candidate := believed([c])) is not None:
                return (candidate, None, f"{words} solution"), seconds
            doubtful = True
        if time.monotonic() > end:
            every = False
            break
    if doubtful or not every:
        return None, max(end - time.monotonic(), 0.5 * seconds)
    return (None, _wide(problem.scene), f"{words} none"), seconds
