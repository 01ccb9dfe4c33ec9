"""The consistent tangent of a step: what balance, joints and pads become to first order about an iterate, compiled.

About an iterate the end of a step differs by the object's small motion u, by changes of the joints δq and by changes of
the pads δs. To first order in them, with forces r that keep their components along axes that turn with the contacts,

    balance   w + G r + A_u u + A_q δq + A_s δs = 0
    joints    (1 + ε) δq = (q_c - q̂) + ε (q⁻ - q̂) - C (Jᵀ r + T_u u + (T_q - H) δq + T_s δs)  C = K⁻¹
    pads      (1 + η) δs = -ŝ + η (s⁻ - ŝ) - P (r + F_u u + F_q δq + F_s δs)
    contacts  v = Gᵀ u - J δq - δs + d

A are the changes of the forces' wrench, T those of the joints' torques (geometric stiffness of the finger included), F
those of the forces, all through turning and moving contacts; ε = 1/h is a damper on the joints, η on the pads. Tendons
along routes, whose arms R change, pull harder at the joints by H δq, H = Σ T ∂R/∂q.
Leaving A, T and F out gives the step in frozen geometry, whose iteration does not converge where every finger slides.
Limits that give way drive the joints back by Y g besides, when the torques Yᵀ τ reach them. δq and δs are eliminated;
what is left is a problem in r, u and g, as every grasp is one:

    v = V_r r + V_u u + V_g g + d',    0 = w' + B_r r + B_u u + B_g g,    Yᵀ τ = Yᵀ Jᵀ r + L (1, r, u, g)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.dense import kernel, product, solve_wide


class Touch(NamedTuple):
    """n contacts of an iterate and how they move, world axes. positions (n, 3), normals (n, 3), gap (n,) [m].

    places (n, 3) : points of the fingertips that their motions refer to, pads deformed. turn, shift (n, 3, 6) : of the
    normal [1/m, 1] and of the position [1, m], by the twist of the fingertip relative to the object about that place;
    both turn and move with the object besides. turn is empty where contacts stay.
    """

    positions: Array
    normals: Array
    gap: Array
    places: Array
    turn: Array
    shift: Array


class Moving(NamedTuple):
    """columns (joints, 6) : of the world Jacobian, the linear part of the world's origin first. support (k, joints) : 1
    where a joint moves a finger. coupling (joints, nv) : of the independent joints; empty where they are all of them.
    """

    columns: Array
    support: Array
    coupling: Array


class Turned(NamedTuple):
    """Changes by (u (6,), δq (nv,), δs (3n,)), columns in this order: wrench (6, ·) about the contacts' centre, torque
    (nv, ·), force (3n, ·) in contact axes.
    """

    wrench: Array
    torque: Array
    force: Array


class Borne(NamedTuple):
    """What a contact bears, world axes: at a point (3,) a force (3,) [N], and a moment [N·m] about the normal (3,)."""

    point: Array
    force: Array
    normal: Array
    torsion: float


class Yielding(NamedTuple):
    """What gives way under the forces. J (c, nv), P (c, c) : of the joints, and flexibility of all else, in contact
    axes, turns of soft contacts last. compliance_factor (nv, m) : A of C = A Aᵀ. give (c,) : ŝ - η (s⁻ - ŝ). d (c,).
    Y (nv, k). tensed (nv, nv) : H; empty: none.
    """

    J: Array
    P: Array
    compliance_factor: Array
    give: Array
    d: Array
    Y: Array
    tensed: Array


class Driven(NamedTuple):
    """The joints. command (nv,) : q_c - q̂, lag (nv,) : q⁻ - q̂, slow : ε; pads : η."""

    command: Array
    lag: Array
    slow: float
    pads: float


class Condensed(NamedTuple):
    """v = V_r r + V_u u + V_g g + d' in contact axes but for J Y g, 0 = w' + B_r r + B_u u + B_g g about the contacts'
    centre, L (k, 1 + c + 6 + k) of limits that give way, and what was eliminated: (δq + Y g, δs) = Z (1, r, u, g). All
    SI. found : whether there is a solution.
    """

    V_r: Array
    V_u: Array
    V_g: Array
    d: Array
    B_r: Array
    B_u: Array
    B_g: Array
    w: Array
    L: Array
    Z: Array
    found: bool


@kernel
def skew(a: Array) -> Array:
    """(3, 3) of a × ."""
    out = np.zeros((3, 3))
    out[0, 1], out[0, 2], out[1, 2] = -a[2], a[1], -a[0]
    out[1, 0], out[2, 0], out[2, 1] = a[2], -a[1], a[0]
    return out


@kernel
def turned_forces(t: Touch, frames: Array, m: Moving, centre: Array, forces: Array, torsion: Array) -> Turned:
    """Of forces (n, 3) [N] in contact axes and moments about the normals (n,) [N·m]. frames (n, 3, 3)."""
    n, k, joints = len(frames), len(m.support), len(m.columns)
    support, wide = m.support, 6 + joints + 3 * n
    wrench, torque, force = np.zeros((6, wide)), np.zeros((joints, wide)), np.zeros((3 * n, wide))
    motion, lever = np.zeros((joints, 3)), np.zeros((joints, 3))
    f, arm, twist, dn, dx, df = np.empty(3), np.empty(3), np.empty(6), np.empty(3), np.empty(3), np.empty(3)
    for i in range(n):
        normal, along = t.normals[i], 0.0
        for a in range(3):
            arm[a], f[a] = t.positions[i, a] - centre[a], 0.0
            for b in range(3):
                f[a] += frames[i, a, b] * forces[i, b]
            along += normal[a] * f[a]
        if i < k:
            _joints(torque, motion, lever, m, i, Borne(t.positions[i], f, normal, torsion[i]))
        for b in range(9 + joints):  # by each part of the object's motion, each joint, each part of the pad's
            if 6 <= b < 6 + joints and (i >= k or support[i, b - 6] == 0.0):
                continue
            at = b if b < 6 + joints else b + 3 * i
            _relative(twist, m, b, t.places[i], centre, frames[i])
            for a in range(3):
                dn[a] = dx[a] = 0.0
            for e in range(6):
                if twist[e] != 0.0:
                    for a in range(3):
                        dn[a] += t.turn[i, a, e] * twist[e]
                        dx[a] += t.shift[i, a, e] * twist[e]
            if b < 3:  # normal and position move with the object besides
                dx[b] += 1.0
            elif b < 6:
                p, q = (b + 1) % 3, (b + 2) % 3
                dn[p] -= normal[q]
                dn[q] += normal[p]
                dx[p] -= arm[q]
                dx[q] += arm[p]
            across = f[0] * dn[0] + f[1] * dn[1] + f[2] * dn[2]
            for a in range(3):  # (n × dn) × f, the force as its axes turn by the least rotation
                df[a] = along * dn[a] - across * normal[a]
                wrench[a, at] += df[a]
            for a in range(3):
                p, q = (a + 1) % 3, (a + 2) % 3
                wrench[3 + a, at] += arm[p] * df[q] - arm[q] * df[p] - f[p] * dx[q] + f[q] * dx[p] + torsion[i] * dn[a]
                force[3 * i + a, at] = frames[i, 0, a] * df[0] + frames[i, 1, a] * df[1] + frames[i, 2, a] * df[2]
            if i < k:
                for j in range(joints):
                    if support[i, j] != 0.0:
                        change = 0.0
                        for a in range(3):
                            change += motion[j, a] * df[a] + lever[j, a] * dx[a]
                            if torsion[i] != 0.0:
                                change += torsion[i] * m.columns[j, 3 + a] * dn[a]
                        torque[j, at] += change
    if len(m.coupling) == 0:
        return Turned(wrench, torque, force)
    rows = product(np.ascontiguousarray(m.coupling.T), torque)
    return Turned(_coupled(wrench, m.coupling), _coupled(rows, m.coupling), _coupled(force, m.coupling))


@kernel
def _relative(twist: Array, m: Moving, b: int, place: Array, centre: Array, R: Array) -> None:
    """Write the twist (6,) of a fingertip relative to the object, about the fingertip's place, by the b-th of
    (u, joints, its own δs).
    """
    joints = len(m.columns)
    for a in range(6):
        twist[a] = 0.0
    if b < 3:
        twist[b] = -1.0
    elif b < 6:
        p, q = (b + 1) % 3, (b + 2) % 3
        twist[b] = -1.0
        twist[p] += place[q] - centre[q]
        twist[q] -= place[p] - centre[p]
    elif b < 6 + joints:
        c = m.columns[b - 6]
        twist[0] = c[0] + c[4] * place[2] - c[5] * place[1]
        twist[1] = c[1] + c[5] * place[0] - c[3] * place[2]
        twist[2] = c[2] + c[3] * place[1] - c[4] * place[0]
        twist[3], twist[4], twist[5] = c[3], c[4], c[5]
    else:
        for a in range(3):
            twist[a] = R[a, b - 6 - joints]


@kernel
def _joints(torque: Array, motion: Array, lever: Array, m: Moving, i: int, at: Borne) -> None:
    """Write, for each joint of finger i, how fast it moves the contact (3,), and f × its axis; add what the force f and
    the moment do to the torques as other joints turn its axis.
    """
    columns, support, x, f, normal = m.columns, m.support, at.point, at.force, at.normal
    for j in range(len(columns)):
        if support[i, j] == 0.0:
            continue
        for a in range(3):
            p, q = (a + 1) % 3, (a + 2) % 3
            motion[j, a] = columns[j, a] + columns[j, 3 + p] * x[q] - columns[j, 3 + q] * x[p]
            lever[j, a] = f[p] * columns[j, 3 + q] - f[q] * columns[j, 3 + p]
        for o in range(j):  # a joint is carried by those of its finger with smaller numbers
            if support[i, o] == 0.0:
                continue
            for a in range(3):
                p, q = (a + 1) % 3, (a + 2) % 3
                spun = columns[j, 3 + p] * normal[q] - columns[j, 3 + q] * normal[p]
                bent = lever[o, a] * motion[j, a] - lever[j, a] * motion[o, a]
                torque[j, 6 + o] += bent + at.torsion * columns[o, 3 + a] * spun


@kernel
def _coupled(rows: Array, coupling: Array) -> Array:
    """With the columns of all joints made those of the independent ones."""
    joints, nv = coupling.shape
    out = np.empty((len(rows), rows.shape[1] - joints + nv))
    out[:, :6] = rows[:, :6]
    out[:, 6 : 6 + nv] = product(rows[:, 6 : 6 + joints].copy(), coupling)
    out[:, 6 + nv :] = rows[:, 6 + joints :]
    return out


@kernel
def condensed(turned: Turned, still: bool, elastic: Yielding, driven: Driven) -> Condensed:
    """Without δq and δs. still : contacts do not move, and `turned` is not read."""
    J, P, Y, slow = elastic.J, elastic.P, elastic.Y, driven.slow
    (c, nv), k = J.shape, Y.shape[1]
    n3, size, found = turned.force.shape[0], nv + c, True
    C = product(elastic.compliance_factor, np.ascontiguousarray(elastic.compliance_factor.T))
    A = np.zeros((size, size + 1 + c + 6 + k))  # the system, then its right sides by (1, r, u, g)
    for j in range(nv):
        A[j, j], A[j, size] = 1.0 + slow, driven.command[j] + slow * driven.lag[j]
    for i in range(c):
        A[nv + i, nv + i], A[nv + i, size] = 1.0 + driven.pads, -elastic.give[i]
    A[:nv, size + 1 : size + 1 + c] = -product(C, np.ascontiguousarray(J.T))
    A[nv:, size + 1 : size + 1 + c] = -P
    w, B_r, B_u, B_g = np.zeros(6), np.zeros((6, c)), np.zeros((6, 6)), np.zeros((6, k))
    L, by = np.zeros((k, 1 + c + 6 + k)), 1 + c + 6
    if still:
        for j in range(nv):
            A[j, size:] /= 1.0 + slow
        for i in range(c):
            A[nv + i, size:] /= 1.0 + driven.pads
        Z = A[:, size:].copy()
    else:
        changes, torque = np.zeros((size, 6 + nv + n3)), turned.torque.copy()
        if len(elastic.tensed) > 0:
            torque[:, 6 : 6 + nv] -= elastic.tensed
        changes[:nv] = np.dot(C, torque)
        changes[nv:] = np.dot(P[:, :n3].copy(), turned.force)
        A[:, : nv + n3] += changes[:, 6:]
        A[:, size + 1 + c : size + by] = -changes[:, :6]
        if k > 0:
            A[:, size + by :] = np.dot(changes[:, 6 : 6 + nv].copy(), Y)
        found = solve_wide(A, 0.0)
        Z = A[:, size:].copy()
        held = Z[: nv + n3].copy()
        if k > 0:
            held[:nv, by:] -= Y
            back = np.ascontiguousarray(Y.T)
            L[:] = np.dot(back, np.dot(turned.torque[:, 6:].copy(), held))
            L[:, 1 + c : by] += np.dot(back, turned.torque[:, :6].copy())
        moved = np.dot(turned.wrench[:, 6:].copy(), held)
        w[:], B_r[:], B_g[:] = moved[:, 0], moved[:, 1 : 1 + c], moved[:, by:]
        B_u[:] = turned.wrench[:, :6] + moved[:, 1 + c : by]
    tip = -np.dot(J, Z[:nv]) - Z[nv:]
    V_r, V_u, V_g = tip[:, 1 : 1 + c].copy(), tip[:, 1 + c : by].copy(), tip[:, by:].copy()
    return Condensed(V_r, V_u, V_g, elastic.d + tip[:, 0], B_r, B_u, B_g, w, L, Z, found)
