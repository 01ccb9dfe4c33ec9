"""What any change of a grasp changes in the laws of an answer: central differences of its laws, not of its answer.

    δv ≈ [v(p + h) - v(p - h)] / 2h,    forces, motion and contact states staying as they are

What is differenced is smooth and costs no solve; with steps as the parameters have them, the error is about 1e-9 of the
largest change.
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
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, no_change


def differences(answer: Answer, count: int, h: float, made: Callable[[int, float], GraspSpec]) -> Change:
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
    if spec.mechanism is None:
        return v, b, scene.limits(answer.section), np.zeros(0)
    others = tuple([e for e in spec.effects if not isinstance(e, TorqueSaturation)])
    torque = spec.mechanism.joints(scene, others, answer.forces, answer.torsion, answer.extra).torque
    return v, b, scene.limits(answer.section), torque
