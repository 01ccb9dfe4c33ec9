"""The whole way from a scene to its certified answer in one compiled call, for scenes whose effects follow from data.

It calls the very kernels that the single steps call (natural units and blocks, stamps, solver, certifier, contact
states, what is left free), in the same order; what it saves is the way in and out of compiled code. A scene is a row of
numbers and so is its answer: many of them are two matrices, and an answer is where the next one may start.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.assembly.candidate import in_si
from handlcp.grasp.model.grasp_matrix import Blocks, Given, Posed, pose
from handlcp.grasp.model.unknowns import add_at, couple
from handlcp.grasp.solve.scene_row import read_scene
from handlcp.grasp.tangent.active_set import Laws, active_rows, rank_of, saddle
from handlcp.grasp.verify.contact_laws import Friction, examine
from handlcp.grasp.verify.contact_states import ESCAPES, RESTING, States, find_escape, find_states
from handlcp.lcp.kernels.contact_rows import in_order
from handlcp.lcp.kernels.contact_run import closed, contact_run, hold, in_turns, newton_first
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import ACTIVE, CERTIFY, GROWTH, SOLVE


class ScenePattern(NamedTuple):
    """What scenes of one kind share: n contacts, the layout of their N unknowns, the section of their cones.

    contacts (n, 4), unknown (m,) : force components, as in `Kind`. role, order (N,), blocks (k, 4) : as in
    `lcp.Pattern`. faces, normals : of the sets. flexible : whether any finger gives way. dof : 6, or 3 in a plane.
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


# An answer's row begins with: Kaczmarz steps, Newton steps, solver's residual; the eight numbers of `Misses`; and what
# else is known: UNIQUE, locally; NO_ANSWER; NONE_HOLDS, where there is none, and in place of its twist there is the
# proof in natural units. Then forces (c), twist (6) and centre (3), where the next one may start; motions (c), contact
# states (n), unknowns (N).
HEAD = 12
UNIQUE, UNKNOWN, NONE_HOLDS, NO_ANSWER = 1.0, 0.0, -1.0, -2.0


@kernel
def solve_scenes(scenes: Array, p: ScenePattern, start: Array, seed: int, rows: Array) -> None:
    """Write the answer to each row of scenes, the numbers of `Given` and the limits, into the same row of rows.

    start (c + 9) : forces, twist and centre of an answer nearby. Where that is empty or leads nowhere, a solve begins
    where every contact sticks.
    """
    n = len(p.contacts)
    for k in range(len(scenes)):
        row = rows[k]
        g, limits = read_scene(scenes[k], n, p.torsional, p.dof)
        posed, blocks = pose(g, p.unknown)
        x, t = np.zeros(p.at[4]), np.zeros(p.dof)
        if len(start) > 0:
            begin(x, start, p, g.freedom, posed)
        M, q = stamped_rows(p, blocks)
        row[0], row[1], row[2], escapes = solved(p, M, q, blocks, limits, len(start) > 0, seed, x, t)
        write_answer(row, p, g, limits, posed, blocks.every, x)
        if escapes and row[11] == NO_ANSWER:
            row[11] = NONE_HOLDS
            _put(row, HEAD + len(g.offset), t)


@kernel
def write_answer(row: Array, p: ScenePattern, g: Given, limits: Array, posed: Posed, every: Array, x: Array) -> None:
    """Certify the unknowns x (N,), and write what they say into the row, from its fourth number on."""
    at, n = (p.at[0], p.at[2], p.at[3]), len(p.contacts)
    forces, free = in_si(x, p.unknown, p.at[1], at, g.prescribed, posed, p.dof)
    twist = np.dot(free, g.freedom)
    friction = Friction(limits, p.faces, p.normals)
    v, m = examine(g, posed, p.contacts, friction, g.offset, forces, twist, GROWTH)
    row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10] = m
    row[11] = NO_ANSWER
    end = _put(row, HEAD, forces)
    end = _put(row, end, twist)
    end = _put(row, end, posed.centre)
    end = _put(row, end, v)
    for i in range(n):
        row[end + i] = 0.0  # states of what is no answer
    _put(row, end + n, x)
    if max(m.balance, m.normal, m.cone, m.slip) <= CERTIFY:
        slow = ACTIVE * max(m.motion_size, posed.motion)
        states = find_states(p.contacts, friction, forces, v, ACTIVE * m.force_size, slow)
        one = _unique(every, g.flexibility, posed.force / posed.motion, p.contacts, states, limits)
        row[11] = UNIQUE if one else UNKNOWN
        for i in range(n):
            row[end + i] = states.kind[i]


@kernel
def solved(
    p: ScenePattern, M: Array, q: Array, blocks: Blocks, limits: Array, begun: bool, seed: int, x: Array, t: Array
) -> tuple[int, int, float, bool]:
    """Write the answer's unknowns into x (N,), or the motion in which the object escapes into t (dof,); returns
    (Kaczmarz steps, Newton steps, residual, whether it escapes). begun : whether x is where to start.
    """
    own = np.empty(len(p.blocks))
    for k in range(len(own)):
        own[k] = limits[p.unknown[p.blocks[k, 0] - p.at[0]] // 3]
    problem = in_order(M, q, p.role, p.blocks, p.order, own, p.faces, p.normals)
    y, newton, r = np.zeros(len(x)), 0, np.inf
    if begun:
        y[:] = x[p.order]
        _, newton, r = contact_run(problem, y, False, seed, 0, True, SOLVE * 1e-2)
    steps, escapes = 0, False
    if not r <= SOLVE:
        hold(problem, problem.q > 0.0, np.zeros(len(problem.blocks), np.bool_), y)
        best, more, r = newton_first(problem, y, True, SOLVE * 1e-2)
        newton += more
        if r <= SOLVE * 1e-2:
            y[:] = best
        elif find_escape(blocks.every, blocks.w, p.contacts, limits, p.faces, t) == ESCAPES:
            escapes = True  # no need to look any further
            y[:] = best
        else:
            steps, more, r = in_turns(problem, y, best, r, seed, len(x), True, SOLVE * 1e-2)
            newton += more
        closed(problem, y)
    x[p.order] = y
    return steps, newton, r, escapes


@kernel
def stamped_rows(p: ScenePattern, blocks: Blocks) -> tuple[Array, Array]:
    """M and q: balance, gaps, tangential offsets and flexibility, as the effects stamp them."""
    normal, count, tangent, u, size = p.at
    M, q = np.zeros((size, size)), np.zeros(size)
    couple(M, u, (normal, count, tangent), blocks.G, 1.0)
    q[u : u + p.dof] += blocks.w
    q[normal : normal + count] += blocks.d[:count]
    q[tangent : tangent + len(blocks.d) - count] += blocks.d[count:]
    if p.flexible:
        add_at(M, (normal, count, tangent), blocks.E)
    return M, q


@kernel
def begin(x: Array, start: Array, p: ScenePattern, freedom: Array, posed: Posed) -> None:
    """Write the start into x, in natural units: its forces, and its twist seen at this scene's centre."""
    normal, count, tangent, u, _ = p.at
    c = len(start) - 9
    for k in range(len(p.unknown)):
        x[normal + k if k < count else tangent + k - count] = start[p.unknown[k]] / posed.force
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
        x[u + i] = total / posed.motion * (posed.length if turns else 1.0)


@kernel
def _unique(every: Array, E: Array, softness: float, contacts: Ints, states: States, limits: Array) -> bool:
    """Whether the active conditions leave nothing free, and no contact rests."""
    for k in states.kind:
        if k == RESTING:
            return False
    K = saddle(E, softness, every, np.empty((0, every.shape[1])))
    kept = np.arange(len(K)) >= len(E)
    A, _ = active_rows(Laws(K, kept, contacts, limits, softness), states)
    return bool(rank_of(A) == len(A))


@kernel
def _put(row: Array, at: int, values: Array) -> int:
    """Write an array into the row; returns where the next one goes."""
    for k in range(len(values)):
        row[at + k] = values[k]
    return at + len(values)
