"""Newton's method contact by contact, and what leads there: contacts that all stick, then proximal steps."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools
from handlcp.lcp.kernels.contact_blocks import Linked, Split, eliminated, motions, split_rows
from handlcp.lcp.kernels.contact_rows import Contacts, rows, work
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import SOLVE

_MEMORY = 8  # steps over which ‖F‖ may rise, as in `contact_run`
_SHORTEST = 2e-2
_FARTHER = 1.6  # over-relaxation of ADMM
# Newton's steps, and those on the ball in place of a polygon, as in `contact_run`
_BALL_STEPS, _ON_BALL, _STEPS = 8, 1e-2, 12
# Proximal steps before Newton's method is tried again: of 20 grasps that it fails on at first, ten were enough for 19.
# Each is a linear solve as Newton's are, and they are counted as such.
_NEARER, _WEIGHT = (10, 20, 70), 10.0


@kernel
def solved_blocks(p: Linked, r: Array, z: Array, begun: bool) -> tuple[int, float]:
    """Solve in place: from r (3n,) and z (m,) where `begun`; where that leads nowhere, from contacts that all stick,
    then with proximal steps between Newton's. Returns (linear solves, residual), inf where contacts cannot be
    eliminated.
    """
    newton, residual = 0, np.inf
    if begun:
        newton, residual = _run(p, r, z, False)
        if residual <= SOLVE:
            return newton, residual
    apart = np.empty(len(p.P), np.bool_)
    for i in range(len(apart)):
        apart[i] = p.d[3 * i] > 0.0
    if not held_blocks(p, apart, r, z):
        return newton, np.inf
    steps, residual = _run(p, r, z, True)
    newton += steps
    copies, pull, k = np.zeros(len(r)), np.zeros(len(r)), 0
    while not residual <= SOLVE and k < len(_NEARER):
        proximal_blocks(p, copies, pull, _NEARER[k], _WEIGHT, z)
        r[:] = copies
        steps, residual = _run(p, r, z, False)
        newton += _NEARER[k] + steps
        k += 1
    return newton, residual


@kernel
def _run(p: Linked, r: Array, z: Array, cold: bool) -> tuple[int, float]:
    """Newton's method in place; a polygon is approached from the answer on the ball, except from a good start."""
    before, own = 0, p.own
    if cold and own.faces > 2:
        ball = Contacts(own.M, own.q, own.role, own.rho, own.blocks, own.limits, 0, own.normals)
        before, _ = newton_blocks(Linked(p.P, p.W, p.R, p.d, p.S, p.w, ball, p.least), r, z, _BALL_STEPS, _ON_BALL)
    steps, residual = newton_blocks(p, r, z, _STEPS, SOLVE * 1e-2)
    return before + steps, residual


@kernel
def held_blocks(p: Linked, apart: Bools, r: Array, z: Array) -> bool:
    """Write the linear solution in which contacts are open where `apart` (n,) and all others stick. Returns whether
    nothing is free then; contacts that cannot give way by themselves cannot be eliminated.
    """
    n, m = len(p.P), len(z)
    split, F, core = Split(np.zeros((n, 3, 3)), np.zeros((n, 3, 3))), np.zeros(3 * n), p.w.copy()
    for i in range(n):
        for a in range(3):
            if apart[i]:
                split.A[i, a, a] = 1.0
            else:
                split.C[i, a, a], F[3 * i + a] = 1.0, p.d[3 * i + a]
    dr, dz = np.empty(3 * n), np.empty(m)
    determined = eliminated(p, split, F, core, dr, dz)
    for k in range(3 * n):
        r[k] = -dr[k]
    for j in range(m):
        z[j] = -dz[j]
    return determined


@kernel
def _size(r: Array, z: Array) -> float:
    """max(1, largest |x|) of forces and the object's motion: what a residual is measured against."""
    largest = 1.0
    for x in r:
        largest = max(largest, abs(x))
    for j in range(len(z) - 6, len(z)):
        largest = max(largest, abs(z[j]))
    return largest


@kernel
def newton_blocks(p: Linked, r: Array, z: Array, steps: int, tolerance: float) -> tuple[int, float]:
    """`contact_newton` in place, each step by elimination. Returns (steps, ‖F‖ over the size of the unknowns)."""
    n3, m = len(r), len(z)
    y, F, core, g = np.empty(n3), np.empty(n3), np.empty(m), work(p.own)
    total = motions(p, r, z, y, core) + rows(p.own, r, y, F, g)
    relative = np.sqrt(total) / _size(r, z)
    if relative <= tolerance:
        return 0, relative
    split = Split(np.empty((n3 // 3, 3, 3)), np.empty((n3 // 3, 3, 3)))
    dr, dz, r1, z1, recent = np.empty(n3), np.empty(m), np.empty(n3), np.empty(m), np.zeros(_MEMORY)
    for step in range(steps + 1):
        relative = np.sqrt(total) / _size(r, z)
        if not total < np.inf:
            return step, np.inf
        if relative <= tolerance or step == steps:
            return step, relative
        split_rows(p, g, split)
        eliminated(p, split, F, core, dr, dz)
        recent[step % _MEMORY] = total
        ceiling, t = np.max(recent), 1.0
        while True:
            for k in range(n3):
                r1[k] = r[k] - t * dr[k]
            for j in range(m):
                z1[j] = z[j] - t * dz[j]
            total = motions(p, r1, z1, y, core) + rows(p.own, r1, y, F, g)
            if total <= (1.0 - 1e-4 * t) * ceiling or t < _SHORTEST:
                break
            t *= 0.5
        r[:] = r1
        z[:] = z1
    return steps, relative


@kernel
def proximal_blocks(p: Linked, copies: Array, pull: Array, steps: int, weight: float, z: Array) -> None:
    """Steps of ADMM on friction with dilatancy (De Saxcé & Feng, Math. Comput. Model. 28, 1998): forces that meet the
    linear laws and their copies (3n,) in the cones draw each other near, pull (3n,) being what holds them together.
    Both in place; z (m,) is written. Far from any answer they lead to where Newton's method converges.

    weight : of the distance, over each contact's own softness.
    """
    n, m, rho, limits = len(p.P), len(z), p.own.rho, p.own.limits
    split, F = Split(np.zeros((n, 3, 3)), np.zeros((n, 3, 3))), np.empty(3 * n)
    dr, dz, t = np.empty(3 * n), np.empty(m), np.empty(3)
    for i in range(n):
        for a in range(3):
            split.A[i, a, a], split.C[i, a, a] = weight / rho[3 * i], 1.0
    for _ in range(steps):
        for i in range(n):
            k, own = 3 * i, weight / rho[3 * i]
            for a in range(3):
                F[k + a] = p.d[k + a] + pull[k + a] - own * copies[k + a]
            F[k] += limits[i] * np.sqrt(pull[k + 1] ** 2 + pull[k + 2] ** 2)
        eliminated(p, split, F, p.w, dr, dz)
        for i in range(n):
            k, own, mu = 3 * i, weight / rho[3 * i], limits[i]
            for a in range(3):
                pull[k + a] -= own * (_FARTHER * dr[k + a] + (_FARTHER - 1.0) * copies[k + a])
                t[a] = pull[k + a] / own
            push, across = t[0], np.sqrt(t[1] * t[1] + t[2] * t[2])
            share = 1.0
            if across > mu * push:
                push = max((push + mu * across) / (1.0 + mu * mu), 0.0)
                share = mu * push / across if across > 0.0 else 0.0
            copies[k], copies[k + 1], copies[k + 2] = push, share * t[1], share * t[2]
            for a in range(3):
                pull[k + a] -= own * copies[k + a]
    for j in range(m):
        z[j] = -dz[j]
