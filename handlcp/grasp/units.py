"""The natural units of a grasp: what the solver calls one newton, one metre of lever, one metre of motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array

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
        """From positions (n, 3), flexibility (3n, 3n), offset (n, 3) and the wrench about the origin: force, moment (3,)."""
        n = len(positions)
        centre = positions.sum(0) / n
        arms = positions - centre
        length = float(np.sqrt((arms * arms).sum() / n)) or float(np.sqrt(centre @ centre)) or 1.0
        m = moment - _cross(centre, force)
        load = float(np.sqrt(force @ force + (m @ m) / length**2))
        softness = float(flexibility.trace()) / (3 * n)
        travel = float(np.sqrt((offset * offset).sum() / n))
        squeeze = travel / softness if softness > 0 else 0.0
        size = load + squeeze or 1.0
        motion = softness * size or travel or length
        return GraspUnits(size, length, motion, centre)


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
