"""The natural units of a grasp: what the solver calls one newton, one metre of lever, one metre of motion."""

from __future__ import annotations

from dataclasses import dataclass

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
