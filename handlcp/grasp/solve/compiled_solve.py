"""`solve_scenes`: the first solve of grasps, each from its numbers to its certified answer, in one compiled call.

A scene is a row of numbers and so is its answer: many of them are two matrices, and an answer is where the next one may
start. `compiled_answer.py` writes the rows of scenes and reads those of answers.

Where a factor of the flexibility is known, contacts are eliminated one by one (`contact/block_newton.py`), at a cost
that grows with their number. Where it is not, or that leads to no answer, all unknowns are solved for at once, at a
cost that grows with its cube. Both write their unknowns, and the same certifier decides what those are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.contact.block_newton import LinkedContacts, is_determined, solve_blocks
from handlcp.grasp.assembly.problem import unknowns_in_si
from handlcp.grasp.derivatives.active_set import LinearLaws, active_rows, matrix_rank, saddle_matrix
from handlcp.grasp.model.equation_system import add_force_block, couple_block
from handlcp.grasp.model.flexibility import FlexibilityFactor
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.grasp.model.scene import (
    GraspArrays,
    GraspGeometry,
    NaturalBlocks,
    compute_geometry,
    nondimensionalise,
)
from handlcp.grasp.verify.certifier import (
    FrictionLimits,
    compute_motions_and_residuals,
    compute_residuals,
    contact_motions_of_factor,
    laws_pass,
)
from handlcp.grasp.verify.contact_state import (
    ESCAPES,
    GLIDING,
    RESTING,
    SEPARATED,
    SLIDING,
    STICKING,
    ContactStates,
    find_escape,
    find_states,
)
from handlcp.lcp.kernels.contact_newton import (
    ContactArrays,
    alternate_methods,
    clip_open_pairs,
    reorder_problem,
    run_newton_first,
    solve_contacts,
    solve_sticking,
)
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import ACTIVE_TOLERANCE, MAX_RESIDUAL_GROWTH, SOLVE_TOLERANCE

_MIN_PIVOT_SHARE = 1e-9  # pivots below this share of the largest say that something may be free

# ----------------------------------------------------------------
# Scenes of one kind as rows.


class ScenePattern(NamedTuple):
    """What scenes of one kind share: n contacts, the layout of their N unknowns, the section of their cones.

    contacts (n, 4), unknown (m,) : force components, `contact_components` and `index` of `SceneKind`. role, order (N,),
    blocks (k, 4) : as in `lcp.Pattern`. faces, normals : of the sets. flexible : whether any finger gives way. dof : 6,
    or 3 in a plane.
    at : where r_N begins, how many there are, where r_T and u begin, N. torsional : how many soft contacts there are.
    flexibility : which parts of it a row has, as in `flexibility_shape`.
    """

    contacts: Ints
    unknown: Ints
    role: Ints
    order: Ints
    blocks: Ints
    faces: int
    normals: Array
    flexible: bool
    dof: int
    at: tuple[int, int, int, int, int]
    torsional: int
    flexibility: tuple[int, int, int, int] = (0, 0, 0, 0)


class SceneNumbers(NamedTuple):
    """What a row says: the arrays of a scene, with no flexibility (0, 0) where a factor was given in its place; that
    factor, without pads where none is known; and the friction coefficient (n,) of each contact's section.
    """

    arrays: GraspArrays
    factor: FlexibilityFactor
    friction: Array


@kernel
def read_scene(row: Array, p: ScenePattern) -> SceneNumbers:
    """The arrays of a scene, as views of its row."""
    n, soft, (rows, pads, joints, columns) = len(p.contacts), p.torsional, p.flexibility
    c = 3 * n + soft
    a = 12 * n
    b = a + rows * rows
    d = b + 2 * c
    e = d + 3 * soft + 6
    f = e + 6 * p.dof
    h = f + n
    i = h + 3 * pads * joints
    j = i + joints * columns
    arrays = GraspArrays(
        row[: 3 * n].reshape(n, 3),
        row[3 * n : a].reshape(n, 3, 3),
        row[a:b].reshape(rows, rows),
        row[b : b + c],
        row[b + c : d],
        row[d : e - 6].reshape(3, soft),
        row[e - 6 : e - 3],
        row[e - 3 : e],
        row[e:f].reshape(p.dof, 6),
    )
    J, A, P = row[h:i].reshape(3 * pads, joints), row[i:j].reshape(joints, columns), row[j:].reshape(pads, 3, 3)
    return SceneNumbers(arrays, FlexibilityFactor(J, A, P), row[f:h])


# ----------------------------------------------------------------
# The whole way from a scene to its certified answer in one compiled call, for scenes whose effects follow from data.
#
# It calls the very kernels that the single steps call (natural units and blocks, stamps, solver, certifier, contact
# states, what is left free), in the same order; what it saves is the way in and out of compiled code.

# A row of numbers is an answer: a header, then forces (c), twist (6) and centre (3), where the next one may start;
# motions (c), contact states (n), unknowns (N). Where it is proven that nothing holds, the escaping motion (dof) in
# natural units stands in place of the twist. The header:
KACZMARZ_STEPS, NEWTON_STEPS, SOLVER_RESIDUAL = 0, 1, 2
FIRST_RESIDUAL, END_OF_RESIDUALS = 3, 11  # the fields of `LawResiduals`, in their order
OUTCOME = 11  # one of the numbers below
HEADER_SIZE = 12
# From MAYBE_FREE up the certifier passes the answer: it is locally UNIQUE, or maybe leaves something free
UNIQUE, MAYBE_FREE, NONE_HOLDS, NO_ANSWER = 1.0, 0.0, -1.0, -2.0


@kernel
def solve_scenes(scenes: Array, p: ScenePattern, start: Array, seed: int) -> Array:
    """The answers (m, ·) to the rows (m, ·) of scenes.

    start (c + 9) : forces, twist and centre of an answer nearby. Where that is empty or leads nowhere, a solve begins
    where every contact sticks. seed : of the row sampling.
    """
    n = len(p.contacts)
    rows = np.empty((len(scenes), HEADER_SIZE + 2 * (3 * n + p.torsional) + 9 + n + p.at[4]))
    for k in range(len(scenes)):
        s, row = read_scene(scenes[k], p), rows[k]
        if len(s.factor.pads) == 0 or not _solve_by_contact(s, p, start, row):
            _solve_at_once(s if len(s.arrays.flexibility) > 0 else _with_matrix(s), p, start, seed, row)
    return rows


@kernel
def _write_answer(
    row: Array, p: ScenePattern, s: SceneNumbers, posed: GraspGeometry, x: Array
) -> tuple[bool, ContactStates]:
    """Certify the unknowns x (N,), and write what they say into the row, from its fourth number on; returns whether
    they are an answer, and the states of its contacts.
    """
    at, g = (p.at[0], p.at[2], p.at[3]), s.arrays
    forces, free = unknowns_in_si(x, p.unknown, p.at[1], at, g.prescribed, posed, p.dof)
    twist, friction = np.dot(free, g.freedom), FrictionLimits(s.friction, p.faces, p.normals)
    if len(g.flexibility) > 0:
        v, m = compute_motions_and_residuals(
            g, posed, p.contacts, friction, g.offset, forces, twist, MAX_RESIDUAL_GROWTH
        )
    else:
        moved = contact_motions_of_factor(posed.grasp_matrix, s.factor, g.offset, forces, twist)
        v = moved.v
        m = compute_residuals(g, posed, p.contacts, friction, g.offset, forces, moved, MAX_RESIDUAL_GROWTH)
    k, passes = FIRST_RESIDUAL, laws_pass(m)
    row[k], row[k + 1], row[k + 2], row[k + 3] = m.lost_force, m.lost_moment, m.balance, m.normal
    row[k + 4], row[k + 5], row[k + 6], row[k + 7] = m.cone, m.slip, m.force_size, m.motion_size
    row[OUTCOME] = MAYBE_FREE if passes else NO_ANSWER
    slow = ACTIVE_TOLERANCE * max(m.motion_size, posed.motion_unit)
    states = find_states(p.contacts, friction, forces, v, ACTIVE_TOLERANCE * m.force_size, slow)
    end = HEADER_SIZE
    for values in (forces, twist, posed.centre, v):
        end = _write_array(row, end, values)
    for i in range(len(states.kind)):
        row[end + i] = states.kind[i] if passes else 0.0
    _write_array(row, end + len(states.kind), x)
    return passes, states


@kernel
def _write_array(row: Array, at: int, values: Array) -> int:
    """Write an array into the row; returns where the next one goes."""
    for k in range(len(values)):
        row[at + k] = values[k]
    return at + len(values)


@kernel
def write_start(x: Array, start: Array, p: ScenePattern, freedom: Array, posed: GraspGeometry) -> None:
    """Write the start into x, in natural units: its forces, and its twist seen at this scene's centre."""
    normal, count, tangent, u, _ = p.at
    c = len(start) - 9
    for k in range(len(p.unknown)):
        x[normal + k if k < count else tangent + k - count] = start[p.unknown[k]] / posed.force_unit
    t, old = start[c : c + 6].copy(), start[c + 6 :]
    ax, ay, az = posed.centre[0] - old[0], posed.centre[1] - old[1], posed.centre[2] - old[2]
    t[0] += t[4] * az - t[5] * ay
    t[1] += t[5] * ax - t[3] * az
    t[2] += t[3] * ay - t[4] * ax
    for i in range(p.dof):
        total = 0.0
        for j in range(6):
            total += freedom[i, j] * t[j]
        turns = i >= (3 if p.dof == 6 else 2)
        x[u + i] = total / posed.motion_unit * (posed.length_unit if turns else 1.0)


# ----------------------------------------------------------------
# All unknowns at once.


@kernel
def _solve_at_once(s: SceneNumbers, p: ScenePattern, start: Array, seed: int, row: Array) -> None:
    """Write the answer's row, of a scene with its flexibility as a matrix."""
    g = s.arrays
    posed, blocks = nondimensionalise(g, p.unknown)
    x, t = np.zeros(p.at[4]), np.zeros(p.dof)
    if len(start) > 0:
        write_start(x, start, p, g.freedom, posed)
    M, q = stamp_rows(p, blocks)
    steps = _solve_unknowns(p, M, q, blocks, s.friction, len(start) > 0, seed, x, t)
    row[KACZMARZ_STEPS], row[NEWTON_STEPS], row[SOLVER_RESIDUAL], escapes = steps
    passes, states = _write_answer(row, p, s, posed, x)
    if passes:
        if _is_unique(
            blocks.full_G, g.flexibility, posed.force_unit / posed.motion_unit, p.contacts, states, s.friction
        ):
            row[OUTCOME] = UNIQUE
    elif escapes:
        row[OUTCOME] = NONE_HOLDS
        _write_array(row, HEADER_SIZE + len(g.offset), t)


@kernel
def _with_matrix(s: SceneNumbers) -> SceneNumbers:
    """The same scene with its flexibility as a matrix, E = J A (J A)ᵀ + P."""
    g, P = s.arrays, s.factor.pads
    E = joint_flexibility(s.factor.rows, s.factor.root)
    for i in range(len(P)):
        for a in range(3):
            for b in range(3):
                E[3 * i + a, 3 * i + b] += P[i, a, b]
    arrays = GraspArrays(g.positions, g.frames, E, g.offset, g.prescribed, g.spin, g.force, g.moment, g.freedom)
    return SceneNumbers(arrays, s.factor, s.friction)


@kernel
def _solve_unknowns(
    p: ScenePattern,
    M: Array,
    q: Array,
    blocks: NaturalBlocks,
    friction: Array,
    begun: bool,
    seed: int,
    x: Array,
    t: Array,
) -> tuple[int, int, float, bool]:
    """Write the answer's unknowns into x (N,), or the motion in which the object escapes into t (dof,); returns
    (Kaczmarz steps, Newton steps, residual, whether it escapes).

    friction (n,) : coefficients. begun : whether x is where to start.
    """
    own = np.empty(len(p.blocks))
    for k in range(len(own)):
        own[k] = friction[p.unknown[p.blocks[k, 0] - p.at[0]] // 3]
    problem = reorder_problem(M, q, p.role, p.blocks, p.order, own, p.faces, p.normals)
    y, newton, r = np.zeros(len(x)), 0, np.inf
    if begun:
        y[:] = x[p.order]
        _, newton, r = solve_contacts(problem, y, False, seed, 0, True, SOLVE_TOLERANCE * 1e-2)
    steps, escapes = 0, False
    if not r <= SOLVE_TOLERANCE:
        solve_sticking(problem, problem.q > 0.0, np.zeros(len(problem.blocks), np.bool_), y)
        best, more, r = run_newton_first(problem, y, True, SOLVE_TOLERANCE * 1e-2)
        newton += more
        if r <= SOLVE_TOLERANCE * 1e-2:
            y[:] = best
        elif find_escape(blocks.full_G, blocks.w, p.contacts, friction, p.faces, t) == ESCAPES:
            escapes = True  # no need to look any further
            y[:] = best
        else:
            steps, more, r = alternate_methods(problem, y, best, r, seed, len(x), True, SOLVE_TOLERANCE * 1e-2)
            newton += more
        clip_open_pairs(problem, y)
    x[p.order] = y
    return steps, newton, r, escapes


@kernel
def stamp_rows(p: ScenePattern, blocks: NaturalBlocks) -> tuple[Array, Array]:
    """The matrix M and the vector q with balance, gaps, tangential offsets and flexibility, as the effects stamp
    them.
    """
    normal, count, tangent, u, size = p.at
    M, q = np.zeros((size, size)), np.zeros(size)
    couple_block(M, u, (normal, count, tangent), blocks.G, 1.0)
    q[u : u + p.dof] += blocks.w
    q[normal : normal + count] += blocks.d[:count]
    q[tangent : tangent + len(blocks.d) - count] += blocks.d[count:]
    if p.flexible:
        add_force_block(M, (normal, count, tangent), blocks.E)
    return M, q


@kernel
def _is_unique(
    full_G: Array, E: Array, stiffness_unit: float, contacts: Ints, states: ContactStates, friction: Array
) -> bool:
    """Whether the active conditions leave nothing free, and no contact rests."""
    for k in states.kind:
        if k == RESTING:
            return False
    K = saddle_matrix(E, stiffness_unit, full_G, np.empty((0, full_G.shape[1])))
    kept = np.arange(len(K)) >= len(E)
    A, _ = active_rows(LinearLaws(K, kept, contacts, friction, stiffness_unit), states)
    return bool(matrix_rank(A) == len(A))


# ----------------------------------------------------------------
# Contact by contact.


@kernel
def _solve_by_contact(s: SceneNumbers, p: ScenePattern, start: Array, row: Array) -> bool:
    """Write the answer's row, with the factor of the flexibility; returns whether it is an answer."""
    B, softness = _joint_columns(s.factor)
    posed = compute_geometry(s.arrays, softness)
    linked = _link_contacts(s, B, posed, softness, p)
    x, r, z, begun = np.zeros(p.at[4]), np.zeros(len(linked.d)), np.zeros(len(linked.w)), len(start) > 0
    if begun:
        write_start(x, start, p, s.arrays.freedom, posed)
        split_unknowns(x, p, linked, r, z)
    row[KACZMARZ_STEPS] = 0.0
    row[NEWTON_STEPS], row[SOLVER_RESIDUAL] = solve_blocks(linked, r, z, begun)
    if not row[SOLVER_RESIDUAL] <= SOLVE_TOLERANCE:
        return False
    for i in range(len(p.contacts)):
        r[3 * i] = max(r[3 * i], 0.0)
    _join_unknowns(r, z, p, x)
    passes, states = _write_answer(row, p, s, posed, x)
    if passes and _leaves_nothing_free(linked, r, z, states, s.friction):
        row[OUTCOME] = UNIQUE
    return passes


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
def _link_contacts(s: SceneNumbers, B: Array, posed: GraspGeometry, softness: Array, p: ScenePattern) -> LinkedContacts:
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
    return link_in_natural_units(
        LinearRows(s.factor.pads, W, W, s.arrays.offset, S, w), posed, softness, s.friction, p, _MIN_PIVOT_SHARE
    )


@kernel
def link_in_natural_units(
    si: LinearRows, posed: GraspGeometry, softness: Array, friction: Array, p: ScenePattern, least: float
) -> LinkedContacts:
    """The problem in natural units, each contact's normal first.

    softness (3n,) : diagonal of the flexibility of all that gives way [m/N]. friction (n,) : coefficients.
    least : as in `LinkedContacts`.
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
    own_rows = ContactArrays(np.empty((0, 0)), np.empty(0), role, rho, blocks, friction.copy(), p.faces, p.normals)
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
def _join_unknowns(r: Array, z: Array, p: ScenePattern, x: Array) -> None:
    """Write unknowns (N,) in the order of their layout from forces and shared motions."""
    normal, count, tangent, u, _ = p.at
    for k in range(len(p.unknown)):
        own = p.unknown[k]
        x[normal + k if k < count else tangent + k - count] = r[own - own % 3 + (own + 1) % 3]
    for k in range(6):
        x[u + k] = z[len(z) - 6 + k]


@kernel
def _leaves_nothing_free(linked: LinkedContacts, r: Array, z: Array, states: ContactStates, friction: Array) -> bool:
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
            same = kind == GLIDING and pushes[i] and friction[i] == 0.0
        if not same:
            return False
    return True
