"""One iteration of a step with many contacts: pads and contacts are eliminated one by one, onto joints and object.

The same tangent as in `tangent.py`, where nothing but its own force and the joints and the object deforms a pad. With
D = (1 + η + P F_s)⁻¹ of each pad, Q = D P, ŝ' = ŝ - η (s⁻ - ŝ), and of joints with C = A Aᵀ
z = Aᵀ (Jᵀ r + T_u u + T_q δq + T_s δs)

    δq = a - A z / (1 + ε),   a = (q_c - q̂ + ε (q⁻ - q̂)) / (1 + ε)
    δs = -D ŝ' - Q (r + F_u u + F_q δq)
    v  = Q r + (Gᵀ + Q F_u) u + (Q F_q - J) δq + D ŝ' + d

each contact sees its own force and what all share, z and u, and so do the rows of z and of balance:
the problem of `contact/block_newton.py`. Its cost grows with the number of contacts, not with its cube.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.contact.block_newton import solve_blocks, tangent_stiffness_blocks
from handlcp.grasp.model.scene import GraspArrays, GraspGeometry, compute_geometry, wrench_map
from handlcp.grasp.path.newton.answer import Found, put, written
from handlcp.grasp.path.newton.iteration import begun_from, carried, loaded, middle, softness_of_components, told
from handlcp.grasp.path.newton.linear_solve import ANY, Rules, accepted, kinds_in_step
from handlcp.grasp.path.newton.numbers import Laws, Situation
from handlcp.grasp.path.newton.tangent import Turned, turned_forces
from handlcp.grasp.solve.compiled_solve import LinearRows, link_in_natural_units, split_unknowns, write_start
from handlcp.grasp.verify.certifier import ContactMotions, FrictionLimits, compute_residuals
from handlcp.lcp.kernels.dense import kernel, product, solve_wide
from handlcp.tolerances import SOLVE_TOLERANCE


class _Pads(NamedTuple):
    """What pads do by themselves: Q (n, 3, 3); D ŝ' (3n,); Q F (3n, 6 + nv) by u and δq, and (T; A)_s (nv + 6, 3n), the
    changes of shared rows, both empty where contacts stay. found : whether that is determined.
    """

    Q: Array
    give: Array
    follow: Array
    back: Array
    found: bool


class _Shared(NamedTuple):
    """Rows of the joints' torques and of balance (nv + 6, ·) by δq (nv,), u (6,), and their constants; pads eliminated.
    a (nv,), A (nv, m) : δq = a - A z.
    """

    by_joints: Array
    by_object: Array
    constant: Array
    a: Array
    A: Array


class _Tangent(NamedTuple):
    """All that an iterate is to first order. What the load is about the contacts' centre is still missing from the w of
    linear. softness (3n,) : diagonal of what gives way.
    """

    turned: Turned
    pads: _Pads
    shared: _Shared
    linear: LinearRows
    softness: Array


@kernel
def iteration_by_contact(
    s: Situation, rules: Rules, start: Array, begun: bool, seed: int, near: float, row: Array
) -> None:
    """As `one_iteration`, for contacts whose pads do not depend on each other, without moments, planes, effects and
    limits that give way. seed is not used: nothing here is random.
    """
    laws, p, centre = rules.laws, rules.pattern, middle(s.touch.positions)
    r = begun_from(start, laws)
    t = _tangent(s, laws, r, centre)
    if not t.pads.found:
        return
    force, moment = loaded(s.loads)
    none, no_matrix, no_spin = np.zeros(0), np.zeros((0, 0)), np.zeros((3, 0))
    g = GraspArrays(s.touch.positions, s.frames, no_matrix, t.linear.d, none, no_spin, force, moment, laws.freedom)
    posed = compute_geometry(g, t.softness)
    m = len(t.linear.w) - 6
    for k in range(6):
        t.linear.w[m + k] += posed.wrench[k]
    problem = link_in_natural_units(t.linear, posed, t.softness, rules.friction_coefficients, p, 0.0)
    z, warm = np.zeros(m + 6), begun and len(start) > 0
    r[:] = 0.0
    if warm:
        x = np.zeros(p.at[4])
        write_start(x, start[: len(r) + 9], p, laws.freedom, posed)
        split_unknowns(x, p, problem, r, z)
    _, residual = solve_blocks(problem, r, z, warm)
    if not residual <= SOLVE_TOLERANCE:
        return
    good, found = _answered(s, rules, t, g, posed, r, z, residual)
    if not good:
        return
    written(s, laws, centre, found, row)
    if row[1] <= near:
        determined, push = tangent_stiffness_blocks(problem, r, z)
        put(row, len(row) - 36, push.reshape(-1))
        row[0] = row[2] = 1.0 if determined else 0.0


@kernel
def _tangent(s: Situation, laws: Laws, r: Array, centre: Array) -> _Tangent:
    """About an iterate, whose forces are r (3n,)."""
    n, nv = len(s.frames), s.elastic.J.shape[1]
    turned = Turned(np.zeros((6, 0)), np.zeros((nv, 0)), np.zeros((0, 0)))
    if len(s.touch.turn) > 0:
        turned = turned_forces(s.touch, s.frames, s.moving, centre, r.reshape(-1, 3), np.zeros(n))
    pads = _alone(s, turned)
    shared = _shared(s, turned, pads, told(s.elastic, s.loads, laws))
    el = s.elastic
    softness = softness_of_components(el.J, el.P, el.compliance_factor, laws)
    return _Tangent(turned, pads, shared, _linear(s, pads, shared, centre), softness)


@kernel
def _alone(s: Situation, turned: Turned) -> _Pads:
    """What pads do by themselves."""
    el, n, first, slow = s.elastic, len(s.frames), 6 + s.elastic.J.shape[1], s.damping.pads
    moves = len(turned.force) > 0
    rows = 3 * n if moves else 0
    pads = _Pads(np.empty((n, 3, 3)), np.empty(3 * n), np.empty((rows, first)), np.empty((first, rows)), True)
    if moves:
        nv = first - 6
        pads.back[:nv], pads.back[nv:] = turned.torque[:, first:], turned.wrench[:, first:]
    own = np.empty((3, 7))  # 1 + η + P F_s, and beside it P and ŝ - η (s⁻ - ŝ)
    for i in range(n):
        k = 3 * i
        for a in range(3):
            own[a, 6] = 0.0
            for b in range(3):
                own[a, b], own[a, 3 + b] = 1.0 + slow if a == b else 0.0, el.P[k + a, k + b]
                own[a, 6] += s.frames[i, b, a] * (s.loads.give[i, b] - slow * s.damping.given[i, b])
                if moves:
                    for e in range(3):
                        own[a, b] += el.P[k + a, k + e] * turned.force[k + e, first + k + b]
        if not solve_wide(own, 0.0):
            return _Pads(pads.Q, pads.give, pads.follow, pads.back, False)
        for a in range(3):
            pads.give[k + a] = own[a, 6]
            for b in range(3):
                pads.Q[i, a, b] = own[a, 3 + b]
        if moves:
            pads.follow[k : k + 3] = product(pads.Q[i], turned.force[k : k + 3, :first])
    return pads


@kernel
def _shared(s: Situation, turned: Turned, pads: _Pads, command: Array) -> _Shared:
    """What joints and object do, pads following them. command (nv,) : from where the joints stand, q_c - q̂."""
    el, slow, lag = s.elastic, s.damping.slow, s.damping.lag
    nv, first = el.J.shape[1], 6 + el.J.shape[1]
    rows, constant = np.zeros((nv + 6, first)), np.zeros(nv + 6)
    if len(turned.force) > 0:
        rows[:nv], rows[nv:] = turned.torque[:, :first], turned.wrench[:, :first]
        if len(el.tensed) > 0:
            rows[:nv, 6:] -= el.tensed
        rows -= product(pads.back, pads.follow)
        constant -= np.dot(pads.back, pads.give)
    a = (command + slow * lag) / (1.0 + slow)
    return _Shared(rows[:, 6:].copy(), rows[:, :6].copy(), constant, a, el.compliance_factor / (1.0 + slow))


@kernel
def _linear(s: Situation, pads: _Pads, shared: _Shared, centre: Array) -> LinearRows:
    """The problem in SI, contacts in their own axes."""
    el, loads, damping, moves = s.elastic, s.loads, s.damping, len(pads.follow) > 0
    (n3, nv), m = el.J.shape, el.compliance_factor.shape[1]
    G = wrench_map(s.touch.positions, centre, s.frames, np.zeros((3, 0)))
    tip, W_u, pull, R_u = -el.J, np.ascontiguousarray(G.T), el.J.copy(), np.ascontiguousarray(G.T)
    if moves:
        W_u += pads.follow[:, :6]
        tip += pads.follow[:, 6:]
        for i in range(n3 // 3):
            k = 3 * i
            pushed = product(np.ascontiguousarray(pads.Q[i].T), np.ascontiguousarray(pads.back[:, k : k + 3].T))
            pull[k : k + 3] -= pushed[:, :nv]
            R_u[k : k + 3] -= pushed[:, nv:]
    W, R = np.empty((n3, m + 6)), np.empty((n3, m + 6))
    W[:, :m], W[:, m:] = -product(tip, shared.A), W_u
    R[:, :m], R[:, m:] = product(pull, el.compliance_factor), R_u
    d = pads.give + np.dot(tip, shared.a)
    for k in range(n3):
        d[k] += loads.base[k // 3, k % 3]
    # Rows of the torques, then of balance: Aᵀ and 1 times (by_object u + by_joints δq + constant), 0 = ... - S z
    S, w = np.zeros((m + 6, m + 6)), np.zeros(m + 6)
    for c in range(m):
        S[c, c] = 1.0
    if moves:
        A = np.ascontiguousarray(el.compliance_factor.T)
        by_z, constant = -product(shared.by_joints, shared.A), shared.constant + np.dot(shared.by_joints, shared.a)
        w[:m], w[m:] = np.dot(A, constant[:nv]), constant[nv:]
        S[:m, :m] -= product(A, by_z[:nv])
        S[:m, m:] -= product(A, shared.by_object[:nv])
        S[m:, :m] -= by_z[nv:]
        S[m:, m:] -= shared.by_object[nv:] + carried(loads, centre)
    for b in range(6):
        w[m + b] -= damping.body[b] * damping.done[b]
        S[m + b, m + b] += damping.body[b]
    return LinearRows(pads.Q, W, R, d, S, w)


@kernel
def _answered(
    s: Situation, rules: Rules, t: _Tangent, g: GraspArrays, posed: GraspGeometry, r: Array, z: Array, residual: float
) -> tuple[bool, Found]:
    """(whether it passes, what it says) of a solution in natural units."""
    el, p, linear, Q = s.elastic, rules.pattern, t.linear, t.pads.Q
    n3, m = len(r), len(z) - 6
    own, v, size, terms = np.empty(n3), np.empty(n3), np.empty(n3), np.empty(n3)
    x, twist, offset = np.empty(m + 6), np.empty(6), linear.d.copy()
    for i in range(n3 // 3):
        for a in range(3):
            value = r[3 * i + (a + 1) % 3] * posed.force_unit
            own[3 * i + a] = max(value, 0.0) if a == 2 else value
    for j in range(m):
        x[j] = z[j] * np.sqrt(posed.force_unit * posed.motion_unit)
    for k in range(6):
        twist[k] = x[m + k] = z[m + k] * posed.motion_unit / (1.0 if k < 3 else posed.length_unit)
    for k in range(n3):
        move, turns, retreat, largest = 0.0, 0.0, 0.0, 0.0
        for j in range(6):
            term = posed.grasp_matrix[j, k] * twist[j]
            move += term
            turns += linear.W[k, m + j] * twist[j] - term
            largest = max(largest, abs(term))
        for j in range(m):
            term = linear.W[k, j] * x[j]
            retreat += term
            largest = max(largest, abs(term))
        for e in range(3):
            term = Q[k // 3, k % 3, e] * own[k - k % 3 + e]
            retreat += term
            largest = max(largest, abs(term))
        offset[k] += turns
        v[k] = move + retreat + offset[k]
        size[k], terms[k] = max(abs(move), abs(retreat), abs(offset[k])), max(largest, abs(offset[k]))
    change = t.shared.a - np.dot(t.shared.A, x[:m])
    torque = el.gravity + np.dot(own, el.J)
    lacks = linear.w[m:] - np.dot(linear.S[m:], x)  # of balance, but for G r and the load
    for b in range(6):
        for k in range(n3):
            lacks[b] += (linear.R[k, m + b] - posed.grasp_matrix[b, k]) * own[k]
    posed.wrench[:] = lacks
    if len(t.turned.force) > 0:
        _turn(torque, t.turned, t.pads, own, change, twist)
    friction = FrictionLimits(rules.friction_coefficients, p.faces, p.normals)
    misses = compute_residuals(
        g, posed, p.contacts, friction, offset, own, ContactMotions(v, size, terms, t.softness), ANY
    )
    kinds = kinds_in_step(p.contacts, friction, misses, posed, own, v)
    return accepted(misses, posed, residual, 1), Found(own, v, twist, kinds, np.zeros(0), change, torque)


@kernel
def _turn(torque: Array, turned: Turned, pads: _Pads, forces: Array, change: Array, twist: Array) -> None:
    """Add what turning and moving contacts do to the torques."""
    nv, shift = len(torque), np.concatenate((twist, change))
    given = -pads.give - np.dot(pads.follow, shift)  # δs
    for k in range(len(forces)):
        for e in range(3):
            given[k] -= pads.Q[k // 3, k % 3, e] * forces[k - k % 3 + e]
    torque += np.dot(pads.back[:nv], given) + np.dot(turned.torque[:, : 6 + nv].copy(), shift)
