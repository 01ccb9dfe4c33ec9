"""Where on a path the object begins to slide through: nothing that presses sticks any more, and the object has gone
farther than ten times the rate while something stuck explains, or it jumps. The same rule as on a path in steps
(`path/advance`).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.limits.kernels.parts import Parts
from handlcp.lcp.kernels.compile import kernel
from handlcp.tolerances import FASTER, RUNS

_STICKS = 1e-6  # of the largest motion at any contact: a smaller one is none
_PRESSES = 1e-9  # of the largest force
_NO_LOAD = 3e-6  # of the load: what happens while it grows by less happens at one load


@kernel
def slides_at(p: Parts, moves: Array, length: float, path: Array, point: Array) -> bool:
    """Whether it does, and write where: a point as `path` (·, 1 + m + dof + k) has them.

    moves (6, dof) : the object's motion, SI, of natural unknowns. length [m] : of the contacts from their centre.
    """
    stuck, beyond, width = 0.0, 0.0, path.shape[1] - 1
    for a in range(1, len(path)):
        size, d = path[a, 0] - path[a - 1, 0], np.empty(width)
        for j in range(width):
            d[j] = path[a, 1 + j] - path[a - 1, 1 + j]
        far = _far(p, moves, length, d)
        if size > _NO_LOAD * abs(path[a, 0]):
            if stuck == 0.0 or _something_sticks(p, path[a - 1], path[a], d):
                stuck, beyond = max(stuck, far / size), 0.0
                continue
            far -= FASTER * stuck * size
        if beyond + far >= RUNS:
            share = max((RUNS - beyond) / far, 0.0)
            for j in range(width + 1):
                point[j] = path[a - 1, j] + share * (path[a, j] - path[a - 1, j])
            return True
        beyond = max(beyond + far, 0.0)
    return False


@kernel
def _far(p: Parts, moves: Array, length: float, d: Array) -> float:
    """How far the object moves by d (m + dof + k,), as `Stepper.far` has it."""
    m, moved = len(p.E), np.zeros(6)
    for b in range(6):
        for c in range(len(p.G)):
            moved[b] += moves[b, c] * d[m + c]
    x, y = np.sqrt((moved[:3] ** 2).sum()), np.sqrt((moved[3:] ** 2).sum())
    return float(x / length + y)


@kernel
def _something_sticks(p: Parts, begin: Array, end: Array, d: Array) -> bool:
    """Whether a contact that presses all the while does not move along its surface."""
    m, dof, k = len(p.E), len(p.G), len(p.rows)
    v, most, force = np.zeros(m), 0.0, 0.0
    for i in range(m):
        for j in range(m):
            v[i] += p.E[i, j] * d[j]
        for c in range(dof):
            v[i] += p.G[c, i] * d[m + c]
        for b in range(k):
            v[i] += p.rows[b, i] * d[m + dof + b]
        most, force = max(most, abs(v[i])), max(force, abs(end[1 + i]))
    for i in range(len(p.mu)):
        j = p.contacts[i, 0]
        if j < 0 or min(begin[1 + j], end[1 + j]) <= _PRESSES * force or p.contacts[i, 1] < 0:
            continue
        moves = 0.0
        for b in range(1, 4):
            if p.contacts[i, b] >= 0:
                moves = max(moves, abs(v[p.contacts[i, b]]))
        if moves <= _STICKS * most:
            return True
    return False
