"""What joints and tendons store on a path, and what their drives put in.

Springs at joints store ½ τ · δq of the deflection δq from where they are commanded, and commands q_c put in ∫ τ · dq_c.
What holds springs beside the drives is in neither: they are a part of K, and count as driven with the joints.
Tendons are drawn in by x = k⁻¹ d, and store what their tension t says; springs at the joints keep their rest angle q₀,
where they balance the pretension T₀:

    E = ½ tᵀ k⁻¹ t + ½ (q - q₀)ᵀ K_p (q - q₀) + T₀ᵀ R₀ (q - q₀),    W = ∫ tᵀ dx + ∫ n · dq

n is what the joints' torques have beside those of tendons and of these springs: what holds rigid joints, fingers'
weight that deflects no spring, and what no tendon could make.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.mechanism import Cables
from handlcp.grasp.path.state import State
from handlcp.grasp.path.step_grasp import StepGrasp


def stored(grasp: StepGrasp, states: Sequence[State]) -> Array:
    """(m,) in springs of joints and tendons since the first state [J]."""
    cables = _cables(grasp)
    if cables is None:
        return np.array([0.5 * float(s.stretched @ s.read.deflection) for s in states])
    rest, preload = _rest(grasp, cables)
    t, away = np.array([s.pull.tension for s in states]), np.array([s.where.q for s in states]) - rest
    found = 0.5 * (t * np.linalg.solve(cables.springs, t.T).T).sum(axis=1)
    found += 0.5 * ((away @ cables.passive) * away).sum(axis=1) + away @ preload
    return np.asarray(found - found[0])


def driven(grasp: StepGrasp, states: Sequence[State]) -> Array:
    """(m-1,) what commands of joints put in at each step [J]."""
    cables = _cables(grasp)
    torque = np.array([s.stretched for s in states])
    if cables is None:
        return done(torque, np.array([s.controls.command for s in states]))
    rest, preload = _rest(grasp, cables)
    t, q = np.array([s.pull.tension for s in states]), np.array([s.where.q for s in states])
    x = np.linalg.solve(cables.springs, np.array([s.pull.drawn for s in states]).T).T
    there = [cables if cables.elasticity_at is None else cables.elasticity_at(s.iterate.at.q)[0] for s in states]
    made = np.array([one.arms.T @ tension for one, tension in zip(there, t, strict=True)])
    return done(t, x) + done(torque - made + (q - rest) @ cables.passive + preload, q)


def done(force: Array, moved: Array) -> Array:
    """(m-1,) work of forces (m, k) along (m, k), of their means over each step."""
    return np.asarray(((force[1:] + force[:-1]) / 2 * np.diff(moved, axis=0)).sum(axis=1))


def _cables(grasp: StepGrasp) -> Cables | None:
    """Of a path; where geometry stays, arms are those of the grasp's posture."""
    mechanism = grasp.spec.mechanism
    cables = None if mechanism is None else mechanism.joint_model.cables
    return cables if cables is None or grasp.geometry.follows else cables._replace(elasticity_at=None)


def _rest(grasp: StepGrasp, cables: Cables) -> tuple[Array, Array]:
    """(nv,) q₀, and R₀ᵀ T₀."""
    rest = grasp.posture + cables.rest
    arms = cables.arms if cables.elasticity_at is None else cables.elasticity_at(rest)[0].arms
    return rest, np.asarray(arms.T @ cables.initial_tension)
