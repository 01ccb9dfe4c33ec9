"""The natural units of a grasp: what the solver calls one newton, one metre of lever, one metre of motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.lcp.kernels.compile import kernel

__all__ = ["GraspUnits"]


@dataclass(frozen=True, slots=True)
class GraspUnits:
    """force [N], length [m] (lever arms), motion [m] (displacements), centre (3,) [m] of the contacts.

    force is the size of the wrench plus that of the squeeze, length the rms distance of the contacts from their
    centre, and motion = flexibility × force with the mean flexibility of the fingers. Every size is a norm or a mean,
    so another unit, a turned world or another order of fingers changes none of them beyond rounding.
    """

    force: float
    length: float
    motion: float
    centre: Array

    @staticmethod
    def of(positions: Array, flexibility: Array, offset: Array, force: Array, moment: Array) -> GraspUnits:
        """From positions, offset (n, 3), flexibility (3n, 3n) and the wrench about the origin: force, moment (3,)."""
        return GraspUnits(*_sizes(positions, flexibility, offset, force, moment))


@kernel
def _sizes(
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
            travel += offset[i, k] ** 2 / n
            softness += flexibility[3 * i + k, 3 * i + k] / (3 * n)
    length = np.sqrt(spread)
    if length == 0.0:
        length = np.sqrt(np.sum(centre * centre))
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
