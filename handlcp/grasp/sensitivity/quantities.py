"""Everything of an answer that can be differentiated, from the rates of its forces, motion and slips."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.change import Change, Rates


@dataclass(frozen=True, slots=True)
class Quantity:
    """unit : of the quantity. rate : (…, p) its rates. joints : whether only a hand has it."""

    unit: str
    rate: Callable[[Answer, Rates, Change], Array]
    joints: bool = False


def _points(answer: Answer, by_component: Array) -> Array:
    """(n, 3, p) of the contact points."""
    n = answer.scene.n
    return by_component[: 3 * n].reshape(n, 3, -1)


def _moments(answer: Answer, by_component: Array) -> Array:
    """(n, p) about the normals, 0 of contacts that bear no moment."""
    out = np.zeros((answer.scene.n, by_component.shape[1]))
    out[list(answer.scene.soft)] = by_component[3 * answer.scene.n :]
    return out


def _relative(answer: Answer, rates: Rates) -> Array:
    """(n, 3, p) motions of the object past the fingertips; 0 where a prescribed force makes the finger follow."""
    points = _points(answer, rates.slip)
    return points if all(answer.scene.governed) else np.where(answer.governed[:, None, None], points, 0.0)


def _torques(answer: Answer, rates: Rates, change: Change) -> Array:
    """τ = Jᵀ r + …"""
    return np.asarray(answer.torque_rows.T @ rates.forces + change.torque)


def _torque_margin(answer: Answer, rates: Rates, change: Change) -> Array:
    """Limit less |τ|; NaN of a joint without a limit."""
    mechanism = answer.spec.mechanism
    limits = np.zeros(0) if mechanism is None else mechanism.limits
    margin = change.torque_limits - np.sign(answer.joints.torque)[:, None] * _torques(answer, rates, change)
    return np.where(np.isfinite(limits)[:, None], margin, np.nan)


def _friction_margin(answer: Answer, rates: Rates, change: Change) -> Array:
    """μ r_N - |r̂_T|, of the exact law; NaN without friction. Without a tangential force any change takes from it."""
    scene, n = answer.scene, answer.scene.n
    lawful, out = rates.forces / answer.scale[:, None], np.full((n, rates.forces.shape[1]), np.nan)
    limits = answer.friction.limits
    for i in range(n):
        if scene.mu[i] <= 0.0:
            continue
        own = [3 * i, 3 * i + 1, *([3 * n + scene.soft.index(i)] if i in scene.soft else [])]
        r, z = answer.lawful[own], 3 * i + 2
        size = float(np.sqrt(r @ r))
        used = r @ lawful[own] / size if size > answer.weak else np.sqrt((lawful[own] ** 2).sum(axis=0))
        grows = change.friction[i] * (scene.mu[i] / limits[i] if limits[i] > 0.0 else 0.0)
        out[i] = scene.mu[i] * lawful[z] + grows * answer.lawful[z] - used
    return out


QUANTITIES = {
    "forces": Quantity("N", lambda a, r, c: _points(a, r.forces)),
    "torsion": Quantity("N·m", lambda a, r, c: _moments(a, r.forces)),
    "torques": Quantity("N·m", _torques, joints=True),
    "slip": Quantity("m", lambda a, r, c: _relative(a, r)[:, :2]),
    "gap": Quantity("m", lambda a, r, c: _relative(a, r)[:, 2]),
    "displacement": Quantity("m, rad", lambda a, r, c: r.motion),
    "friction_margin": Quantity("N", _friction_margin),
    "torque_margin": Quantity("N·m", _torque_margin, joints=True),
}
