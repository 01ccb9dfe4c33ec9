"""One solve of a step in compiled code: the condensed tangent as a contact problem, its answer, and how far it misses.

The rows are those of every grasp, with what the tangent adds: balance sees the object's motion, motions of the contacts
see how forces turn. Limits that give way (joints at their torque limits, bounds on forces) are pairs beside them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.assembly.problem import unknowns_in_si
from handlcp.grasp.model.scene import GraspArrays, GraspGeometry, compute_geometry, natural_blocks
from handlcp.grasp.path.newton.numbers import Laws
from handlcp.grasp.path.newton.tangent import Condensed
from handlcp.grasp.solve.compiled_solve import ScenePattern, stamp_rows, write_start
from handlcp.grasp.verify.certifier import FrictionLimits, LawResiduals, compute_motions_and_residuals
from handlcp.grasp.verify.contact_state import find_states
from handlcp.lcp.kernels.contact_newton import (
    ContactArrays,
    alternate_methods,
    clip_open_pairs,
    evaluate_rows,
    new_subgradient,
    reorder_problem,
    run_newton_first,
    solve_sticking,
    step_in_expected_states,
    write_jacobian,
)
from handlcp.lcp.kernels.dense import kernel, multiply_add, product, solve_wide
from handlcp.tolerances import ACTIVE_TOLERANCE, CERTIFY_TOLERANCE, SOLVE_TOLERANCE

ANY = 1e30  # times the load: a step without any is measured by the forces of the squeeze, however large
_NOTHING = 1e-9  # of the natural unit of force: less is none


class Giving(NamedTuple):
    """Limits that give way: rows (k, c) over the forces in the laws' coordinates, room (k,) [N], both over their levers
    where they are torques; at : where their unknowns begin. begun (k,) : motions that a solve starts from [m].
    """

    rows: Array
    room: Array
    at: int
    begun: Array


class Rules(NamedTuple):
    """What answers obey. friction_coefficients (n,). extra (c, c) : flexibility that effects add, in contact axes;
    empty: none. yields (nv, k) : how far limits that give way drive joints back. pattern : of the problem.
    """

    laws: Laws
    friction_coefficients: Array
    extra: Array
    giving: Giving
    yields: Array
    pattern: ScenePattern


@kernel
def linear_problem(
    positions: Array,
    frames: Array,
    rules: Rules,
    t: Condensed,
    load: tuple[Array, Array],
    softness: Array,
    start: Array,
) -> tuple[GraspArrays, GraspGeometry, ContactArrays, Array, Array]:
    """The grasp as it stands about the iterate, its natural units, its problem, where the solve begins (N,), and the
    motions that are expected there (N,).

    t : the tangent there. load : force and moment (3,), about the world's origin. softness (c,) : the diagonal of the
    flexibility of joints and pads, which sets the natural units: that of the tangent may be negative, where a finger
    would buckle if its force turned with the contact. start : as in `Reached`.
    """
    laws, giving, p = rules.laws, rules.giving, rules.pattern
    n, c, k, s = len(positions), len(laws.scale), len(giving.room), laws.scale
    m, soft = 3 * n, len(laws.soft)
    turned, spin, E = np.empty((n, 3, 3)), np.empty((3, soft)), np.empty((c, c))
    for i in range(n):
        for a in range(3):
            for b in range(3):
                turned[i, a, b] = frames[i, a, b] * s[3 * i + b]
    for j in range(soft):
        for a in range(3):
            spin[a, j] = frames[laws.soft[j], a, 2] * s[m + j]
    for i in range(c):
        for j in range(c):
            E[i, j] = t.V_r[i, j] * s[i] * s[j]
    offset = t.d * s
    g = GraspArrays(positions, turned, E, offset, np.zeros(c), spin, load[0], load[1], laws.freedom)
    posed = compute_geometry(g, softness)
    blocks = natural_blocks(g, posed, p.unknown)
    M, q = stamp_rows(p, blocks)
    normal, count, tangent, u, size = p.at
    U = laws.freedom.copy() * posed.motion_unit  # (dof, 6) twists of the natural unknowns
    P = laws.freedom.copy() / posed.force_unit  # wrenches to natural rows
    for i in range(p.dof):
        for j in range(3, 6):
            U[i, j] /= posed.length_unit
            P[i, j] /= posed.length_unit
    UT = np.ascontiguousarray(U.T)
    uu, ur, vu = product(P, product(t.B_u, UT)), product(P, t.B_r), product(t.V_u, UT)
    for i in range(p.dof):
        for j in range(6):
            q[u + i] += P[i, j] * t.w[j]
        for j in range(p.dof):
            M[u + i, u + j] += uu[i, j]
    for a in range(len(p.unknown)):
        j = p.unknown[a]
        at = normal + a if a < count else tangent + a - count
        for i in range(p.dof):
            M[u + i, at] += ur[i, j] * s[j] * posed.force_unit
            M[at, u + i] += vu[j, i] * s[j] / posed.motion_unit
        for b in range(k):
            M[giving.at + b, at] -= giving.rows[b, j] + t.L[b, 1 + j] * s[j]
            M[at, giving.at + b] += giving.rows[b, j] + t.V_g[j, b] * s[j]
    if k > 0:
        ug, gu = product(P, t.B_g), product(t.L[:, 1 + c : 7 + c].copy(), UT)
        for b in range(k):
            q[giving.at + b] -= t.L[b, 0] / posed.force_unit
            for i in range(p.dof):
                M[u + i, giving.at + b] += ug[i, b] * posed.motion_unit
                M[giving.at + b, u + i] -= gu[b, i] / posed.force_unit
            for e in range(k):
                M[giving.at + b, giving.at + e] -= t.L[b, 7 + c + e] * posed.motion_unit / posed.force_unit
    x, expected = np.zeros(size), np.zeros(size)
    if len(start) > 0:
        write_start(x, start[: c + 9], p, laws.freedom, posed)
        for a in range(len(p.unknown)):
            at = normal + a if a < count else tangent + a - count
            expected[at] = start[c + 9 + p.unknown[a]] / posed.motion_unit
    for b in range(k):
        q[giving.at + b] += giving.room[b] / posed.force_unit
        x[giving.at + b] = giving.begun[b] / posed.motion_unit
    own = np.empty(len(p.blocks))
    for b in range(len(own)):
        own[b] = rules.friction_coefficients[p.unknown[p.blocks[b, 0] - normal] // 3]
    problem = reorder_problem(M, q, p.role, p.blocks, p.order, own, p.faces, p.normals)
    return g, posed, problem, x[p.order], expected[p.order]


@kernel
def answered(
    g: GraspArrays, posed: GraspGeometry, rules: Rules, t: Condensed, y: Array, residual: float
) -> tuple[bool, Array, Array, Array, Ints, Array]:
    """(whether a solution y (N,) passes, forces (c,) and motions (c,) in contact axes, twist (6,) of the object about
    the contacts' centre, contact states (n,), motions (k,) of limits that give way).
    """
    laws, giving, p = rules.laws, rules.giving, rules.pattern
    c, k, s, offset = len(laws.scale), len(giving.room), laws.scale, g.offset
    normal, count, tangent, u, size = p.at
    x = np.empty(size)
    x[p.order] = y
    own, free = unknowns_in_si(x, p.unknown, count, (normal, tangent, u), g.prescribed, posed, p.dof)
    twist, forces = np.zeros(6), own * s
    for i in range(p.dof):
        for j in range(6):
            twist[j] += free[i] * laws.freedom[i, j]
    gives = x[giving.at : giving.at + k] * posed.motion_unit
    for i in range(c):
        for j in range(6):
            offset[i] += t.V_u[i, j] * twist[j] * s[i]
        for b in range(k):
            offset[i] += gives[b] * (giving.rows[b, i] + t.V_g[i, b] * s[i])
    for j in range(6):
        posed.wrench[j] += t.w[j]
        for b in range(k):
            posed.wrench[j] += t.B_g[j, b] * gives[b]
        for i in range(c):
            posed.wrench[j] += t.B_r[j, i] * forces[i]
        for i in range(6):
            posed.wrench[j] += t.B_u[j, i] * twist[i]
    friction = FrictionLimits(rules.friction_coefficients, p.faces, p.normals)
    v, misses = compute_motions_and_residuals(g, posed, p.contacts, friction, offset, own, twist, ANY)
    kinds = kinds_in_step(p.contacts, friction, misses, posed, own, v)
    return accepted(misses, posed, residual, k), forces, v / s, twist, kinds, gives


@kernel
def kinds_in_step(
    contacts: Ints, friction: FrictionLimits, misses: LawResiduals, posed: GraspGeometry, own: Array, v: Array
) -> Ints:
    """(n,) contact states of forces (c,) and motions (c,).

    A contact slides where it slips by more than a solver leaves of a slip that is zero. Any wider limit would be a
    rate: whatever creeps would slide in long steps, stick in short ones, and change from one to the other at each step.
    """
    weak, slow = ACTIVE_TOLERANCE * misses.force_size, SOLVE_TOLERANCE * max(misses.motion_size, posed.motion_unit)
    return find_states(contacts, friction, own, v, weak, slow).kind


@kernel
def accepted(misses: LawResiduals, posed: GraspGeometry, residual: float, k: int) -> bool:
    """Whether a solution is an answer; k : how many rows the misses do not see."""
    worst = max(misses.balance, misses.normal, misses.cone, misses.slip)
    nothing = (
        misses.force_size <= _NOTHING * posed.force_unit
    )  # what is left of forces that are zero has no relative miss
    return bool(
        (worst <= CERTIFY_TOLERANCE and (k == 0 or residual <= SOLVE_TOLERANCE))
        or (nothing and residual <= SOLVE_TOLERANCE)
    )


@kernel
def solved(problem: ContactArrays, y: Array, expected: Array, begun: bool, seed: int) -> float:
    """Solve in place, where `begun` from y (N,) and the motions that are expected there (N,); where that leads nowhere,
    from contacts that all stick, then with Kaczmarz steps between Newton's. Returns the residual.
    """
    cold = not begun
    if begun:
        step_in_expected_states(problem, y, expected)
    while True:
        if cold:
            solve_sticking(problem, problem.q > 0.0, np.zeros(len(problem.blocks), np.bool_), y)
        best, _, r = run_newton_first(problem, y, cold, SOLVE_TOLERANCE * 1e-2)
        if cold or r <= SOLVE_TOLERANCE:
            break
        cold = True
    if cold and not r <= SOLVE_TOLERANCE * 1e-2:
        _, _, r = alternate_methods(problem, y, best, r, seed, len(y), True, SOLVE_TOLERANCE * 1e-2)
    else:
        y[:] = best
    clip_open_pairs(problem, y)
    return r


@kernel
def met(problem: ContactArrays, y: Array, p: ScenePattern) -> tuple[bool, Array]:
    """(dof, dof) the wrench that a small motion of the object meets, contacts and fingers following it as they are:
    natural units, along the motion where it drives it further; and whether there is one.
    """
    n, u, dof = len(y), p.at[3], p.dof
    F, w, J, g = np.empty(n), np.empty(n), np.empty((n, n)), new_subgradient(problem)
    multiply_add(problem.M, y, problem.q, w)
    evaluate_rows(problem, y, w, F, g)
    write_jacobian(problem, g, J)
    place, a, b = np.empty(n, np.int64), 0, n - dof  # the object's motion last
    for i in range(n):
        if u <= p.order[i] < u + dof:
            place[b] = i
            b += 1
        else:
            place[a] = i
            a += 1
    A, out, most = np.empty((a, n)), np.empty((dof, dof)), 0.0
    for i in range(a):
        for j in range(n):
            A[i, j] = J[place[i], place[j]]
            if j < a:
                most = max(most, abs(A[i, j]))
    for i in range(a):
        A[i, i] += 1e-14 * most  # forces of rigid contacts may not be determined
    found = solve_wide(A, 0.0)
    for i in range(dof):
        for j in range(dof):
            out[i, j] = J[place[a + i], place[a + j]]
            for k in range(a):
                out[i, j] -= J[place[a + i], place[k]] * A[k, a + j]
    return found, out
