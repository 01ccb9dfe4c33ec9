"""From a judged candidate to what a designer gets: status, states, uniqueness, the smallest motion, all in SI."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.active_conditions import free_branches
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.uniqueness import Uniqueness, describe, minimum_norm
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.kind import shifted
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verify.contact_laws import in_world
from handlcp.grasp.verify.contact_states import classify, names_of
from handlcp.grasp.verify.judge import Residuals, Verdict, judge
from handlcp.lcp import Status


class Judged(NamedTuple):
    """A candidate, what the certifier says of it, and how many steps of the method it took."""

    candidate: Candidate
    verdict: Verdict
    iterations: int


def make_solution(
    spec: GraspSpec, scene: Scene, section: Section, effects: tuple[Effect, ...], judged: Judged,
    trace: tuple[str, ...], smallest: bool = True,
) -> GraspSolution:  # fmt: skip
    """The solution from a candidate that the certifier passes; effects : all that were stamped. smallest : where it
    leaves something free, the least forces and motion in place of the candidate's.
    """
    candidate, verdict, arm = judged.candidate, judged.verdict, spec.reference - scene.units.centre
    states = classify(scene, section, candidate, verdict)
    if not all(e.only_limits for e in effects):
        return solution_of(spec, scene, section, judged, names_of(states.kind), None, trace, arm)
    free = free_branches(scene, effects, section, states, candidate)
    if free and smallest:
        least = minimum_norm(scene, effects, section, states, candidate, verdict, free)
        if (checked := judge(scene, effects, section, least)).residuals.passes:
            judged = Judged(least, checked, judged.iterations)
            states = classify(scene, section, least, checked)
    free_to = replace(describe(scene, free, arm), smallest=smallest)
    return solution_of(spec, scene, section, judged, names_of(states.kind), free_to, trace, arm)


def solution_of(
    spec: GraspSpec, scene: Scene, section: Section, judged: Judged, states: tuple[str, ...],
    uniqueness: Uniqueness | None, trace: tuple[str, ...], arm: Array,
) -> GraspSolution:  # fmt: skip
    """A SOLVED solution with these numbers, and with what moves the fingers reads off it; arm (3,) [m] leads from the
    point that the candidate's twist refers to to the grasp's reference.
    """
    candidate, n = judged.candidate, scene.n
    forces, motion = scene.physical(candidate.components), scene.lawful(judged.verdict.motion)
    points = motion[: 3 * n].reshape(-1, 3)
    if not all(scene.governed):  # no law makes a finger under force control keep a gap or a slip
        points = np.where(scene.governed_mask[:, None], points, 0.0)
    own = read_only(forces[: 3 * n].reshape(-1, 3))
    torsion, spin, read, kind = None, None, dict[str, Any](), GraspSolution
    if scene.soft:
        torsion, spin = scene.by_contact(forces[3 * n :]), scene.by_contact(motion[3 * n :])
    mechanism = spec.mechanism
    if mechanism is not None:
        kind, read = mechanism.solution, mechanism.read(scene, spec.effects, own, torsion, candidate.extra)
    return kind(
        status=Status.SOLVED, names=spec.names, forces=own,
        forces_world=read_only(in_world(scene.frames, candidate.components)), gap=read_only(points[:, 2]),
        slip=read_only(points[:, :2]), object_displacement=read_only(shifted(candidate.twist, arm)),
        contact_state=states, residuals=judged.verdict.residuals, uniqueness=uniqueness, certificate=None,
        iterations=judged.iterations, trace=trace, extra=candidate.extra, torsion=torsion, spin=spin, scene=scene,
        reference=spec.reference, spec=spec, section=section, **read,
    )  # fmt: skip


def not_holdable(made: GraspSolution, spec: GraspSpec, scene: Scene, twist: Array) -> GraspSolution:
    """The solution without numbers, with the proof that nothing holds: a motion (6,) about the contacts' centre."""
    return replace(made, status=Status.NOT_HOLDABLE, certificate=certificate_of(spec, scene, twist))


def certificate_of(spec: GraspSpec, scene: Scene, twist: Array) -> Array:
    """(6,) as a solution tells a motion about the contacts' centre: about the grasp's reference."""
    return read_only(shifted(twist, spec.reference - scene.units.centre))


def without_numbers(
    spec: GraspSpec, scene: Scene, section: Section, residuals: Residuals, iterations: int, trace: tuple[str, ...]
) -> GraspSolution:
    """UNDECIDED, without numbers that anybody could use."""
    nothing = np.full(scene.components, np.nan)
    judged = Judged(
        Candidate(nothing, np.full(6, np.nan), {}, len(scene.soft)), Verdict(nothing, residuals), iterations
    )
    made = solution_of(spec, scene, section, judged, ("unknown",) * scene.n, None, trace, np.zeros(3))
    return replace(made, status=Status.UNDECIDED)
