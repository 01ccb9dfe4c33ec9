"""The whole way from a scene to its certified answer in one compiled call, for scenes whose effects follow from data.

It calls the very kernels that the single steps call (natural units and blocks, stamps, solver, certifier, states, what
is left free), in the same order and with the same bits; what it saves is the way in and out of compiled code. A scene
is a row of numbers and so is its answer: many of them are two matrices, and an answer is where the next one may start.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.candidate import in_si
from handlcp.grasp.kernels import examine, to_world
from handlcp.grasp.natural import resolve
from handlcp.grasp.states import RESTING, classify_contacts
from handlcp.grasp.system import add_at, couple
from handlcp.grasp.tangent import tangent_system
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import prepare
from handlcp.lcp.solvers.contact_run import run
from handlcp.tolerances import ACTIVE, CERTIFY, GROWTH, RANK, SOLVE

__all__ = ["HEAD", "Pattern", "answer_width", "answers", "scene_width"]


class Pattern(NamedTuple):
    """What scenes of one kind share: n contacts, the layout of their N unknowns, the section of their cones.

    unknown, normal, tangent : entries of the 3n force components: all unknown ones, along normals, along tangents.
    rough : contacts with friction. governed (n,). role (N,), blocks (k, 3) : as in `ContactProblem`.
    normals (2, m), faces : of the section. flexible : whether any finger gives way. dof : 6, or 3 in a plane.
    at : where r_N begins, how many there are, where r_T and u begin, N. most : Kaczmarz steps at most.
    """

    unknown: Ints
    normal: Ints
    tangent: Ints
    rough: Ints
    governed: Bools
    role: Ints
    blocks: Ints
    normals: Array
    faces: int
    flexible: bool
    dof: int
    at: tuple[int, int, int, int, int]
    most: int


# An answer's row begins with: Kaczmarz steps, Newton steps, solver's residual; lost force, lost moment, balance,
# normal, cone, slip, F, largest motion (`examine`); units of force, length, motion; whether it is locally unique.
HEAD = 15


def scene_width(n: int, dof: int) -> int:
    """Numbers of a scene: positions, frames, flexibility, offset, force and moment, limits, freedom (dof, 6)."""
    return 16 * n + 9 * n * n + 6 + 6 * dof


def answer_width(n: int, unknowns: int) -> int:
    """Numbers of an answer: head; forces, twist, centre (where the next may start); world forces, motion, kind; x."""
    return HEAD + 3 * n + 9 + 6 * n + n + unknowns


@kernel
def answers(scenes: Array, p: Pattern, start: Array, seed: int, rows: Array) -> None:
    """Write the answer to each row of scenes (m, `scene_width`) into rows (m, `answer_width`).

    start (3n + 9) : forces, twist and centre of an answer nearby. Where that is empty or leads nowhere, a solve begins
    where every contact sticks.
    """
    n, dof = len(p.governed), p.dof
    normal, _, tangent, u, size = p.at
    for k in range(len(scenes)):
        row = rows[k]
        positions, frames, E, offset, force, moment, limits, freedom = _read(scenes[k], n, dof)
        unit, length, motion, centre, arms, wrench, blocks = resolve(
            positions, frames, E, offset, force, moment, freedom, p.unknown
        )
        M, q = _stamped(p, blocks)
        order, starts, own, side, below, moved, role, rho, places = prepare(M, q, p.role, p.blocks)
        x, steps, newton, r = np.zeros(size), 0, 0, np.inf
        for cold in range(0 if len(start) > 0 else 1, 2):
            if r <= SOLVE:
                break
            x[:] = 0.0
            if cold == 0:
                _begin(x, start, p, freedom, unit, length, motion, centre)
            steps, more, r = run(
                M, order, starts, own, side, below, moved, role, rho, places, limits[p.rough], p.faces,
                x, cold == 1, seed, p.most * cold, True, SOLVE * 1e-2, RANK,
            )  # fmt: skip
            newton += more
        forces, free = in_si(x, p.normal, normal, p.tangent, tangent, n, u, dof, unit, motion, length)
        twist = np.dot(free, freedom)
        v, values = examine(
            arms, frames, E, offset, forces, twist, wrench, limits, p.governed, p.faces, length, unit, 1e-12 * motion,
            GROWTH,
        )  # fmt: skip
        row[0], row[1], row[2] = steps, newton, r
        row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10] = values
        row[11], row[12], row[13], row[14] = unit, length, motion, 0.0
        at = _put(row, HEAD, forces)
        at = _put(row, at, twist)
        at = _put(row, at, centre)
        at = _put(row, at, to_world(frames, forces))
        at = _put(row, at, v)
        if max(values[2], values[3], values[4], values[5]) <= CERTIFY:
            slow = ACTIVE * max(values[7], motion)
            kind, faces, turn = classify_contacts(
                forces, v, limits, p.normals, p.faces == 0, dof == 3, ACTIVE * values[6], slow
            )
            row[14] = _unique(blocks[1], E, unit / motion, kind, faces, turn, limits, dof == 3)
            for i in range(n):
                row[at + i] = kind[i]
        _put(row, at + n, x)


@kernel
def _read(scene: Array, n: int, dof: int) -> tuple[Array, Array, Array, Array, Array, Array, Array, Array]:
    """Positions, frames, flexibility, offset, force, moment, limits, freedom, as views of the scene's row."""
    a = 12 * n
    b = a + 9 * n * n
    c = b + 3 * n + 6
    return (
        scene[: 3 * n].reshape(n, 3),
        scene[3 * n : a].reshape(n, 3, 3),
        scene[a:b].reshape(3 * n, 3 * n),
        scene[b : b + 3 * n].reshape(n, 3),
        scene[c - 6 : c - 3],
        scene[c - 3 : c],
        scene[c : c + n],
        scene[c + n :].reshape(dof, 6),
    )


@kernel
def _stamped(p: Pattern, blocks: tuple[Array, Array, Array, Array, Array]) -> tuple[Array, Array]:
    """M and q: balance, gaps, tangential offsets and flexibility, as the effects stamp them."""
    G, _, soft, d, w = blocks
    normal, count, tangent, u, size = p.at
    M, q = np.zeros((size, size)), np.zeros(size)
    couple(M, u, (normal, count, tangent), G, 1.0)
    q[u : u + p.dof] += w
    q[normal : normal + count] += d[:count]
    q[tangent : tangent + len(p.tangent)] += d[count:]
    if p.flexible:
        add_at(M, (normal, count, tangent), soft)
    return M, q


@kernel
def _begin(
    x: Array, start: Array, p: Pattern, freedom: Array, unit: float, length: float, motion: float, centre: Array
) -> None:
    """X ← the start in natural units: its forces, and its twist seen at this scene's centre."""
    normal, _, tangent, u, _ = p.at
    n = len(p.governed)
    for k in range(len(p.normal)):
        x[normal + k] = start[p.normal[k]] / unit
    for k in range(len(p.tangent)):
        x[tangent + k] = start[p.tangent[k]] / unit
    t, old = start[3 * n : 3 * n + 6].copy(), start[3 * n + 6 :]
    ax, ay, az = centre[0] - old[0], centre[1] - old[1], centre[2] - old[2]
    t[0] += t[4] * az - t[5] * ay
    t[1] += t[5] * ax - t[3] * az
    t[2] += t[3] * ay - t[4] * ax
    for i in range(p.dof):
        total = 0.0
        for j in range(6):
            total += freedom[i, j] * t[j]
        turns = i >= (3 if p.dof == 6 else 2)
        x[u + i] = total / motion * (length if turns else 1.0)


@kernel
def _unique(
    every: Array, E: Array, softness: float, kind: Ints, faces: Array, turn: Array, limits: Array, planar: bool
) -> float:
    """One where the active conditions leave nothing free; zero where they do, or where contacts rest."""
    for k in kind:
        if k == RESTING:
            return 0.0
    A, rank = tangent_system(every, E, softness, kind, faces, turn, limits, planar, np.empty((0, 3 * len(kind))))
    return 1.0 if rank == len(A) else 0.0


@kernel
def _put(row: Array, at: int, values: Array) -> int:
    """Write an array into the row; returns where the next one goes."""
    flat = values.ravel()
    for k in range(len(flat)):
        row[at + k] = flat[k]
    return at + len(flat)
