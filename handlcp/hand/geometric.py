"""The forces of a grasp whose fingers are softened or stiffened by those very forces: solved again until they stay.

    f ← forces of the grasp with E(f) and d(f),    d += J [(K + K_g)⁻¹ g - K⁻¹ g + (K + K_g)⁻¹ K_g δq]

E(f) as in `GeometricStiffness`; d(f) is what its joints make of the fingers' weight g and of a commanded offset δq,
each absent unless asked for. Torques are those in the given posture, Jᵀ f; the weight's own gradient ∂g/∂q is left out.
Every solve is certified for its E, and the last one for the E of its own forces: that is what SOLVED means here. Where
fingers buckle, where the forces keep changing, or where the softened grasp has no answer, nothing is claimed.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError, NoSolutionFound
from handlcp.grasp import arguments
from handlcp.grasp.assemble import assemble_contact
from handlcp.grasp.changed import changed
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness, relative
from handlcp.grasp.first import NOWHERE
from handlcp.grasp.pyramid import Pyramid, Section
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.solving import solve
from handlcp.hand.weight import tip_motion
from handlcp.lcp import Auto, ContactSolver, Solver, Status
from handlcp.tolerances import FIXED_POINT, SEMIDEFINITE

if TYPE_CHECKING:
    from handlcp.hand.grasp import HandGrasp
    from handlcp.hand.solution import HandGraspSolution

__all__ = ["bends", "geometric_change", "of_the_joints", "settle", "under"]

_MOST = 100  # solves


def bends(grasp: HandGrasp) -> GeometricStiffness | None:
    """The effect, where the grasp has it."""
    return next((e for e in grasp.stamped if isinstance(e, GeometricStiffness)), None)


def settle(
    grasp: HandGrasp,
    effect: GeometricStiffness,
    section: Section,
    solver: Solver | ContactSolver | Auto | None,
    throw: bool,
    start: Array,
) -> GraspSolution:
    """As `solving.solve`; the trace ends with how the iteration went. What is said of uniqueness holds for the last E.

    Raises InputError where the grasp's flexibility was replaced by less than that of its joints.
    """
    of_the_joints(grasp, "GeometricStiffness")
    n, forces, solution = grasp.scene.n, np.zeros((grasp.scene.n, 3)), None
    given = start
    if len(start):
        forces = start[: 3 * n].reshape(n, 3)
    words, change = f"the forces still change after {_MOST} solves", np.inf
    for count in range(1, _MOST + 1):
        bent = under(grasp, effect, forces)
        if bent is None:
            words = _buckled(effect, forces)
            break
        solution = solve(bent, section, solver, False, start)
        if not solution.held:
            if count == 1 and len(given):
                return settle(grasp, effect, section, solver, throw, NOWHERE)
            words = f"no answer with the flexibility under these forces, in solve {count}: {solution.status.name}"
            break
        change, forces = relative(solution.forces - forces, solution.forces), solution.forces
        start = arguments.start(solution, n)
        if change <= FIXED_POINT or count == _MOST:
            made = _certified(grasp, effect, bent, solution, f"{count} solves, forces change by {change:.1e}")
            if made.held:
                return made
            words = made.trace[-1] if change <= FIXED_POINT else words
    if solution is None:  # buckled at the start that was passed
        return settle(grasp, effect, section, solver, throw, NOWHERE)
    if solution.status is not Status.NOT_HOLDABLE:  # whatever gives way, no force within friction balances the load
        solution = _open(grasp, solution)
    solution = replace(solution, trace=(*solution.trace, f"geometric stiffness: {words}"))
    if throw:
        problem = assemble_contact(grasp.scene, section, grasp.stamped)
        raise NoSolutionFound("\n  ".join((str(solution), *solution.trace)), problem, solution)
    return solution


def geometric_change(grasp: HandGrasp, solution: GraspSolution, faces: int | str | Pyramid = 8) -> Array:
    """(n,) by how much geometric stiffness would change each finger's force, as a share of the largest force: from one
    correction, E under the solution's own forces. Infinite where a finger buckles under them or the corrected grasp
    has no answer; 0 to rounding where the grasp has the effect already.

    solution : of this grasp, an answer. faces : those that it was solved with. It costs one solve and the second
    derivatives. Raises InputError.
    """
    n = grasp.scene.n
    start = arguments.start(solution, n)
    if not len(start):
        raise InputError("solution", "an answer of this grasp", "one without forces" if solution else repr(solution))
    section = grasp._section(faces)
    effect = bends(grasp) or GeometricStiffness().for_grasp("grasp", n, grasp.joints, ())
    bent = under(grasp, effect, solution.forces)
    again = None if bent is None else solve(bent, section, Auto(search_seconds=0), False, start)
    if again is None or not again.held:
        return read_only(np.full(n, np.inf))
    moved = np.sqrt(((again.forces - solution.forces) ** 2).sum(axis=1))
    return read_only(moved / (np.sqrt((solution.forces**2).sum(axis=1).max()) or 1.0))


def of_the_joints(grasp: HandGrasp, beside: str) -> None:
    """Raises InputError unless E has the joints' share: K_g changes it, and it also turns soft fingertips."""
    pads = np.linalg.eigvalsh(grasp.flexibility - grasp.state.hand.stiffness.compliance(grasp.jacobian))
    if pads[0] < -SEMIDEFINITE * float(abs(grasp.flexibility).max(initial=0.0)):
        expected = f"that of the hand's joints, and what else gives way, beside {beside}"
        raise InputError("flexibility", expected, f"less than its joints have by up to {-pads[0]:.3g} m/N")


def under(grasp: HandGrasp, effect: GeometricStiffness, forces: Array) -> HandGrasp | None:
    """The grasp without the effect, with the E and the offsets that it has under these forces; None: it buckles."""
    change = effect.change(forces)
    if change is None:
        return None
    others = tuple(e for e in grasp.effects if not isinstance(e, GeometricStiffness))
    offset = grasp.offset
    if grasp.sag.any() or grasp.joint_offset.any():
        C = effect.compliance(forces)
        assert C is not None  # there is a change
        moved = _given_way(grasp, effect, C, forces, np.zeros(len(C))) - grasp.sag
        offset = offset + tip_motion(grasp.jacobian, moved, grasp.scene.plane is not None)
    return changed(grasp, flexibility=read_only(grasp.flexibility + change), offset=read_only(offset), effects=others)


def _given_way(grasp: HandGrasp, effect: GeometricStiffness, C: Array, forces: Array, torque: Array) -> Array:
    """(nv,) how far the joints stand from where they are commanded: (K + K_g)⁻¹ (τ + g + K_g δq)."""
    weight = grasp.gravity_torque if grasp.finger_weight is True else 0.0
    return np.asarray(C @ (torque + weight + effect.stiffness(forces) @ grasp.joint_offset))


def _certified(
    grasp: HandGrasp, effect: GeometricStiffness, bent: HandGrasp, solution: GraspSolution, words: str
) -> GraspSolution:
    """The solution with the effect's own law among its residuals: E and offsets are those of its forces."""
    own, C = under(grasp, effect, solution.forces), effect.compliance(solution.forces)
    if own is None or C is None:
        return _open(grasp, replace(solution, trace=(_buckled(effect, solution.forces),)))
    miss = relative(own.flexibility - bent.flexibility, own.flexibility)
    if (moved := own.offset - bent.offset).any():
        miss = max(miss, float(abs(moved).max()) / solution.residuals.motion_scale)
    residuals = replace(solution.residuals, effects=max(solution.residuals.effects, miss))
    said = f"{words}, E(f) by {miss:.1e}"
    if not residuals.passes:
        return _open(grasp, replace(solution, residuals=residuals, trace=(said,)))
    torque = solution.forces.reshape(-1) @ grasp.jacobian
    deflection = read_only(_given_way(grasp, effect, C, solution.forces, torque))
    trace = (*solution.trace, f"geometric stiffness: {said}")
    more: dict[str, Any] = {"joint_deflection": deflection}
    return replace(solution, residuals=residuals, trace=trace, **more)


def _buckled(effect: GeometricStiffness, forces: Array) -> str:
    return f"K + K_g is not positive definite: {', '.join(effect.buckling(forces))} buckle under these forces"


def _open(grasp: HandGrasp, solution: GraspSolution) -> HandGraspSolution:
    """UNDECIDED, without numbers that anybody could use: what was proven of one E is not proven of all."""
    parts = {f.name: getattr(solution, f.name) for f in fields(GraspSolution)}
    for name in ("forces", "forces_world", "gap", "slip", "object_displacement"):
        parts[name] = read_only(np.full_like(parts[name], np.nan))
    none: dict[str, Any] = {
        "status": Status.UNDECIDED, "contact_state": ("unknown",) * grasp.scene.n, "uniqueness": None,
        "certificate": None, "extra": {}, "bounds": None, "required_preload": None, "scene": grasp.scene,
    }  # fmt: skip
    return grasp._complete(GraspSolution(**(parts | none)))
