"""What users ask of a grasp, as the specification that says it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.effects import Effect
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.environment import beside, joined, offset_beside
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["as_asked", "asked_for", "replaced"]


def asked_for(
    contacts: Iterable[Contact], wrench: Any, flexibility: Any, preload: Any, offset: Any, reference: Any,
    effects: Iterable[Effect], plane: Any, environment: Any,
) -> GraspSpec:  # fmt: skip
    """See `Grasp`. Raises InputError."""
    cs = validate.contacts(contacts)
    k, around = len(cs), None if environment is None else joined(environment)
    if around is not None:
        cs = validate.contacts((*cs, *around.contacts))
    positions, frames, normal = validate.placed(plane, cs)
    point = validate.reference(reference, normal, positions)
    load = validate.wrench(wrench, normal, validate.lift(positions, point, normal))
    E, d = validate.flexibility(flexibility, k, normal is not None), validate.offset(offset, preload, k)
    if around is not None:
        E, d = beside(E, around.flexibility), read_only(np.concatenate([d, around.offset]))
    fingers, R = None if around is None else k, read_only(frames)
    spec = GraspSpec(cs, read_only(positions), R, normal, fingers, None, load, point, E, d)
    return as_asked(spec, effects)


def as_asked(spec: GraspSpec, effects: Any) -> GraspSpec:
    """The specification with the effects that a user asks for by name, besides those it has. Raises InputError."""
    asked = validate.effects(effects, spec)
    return spec.replace(effects=(*asked, *spec.effects)) if asked else spec


def replaced(spec: GraspSpec, wrench: Any, flexibility: Any, offset: Any, preload: Any) -> GraspSpec:
    """See `Grasp.replace`."""
    n, changes = spec.of_fingers, dict[str, Array]()
    if wrench is not None:
        height = validate.lift(spec.positions, spec.reference, spec.plane)
        changes["wrench"] = validate.wrench(wrench, spec.plane, height)
    if flexibility is not None:
        around = spec.flexibility[3 * n :, 3 * n :]
        changes["flexibility"] = beside(validate.flexibility(flexibility, n, spec.planar), around)
    if offset is not None or preload is not None:
        changes["offset"] = offset_beside(offset, 0.0 if preload is None else preload, n, spec.offset[n:])
    return spec.replace(**changes)
