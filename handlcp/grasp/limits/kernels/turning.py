"""How a path bends while contacts slip on a round friction cone, by the length of the path.

With the direction of each sliding force known, the rates are those of one face a contact. Steps are by the formula of
order five of Dormand & Prince, J. Comp. Appl. Math. 6 (1980).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.pairs import solved
from handlcp.grasp.limits.kernels.parts import Parts
from handlcp.grasp.limits.kernels.slips import Solved, face_of_force, respond
from handlcp.lcp.kernels.compile import kernel

__all__ = ["onto_cones", "slope_at", "step_ahead"]

_ERROR = 1e-8  # of a step, relative to forces and motions
_SMALL = 1e-3
_SINGULAR = 1e-15
_ON = 1e-12  # of the largest force: what is no farther from its cone lies on it
_C = np.array([
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
    [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
    [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
])  # fmt: skip
_E = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


@kernel
def slope_at(
    p: Parts, at: Solved, w: Array, kinds: Ints, index: Ints, y: Array, before: Array, dy: Array, tangent: Array
) -> bool:  # fmt: skip
    """Write dy by the length of the path, and its direction in (γ, load), on the side of `before`."""
    count, m = len(kinds), len(p.E)
    for c in range(count):
        if p.moving[index[c]] == 1:
            face_of_force(p, index[c], y[:m])
    X, M, q = respond(p, at, kinds, index)
    A = np.zeros((count + 1, count + 1))
    A[:count, :count], A[:count, count], A[count] = M, q, before
    tangent[:] = 0.0
    tangent[count] = 1.0
    if not solved(A, tangent, _SINGULAR):
        return False
    dy[:-1] = tangent[count] * at.x0
    for c in range(count):
        dy[:-1] += tangent[c] * X[c]
    dy[-1] = tangent[count]
    length = np.sqrt(np.sum(dy[: m + len(w)] ** 2) + (dy[-1] * np.max(np.abs(w))) ** 2)
    dy /= length
    tangent /= length
    return bool(length > 0.0)


@kernel
def step_ahead(
    p: Parts, at: Solved, w: Array, kinds: Ints, index: Ints, y: Array, h: float, tangent: Array, slopes: Array,
    ahead: Array, turned: Array,
) -> float:  # fmt: skip
    """Write the place one step ahead and the direction there; the error as a share of what is allowed."""
    size = len(y)
    for stage in range(6):
        ahead[:] = y
        for c in range(stage + 1):
            if _C[stage, c] != 0.0:
                ahead += (h * _C[stage, c]) * slopes[c]
        if not slope_at(p, at, w, kinds, index, ahead, tangent, slopes[stage + 1], turned):
            return 1e10
    m, dof, worst = len(p.E), len(p.G), 0.0
    force, motion = np.max(np.abs(ahead[:m])), np.max(np.abs(ahead[m : m + dof])) + np.max(np.abs(ahead[:m]))
    scale = np.full(size - 1, motion)
    scale[:m] = force
    for c in range(len(kinds)):  # small forces that slip turn fast
        i = kinds[c]
        if p.moving[index[c]] == 1:
            for a in range(4):
                if p.contacts[i, a] >= 0:
                    scale[p.contacts[i, a]] = max(ahead[p.contacts[i, 0]], _SMALL * force)
    for j in range(size - 1):
        off = 0.0
        for c in range(7):
            off += _E[c] * slopes[c, j]
        worst = max(worst, abs(h * off) / scale[j])
    return worst / _ERROR


@kernel
def onto_cones(p: Parts, at: Solved, kinds: Ints, index: Ints, y: Array, tangent: Array) -> None:
    """Bring the sliding forces of y back onto their cones, across the path, where steps have left them beside."""
    count, m = len(kinds), len(p.E)
    A, off, size, worst = np.zeros((count + 1, count + 1)), np.zeros(count + 1), np.max(np.abs(y[:m])), 0.0
    for c in range(count):
        f, i, used = index[c], kinds[c], 0.0
        if p.moving[f] == 1:
            face_of_force(p, f, y[:m])
        for a in range(3):
            t = p.contacts[i, a + 1]
            if t >= 0:
                used += p.normals[f, a] * y[t]
        off[c] = used - p.mu[i] * y[p.contacts[i, 0]]
        worst = max(worst, abs(off[c]))
    if worst <= _ON * size:
        return
    X, M, q = respond(p, at, kinds, index)
    A[:count, :count], A[:count, count], A[count] = M, q, tangent
    if not solved(A, off, _SINGULAR):
        return
    y[:-1] += off[count] * at.x0
    y[-1] += off[count]
    for c in range(count):
        y[:-1] += off[c] * X[c]
