"""Whether fingertips that touch can hold the object, and with which normal forces they should press.

    the smallest f with  w + G f = 0,   |f_t| ≤ s μ f_n,   f_n ≥ f_least

at every contact, s < 1 so that friction keeps something in reserve. Cones become pyramids of eight edges, and the
problem one of non-negative least squares (Lawson and Hanson, 1974).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.hand.find.touch import Touch

RESERVE = 0.6  # s, the share of friction that is planned with
_EDGES = 2 * np.pi * np.arange(8) / 8
_HEAVY = 1e3  # of balance beside the size of the forces
_MISSED = 0.02  # of the forces: what may be missing from balance


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """What the contacts are to hold. load (6,): the wrench on the object about its centre of mass, without turning with
    it [N, N·m]; mu (k,): coefficients of friction; levers (k,) [m]: of soft fingers, moment about
    the normal for each newton of friction; size [m] of the object; least [N] of the normal forces.
    """

    load: Array
    mu: Array
    levers: Array
    size: float
    least: float


def normal_forces(touch: Touch, centre: Array, asked: Asked) -> Array | None:
    """(k,) [N], one for each fingertip; None where none hold the object. centre (3,): its centre of mass [m]."""
    from scipy.optimize import nnls  # half a second of import that only a search should pay

    n = touch.normals
    x = np.eye(3)[np.argmin(abs(n), axis=1)]
    x = x - n * (n * x).sum(axis=1)[:, None]
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross(n, x)
    turn = np.cos(_EDGES)[:, None, None] * x + np.sin(_EDGES)[:, None, None] * y
    edges = (n + RESERVE * asked.mu[:, None] * turn).transpose(1, 0, 2)  # (k, 8, 3)
    arms = (touch.positions - centre)[:, None, :]
    moments, pressed = np.cross(arms, edges), np.cross(arms[:, 0], n)
    torsion = RESERVE * (asked.mu * asked.levers)[:, None] * n
    edges = np.concatenate([edges, n[:, None], n[:, None]], axis=1)  # the last two bear moments about the normal
    moments = np.concatenate([moments, (pressed + torsion)[:, None], (pressed - torsion)[:, None]], axis=1)
    W = np.concatenate([edges, moments / asked.size], axis=2).reshape(-1, 6).T
    load = asked.load / np.repeat([1.0, asked.size], 3)
    base = np.full(W.shape[1], asked.least / edges.shape[1])
    A = np.vstack([_HEAVY * W, np.eye(W.shape[1])])
    try:
        more, _ = nnls(A, np.append(-_HEAVY * (load + W @ base), -base))
    except RuntimeError:
        return None  # too many iterations
    forces = base + more
    if float(np.linalg.norm(load + W @ forces)) > _MISSED * float(forces.sum()):
        return None
    return np.asarray(forces.reshape(len(n), -1).sum(axis=1))
