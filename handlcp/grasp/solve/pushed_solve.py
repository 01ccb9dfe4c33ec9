"""A scene under a load of unknown size: the object is moved on by so much, and the load follows.

With the load w + λ p, λ unknown, and one component of the object's motion prescribed,

    G r + w + λ p = 0,    c · u = s,    v = Gᵀ u + E r + d    and the laws of contact and friction.

Where λ has a largest value on a path, s goes on past it: a path that is led by s meets no solve without an answer
there. In natural units, a reflection takes p to the last axis of the wrenches; that row of balance says what λ is, and
c · u = s takes its place.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.grasp_matrix import Blocks, pose
from handlcp.grasp.solve.compiled_solve import (
    ScenePattern,
    begin,
    solved,
    stamped_rows,
    write_answer,
)
from handlcp.grasp.solve.scene_row import read_scene
from handlcp.lcp.kernels.dense import kernel


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
    posed, blocks = pose(g, p.unknown)
    push = _about(load, posed.centre)
    a, c = _natural(push, g.freedom, posed.length), _natural(_about(along, posed.centre), g.freedom, posed.length)
    size, reach = np.sqrt(np.dot(a, a)), np.sqrt(np.dot(c, c))
    mirror, sign = _mirror(a / size)
    u, last = p.at[3], p.dof - 1
    x, t = np.zeros(p.at[4]), np.zeros(p.dof)
    if len(start) > 0:
        begin(x, start, p, g.freedom, posed)
    M, q = stamped_rows(p, blocks)
    turned, every, w = np.dot(mirror, M[u : u + p.dof]), np.dot(mirror, blocks.every), np.dot(mirror, blocks.w)
    M[u : u + p.dof], q[u : u + p.dof] = turned, w
    M[u + last] = 0.0
    M[u + last, u : u + p.dof] = c / reach
    q[u + last] = -travel / (reach * posed.motion)
    every[last] = 0.0
    free = Blocks(blocks.G, every, blocks.E, blocks.d, w)
    balance, free.w[last] = w[last], 0.0
    row[0], row[1], row[2], _ = solved(p, M, q, free, limits, len(start) > 0, seed, x, t)
    factor = -(balance + np.dot(turned[last], x)) * posed.force / (sign * size)
    for j in range(6):
        posed.wrench[j] += factor * push[j]
    write_answer(row, p, g, limits, posed, blocks.every, x)
    return float(factor)


@kernel
def _natural(wrench: Array, freedom: Array, length: float) -> Array:
    """(dof,) of a wrench (6,) about the centre, along what the object may do; moments over the unit of length."""
    out = np.zeros(len(freedom))
    for i in range(len(freedom)):
        for j in range(6):
            out[i] += freedom[i, j] * wrench[j] / (1.0 if j < 3 else length)
    return out


@kernel
def _about(wrench: Array, point: Array) -> Array:
    """(6,) of a wrench about the world's origin, about a point (3,)."""
    out = wrench.copy()
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[3 + k] -= point[i] * wrench[j] - point[j] * wrench[i]
    return out


@kernel
def _mirror(axis: Array) -> tuple[Array, float]:
    """(d, d) the reflection that takes a unit vector (d,) to the last axis times a sign, and this sign, which is the
    one with which no digits cancel.
    """
    v, sign = axis.copy(), -1.0 if axis[-1] >= 0.0 else 1.0
    v[-1] -= sign
    return np.eye(len(v)) - np.outer(v, v) * (2.0 / np.dot(v, v)), sign
