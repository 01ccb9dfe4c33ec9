"""How hard contacts may press on the object, and which of them press harder on the way."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from handlcp.check import Array, array, number
from handlcp.errors import InputError
from handlcp.grasp.cause.judge import exceeded
from handlcp.grasp.model.limit import by_finger
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.follow import Loading

MOST_FORCE = "most_force"


def most_forces(value: Any, spec: GraspSpec) -> Array:
    """(n,) the largest normal force that the object bears at each contact [N]. value : a number, one for each contact,
    or a mapping by name, others any; None: any everywhere. Raises InputError, UnknownName.
    """
    n = len(spec.names)
    if value is None:
        return np.full(n, np.inf)
    listed = by_finger(MOST_FORCE, dict(value) if isinstance(value, Mapping) else value, spec.names, None)
    if isinstance(value, Mapping):
        said = [number(f"{MOST_FORCE}[{name!r}]", one, above=0.0) if one is not None else np.inf
                for name, one in zip(spec.names, listed, strict=True)]  # fmt: skip
        return np.array(said)
    given = array(MOST_FORCE, listed, (), (n,))
    if not (given > 0.0).all():
        raise InputError(MOST_FORCE, "forces > 0 [N] that the object bears at a contact", repr(value)[:80])
    return np.full(n, 1.0) * given


def pressed(path: Loading, most: Array) -> str:
    """Which contact presses harder than it may (n,) [N], and how hard, on the way; "" where none does."""
    largest = path.steps.forces[:, :, 2].max(axis=0, initial=0.0)
    over = exceeded(largest / most)
    if not over.any():
        return ""
    k = int(np.argmax(largest / most))
    name = path.steps.grasp.spec.names[k]
    return f"{name} presses with {largest[k]:.4g} N, and the object bears {most[k]:.4g} N there"
