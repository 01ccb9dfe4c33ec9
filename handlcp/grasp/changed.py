"""The same grasp with some of its numbers changed."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.scene import cross_rows

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["changed", "load"]

G = TypeVar("G", bound="Grasp")


def changed(grasp: G, **changes: Any) -> G:
    """A copy, of a subclass and with its further attributes, too, placed anew; changes are sound, by the names of
    `Grasp._place`.
    """
    s = grasp.scene
    data = {
        "contacts": grasp.contacts,
        "positions": s.positions,
        "frames": s.frames,
        "wrench": load(grasp),
        "reference": grasp.reference,
        "flexibility": s.flexibility,
        "offset": s.offset,
        "effects": grasp.effects,
        "plane": s.plane,
    }
    made = copy.copy(grasp)
    made._place(**(data | changes))
    return made


def load(grasp: Grasp) -> Array:
    """(6,) the world's force [N] and torque [N·m] on the object about the grasp's reference."""
    s = grasp.scene
    return read_only(np.append(s.force, s.moment - cross_rows(grasp.reference, s.force)))
