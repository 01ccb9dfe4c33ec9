"""The solve inside a step of loading: the first stage of the solver, started at what is expected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.assembly.build import build
from handlcp.grasp.assembly.contact_form import stamped
from handlcp.grasp.friction import Section
from handlcp.grasp.loading.state import Failure
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import NOWHERE, solve_scene, start_from
from handlcp.grasp.solve.stages import solve_built
from handlcp.lcp import Auto

__all__ = ["Answer", "continued"]


@dataclass(frozen=True, slots=True)
class Answer:
    """forces (n, 3), torsion (n,), motion (n, 3) and spin (n,) in contact axes; twist (6,) about centre (3,).
    kinds (n,) : of the contacts. joints : what they do. start : where the next solve may begin.
    """

    forces: Array
    torsion: Array
    motion: Array
    spin: Array
    twist: Array
    centre: Array
    kinds: tuple[str, ...]
    joints: JointReading | None
    start: Array


def continued(
    spec: GraspSpec, section: Section, seed: int, start: Array, kinds: tuple[str, ...], patient: bool
) -> Answer | Failure:
    """The answer that continues what is expected. Where a contact changes its state, the answer that a solve finds from
    contacts that all stick is asked for, too; of both, the one whose forces are nearer to those expected is taken.

    start : as in `compiled_answer.start_from`. kinds (n,) : the contacts' states before. patient : whether to search
    for an answer where the first stage finds none.
    """
    scene = build(spec)
    start = _restarted(start, scene)
    found = _solved(spec, scene, section, seed, start, patient)
    if not len(start) or (isinstance(found, Answer) and found.kinds == kinds):
        return found
    other = _solved(spec, scene, section, seed, NOWHERE, patient)
    if isinstance(found, Failure) or isinstance(other, Failure):
        return other if isinstance(found, Failure) else found
    expected = start[:-9]
    off = [float(abs(a.start[:-9] - expected).max()) for a in (found, other)]
    return found if off[0] <= off[1] else other


def _restarted(start: Array, scene: Scene) -> Array:
    """Where a solve begins: the last forces, and no motion; where nothing is loaded yet, where every contact sticks."""
    if len(start) != scene.components + 9 or not start[:-9].any():
        return NOWHERE
    out = np.array(start)
    out[-9:-3] = 0.0
    out[-3:] = scene.positions.mean(axis=0)
    return read_only(out)


def _solved(
    spec: GraspSpec, scene: Scene, section: Section, seed: int, start: Array, patient: bool
) -> Answer | Failure:
    if patient or stamped(spec.effects):
        return _in_stages(spec, scene, section, seed, start, patient)
    found, n = solve_scene(scene, section, seed, start), scene.n
    if not found.passes:
        return Failure("no answer" if found.escape is None else "no balance")
    components, moved = scene.physical(found.components), scene.lawful(found.motion)
    torsion, spin = scene.by_contact(components[3 * n :]), scene.by_contact(moved[3 * n :])
    forces = components[: 3 * n].reshape(n, 3)
    return Answer(
        forces, torsion, moved[: 3 * n].reshape(n, 3), spin, found.twist, found.centre, found.states,
        _joints(spec, scene, forces, torsion, {}), found.start,
    )  # fmt: skip


def _in_stages(
    spec: GraspSpec, scene: Scene, section: Section, seed: int, start: Array, patient: bool
) -> Answer | Failure:
    """Of a grasp with effects that have rows of their own, or with the stages of the solver that search."""
    s = solve_built(spec, scene, section, Auto(seed=seed), start, patient)
    if not s.held:
        return Failure("no answer" if s.certificate is None else "no balance")
    torsion = np.zeros(scene.n) if s.torsion is None else s.torsion
    spin = np.zeros(scene.n) if s.spin is None else s.spin
    return Answer(
        s.forces, torsion, np.column_stack([s.slip, s.gap]), spin, s.object_displacement, spec.reference,
        s.contact_state, _joints(spec, scene, s.forces, torsion, s.extra), start_from(s, scene),
    )  # fmt: skip


def _joints(
    spec: GraspSpec, scene: Scene, forces: Array, torsion: Array, extra: dict[str, Array]
) -> JointReading | None:
    if spec.mechanism is None:
        return None
    return spec.mechanism.joints(scene, spec.effects, forces, torsion if scene.soft else None, extra)
