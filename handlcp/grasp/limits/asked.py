"""What is asked of a load limit: which load, which geometry, how far the object may move."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, number, read_only
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.follow import geometry_of


def is_followed(spec: GraspSpec, geometry: Any) -> bool:
    """Whether contacts are followed: where hand and object are known, but for "fixed". Raises InputError."""
    return geometry != "fixed" and geometry_of(spec, geometry).follows


def load_of(spec: GraspSpec, wrench: Any) -> Array:
    """(6,) the load beside the weight, given as `Grasp` takes it; None: the grasp's own. Raises InputError."""
    if wrench is not None:
        height = validate.lift(spec.positions, spec.reference, spec.plane)
        given = validate.wrench(wrench, spec.plane, height)
        if not given.any():
            raise InputError("wrench", "a load that is not zero", given.tolist())
        return given
    own = spec.wrench.copy()
    if spec.mechanism is not None:
        own -= spec.mechanism.weight_of_object(spec.reference)
    if not abs(own).max() > 1e-12 * abs(spec.wrench).max():
        raise InputError("wrench", "a load: this grasp has none beside the object's weight", wrench)
    return read_only(own)


def tolerance(name: str, value: Any) -> float:
    """How far the object may move, or turn. Raises InputError."""
    return np.inf if value is None else number(name, value, above=0.0)
