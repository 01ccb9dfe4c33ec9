"""One iteration of a step in one compiled call: the tangent about it, the solve, and where its answer leads."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.path.newton.answer import Found, of_contacts, put, written
from handlcp.grasp.path.newton.linear_solve import Rules, answered, linear_problem, met, solved
from handlcp.grasp.path.newton.numbers import Elastic, Laws, Loads, Situation
from handlcp.grasp.path.newton.tangent import (
    Condensed,
    Driven,
    Turned,
    Yielding,
    condensed,
    skew,
    turned_forces,
)
from handlcp.lcp.kernels.dense import kernel


@kernel
def one_iteration(s: Situation, rules: Rules, start: Array, begun: bool, seed: int, near: float, row: Array) -> None:
    """Write the numbers of `Answer` into the row (of zeros): each array that compiled code makes for Python costs more
    than most of what is computed here.

    start : forces in the laws' coordinates (c,), about which they turn, twist and centre; empty: no forces. begun :
    whether the solve begins there, or else from contacts that all stick. near : what a push meets is measured where the
    answer misses its iterate by no more.
    """
    t, el, loads, laws, damping = s.touch, s.elastic, s.loads, rules.laws, s.damping
    n, nv, soft = len(s.frames), el.J.shape[1], laws.soft
    n3, still = 3 * n, len(t.turn) == 0
    centre = middle(t.positions)
    J, P, give, d = _by_component(el, loads, s.frames, laws, rules.extra)
    behind = give - damping.pads * _pads(damping.given, damping.spun, s.frames, soft)
    forces, torsion = of_contacts(begun_from(start, laws), n, soft)
    turned = Turned(np.zeros((6, 6 + nv + n3)), np.zeros((nv, 6 + nv + n3)), np.zeros((n3, 6 + nv + n3)))
    if not still:
        turned = turned_forces(t, s.frames, s.moving, centre, forces, torsion)
    driven = Driven(told(el, loads, laws), damping.lag, damping.slow, damping.pads)
    lin = condensed(turned, still, Yielding(J, P, el.compliance_factor, behind, d, rules.yields, el.tensed), driven)
    if not lin.found:
        return
    for a in range(6):
        lin.w[a] -= damping.body[a] * damping.done[a]
        lin.B_u[a, a] -= damping.body[a]
    if not still:
        lin.B_u[:] += carried(loads, centre)
    softness = softness_of_components(J, P, el.compliance_factor, laws)
    g, posed, problem, y, expected = linear_problem(t.positions, s.frames, rules, lin, loaded(loads), softness, start)
    residual = solved(problem, y, expected, begun and len(start) > 0, seed)
    passes, r, v, twist, kinds, gives = answered(g, posed, rules, lin, y, residual)
    if not passes:
        return
    change, torque = _reached(s, rules, lin, turned, J, r, twist, gives)
    written(s, laws, centre, Found(r, v, twist, kinds, gives, change, torque), row)
    if row[1] <= near:
        found, push = met(problem, y, rules.pattern)
        put(row, len(row) - push.size, push.reshape(-1))
        row[0] = row[2] = 1.0 if found else 0.0


@kernel
def softness_of_components(J: Array, P: Array, factor: Array, laws: Laws) -> Array:
    """(c,) the diagonal of J K⁻¹ Jᵀ + P in the laws' coordinates, K⁻¹ = factor factorᵀ."""
    out = np.empty(len(P))
    for i in range(len(P)):
        total = P[i, i]
        for m in range(factor.shape[1]):
            along = 0.0
            for j in range(len(factor)):
                along += J[i, j] * factor[j, m]
            total += along * along
        out[i] = total * laws.scale[i] * laws.scale[i]
    return out


@kernel
def middle(positions: Array) -> Array:
    """(3,) the contacts' centre."""
    centre = np.zeros(3)
    for i in range(len(positions)):
        for a in range(3):
            centre[a] += positions[i, a] / len(positions)
    return centre


@kernel
def begun_from(start: Array, laws: Laws) -> Array:
    """(c,) forces about which the tangent is taken."""
    r = np.zeros(len(laws.scale))
    if len(start) > 0:
        for i in range(len(r)):
            r[i] = start[i] * laws.scale[i]
    return r


@kernel
def loaded(loads: Loads) -> tuple[Array, Array]:
    """Force and moment (3,) of the load, about the world's origin."""
    force, moment = loads.load[:3] + loads.weight, loads.load[3:].copy()
    _moment(moment, loads.reference, loads.load)
    _moment(moment, loads.mass_at, loads.weight)
    return force, moment


@kernel
def carried(loads: Loads, centre: Array) -> Array:
    """(6, 6) how the load's wrench about the contacts' centre changes as its points move with the object."""
    change = np.zeros((6, 6))
    _follows(change, loads.load, loads.reference, centre)
    _follows(change, loads.weight, loads.mass_at, centre)
    return change


@kernel
def told(el: Elastic, loads: Loads, laws: Laws) -> Array:
    """(nv,) from where the joints stand to where they are commanded, and their fingers' weight pulls them."""
    command, A = loads.command.copy(), el.compliance_factor
    if laws.sags == 0.0:
        return command
    for m in range(A.shape[1]):
        pull = 0.0
        for j in range(len(command)):
            pull += A[j, m] * el.gravity[j]
        for j in range(len(command)):
            command[j] -= laws.sags * A[j, m] * pull
    return command


@kernel
def _reached(
    s: Situation, rules: Rules, lin: Condensed, turned: Turned, J: Array, r: Array, twist: Array, gives: Array
) -> tuple[Array, Array]:
    """(nv,) changes of the joints, and their torques, of forces r (c,), the object's twist (6,), and limits that give
    way by (k,).
    """
    el, soft, nv, c, n3 = s.elastic, rules.laws.soft, J.shape[1], len(r), turned.force.shape[0]
    joints, torque, (_, torsion) = np.empty(nv), el.gravity.copy(), of_contacts(r, len(s.frames), soft)
    for j in range(nv + n3):
        row = lin.Z[j]
        change = row[0]
        for b in range(c):
            change += row[1 + b] * r[b]
        for b in range(6):
            change += row[1 + c + b] * twist[b]
        for b in range(len(gives)):
            change += row[7 + c + b] * gives[b]
            if j < nv:
                change -= rules.yields[j, b] * gives[b]
        if j < nv:
            joints[j] = change
        for o in range(nv):
            torque[o] += turned.torque[o, 6 + j] * change
    for o in range(nv):
        for b in range(6):
            torque[o] += turned.torque[o, b] * twist[b]
        for b in range(n3):
            torque[o] += r[b] * J[b, o]
        for i in soft:
            torque[o] += torsion[i] * el.turning[i, o]
    return joints, torque


@kernel
def _by_component(
    el: Elastic, loads: Loads, frames: Array, laws: Laws, extra: Array
) -> tuple[Array, Array, Array, Array]:
    """(J (c, nv), P (c, c), ŝ (c,), d (c,)) over all force components, turns of soft contacts last."""
    n, nv, soft = len(frames), el.J.shape[1], laws.soft
    n3, k = 3 * n, len(soft)
    J, P, d = np.zeros((n3 + k, nv)), np.zeros((n3 + k, n3 + k)), np.zeros(n3 + k)
    give = _pads(loads.give, loads.turn, frames, soft)
    J[:n3], P[:n3, :n3] = el.J, el.P
    for i in range(n):
        for a in range(3):
            d[3 * i + a] = loads.base[i, a]
    for a in range(k):
        i = soft[a]
        P[n3 + a, n3 + a] = laws.torsion[a]
        d[n3 + a] = loads.spin[i]
        if laws.joined:
            J[n3 + a] = el.turning[i]
    if len(extra) > 0:
        P += extra
    return J, P, give, d


@kernel
def _pads(give: Array, turn: Array, frames: Array, soft: Ints) -> Array:
    """(c,) of pads (n, 3), world axes, and turns of soft ones (n,)."""
    n = len(frames)
    out = np.zeros(3 * n + len(soft))
    for i in range(n):
        for a in range(3):
            for b in range(3):
                out[3 * i + a] += frames[i, b, a] * give[i, b]
    for a in range(len(soft)):
        out[3 * n + a] = turn[soft[a]]
    return out


@kernel
def _moment(moment: Array, at: Array, force: Array) -> None:
    """Add that of a force (3,) or more, at a point."""
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        moment[a] += at[b] * force[c] - at[c] * force[b]


@kernel
def _follows(B_u: Array, force: Array, point: Array, centre: Array) -> None:
    """Add how the moment of a force that keeps its direction changes as its point moves with the object."""
    along, turn = 0.0, skew(force)
    for a in range(3):
        along += force[a] * (point[a] - centre[a])
    for a in range(3):
        for b in range(3):
            B_u[3 + a, b] -= turn[a, b]
            B_u[3 + a, 3 + b] += (point[a] - centre[a]) * force[b]  # f × (r × ) = r fᵀ - (f·r) 1
        B_u[3 + a, 3 + a] -= along
