"""The first stage of a solve for many contacts whose flexibility is a factor: contact by contact, in one compiled call.

The same laws and steps as in `compiled_solve`, over blocks of three (`lcp/kernels/contact_blocks.py`), and the same row
of numbers as its answer. Where it leads to no answer, scenes go the other way, with E as a matrix.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.flexibility import Factor
from handlcp.grasp.model.grasp_matrix import Given, Posed, placed
from handlcp.grasp.solve.compiled_solve import HEAD, UNIQUE, UNKNOWN, ScenePattern, begin
from handlcp.grasp.verify.contact_laws import Friction, examine, examined, motions_of_factor
from handlcp.grasp.verify.contact_states import GLIDING, SEPARATED, SLIDING, STICKING, States, find_states
from handlcp.lcp.kernels.contact_blocks import Linked, determined_by, held_blocks, newton_blocks, proximal_blocks
from handlcp.lcp.kernels.contact_rows import Contacts
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import ACTIVE, CERTIFY, GROWTH, SOLVE

# Newton's steps, and those on the ball in place of a polygon, as in `contact_run`
_BALL_STEPS, _ON_BALL, _STEPS = 8, 1e-2, 12
# Proximal steps before Newton's method is tried again: of 20 grasps that it fails on at first, ten were enough for 19.
# Each is a linear solve as Newton's are, and they are counted as such.
_NEARER, _WEIGHT = (10, 20, 70), 10.0


class Row(NamedTuple):
    """A scene's numbers, one after the other, and how many joints and columns of their root there are: positions (3n),
    frames (9n), offset (3n), force, moment (3), freedom (36), J (3n nv), A (nv m), P (9n), limits (n). matrix :
    (3n, 3n) E where it was given as one, which answers are judged by; else (0, 0).
    """

    numbers: Array
    joints: int
    columns: int
    matrix: Array


@kernel
def solve_factored(scene: Row, p: ScenePattern, start: Array, row: Array) -> bool:
    """Write the answer's row, as `solve_scenes` does; start as there. Returns whether it is an answer."""
    n = len(p.contacts)
    g, factor, limits = _read(scene, n)
    B, softness = _columns(factor)
    posed = placed(g, softness)
    linked = _linked(g, factor.pads, B, posed, softness, limits, p)
    r, z, newton, residual = np.zeros(3 * n), np.zeros(scene.columns + 6), 0, np.inf
    if len(start) > 0:
        x = np.zeros(p.at[4])
        begin(x, start, p, g.freedom, posed)
        _from_unknowns(x, p, linked, r, z)
        newton, residual = _run(linked, r, z, False)
    if not residual <= SOLVE:
        apart = np.empty(n, np.bool_)
        for i in range(n):
            apart[i] = linked.d[3 * i] > 0.0
        if not held_blocks(linked, apart, r, z):
            return False
        steps, residual = _run(linked, r, z, True)
        newton += steps
        copies, pull, k = np.zeros(3 * n), np.zeros(3 * n), 0
        while not residual <= SOLVE and k < len(_NEARER):
            proximal_blocks(linked, copies, pull, _NEARER[k], _WEIGHT, z)
            r[:] = copies
            steps, residual = _run(linked, r, z, False)
            newton += _NEARER[k] + steps
            k += 1
    row[0], row[1], row[2] = 0.0, newton, residual
    if not residual <= SOLVE:
        return False
    for i in range(n):
        r[3 * i] = max(r[3 * i], 0.0)
    return _write(row, p, g, factor, limits, posed, linked, r, z)


@kernel
def _read(scene: Row, n: int) -> tuple[Given, Factor, Array]:
    """The arrays of a scene, as views of its row."""
    s, nv, m = scene.numbers, scene.joints, scene.columns
    a, b = 3 * n, 12 * n
    c = b + 3 * n
    e = c + 42
    f = e + 3 * n * nv
    h = f + nv * m
    factor = Factor(s[e:f].reshape(3 * n, nv), s[f:h].reshape(nv, m), s[h : h + 9 * n].reshape(n, 3, 3))
    g = Given(
        s[:a].reshape(n, 3), s[a:b].reshape(n, 3, 3), scene.matrix, s[b:c], s[:0], s[:0].reshape(3, 0),
        s[c : c + 3], s[c + 3 : c + 6], s[c + 6 : e].reshape(6, 6),
    )  # fmt: skip
    return g, factor, s[h + 9 * n :]


@kernel
def _columns(E: Factor) -> tuple[Array, Array]:
    """(J A (3n, m), diagonal of E (3n,))."""
    c, (nv, m) = len(E.rows), E.root.shape
    B, softness = np.zeros((c, m)), np.empty(c)
    for i in range(c):
        for j in range(nv):
            x = E.rows[i, j]
            if x != 0.0:  # a finger's joints move no other finger
                for a in range(m):
                    B[i, a] += x * E.root[j, a]
        softness[i] = E.pads[i // 3, i % 3, i % 3]
        for a in range(m):
            softness[i] += B[i, a] * B[i, a]
    return B, softness


@kernel
def _linked(g: Given, pads: Array, B: Array, posed: Posed, softness: Array, limits: Array, p: ScenePattern) -> Linked:
    """The problem in natural units, each contact's normal first; B = J A."""
    n, m = len(g.positions), B.shape[1]
    units = posed.force / posed.motion
    scale = np.sqrt(units)
    P, W, d = np.empty((n, 3, 3)), np.zeros((3 * n, m + 6)), np.empty(3 * n)
    S, w, rho, largest = np.zeros(m + 6), np.zeros(m + 6), np.empty(3 * n), 0.0
    for j in range(m):
        S[j] = 1.0
    for k in range(6):
        w[m + k] = posed.wrench[k] / (posed.force if k < 3 else posed.force * posed.length)
    for i in range(n):
        for a in range(3):
            at, own = 3 * i + a, 3 * i + (a + 2) % 3
            d[at] = g.offset[own] / posed.motion
            for b in range(3):
                P[i, a, b] = pads[i, (a + 2) % 3, (b + 2) % 3] * units
            for j in range(m):
                W[at, j] = B[own, j] * scale
            for k in range(6):
                W[at, m + k] = posed.grasp_matrix[k, own] / (1.0 if k < 3 else posed.length)
            largest = max(largest, softness[own] * units)
    for i in range(n):
        mean = (softness[3 * i] + softness[3 * i + 1] + softness[3 * i + 2]) * units / 3
        for a in range(3):
            rho[3 * i + a] = 1.0 / max(mean, 1e-6 * largest)
    role, blocks = np.full(3 * n, 2), np.full((n, 4), -1)
    for i in range(n):
        role[3 * i] = 1
        for a in range(3):
            blocks[i, a] = 3 * i + a
    own_rows = Contacts(np.empty((0, 0)), np.empty(0), role, rho, blocks, limits.copy(), p.faces, p.normals)
    return Linked(P, W, d, S, w, own_rows)


@kernel
def _from_unknowns(x: Array, p: ScenePattern, linked: Linked, r: Array, z: Array) -> None:
    """Write forces and shared motions from unknowns (N,) in the order of their layout."""
    normal, count, tangent, u, _ = p.at
    m = len(z) - 6
    for k in range(len(p.unknown)):
        own = p.unknown[k]
        r[own - own % 3 + (own + 1) % 3] = x[normal + k if k < count else tangent + k - count]
    z[:] = 0.0
    for k in range(6):
        z[m + k] = x[u + k]
    for k in range(len(r)):
        for j in range(m):
            z[j] += linked.W[k, j] * r[k]


@kernel
def _run(p: Linked, r: Array, z: Array, cold: bool) -> tuple[int, float]:
    """Newton's method in place; a polygon is approached from the answer on the ball, except from a good start."""
    before, own = 0, p.own
    if cold and own.faces > 2:
        ball = Contacts(own.M, own.q, own.role, own.rho, own.blocks, own.limits, 0, own.normals)
        before, _ = newton_blocks(Linked(p.P, p.W, p.d, p.S, p.w, ball), r, z, _BALL_STEPS, _ON_BALL)
    steps, residual = newton_blocks(p, r, z, _STEPS, SOLVE * 1e-2)
    return before + steps, residual


@kernel
def _write(
    row: Array, p: ScenePattern, g: Given, E: Factor, limits: Array, posed: Posed, linked: Linked, r: Array, z: Array
) -> bool:
    """Certify forces and motion, and write what they say into the row; returns whether they are an answer."""
    n, m = len(p.contacts), len(z) - 6
    normal, count, tangent, u, _ = p.at
    forces, twist, friction = np.empty(3 * n), np.empty(6), Friction(limits, p.faces, p.normals)
    for i in range(n):
        for a in range(3):
            forces[3 * i + a] = r[3 * i + (a + 1) % 3] * posed.force
    for k in range(6):
        twist[k] = z[m + k] * posed.motion / (1.0 if k < 3 else posed.length)
    if len(g.flexibility) > 0:
        v, miss = examine(g, posed, p.contacts, friction, g.offset, forces, twist, GROWTH)
    else:
        moved = motions_of_factor(posed.grasp_matrix, E, g.offset, forces, twist)
        v, miss = moved.v, examined(g, posed, p.contacts, friction, g.offset, forces, moved, GROWTH)
    row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10] = miss
    if not max(miss.balance, miss.normal, miss.cone, miss.slip) <= CERTIFY:
        return False
    at = HEAD
    row[at : at + 3 * n] = forces
    row[at + 3 * n : at + 3 * n + 6] = twist
    row[at + 3 * n + 6 : at + 3 * n + 9] = posed.centre
    at += 3 * n + 9
    row[at : at + 3 * n] = v
    at += 3 * n
    slow = ACTIVE * max(miss.motion_size, posed.motion)
    states = find_states(p.contacts, friction, forces, v, ACTIVE * miss.force_size, slow)
    for i in range(n):
        row[at + i] = states.kind[i]
    at += n
    for k in range(len(p.unknown)):
        own = p.unknown[k]
        row[at + (normal + k if k < count else tangent + k - count)] = r[own - own % 3 + (own + 1) % 3]
    for k in range(6):
        row[at + u + k] = z[m + k]
    row[11] = UNIQUE if _unique(linked, r, z, states, limits) else UNKNOWN
    return True


@kernel
def _unique(linked: Linked, r: Array, z: Array, states: States, limits: Array) -> bool:
    """Whether nothing is free, and rows of the laws and contact states say the same; else it is left to others."""
    n = len(states.kind)
    D, pushes = np.empty((n, 3, 4)), np.empty(n, np.bool_)
    if not determined_by(linked, r, z, D, pushes):
        return False
    for i in range(n):
        kind = states.kind[i]
        sticks = D[i, 0, 0] == 1.0 and D[i, 1, 1] == 1.0
        if kind == SEPARATED:
            same = not pushes[i]
        elif kind == STICKING:
            same = pushes[i] and sticks
        elif kind == SLIDING:
            same = pushes[i] and not sticks
        else:
            same = kind == GLIDING and pushes[i] and limits[i] == 0.0
        if not same:
            return False
    return True
