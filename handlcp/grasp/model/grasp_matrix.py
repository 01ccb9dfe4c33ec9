"""Compiled geometry of a grasp: natural units, the grasp matrix, and the blocks that effects stamp, in those units.

The c = 3n + k force components are the contacts' x, y and z and then the moments of the k soft contacts about their
normals (over a lever, so that they are forces).

    w + G r = 0,    v = Gᵀ u + E r + d,    G = [R; skew(p - centre) R | 0; lever n]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel


class Given(NamedTuple):
    """A grasp as arrays, SI: positions (n, 3), frames (n, 3, 3), flexibility (c, c), offset (c,), forces (c,) that are
    prescribed, spin (3, k) moments that one of each torsional component stands for, force and moment (3,) of the load
    about the world's origin, freedom (dof, 6) of the object.
    """

    positions: Array
    frames: Array
    flexibility: Array
    offset: Array
    prescribed: Array
    spin: Array
    force: Array
    moment: Array
    freedom: Array


class Blocks(NamedTuple):
    """In natural units, over the unknown force components, normal ones first: G (dof, m), E (m, m), d (m,); the load
    w (dof,); and `every` (dof, c), G over all components. Prescribed forces are part of w and d.
    """

    G: Array
    every: Array
    E: Array
    d: Array
    w: Array


class Posed(NamedTuple):
    """Natural units of force [N], length (of levers) and motion [m]; centre (3,) of the contacts [m]; wrench (6,) of
    the load about it [N, N·m]; grasp_matrix (6, c).

    Every unit is a norm or a mean (`_sizes`), so another unit, a turned world or another order of fingers changes none
    of them beyond rounding.
    """

    force: float
    length: float
    motion: float
    centre: Array
    wrench: Array
    grasp_matrix: Array


@kernel
def pose(g: Given, index: Ints) -> tuple[Posed, Blocks]:
    """Units, geometry and blocks of a grasp; index (m,): which force components are unknown, normal ones first."""
    posed = placed(g, diagonal(g.flexibility))
    return posed, _blocks(g, posed, index)


@kernel
def placed(g: Given, own: Array) -> Posed:
    """Units and geometry of a grasp; own (c,): the diagonal of E, all that they see of it."""
    force, length, motion, centre, wrench = _sizes(g, own)
    grasp_matrix = wrench_map(g.positions, centre, g.frames, g.spin)
    return Posed(force, length, motion, centre, wrench, grasp_matrix)


@kernel
def diagonal(E: Array) -> Array:
    """(c,) of E (c, c)."""
    own = np.empty(len(E))
    for i in range(len(E)):
        own[i] = E[i, i]
    return own


@kernel
def _sizes(g: Given, own: Array) -> tuple[float, float, float, Array, Array]:
    """(force, length, motion, centre, wrench): force is the size of the load plus that of the squeeze, length the rms
    distance of the contacts from their centre, motion = force × the mean flexibility; wrench (6,) of the load about the
    centre.
    """
    positions, offset = g.positions, g.offset
    n = len(positions)
    centre = np.zeros(3)
    for i in range(n):
        for k in range(3):
            centre[k] += positions[i, k] / n
    spread, travel, softness = 0.0, 0.0, 0.0
    for i in range(n):
        for k in range(3):
            spread += (positions[i, k] - centre[k]) ** 2 / n
            if k < 2 or offset[3 * i + k] < 0.0:  # a gap loads nothing, however wide
                travel += offset[3 * i + k] ** 2 / n
            softness += own[3 * i + k] / (3 * n)
    length, away = np.sqrt(spread), np.sqrt(centre[0] ** 2 + centre[1] ** 2 + centre[2] ** 2)
    if length <= 1e-12 * away:  # all at one point: what is left is rounding, no size
        length = away
    if length == 0.0:
        length = 1.0
    wrench, force, moment, load = np.empty(6), g.force, g.moment, 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        wrench[k], wrench[3 + k] = force[k], moment[k] - centre[i] * force[j] + centre[j] * force[i]
        load += wrench[k] ** 2 + (wrench[3 + k] / length) ** 2
    load = np.sqrt(load)
    travel = np.sqrt(travel)
    size = load + (travel / softness if softness > 0.0 else 0.0)
    if size == 0.0:
        size = 1.0
    motion = softness * size
    if motion == 0.0:
        motion = travel if travel > 0.0 else length
    return size, length, motion, centre, wrench


@kernel
def wrench_map(points: Array, centre: Array, frames: Array, spin: Array) -> Array:
    """(6, 3n + k) G: columns [R; skew(a) R] for frames (n, 3, 3) and arms a from the centre (3,) to the points (n, 3),
    then [0; spin] for spin (3, k).
    """
    n, k = len(points), spin.shape[1]
    G = np.empty((6, 3 * n + k))
    for i in range(n):
        ax, ay, az = points[i, 0] - centre[0], points[i, 1] - centre[1], points[i, 2] - centre[2]
        for a in range(3):
            x, y, z = frames[i, 0, a], frames[i, 1, a], frames[i, 2, a]
            c = 3 * i + a
            G[0, c], G[1, c], G[2, c] = x, y, z
            G[3, c], G[4, c], G[5, c] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
    for j in range(k):
        for a in range(3):
            G[a, 3 * n + j], G[3 + a, 3 * n + j] = 0.0, spin[a, j]
    return G


@kernel
def _blocks(g: Given, p: Posed, index: Ints) -> Blocks:
    """`freedom` projects G and w on what the object is free to do."""
    freedom, flexibility, offset, given = g.freedom, g.flexibility, g.offset, g.prescribed
    about, wrench = p.grasp_matrix, p.wrench
    dof, columns, m = freedom.shape[0], about.shape[1], len(index)
    every, w = np.zeros((dof, columns)), np.zeros(dof)
    for i in range(dof):
        for j in range(6):
            f = freedom[i, j]
            if f != 0.0:
                if j >= 3:
                    f /= p.length
                w[i] += f * wrench[j] / p.force
                for c in range(columns):
                    every[i, c] += f * about[j, c]
    G, E, d = np.empty((dof, m)), np.empty((m, m)), np.empty(m)
    softness = p.force / p.motion
    for a in range(m):
        d[a] = offset[index[a]] / p.motion
        for i in range(dof):
            G[i, a] = every[i, index[a]]
        for b in range(m):
            E[a, b] = flexibility[index[a], index[b]] * softness
    for c in range(columns):
        r = given[c] / p.force
        if r != 0.0:
            for i in range(dof):
                w[i] += every[i, c] * r
            for a in range(m):
                d[a] += flexibility[index[a], c] * softness * r
    return Blocks(G, every, E, d, w)
