"""The derivatives that are asked for most, together and compiled, of an answer in its ordinary case.

That is: nothing is left free, no contact is at a kink, no limit gives way, and neither a soft palm nor turning levers
take part. The equations are those of `by/loads.py` and `by/contacts.py`, which serve every other case; a test holds
both against each other.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel

ORDINARY = ("wrench", "squeeze", "pads", "friction", "positions", "joint_offset", "stiffness")  # in this order


@kernel
def ordinary_changes(
    positions: Array, frames: Array, forces: Array, omega: Array, scale: Array, J: Array, C: Array, give: Array,
    moved: Array, angular: Array, planar: bool,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """(motion (c, p), balance (6, p), torque (nv, p)) of `Change`, by the parameters in `ORDINARY`.

    forces (c,), frames, J (c, nv), C (nv, nv), angular (n, 3, nv) : as in `Answer`, SI, contact axes. omega (3,) : of
    the object. give (nv,) δ, and moved (nv,) δ - δq of the joints.
    """
    n, (c, nv) = len(positions), J.shape
    p = 6 + 6 * n + 2 * nv
    v, b, tau = np.zeros((c, p)), np.zeros((6, p)), np.zeros((nv, p))
    for k in range(6):
        b[k, k] = 1.0
    f, w, e = np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(n):
        v[3 * i + 2, 6 + i] = -1.0
        for a in range(3):
            v[3 * i + a, 6 + n + i] = forces[3 * i + a]
            f[a], w[a] = 0.0, omega[a]
            for k in range(3):
                f[a] += frames[i, a, k] * forces[3 * i + k]
            for j in range(nv):
                w[a] += angular[i, a, j] * moved[j]
        for a in range(3):
            at, x, y = 6 + 3 * n + 3 * i + a, (a + 1) % 3, (a + 2) % 3
            b[3 + x, at], b[3 + y, at] = -f[y], f[x]  # e × f
            e[a], e[x], e[y] = 0.0, w[y], -w[x]  # w × e
            for k in range(3):
                v[3 * i + k, at] = frames[i, 0, k] * e[0] + frames[i, 1, k] * e[1] + frames[i, 2, k] * e[2]
            for j in range(nv):
                tau[j, at] = angular[i, y, j] * f[x] - angular[i, x, j] * f[y]
    if nv > 0:
        JC = np.dot(J, C)
        first, last = 6 + 3 * n, 6 + 6 * n
        for r in range(c):
            for j in range(nv):
                x = JC[r, j]
                v[r, last + j] = -J[r, j]
                v[r, last + nv + j] = -x * give[j]
                if x != 0.0:
                    for k in range(first, last):
                        v[r, k] += x * tau[j, k]
    for r in range(c):
        for k in range(p):
            v[r, k] *= scale[r]
            if planar and r % 3 == 1:
                v[r, k] = 0.0
    return v, b, tau


@kernel
def ordinary_rates(
    G: Array, inverse: Array, tangent: Array, freedom: Array, scale: Array, room: Array, v: Array, b: Array,
    sizes: Array, twist_units: Array, balance_sizes: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """(forces (c, p), motion (6, p), slip (c, p)) of `Rates`.

    room (n,) : what friction bears more per unit of its coefficient [N]. v, b : of `ordinary_changes`.
    """
    c, dof, n, p = len(scale), len(freedom), len(room), v.shape[1]
    rhs = np.zeros((c + dof + n, p))
    for r in range(c):
        for k in range(p):
            rhs[r, k] = v[r, k] / sizes[1]
    lowered = np.dot(freedom, b)
    for r in range(dof):
        for k in range(p):
            rhs[c + r, k] = lowered[r, k] / balance_sizes[r]
    for i in range(n):
        rhs[c + dof + i, 6 + 2 * n + i] = room[i] / sizes[0]
    x = np.dot(inverse, rhs)
    for r in range(c):
        for k in range(p):
            x[r, k] *= sizes[0]
    for r in range(dof):
        for k in range(p):
            x[c + r, k] *= twist_units[r]
    motion = np.dot(freedom.T.copy(), x[c : c + dof])
    slip = np.dot(G.T.copy(), motion) + np.dot(tangent, x[:c]) + v
    forces = x[:c].copy()
    for r in range(c):
        for k in range(p):
            forces[r, k] *= scale[r]
            slip[r, k] /= scale[r]
    return forces, motion, slip
