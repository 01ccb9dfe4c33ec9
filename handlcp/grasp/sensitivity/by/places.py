"""What postures and lengths change in the laws of a grasp: central differences of its laws, not of its answer.

    δv ≈ [v(p + h) - v(p - h)] / 2h,    forces, motion and contact states staying as they are

The grasp is made again with each parameter a little larger and smaller, as it was asked for: contacts on an object are
detected anew, a squeeze is commanded anew. What is differenced is smooth and costs no solve; with `STEPS` the error is
about 1e-9 of the largest change. Geometric stiffness changes with the contacts in no closed form that is known here, so
that beside it moved and turned contacts are differenced, too.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.assembly.build import build
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.model.grasp_matrix import wrench_map
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.by.vary import STEPS, moved
from handlcp.grasp.sensitivity.change import Change, no_change

__all__ = ["by_lengths", "by_moved_normals", "by_moved_positions", "by_posture"]


def by_posture(answer: Answer) -> Change:
    """Of the joint positions (nv,) [1/rad, 1/m]."""
    mechanism = answer.spec.mechanism
    if mechanism is None:
        return no_change(answer, 0)
    made = mechanism.varied
    return _differences(answer, len(mechanism.names), STEPS["posture"], lambda k, h: made(answer.spec, "posture", k, h))


def by_lengths(answer: Answer) -> Change:
    """Of the lengths of links (m, 3) [1/m], see `Mechanism.lengths`."""
    mechanism = answer.spec.mechanism
    if mechanism is None:
        return no_change(answer, 0)
    made = mechanism.varied
    return _differences(
        answer, 3 * len(mechanism.lengths), STEPS["lengths"], lambda k, h: made(answer.spec, "lengths", k, h)
    )


def by_moved_positions(answer: Answer) -> Change:
    """Of the contact points (n, 3), world axes [1/m]."""
    spec = answer.spec
    return _differences(answer, 3 * spec.n, STEPS["positions"], lambda k, h: moved(spec, "positions", k, h))


def by_moved_normals(answer: Answer) -> Change:
    """Of turns (n, 3) of the contact axes about themselves [1/rad]."""
    spec = answer.spec
    return _differences(answer, 3 * spec.n, STEPS["normals"], lambda k, h: moved(spec, "normals", k, h))


def _differences(answer: Answer, count: int, h: float, made: Callable[[int, float], GraspSpec]) -> Change:
    """Of the laws of grasps made(k, ±h)."""
    change = no_change(answer, count)
    for k in range(count):
        try:
            ahead, behind = _laws(answer, made(k, h)), _laws(answer, made(k, -h))
        except InputError:  # no such grasp, as where a link leaves the plane of a planar one
            change.motion[:, k] = np.nan
            continue
        for column, a, b in zip(
            (change.motion, change.balance, change.friction, change.torque), ahead, behind, strict=True
        ):
            column[:, k] = (a - b) / (2.0 * h)
    return change


def _laws(answer: Answer, spec: GraspSpec) -> tuple[Array, Array, Array, Array]:
    """(v, b, μ, τ) of the answer's forces and motion in another grasp: motions (c,) in the laws' coordinates, the
    wrench (6,) that is left over about the answer's reference, the sections' coefficients (n,), torques (nv,).
    """
    effects = []
    for e in spec.effects:
        made = e.under(spec, answer.forces, spec.effects) if e.depends_on_forces else e
        if isinstance(made, str):
            raise Unsupported(made)
        effects.append(made)
    spec = spec.replace(effects=tuple(effects))
    scene, r = build(spec), answer.lawful
    G = wrench_map(scene.positions, answer.spec.reference, scene.frames, scene.given.spin)
    v = G.T @ answer.twist + scene.flexibility @ r + scene.offset
    for e in spec.effects:
        if (more := e.opening(scene, answer.extra)) is not None:
            v = v + more
    b = G @ r
    b[:3] += scene.force
    b[3:] += scene.moment - np.cross(answer.spec.reference, scene.force)
    mechanism = spec.mechanism
    assert mechanism is not None  # only hands have postures and lengths
    others = tuple([e for e in spec.effects if not isinstance(e, TorqueSaturation)])
    torque = mechanism.joints(scene, others, answer.forces, answer.torsion, answer.extra).torque
    return v, b, scene.limits(answer.section), torque
