"""What users pass about actuators: a named row over the joints for each, and its stiffness."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, per_name, read_only, spd
from handlcp.errors import InputError
from handlcp.hand.elasticity.stiffness import springs

Given = Array | dict[str, dict[str, float]]


def given_rows(argument: str, value: Any) -> Given:
    """Finite rows (m, nv), or as many named mappings of joint names to numbers; m ≥ 1. Raises InputError."""
    if not isinstance(value, Mapping):
        rows = array(argument, value, (-1, -1))
        if not len(rows):
            raise InputError(argument, "a row for each, at least one", f"shape {rows.shape}")
        return rows
    out: dict[str, dict[str, float]] = {}
    for name, row in value.items():
        if not isinstance(row, Mapping):
            raise InputError(f"{argument}[{name!r}]", "a mapping of joint names to numbers", repr(row)[:80])
        out[str(name)] = {str(j): number(f"{argument}[{name!r}][{j!r}]", x) for j, x in row.items()}
    if not out:
        raise InputError(argument, "one name or more", "none")
    return out


def read_rows(argument: str, given: Given, kind: str, joints: Sequence[str]) -> tuple[tuple[str, ...], Array]:
    """Names and rows (m, nv) over these joints; joints that a mapping leaves out: 0. An array's rows are "kind 1", …

    Raises InputError (wrong size, a row of zeros), UnknownName.
    """
    if isinstance(given, dict):
        names, rows = tuple(given), np.zeros((len(given), len(joints)))
        for name, row, out in zip(names, given.values(), rows, strict=True):
            for joint, x in per_name(f"{argument}[{name!r}]", row, joints, "a joint").items():
                out[joints.index(joint)] = x
    else:
        names, rows = tuple(f"{kind} {i + 1}" for i in range(len(given))), given
        if rows.shape[1] != len(joints):
            listed = ", ".join(joints)
            raise InputError(argument, f"{len(joints)} numbers a {kind}, one for each of {listed}", rows.shape[1])
    for name, out in zip(names, rows, strict=True):
        if not out.any():
            raise InputError(argument, f"a {kind} that moves with some joint", f"only zeros for {name!r}")
    return names, read_only(rows)


def read_springs(
    argument: str, value: Any, kind: str, names: Sequence[str], read: Callable[[str, Any], float]
) -> Array:
    """(m, m) stiffness of the actuators from a number, a mapping by name (all of them), (m,) or an SPD matrix.

    read : checks a number, as in `springs`. Raises InputError, UnknownName.
    """
    if isinstance(value, Mapping):
        values = per_name(argument, value, names, f"a {kind}")
        if missing := [name for name in names if name not in values]:
            raise InputError(argument, f"a stiffness for every {kind}, {', '.join(missing)} included", sorted(values))
        return np.diag([read(f"{argument}[{name!r}]", values[name]) for name in names])
    diagonal = springs(argument, value, names, read)
    return spd(argument, array(argument, value, (len(names), len(names)))) if diagonal is None else diagonal
