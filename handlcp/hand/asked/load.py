"""The wrench on an object: what is given, and its weight at its centre of mass."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.kind import cross_rows
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.objects.object import Object


def point_of(reference: Any, obj: Object | None, positions: Array, normal: Array | None) -> Array:
    """(3,) the point [m] that wrench and motion refer to; the object's centre of mass where none is given."""
    if reference is None:
        return read_only(np.zeros(3)) if obj is None else obj.center_of_mass
    return validate.reference(reference, normal, positions)


def load_of(
    wrench: Any, point: Array, obj: Object | None, gravity: Array, positions: Array, normal: Array | None
) -> Array:
    """(6,) the whole load about a point (3,): the given wrench and the weight. Raises InputError."""
    load = validate.wrench(wrench, normal, validate.lift(positions, point, normal))
    if obj is None or obj.mass == 0.0:
        return load
    weight = obj.mass * gravity
    if normal is not None and abs(float(weight @ normal)) > 1e-9 * float(abs(weight).max()):
        raise InputError("gravity", "gravity in the plane of a planar scene", gravity.tolist())
    if weight.any() and (off := validate.lift(positions, obj.center_of_mass, normal)):
        expected = "an object whose centre of mass lies in the plane of a planar scene"
        raise InputError("target", expected, f"one {abs(off):.3g} m off it")
    return read_only(load + weight_of(obj, gravity, point))


def weight_left_out(spec: GraspSpec, weight: Array) -> str:
    """In words, where the load was given as one wrench in place of the object's weight (6,), and pulls less than that
    along gravity; "" where it was not.
    """
    size = float(np.linalg.norm(weight[:3]))
    if getattr(spec.asked, "load", None) is None or size == 0.0:
        return ""
    along = float(spec.wrench[:3] @ weight[:3]) / size
    if along >= (1.0 - 1e-9) * size:
        return ""
    return (
        f"the object's weight of {words.force(size)} is left out: replace(wrench=...) gave the whole load, "
        f"which pulls along gravity with {words.force(along)}; replace(load=...) comes beside the weight"
    )


def weight_of(obj: Object | None, gravity: Array, point: Array) -> Array:
    """(6,) of the object, about a point (3,)."""
    if obj is None or obj.mass == 0.0:
        return np.zeros(6)
    weight = obj.mass * gravity
    return np.append(weight, cross_rows(obj.center_of_mass - point, weight))
