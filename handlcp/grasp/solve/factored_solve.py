"""`solve_factored`: the first stage for many contacts whose flexibility is a factor, in one compiled call.

The same laws and steps as in `compiled_solve`, over blocks of three (`contact/block_newton.py`), and the same row
of numbers as its answer. Where it leads to no answer, scenes go the other way, with E as a matrix.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.contact.block_newton import LinkedContacts, is_determined, solve_blocks
from handlcp.grasp.model.flexibility import FlexibilityFactor
from handlcp.grasp.model.scene import GraspArrays, GraspGeometry, compute_geometry
from handlcp.grasp.solve.compiled_solve import (
    HEADER_SIZE,
    MAYBE_FREE,
    OUTCOME,
    UNIQUE,
    ScenePattern,
    write_residuals,
    write_start,
)
from handlcp.grasp.verify.certifier import (
    FrictionLimits,
    compute_motions_and_residuals,
    compute_residuals,
    contact_motions_of_factor,
    laws_pass,
)
from handlcp.grasp.verify.contact_state import GLIDING, SEPARATED, SLIDING, STICKING, ContactStates, find_states
from handlcp.lcp.kernels.contact_newton import ContactArrays
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import ACTIVE_TOLERANCE, MAX_RESIDUAL_GROWTH, SOLVE_TOLERANCE

_MIN_PIVOT_SHARE = 1e-9  # pivots below this share of the largest say that something may be free


class FactoredRow(NamedTuple):
    """A scene's numbers, one after the other, and how many joints and columns of their root there are: positions (3n),
    frames (9n), offset (3n), force, moment (3), freedom (36), J (3n nv), A (nv m), P (9n), limits (n). matrix :
    (3n, 3n) E where it was given as one, which answers are judged by; else (0, 0).
    """

    numbers: Array
    joints: int
    columns: int
    matrix: Array


class _FactoredScene(NamedTuple):
    """What a row says. limits (n,) : of friction."""

    given: GraspArrays
    factor: FlexibilityFactor
    limits: Array


class LinearRows(NamedTuple):
    """The rows of `LinkedContacts` that are linear: P (n, 3, 3), W, R (3n, m), d (3n,), S (m, m), w (m,); SI, contact
    axes.
    """

    P: Array
    W: Array
    R: Array
    d: Array
    S: Array
    w: Array


@kernel
def solve_factored(scene: FactoredRow, p: ScenePattern, start: Array, row: Array) -> bool:
    """Write the answer's row, as `solve_scenes` does; start as there. Returns whether it is an answer."""
    n = len(p.contacts)
    read = _read_row(scene, n)
    g = read.given
    B, softness = _joint_columns(read.factor)
    posed = compute_geometry(g, softness)
    linked = _link_contacts(g, read.factor.pads, B, posed, softness, read.limits, p)
    r, z, begun = np.zeros(3 * n), np.zeros(scene.columns + 6), len(start) > 0
    if begun:
        x = np.zeros(p.at[4])
        write_start(x, start, p, g.freedom, posed)
        split_unknowns(x, p, linked, r, z)
    newton, residual = solve_blocks(linked, r, z, begun)
    row[0], row[1], row[2] = 0.0, newton, residual
    if not residual <= SOLVE_TOLERANCE:
        return False
    for i in range(n):
        r[3 * i] = max(r[3 * i], 0.0)
    return _write_answer(row, p, read, posed, linked, r, z)


@kernel
def _read_row(scene: FactoredRow, n: int) -> _FactoredScene:
    """The arrays of a scene, as views of its row."""
    s, nv, m = scene.numbers, scene.joints, scene.columns
    a, b = 3 * n, 12 * n
    c = b + 3 * n
    e = c + 42
    f = e + 3 * n * nv
    h = f + nv * m
    factor = FlexibilityFactor(s[e:f].reshape(3 * n, nv), s[f:h].reshape(nv, m), s[h : h + 9 * n].reshape(n, 3, 3))
    g = GraspArrays(
        s[:a].reshape(n, 3),
        s[a:b].reshape(n, 3, 3),
        scene.matrix,
        s[b:c],
        s[:0],
        s[:0].reshape(3, 0),
        s[c : c + 3],
        s[c + 3 : c + 6],
        s[c + 6 : e].reshape(6, 6),
    )
    return _FactoredScene(g, factor, s[h + 9 * n :])


@kernel
def _joint_columns(E: FlexibilityFactor) -> tuple[Array, Array]:
    """The columns J A (3n, m) of the joints, and the diagonal of E (3n,)."""
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
def _link_contacts(
    g: GraspArrays, pads: Array, B: Array, posed: GraspGeometry, softness: Array, limits: Array, p: ScenePattern
) -> LinkedContacts:
    """The problem in natural units; B = J A."""
    c, m = B.shape
    W, S, w = np.empty((c, m + 6)), np.zeros((m + 6, m + 6)), np.zeros(m + 6)
    for i in range(c):
        for j in range(m):
            W[i, j] = B[i, j]
        for k in range(6):
            W[i, m + k] = posed.grasp_matrix[k, i]
    for j in range(m):
        S[j, j] = 1.0
    for k in range(6):
        w[m + k] = posed.wrench[k]
    return link_in_natural_units(LinearRows(pads, W, W, g.offset, S, w), posed, softness, limits, p, _MIN_PIVOT_SHARE)


@kernel
def link_in_natural_units(
    si: LinearRows, posed: GraspGeometry, softness: Array, limits: Array, p: ScenePattern, least: float
) -> LinkedContacts:
    """The problem in natural units, each contact's normal first.

    softness (3n,) : diagonal of the flexibility of all that gives way [m/N]. limits (n,) : of friction. least : as in
    `LinkedContacts`.
    """
    n, size = len(si.P), len(si.w)
    m, units, largest = size - 6, posed.force_unit / posed.motion_unit, 0.0
    unit = np.empty(size)  # of z: of the joints' √(force · motion), of the object's motion
    for j in range(size):
        unit[j] = np.sqrt(posed.force_unit * posed.motion_unit) if j < m else posed.motion_unit
        if j >= m + 3:
            unit[j] /= posed.length_unit
    P, W, R, d = np.empty((n, 3, 3)), np.empty((3 * n, size)), np.empty((3 * n, size)), np.empty(3 * n)
    S, w, rho = np.empty((size, size)), np.empty(size), np.empty(3 * n)
    work = posed.force_unit * posed.motion_unit  # a row times its unknown
    for j in range(size):
        w[j] = si.w[j] * unit[j] / work
        for k in range(size):
            S[j, k] = si.S[j, k] * unit[j] * unit[k] / work
    for i in range(n):
        mean = (softness[3 * i] + softness[3 * i + 1] + softness[3 * i + 2]) * units / 3
        for a in range(3):
            at, own = 3 * i + a, 3 * i + (a + 2) % 3
            d[at], rho[at] = si.d[own] / posed.motion_unit, mean
            for b in range(3):
                P[i, a, b] = si.P[i, (a + 2) % 3, (b + 2) % 3] * units
            for j in range(size):
                W[at, j] = si.W[own, j] * (unit[j] / posed.motion_unit)
                R[at, j] = si.R[own, j] * (unit[j] / posed.motion_unit)
            largest = max(largest, softness[own] * units)
    for i in range(3 * n):
        rho[i] = 1.0 / max(rho[i], 1e-6 * largest)
    role, blocks = np.full(3 * n, 2), np.full((n, 4), -1)
    for i in range(n):
        role[3 * i] = 1
        for a in range(3):
            blocks[i, a] = 3 * i + a
    own_rows = ContactArrays(np.empty((0, 0)), np.empty(0), role, rho, blocks, limits.copy(), p.faces, p.normals)
    return LinkedContacts(P, W, R, d, S, w, own_rows, least)


@kernel
def split_unknowns(x: Array, p: ScenePattern, linked: LinkedContacts, r: Array, z: Array) -> None:
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
            z[j] += linked.R[k, j] * r[k]


@kernel
def _write_answer(
    row: Array, p: ScenePattern, read: _FactoredScene, posed: GraspGeometry, linked: LinkedContacts, r: Array, z: Array
) -> bool:
    """Certify forces and motion, and write what they say into the row; returns whether they are an answer."""
    n, m, g, limits = len(p.contacts), len(z) - 6, read.given, read.limits
    normal, count, tangent, u, _ = p.at
    forces, twist, friction = np.empty(3 * n), np.empty(6), FrictionLimits(limits, p.faces, p.normals)
    for i in range(n):
        for a in range(3):
            forces[3 * i + a] = r[3 * i + (a + 1) % 3] * posed.force_unit
    for k in range(6):
        twist[k] = z[m + k] * posed.motion_unit / (1.0 if k < 3 else posed.length_unit)
    if len(g.flexibility) > 0:
        v, miss = compute_motions_and_residuals(
            g, posed, p.contacts, friction, g.offset, forces, twist, MAX_RESIDUAL_GROWTH
        )
    else:
        moved = contact_motions_of_factor(posed.grasp_matrix, read.factor, g.offset, forces, twist)
        v, miss = (
            moved.v,
            compute_residuals(g, posed, p.contacts, friction, g.offset, forces, moved, MAX_RESIDUAL_GROWTH),
        )
    write_residuals(row, miss)
    if not laws_pass(miss):
        return False
    at = HEADER_SIZE
    row[at : at + 3 * n] = forces
    row[at + 3 * n : at + 3 * n + 6] = twist
    row[at + 3 * n + 6 : at + 3 * n + 9] = posed.centre
    at += 3 * n + 9
    row[at : at + 3 * n] = v
    at += 3 * n
    slow = ACTIVE_TOLERANCE * max(miss.motion_size, posed.motion_unit)
    states = find_states(p.contacts, friction, forces, v, ACTIVE_TOLERANCE * miss.force_size, slow)
    for i in range(n):
        row[at + i] = states.kind[i]
    at += n
    for k in range(len(p.unknown)):
        own = p.unknown[k]
        row[at + (normal + k if k < count else tangent + k - count)] = r[own - own % 3 + (own + 1) % 3]
    for k in range(6):
        row[at + u + k] = z[m + k]
    row[OUTCOME] = UNIQUE if _is_unique(linked, r, z, states, limits) else MAYBE_FREE
    return True


@kernel
def _is_unique(linked: LinkedContacts, r: Array, z: Array, states: ContactStates, limits: Array) -> bool:
    """Whether nothing is free, and rows of the laws and contact states say the same; else it is left to others."""
    n = len(states.kind)
    D, pushes = np.empty((n, 3, 4)), np.empty(n, np.bool_)
    if not is_determined(linked, r, z, D, pushes):
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
