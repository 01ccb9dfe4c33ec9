"""From a judged candidate to what a designer gets: status, states, uniqueness, the smallest motion, all in SI."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.certify import Verdict, judge
from handlcp.grasp.effects import Effect
from handlcp.grasp.first import Found
from handlcp.grasp.holdable import escaping_twist, load_to_balance
from handlcp.grasp.kernels import to_world
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene, shifted
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.states import classify
from handlcp.grasp.tangent import free_branches
from handlcp.grasp.uniqueness import Uniqueness, describe, minimum_norm
from handlcp.lcp import Status

__all__ = ["conclude", "conclude_first"]


def conclude(
    scene: Scene,
    reference: Array,
    finger_names: tuple[str, ...],
    effects: tuple[Effect, ...],
    section: Section,
    candidate: Candidate,
    verdict: Verdict,
    iterations: int,
    trace: tuple[str, ...],
) -> GraspSolution:
    """The solution that the certifier's verdict allows; where it allows none, the proof that nothing holds, if any."""
    arm = reference - scene.units.centre
    uniqueness: Uniqueness | None = None
    certificate: Array | None = None
    if verdict.residuals.passes:
        status = Status.SOLVED
        states = classify(scene, section, candidate, verdict)
        free = free_branches(scene, effects, section, states, candidate)
        if free:
            smallest = minimum_norm(scene, effects, section, states, candidate, verdict, free)
            if (checked := judge(scene, effects, section, smallest)).residuals.passes:
                candidate, verdict = smallest, checked
                states = classify(scene, section, candidate, verdict)
        uniqueness = describe(scene, free, arm)
        names = states.names
    else:
        status, names = Status.UNDECIDED, ("unknown",) * scene.n
        if (twist := escaping_twist(scene, section, load_to_balance(scene, effects))) is not None:
            status, certificate = Status.NOT_HOLDABLE, read_only(shifted(twist, arm))
        nothing = np.full((scene.n, 3), np.nan)  # so that nobody uses them by accident
        candidate = Candidate(nothing, np.full(6, np.nan), {}, np.full(len(scene.soft), np.nan))
        verdict = Verdict(nothing, verdict.residuals, candidate.torsion)
    # A finger under force control follows the object: no law makes it keep a gap or a slip
    motion = verdict.motion
    if not all(scene.governed):
        motion = np.where(scene.governed_mask[:, None], motion, 0.0)
    return GraspSolution(
        status,
        finger_names,
        read_only(candidate.forces),
        read_only(to_world(scene.frames, candidate.forces)),
        read_only(motion[:, 2]),
        read_only(motion[:, :2]),
        read_only(shifted(candidate.twist, arm)),
        names,
        verdict.residuals,
        uniqueness,
        certificate,
        iterations,
        trace,
        candidate.extra,
        torsion=_by_contact(scene, candidate.torsion),
        spin=_by_contact(scene, verdict.turn),
        scene=scene,
        reference=reference,
    )


def _by_contact(scene: Scene, soft: Array) -> Array | None:
    """(n,) from (k,) of the soft contacts; None where there are none."""
    if not scene.soft:
        return None
    out = np.zeros(scene.n)
    out[list(scene.soft)] = soft
    return read_only(out)


def conclude_first(
    scene: Scene, reference: Array, finger_names: tuple[str, ...], found: Found, trace: tuple[str, ...]
) -> GraspSolution:
    """The same for an answer of the first stage that the certifier passes and that leaves nothing free."""
    motion = found.motion
    return GraspSolution(
        Status.SOLVED,
        finger_names,
        found.forces,
        found.forces_world,
        motion[:, 2],
        motion[:, :2],
        read_only(shifted(found.twist, reference - found.centre)),
        found.states,
        found.residuals,
        describe(scene, (), reference),
        None,
        found.iterations,
        trace,
        {},
        scene=scene,
        reference=reference,
    )
