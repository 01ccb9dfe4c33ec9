"""`solve_scenes`: a scene as a row of numbers, and the whole solve of it in one compiled call.

The layout is known here alone; rows are written and read by the names of these arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from inspect import unwrap
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.problem import unknowns_in_si
from handlcp.grasp.derivatives.active_set import LinearLaws, active_rows, matrix_rank, saddle_matrix
from handlcp.grasp.model.equation_system import add_force_block, couple_block
from handlcp.grasp.model.scene import GraspArrays, GraspGeometry, NaturalBlocks, Scene, nondimensionalise
from handlcp.grasp.verify.certifier import FrictionLimits, LawResiduals, compute_motions_and_residuals, laws_pass
from handlcp.grasp.verify.contact_state import ESCAPES, RESTING, ContactStates, find_escape, find_states
from handlcp.lcp.kernels.contact_newton import (
    alternate_methods,
    clip_open_pairs,
    reorder_problem,
    run_newton_first,
    solve_contacts,
    solve_sticking,
)
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import ACTIVE_TOLERANCE, MAX_RESIDUAL_GROWTH, SOLVE_TOLERANCE


@kernel
def read_scene(scene: Array, n: int, soft: int, dof: int) -> tuple[GraspArrays, Array]:
    """The arrays of a scene with n contacts, some of them soft, and its limits (n,), as views of its row."""
    c = 3 * n + soft
    a = 12 * n
    b = a + c * c
    d = b + 2 * c
    e = d + 3 * soft + 6
    f = e + 6 * dof
    return GraspArrays(
        scene[: 3 * n].reshape(n, 3),
        scene[3 * n : a].reshape(n, 3, 3),
        scene[a:b].reshape(c, c),
        scene[b : b + c],
        scene[b + c : d],
        scene[d : e - 6].reshape(3, soft),
        scene[e - 6 : e - 3],
        scene[e - 3 : e],
        scene[e:f].reshape(dof, 6),
    ), scene[f:]


def scene_views(row: Array, n: int, soft: int, dof: int) -> tuple[GraspArrays, Array]:
    """As `read_scene`, of a row that is written to."""
    found: tuple[GraspArrays, Array] = unwrap(read_scene)(row, n, soft, dof)
    return found


def row_width(scene: Scene) -> int:
    """How many numbers a scene is."""
    return sum([a.size for a in scene.arrays]) + scene.n


def write_row(scene: Scene, section: Section, row: Array) -> None:
    """Write a scene's numbers into a row."""
    np.concatenate((*scene.arrays, scene.friction_coefficients(section)), axis=None, out=row)


def write_rows(count: int, width: int, **fields: Sequence[Array] | Array) -> Array:
    """Write the rows (m, width) of m scenes, field by field. Read-only.

    Each field of `GraspArrays`, and `limits`, is an array (m, …), or one for each scene; where all of these are one and
    the same, as after `replace`, it is copied once.
    """
    out, at = np.empty((count, width)), 0
    for own in [fields[name] for name in (*GraspArrays._fields, "limits")]:
        first = own[0]
        if isinstance(own, np.ndarray):
            whole = own.reshape(count, -1)
        elif all([a is first for a in own]):
            whole = first.reshape(1, -1)
        else:
            whole = np.concatenate(own).reshape(count, -1)
        out[:, at : at + first.size] = whole
        at += first.size
    return read_only(out)


# ----------------------------------------------------------------
# The whole way from a scene to its certified answer in one compiled call, for scenes whose effects follow from data.
#
# It calls the very kernels that the single steps call (natural units and blocks, stamps, solver, certifier, contact
# states, what is left free), in the same order; what it saves is the way in and out of compiled code. A scene is a
# row of numbers and so is its answer: many of them are two matrices, and an answer is where the next one may start.


class ScenePattern(NamedTuple):
    """What scenes of one kind share: n contacts, the layout of their N unknowns, the section of their cones.

    contacts (n, 4), unknown (m,) : force components, `contact_components` and `index` of `SceneKind`. role, order (N,),
    blocks (k, 4) : as in `lcp.Pattern`. faces, normals : of the sets. flexible : whether any finger gives way. dof : 6,
    or 3 in a plane.
    at : where r_N begins, how many there are, where r_T and u begin, N. torsional : how many soft contacts there are.
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
def solve_scenes(scenes: Array, p: ScenePattern, start: Array, seed: int, rows: Array) -> None:
    """Write the answer to each row of scenes, the numbers of `GraspArrays` and friction coefficients, into one of rows.

    start (c + 9) : forces, twist and centre of an answer nearby. Where that is empty or leads nowhere, a solve begins
    where every contact sticks.
    """
    n = len(p.contacts)
    for k in range(len(scenes)):
        row = rows[k]
        g, limits = read_scene(scenes[k], n, p.torsional, p.dof)
        posed, blocks = nondimensionalise(g, p.unknown)
        x, t = np.zeros(p.at[4]), np.zeros(p.dof)
        if len(start) > 0:
            write_start(x, start, p, g.freedom, posed)
        M, q = stamp_rows(p, blocks)
        steps = solve_unknowns(p, M, q, blocks, limits, len(start) > 0, seed, x, t)
        row[KACZMARZ_STEPS], row[NEWTON_STEPS], row[SOLVER_RESIDUAL], escapes = steps
        write_answer(row, p, g, limits, posed, blocks.full_G, x)
        if escapes and row[OUTCOME] == NO_ANSWER:
            row[OUTCOME] = NONE_HOLDS
            _write_array(row, HEADER_SIZE + len(g.offset), t)


@kernel
def write_residuals(row: Array, m: LawResiduals) -> None:
    """Write the residuals into the header of an answer's row."""
    k = FIRST_RESIDUAL
    row[k], row[k + 1], row[k + 2], row[k + 3] = m.lost_force, m.lost_moment, m.balance, m.normal
    row[k + 4], row[k + 5], row[k + 6], row[k + 7] = m.cone, m.slip, m.force_size, m.motion_size


@kernel
def write_answer(
    row: Array, p: ScenePattern, g: GraspArrays, limits: Array, posed: GraspGeometry, full_G: Array, x: Array
) -> None:
    """Certify the unknowns x (N,), and write what they say into the row, from its fourth number on."""
    at, n = (p.at[0], p.at[2], p.at[3]), len(p.contacts)
    forces, free = unknowns_in_si(x, p.unknown, p.at[1], at, g.prescribed, posed, p.dof)
    twist = np.dot(free, g.freedom)
    friction = FrictionLimits(limits, p.faces, p.normals)
    v, m = compute_motions_and_residuals(g, posed, p.contacts, friction, g.offset, forces, twist, MAX_RESIDUAL_GROWTH)
    write_residuals(row, m)
    row[OUTCOME] = NO_ANSWER
    end = _write_array(row, HEADER_SIZE, forces)
    end = _write_array(row, end, twist)
    end = _write_array(row, end, posed.centre)
    end = _write_array(row, end, v)
    for i in range(n):
        row[end + i] = 0.0  # states of what is no answer
    _write_array(row, end + n, x)
    if laws_pass(m):
        slow = ACTIVE_TOLERANCE * max(m.motion_size, posed.motion_unit)
        states = find_states(p.contacts, friction, forces, v, ACTIVE_TOLERANCE * m.force_size, slow)
        one = _is_unique(full_G, g.flexibility, posed.force_unit / posed.motion_unit, p.contacts, states, limits)
        row[OUTCOME] = UNIQUE if one else MAYBE_FREE
        for i in range(n):
            row[end + i] = states.kind[i]


@kernel
def solve_unknowns(
    p: ScenePattern,
    M: Array,
    q: Array,
    blocks: NaturalBlocks,
    limits: Array,
    begun: bool,
    seed: int,
    x: Array,
    t: Array,
) -> tuple[int, int, float, bool]:
    """Write the answer's unknowns into x (N,), or the motion in which the object escapes into t (dof,); returns
    (Kaczmarz steps, Newton steps, residual, whether it escapes). begun : whether x is where to start.
    """
    own = np.empty(len(p.blocks))
    for k in range(len(own)):
        own[k] = limits[p.unknown[p.blocks[k, 0] - p.at[0]] // 3]
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
        elif find_escape(blocks.full_G, blocks.w, p.contacts, limits, p.faces, t) == ESCAPES:
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


@kernel
def _is_unique(
    full_G: Array, E: Array, stiffness_unit: float, contacts: Ints, states: ContactStates, limits: Array
) -> bool:
    """Whether the active conditions leave nothing free, and no contact rests."""
    for k in states.kind:
        if k == RESTING:
            return False
    K = saddle_matrix(E, stiffness_unit, full_G, np.empty((0, full_G.shape[1])))
    kept = np.arange(len(K)) >= len(E)
    A, _ = active_rows(LinearLaws(K, kept, contacts, limits, stiffness_unit), states)
    return bool(matrix_rank(A) == len(A))


@kernel
def _write_array(row: Array, at: int, values: Array) -> int:
    """Write an array into the row; returns where the next one goes."""
    for k in range(len(values)):
        row[at + k] = values[k]
    return at + len(values)


# ----------------------------------------------------------------
# A scene under a load of unknown size: the object is moved on by so much, and the load follows.
#
# With the load w + λ p, λ unknown, and one component of the object's motion prescribed,
#
#     G r + w + λ p = 0,    c · u = s,    v = Gᵀ u + E r + d    and the laws of contact and friction.
#
# Where λ has a largest value on a path, s goes on past it: a path that is led by s meets no solve without an answer
# there. In natural units, a reflection takes p to the last axis of the wrenches; that row of balance says what λ is,
# and c · u = s takes its place.


@kernel
def push_scene(
    scene: Array, p: ScenePattern, load: Array, along: Array, travel: float, start: Array, seed: int, row: Array
) -> float:
    """Write the answer into a row, as `solve_scenes` does, under the scene's load and λ times another; returns λ.

    load (6,) : that other load, force [N] and moment [N·m] about the world's origin; not 0 along what the object is
    free to do. along (6,), travel : along · (motion of the object) = travel; along as a wrench about the world's origin
    is. start : as in `solve_scenes`. The row says whether there is an answer.
    """
    g, limits = read_scene(scene, len(p.contacts), p.torsional, p.dof)
    posed, blocks = nondimensionalise(g, p.unknown)
    push = _wrench_about(load, posed.centre)
    a, c = (
        _natural_wrench(push, g.freedom, posed.length_unit),
        _natural_wrench(_wrench_about(along, posed.centre), g.freedom, posed.length_unit),
    )
    size, reach = np.sqrt(np.dot(a, a)), np.sqrt(np.dot(c, c))
    mirror, sign = _reflection(a / size)
    u, last = p.at[3], p.dof - 1
    x, t = np.zeros(p.at[4]), np.zeros(p.dof)
    if len(start) > 0:
        write_start(x, start, p, g.freedom, posed)
    M, q = stamp_rows(p, blocks)
    turned, full_G, w = np.dot(mirror, M[u : u + p.dof]), np.dot(mirror, blocks.full_G), np.dot(mirror, blocks.w)
    M[u : u + p.dof], q[u : u + p.dof] = turned, w
    M[u + last] = 0.0
    M[u + last, u : u + p.dof] = c / reach
    q[u + last] = -travel / (reach * posed.motion_unit)
    full_G[last] = 0.0
    free = NaturalBlocks(blocks.G, full_G, blocks.E, blocks.d, w)
    balance, free.w[last] = w[last], 0.0
    steps = solve_unknowns(p, M, q, free, limits, len(start) > 0, seed, x, t)
    row[KACZMARZ_STEPS], row[NEWTON_STEPS], row[SOLVER_RESIDUAL], _ = steps
    factor = -(balance + np.dot(turned[last], x)) * posed.force_unit / (sign * size)
    for j in range(6):
        posed.wrench[j] += factor * push[j]
    write_answer(row, p, g, limits, posed, blocks.full_G, x)
    return float(factor)


@kernel
def _natural_wrench(wrench: Array, freedom: Array, length: float) -> Array:
    """(dof,) of a wrench (6,) about the centre, along what the object may do; moments over the unit of length."""
    out = np.zeros(len(freedom))
    for i in range(len(freedom)):
        for j in range(6):
            out[i] += freedom[i, j] * wrench[j] / (1.0 if j < 3 else length)
    return out


@kernel
def _wrench_about(wrench: Array, point: Array) -> Array:
    """(6,) of a wrench about the world's origin, about a point (3,)."""
    out = wrench.copy()
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[3 + k] -= point[i] * wrench[j] - point[j] * wrench[i]
    return out


@kernel
def _reflection(axis: Array) -> tuple[Array, float]:
    """(d, d) the reflection that takes a unit vector (d,) to the last axis times a sign, and this sign, which is the
    one with which no digits cancel.
    """
    v, sign = axis.copy(), -1.0 if axis[-1] >= 0.0 else 1.0
    v[-1] -= sign
    return np.eye(len(v)) - np.outer(v, v) * (2.0 / np.dot(v, v)), sign
