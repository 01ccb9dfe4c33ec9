"""Compiled geometry of a grasp: its natural units, grasp matrix, and the blocks that effects stamp, in those units."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["resolve", "resolve_soft", "wrench_map"]


@kernel
def sizes(
    positions: Array, flexibility: Array, offset: Array, force: Array, moment: Array
) -> tuple[float, float, float, Array]:
    n = len(positions)
    centre = np.zeros(3)
    for i in range(n):
        centre += positions[i] / n
    spread, travel, softness = 0.0, 0.0, 0.0
    for i in range(n):
        for k in range(3):
            spread += (positions[i, k] - centre[k]) ** 2 / n
            if k < 2 or offset[i, k] < 0.0:  # a gap loads nothing, however wide
                travel += offset[i, k] ** 2 / n
            softness += flexibility[3 * i + k, 3 * i + k] / (3 * n)
    length, away = np.sqrt(spread), np.sqrt(np.sum(centre * centre))
    if length <= 1e-12 * away:  # all at one point: what is left is rounding, no size
        length = away
    if length == 0.0:
        length = 1.0
    m = moment - np.array(
        [
            centre[1] * force[2] - centre[2] * force[1],
            centre[2] * force[0] - centre[0] * force[2],
            centre[0] * force[1] - centre[1] * force[0],
        ]
    )
    load = np.sqrt(np.sum(force * force) + np.sum(m * m) / length**2)
    travel = np.sqrt(travel)
    size = load + (travel / softness if softness > 0.0 else 0.0)
    if size == 0.0:
        size = 1.0
    motion = softness * size
    if motion == 0.0:
        motion = travel if travel > 0.0 else length
    return size, length, motion, centre


@kernel
def wrench_map(arms: Array, frames: Array) -> Array:
    """(6, 3n) G: columns [R; skew(a) R] for arms (n, 3) and frames (n, 3, 3)."""
    n = len(arms)
    G = np.empty((6, 3 * n))
    for i in range(n):
        ax, ay, az = arms[i, 0], arms[i, 1], arms[i, 2]
        for k in range(3):
            x, y, z = frames[i, 0, k], frames[i, 1, k], frames[i, 2, k]
            c = 3 * i + k
            G[0, c], G[1, c], G[2, c] = x, y, z
            G[3, c], G[4, c], G[5, c] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
    return G


@kernel
def natural_blocks(
    grasp_matrix: Array,
    wrench: Array,
    freedom: Array,
    flexibility: Array,
    offset: Array,
    index: Ints,
    force: float,
    length: float,
    motion: float,
) -> tuple[Array, Array, Array, Array, Array]:
    """(G over `index`, G over all, E and d over `index`, w) in natural units; freedom (dof, 6) projects G and w."""
    dof, columns, k = freedom.shape[0], grasp_matrix.shape[1], len(index)
    every, w = np.zeros((dof, columns)), np.zeros(dof)
    for i in range(dof):
        for j in range(6):
            f = freedom[i, j]
            if f != 0.0:
                if j >= 3:
                    f /= length
                w[i] += f * wrench[j] / force
                for c in range(columns):
                    every[i, c] += f * grasp_matrix[j, c]
    G, E, d = np.empty((dof, k)), np.empty((k, k)), np.empty(k)
    softness = force / motion
    for a in range(k):
        d[a] = offset[index[a] // 3, index[a] % 3] / motion
        for i in range(dof):
            G[i, a] = every[i, index[a]]
        for b in range(k):
            E[a, b] = flexibility[index[a], index[b]] * softness
    return G, every, E, d, w


@kernel
def centred(
    positions: Array, flexibility: Array, offset: Array, force: Array, moment: Array
) -> tuple[float, float, float, Array, Array, Array]:
    """(force, length, motion, centre, arms (n, 3), wrench (6,) about the centre)."""
    size, length, motion, centre = sizes(positions, flexibility, offset, force, moment)
    wrench = np.empty(6)
    wrench[:3] = force
    wrench[3] = moment[0] - centre[1] * force[2] + centre[2] * force[1]
    wrench[4] = moment[1] - centre[2] * force[0] + centre[0] * force[2]
    wrench[5] = moment[2] - centre[0] * force[1] + centre[1] * force[0]
    return size, length, motion, centre, positions - centre, wrench


@kernel
def resolve(
    positions: Array,
    frames: Array,
    flexibility: Array,
    offset: Array,
    force: Array,
    moment: Array,
    freedom: Array,
    index: Ints,
) -> tuple[float, float, float, Array, Array, Array, tuple[Array, Array, Array, Array, Array]]:
    """What `centred` gives, and blocks as in `natural_blocks`."""
    size, length, motion, centre, arms, wrench = centred(positions, flexibility, offset, force, moment)
    G = wrench_map(arms, frames)
    blocks = natural_blocks(G, wrench, freedom, flexibility, offset, index, size, length, motion)
    return size, length, motion, centre, arms, wrench, blocks


def resolve_soft(
    positions: Array,
    frames: Array,
    flexibility: Array,
    offset: Array,
    force: Array,
    moment: Array,
    freedom: Array,
    index: Ints,
    spin_axes: Array,
    every_offset: Array,
) -> tuple[float, float, float, Array, Array, Array, tuple[Array, Array, Array, Array, Array]]:
    """The same for n contacts of which k bear moments about their normals; spin_axes (3, k), flexibility (c, c) and
    every_offset (c,) over all c = 3n + k components.
    """
    n, k = len(positions), spin_axes.shape[1]
    size, length, motion, centre, arms, wrench = centred(positions, flexibility, offset, force, moment)
    G = np.hstack([wrench_map(arms, frames), np.vstack([np.zeros((3, k)), spin_axes])])
    padded = np.append(every_offset, np.zeros(2 * k)).reshape(n + k, 3)  # rows of three, as the kernel reads them
    blocks = natural_blocks(G, wrench, freedom, flexibility, padded, index, size, length, motion)
    return size, length, motion, centre, arms, wrench, blocks
