"""Holdability in one compiled call: the forces within friction that balance a load, or the motion in which it escapes.

t = load + W a, with the a ≥ 0 in the friction cones that makes it smallest: what is left of the load when the contacts
do all they can. By the optimality of a, no force within friction works against t, and load·t = |t|²: t is the proof as
well as the direction in which the object goes. Its signs alone are what is believed.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.modes.active_columns import new_active
from handlcp.lcp.modes.fit import fit
from handlcp.lcp.modes.generators import STUCK, Cones, reach, support
from handlcp.tolerances import CERTIFY

BALANCED, ESCAPES, UNCLEAR = 0, 1, 2
_FORCES = 1e3  # of the load: forces up to that are what rounding in the signs may hide
_DISC = 64  # faces of the pyramid around the cone; what nothing in it holds, nothing in the cone does


@kernel
def find_escape(every: Array, load: Array, contacts: Ints, limits: Array, faces: int, t: Array) -> int:
    """BALANCED, or ESCAPES with a proof in t (dof,), or UNCLEAR, all in natural units.

    every (dof, c) : wrenches of the force components. load (dof,). contacts (n, 4) : as in `Kind`. limits (n,), faces :
    of the friction sets; polyhedra are not known here.
    """
    n, dof = len(contacts), len(load)
    columns, products = np.zeros((dof, n, 8)), np.zeros((n, 2, 4, 4))
    tangents, codes, corners = np.zeros(n, np.int64), np.full(n, STUCK), np.zeros((n, 3, 3))
    for i in range(n):
        for a in range(4):
            if contacts[i, a] >= 0:
                tangents[i] = a
                for k in range(dof):
                    columns[k, i, a] = every[k, contacts[i, a]]
        if tangents[i] == 3 and faces > 2:
            return UNCLEAR
        for a in range(4):
            for b in range(4):
                for k in range(dof):
                    products[i, 0, a, b] += columns[k, i, a] * columns[k, i, b]
    cones = Cones(columns, products, tangents, limits, faces if faces > 0 else _DISC)
    active = new_active(-load)
    left, _ = fit(cones, codes, corners, active)
    if left == 0.0:
        return BALANCED
    t[:] = -active.rest
    along, of, gain, size, loss = np.zeros((n, 2, 4)), np.zeros((2, 4)), 0.0, 0.0, 0.0
    reach(cones, active.rest, along)
    for i in range(n):
        force, _ = support(cones, i, STUCK, corners[i], along[i], of)
        loss += _FORCES * max(force, 0.0)
    for k in range(dof):
        gain += load[k] * t[k]
        size += t[k] * t[k]
    length = np.sqrt(np.dot(load, load))
    return ESCAPES if gain > CERTIFY * length * np.sqrt(size) and gain > length * loss else UNCLEAR
