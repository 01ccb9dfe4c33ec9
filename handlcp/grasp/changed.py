"""The same grasp with some of its numbers changed."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.scene import cross_rows

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["changed", "wrench_about"]

G = TypeVar("G", bound="Grasp")


def changed(grasp: G, **changes: Any) -> G:
    """A copy, of a subclass and with its further attributes, too, placed anew; changes are sound, by the names of
    `Grasp._place`.
    """
    s = grasp.scene
    data = {
        "contacts": grasp.contacts,
        "positions": s.positions,
        "frames": grasp.frames,
        "wrench": wrench_about(grasp.reference, s.force, s.moment),
        "reference": grasp.reference,
        "flexibility": grasp.flexibility,
        "offset": grasp.offset,
        "effects": grasp.effects,
        "plane": s.plane,
        "fingers": s.fingers,
    }
    made = copy.copy(grasp)
    made._place(**(data | changes))
    return made


def wrench_about(point: Array, force: Array, moment: Array) -> Array:
    """(6,) the wrench about a point (3,) from its force and its moment about the world's origin, (3,) each."""
    return read_only(np.append(force, moment - cross_rows(point, force)))
