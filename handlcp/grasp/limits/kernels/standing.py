"""Whether a place obeys the laws: balance, no pull, and friction within its bounds."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.happens import room_of
from handlcp.grasp.limits.kernels.parts import CLOSED, Parts, Place
from handlcp.grasp.limits.kernels.slips import face_of_force
from handlcp.lcp.kernels.compile import kernel


@kernel
def is_sound(p: Parts, s: Place, load: Array, allowed: float) -> bool:
    """Whether forces balance load (dof,), press and stay within friction, to a share of the largest of all these."""
    size, off = 1e-300, 0.0
    for x in s.r:
        if not np.isfinite(x):
            return False
        size = max(size, abs(x))
    for x in load:
        size = max(size, abs(x))
    for a in range(len(load)):
        total = load[a]
        for j in range(len(s.r)):
            total += p.G[a, j] * s.r[j]
        off = max(off, abs(total))
    for i in range(len(p.mu)):
        j = p.contacts[i, 0]
        if j >= 0:
            off = max(off, -s.r[j])
    for f in range(len(p.owner)):
        if s.closed[p.owner[f]] == CLOSED:
            off = max(off, -room_of(p, s.r, f))
    return bool(off <= allowed * size)


@kernel
def faces_reached(p: Parts, r: Array, closed: Ints, active: Ints, near: float) -> None:
    """Write into `active` (f,) which faces the forces of closed contacts lie on; round ones are turned to them."""
    for f in range(len(p.owner)):
        active[f] = 0
        if closed[p.owner[f]] == CLOSED:
            if p.moving[f] == 1:
                face_of_force(p, f, r)
            if room_of(p, r, f) <= near:
                active[f] = 1
