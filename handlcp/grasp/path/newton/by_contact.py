"""One iteration of a step with many contacts: pads and contacts are eliminated one by one, onto joints and object.

The same tangent as in `tangent.py`, where nothing but its own force and the joints and the object deforms a pad. With
D = (1 + η + P F_s)⁻¹ of each pad, Q = D P, ŝ' = ŝ - η (s⁻ - ŝ), and of joints with C = A Aᵀ
z = Aᵀ (Jᵀ r + T_u u + T_q δq + T_s δs)

    δq = a - A z / (1 + ε),   a = (q_c - q̂ + ε (q⁻ - q̂)) / (1 + ε)
    δs = -D ŝ' - Q (r + F_u u + F_q δq)
    v  = Q r + (Gᵀ + Q F_u) u + (Q F_q - J) δq + D ŝ' + d

each contact sees its own force and what all share, z and u, and so do the rows of z and of balance:
the problem of `lcp/kernels/contact_blocks.py`. Its cost grows with the number of contacts, not with its cube.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.grasp_matrix import Given, Posed, placed, wrench_map
from handlcp.grasp.path.newton.iteration import (
    Found,
    Situation,
    begun_from,
    carried,
    loaded,
    middle,
    put,
    told,
    written,
)
from handlcp.grasp.path.newton.linear_solve import ANY, Rules, accepted
from handlcp.grasp.path.newton.tangent import Turned, turned_forces
from handlcp.grasp.solve.compiled_solve import begin
from handlcp.grasp.solve.factored_solve import from_unknowns, in_natural_units, nothing
from handlcp.grasp.verify.contact_laws import Friction, Moved, examined
from handlcp.grasp.verify.contact_states import find_states
from handlcp.lcp.kernels.block_run import solved_blocks
from handlcp.lcp.kernels.contact_blocks import Linked, met_blocks
from handlcp.lcp.kernels.dense import kernel, product, solve_wide
from handlcp.tolerances import ACTIVE, SOLVE


class _Pads(NamedTuple):
    """Q (n, 3, 3), what a pad gives way by at first, D ŝ' (3n,), and the changes of shared rows by the pads (T; A)_s
    (nv + 6, 3n), columns as the pads.
    """

    Q: Array
    give: Array
    back: Array


class _Shared(NamedTuple):
    """Rows of the joints' torques and of balance (nv + 6, ·) by δq (nv,), u (6,), and their constants; pads eliminated.
    a (nv,), A (nv, m) : δq = a - A z.
    """

    by_joints: Array
    by_object: Array
    constant: Array
    a: Array
    A: Array


@kernel
def iteration_by_contact(
    s: Situation, rules: Rules, start: Array, begun: bool, seed: int, near: float, row: Array
) -> None:
    """As `one_iteration`, for contacts whose pads do not depend on each other, without moments, planes, effects and
    limits that give way. seed is not used: nothing here is random.
    """
    laws, p = rules.laws, rules.pattern
    n3, nv, centre = len(s.elastic.J), s.elastic.J.shape[1], middle(s.touch.positions)
    r = begun_from(start, laws)
    turned = Turned(np.zeros((6, 0)), np.zeros((nv, 0)), np.zeros((0, 0)))
    if len(s.touch.turn) > 0:
        turned = turned_forces(s.touch, s.frames, s.moving, centre, r.reshape(-1, 3), np.zeros(n3 // 3))
    pads = _Pads(np.empty((n3 // 3, 3, 3)), np.empty(n3), np.empty((nv + 6, n3)))
    if not _alone(s, turned, pads):
        return
    shared = _shared(s, turned, pads, told(s.elastic, s.loads, laws))
    si, softness = _problem(s, turned, pads, shared, centre)
    force, moment = loaded(s.loads)
    none = np.zeros(0)
    g = Given(
        s.touch.positions, s.frames, np.zeros((0, 0)), si.d, none, np.zeros((3, 0)), force, moment, laws.freedom
    )  # fmt: skip
    posed = placed(g, softness)
    m = len(si.w) - 6
    for k in range(6):
        si.w[m + k] += posed.wrench[k]
    problem = in_natural_units(si, posed, softness, rules.limits, p)
    z, warm = np.zeros(m + 6), begun and len(start) > 0
    r[:] = 0.0
    if warm:
        x = np.zeros(p.at[4])
        begin(x, start, p, laws.freedom, posed)
        from_unknowns(x, p, problem, r, z)
    _, residual = solved_blocks(problem, r, z, warm)
    if not residual <= SOLVE:
        return
    good, found = _answered(s, rules, turned, pads, shared, si, softness, g, posed, r, z, residual)
    if not good:
        return
    written(s, laws, centre, found, row)
    if row[1] <= near:
        determined, push = met_blocks(problem, r, z)
        put(row, len(row) - 36, push.reshape(-1))
        row[0] = row[2] = 1.0 if determined else 0.0


@kernel
def _alone(s: Situation, turned: Turned, pads: _Pads) -> bool:
    """Write what pads do by themselves; returns whether it is determined."""
    el, n, nv = s.elastic, len(s.frames), s.elastic.J.shape[1]
    first = 6 + nv
    if len(turned.force) > 0:
        pads.back[:nv], pads.back[nv:] = turned.torque[:, first:], turned.wrench[:, first:]
    slow = s.damping.pads
    own = np.empty((3, 7))  # 1 + η + P F_s, and beside it P and ŝ - η (s⁻ - ŝ)
    for i in range(n):
        k = 3 * i
        for a in range(3):
            own[a, 6] = 0.0
            for b in range(3):
                own[a, b], own[a, 3 + b] = 1.0 + slow if a == b else 0.0, el.P[k + a, k + b]
                own[a, 6] += s.frames[i, b, a] * (s.loads.give[i, b] - slow * s.damping.given[i, b])
                if len(turned.force) > 0:
                    for e in range(3):
                        own[a, b] += el.P[k + a, k + e] * turned.force[k + e, first + k + b]
        if not solve_wide(own, 0.0):
            return False
        for a in range(3):
            pads.give[k + a] = own[a, 6]
            for b in range(3):
                pads.Q[i, a, b] = own[a, 3 + b]
    return True


@kernel
def _shared(s: Situation, turned: Turned, pads: _Pads, command: Array) -> _Shared:
    """What joints and object do, pads following them. command (nv,) : from where the joints stand, q_c - q̂."""
    el, slow, lag = s.elastic, s.damping.slow, s.damping.lag
    nv, n3 = el.J.shape[1], len(el.J)
    a, rows = (command + slow * lag) / (1.0 + slow), np.zeros((nv + 6, nv + 7))
    if len(turned.force) > 0:
        first = 6 + nv
        rows[:nv, : nv + 6] = turned.torque[:, :first]
        rows[nv:, : nv + 6] = turned.wrench[:, :first]
        follows = np.empty((n3, nv + 7))  # of the pads, by what is shared
        for i in range(n3 // 3):
            for b in range(3):
                k = 3 * i + b
                for j in range(first):
                    follows[k, j] = 0.0
                    for e in range(3):
                        follows[k, j] -= pads.Q[i, b, e] * turned.force[3 * i + e, j]
                follows[k, first] = -pads.give[k]
        rows += product(pads.back, follows)
    by_object, by_joints, constant = rows[:, :6].copy(), rows[:, 6 : 6 + nv].copy(), rows[:, nv + 6].copy()
    return _Shared(by_joints, by_object, constant, a, el.root / (1.0 + slow))


@kernel
def _problem(s: Situation, turned: Turned, pads: _Pads, shared: _Shared, centre: Array) -> tuple[Linked, Array]:
    """The problem in SI, contacts in their own axes, and the diagonal of what gives way (3n,). What the load is about
    the contacts' centre is still missing from its w.
    """
    el, loads, damping, root = s.elastic, s.loads, s.damping, s.elastic.root
    (n3, nv), m, still = el.J.shape, root.shape[1], len(turned.force) == 0
    W, R, d, softness = np.zeros((n3, m + 6)), np.zeros((n3, m + 6)), np.empty(n3), np.empty(n3)
    S, w, G = (
        np.zeros((m + 6, m + 6)),
        np.zeros(m + 6),
        wrench_map(s.touch.positions, centre, s.frames, np.zeros((3, 0))),
    )
    tip, pull = np.empty(nv), np.empty(nv + 6)
    for k in range(n3):
        i, own = k // 3, k % 3
        for j in range(nv):
            tip[j], pull[j] = -el.J[k, j], el.J[k, j]
        for j in range(6):
            pull[nv + j] = W[k, m + j] = G[j, k]
        if not still:
            for e in range(3):
                for j in range(nv):
                    tip[j] += pads.Q[i, own, e] * turned.force[3 * i + e, 6 + j]
                for j in range(6):
                    W[k, m + j] += pads.Q[i, own, e] * turned.force[3 * i + e, j]
                for j in range(nv + 6):
                    pull[j] -= pads.back[j, 3 * i + e] * pads.Q[i, e, own]
        d[k], softness[k] = loads.base[i, own] + pads.give[k], pads.Q[i, own, own]
        for j in range(nv):
            d[k] += tip[j] * shared.a[j]
            if tip[j] != 0.0:
                for c in range(m):
                    W[k, c] -= tip[j] * shared.A[j, c]
            if pull[j] != 0.0:
                for c in range(m):
                    R[k, c] += root[j, c] * pull[j]
        for j in range(6):
            R[k, m + j] = pull[nv + j]
        for c in range(m):
            softness[k] += R[k, c] * W[k, c]
    for c in range(m):
        S[c, c] = 1.0
    if not still:
        # Rows of the torques, then of balance: Aᵀ and 1 times (by_object u + by_joints δq + constant), 0 = ... - S z
        by_z = -product(shared.by_joints, shared.A)
        constant = shared.constant + np.dot(shared.by_joints, shared.a)
        for j in range(nv):
            for c in range(m):
                x = root[j, c]
                if x != 0.0:
                    w[c] += x * constant[j]
                    for e in range(m):
                        S[c, e] -= x * by_z[j, e]
                    for e in range(6):
                        S[c, m + e] -= x * shared.by_object[j, e]
        for b in range(6):
            w[m + b] = constant[nv + b]
            for e in range(m):
                S[m + b, e] -= by_z[nv + b, e]
            for e in range(6):
                S[m + b, m + e] -= shared.by_object[nv + b, e]
        S[m:, m:] -= carried(loads, centre)
    for b in range(6):
        w[m + b] -= damping.body[b] * damping.done[b]
        S[m + b, m + b] += damping.body[b]
    return Linked(pads.Q, W, R, d, S, w, nothing(), 0.0), softness


@kernel
def _answered(
    s: Situation, rules: Rules, turned: Turned, pads: _Pads, shared: _Shared, si: Linked, softness: Array, g: Given,
    posed: Posed, r: Array, z: Array, residual: float,
) -> tuple[bool, Found]:  # fmt: skip
    """(whether it passes, what it says) of a solution in natural units."""
    el, p, n3, nv = s.elastic, rules.pattern, len(r), s.elastic.J.shape[1]
    m = len(z) - 6
    own, v, size, terms = np.empty(n3), np.empty(n3), np.empty(n3), np.empty(n3)
    x, twist, offset = np.empty(m + 6), np.empty(6), si.d.copy()
    for i in range(n3 // 3):
        for a in range(3):
            value = r[3 * i + (a + 1) % 3] * posed.force
            own[3 * i + a] = max(value, 0.0) if a == 2 else value
    for j in range(m):
        x[j] = z[j] * np.sqrt(posed.force * posed.motion)
    for k in range(6):
        twist[k] = x[m + k] = z[m + k] * posed.motion / (1.0 if k < 3 else posed.length)
    for k in range(n3):
        move, turns, retreat, largest = 0.0, 0.0, 0.0, 0.0
        for j in range(6):
            term = posed.grasp_matrix[j, k] * twist[j]
            move += term
            turns += si.W[k, m + j] * twist[j] - term
            largest = max(largest, abs(term))
        for j in range(m):
            term = si.W[k, j] * x[j]
            retreat += term
            largest = max(largest, abs(term))
        for e in range(3):
            term = pads.Q[k // 3, k % 3, e] * own[k - k % 3 + e]
            retreat += term
            largest = max(largest, abs(term))
        offset[k] += turns
        v[k] = move + retreat + offset[k]
        size[k], terms[k] = max(abs(move), abs(retreat), abs(offset[k])), max(largest, abs(offset[k]))
    change = shared.a.copy()
    for j in range(nv):
        for c in range(m):
            change[j] -= shared.A[j, c] * x[c]
    torque = el.gravity.copy()
    for j in range(nv):
        for k in range(n3):
            torque[j] += el.J[k, j] * own[k]
    lacks = si.w[m:].copy()  # of balance, but for G r and the load
    for b in range(6):
        for e in range(m + 6):
            lacks[b] -= si.S[m + b, e] * x[e]
        for k in range(n3):
            lacks[b] += (si.R[k, m + b] - posed.grasp_matrix[b, k]) * own[k]
    posed.wrench[:] = lacks
    if len(turned.force) > 0:
        _turn(torque, turned, pads, own, change, twist)
    friction = Friction(rules.limits, p.faces, p.normals)
    misses = examined(g, posed, p.contacts, friction, offset, own, Moved(v, size, terms, softness), ANY)
    slow = ACTIVE * max(misses.motion_size, posed.motion)
    kinds = find_states(p.contacts, friction, own, v, ACTIVE * misses.force_size, slow).kind
    return accepted(misses, posed, residual, 1), Found(own, v, twist, kinds, np.zeros(0), change, torque)


@kernel
def _turn(torque: Array, turned: Turned, pads: _Pads, forces: Array, change: Array, twist: Array) -> None:
    """Add what turning and moving contacts do to the torques."""
    nv, n3 = len(torque), len(forces)
    shift = np.concatenate((twist, change))
    for k in range(n3):
        i, given = k // 3, -pads.give[k]
        for e in range(3):
            force = forces[3 * i + e]
            for j in range(6 + nv):
                force += turned.force[3 * i + e, j] * shift[j]
            given -= pads.Q[i, k % 3, e] * force
        for j in range(nv):
            torque[j] += pads.back[j, k] * given
    for j in range(nv):
        for e in range(6 + nv):
            torque[j] += turned.torque[j, e] * shift[e]
