"""What users pass about actuators: named rows over the joints, and a stiffness for each actuator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, read_only, spd
from handlcp.errors import InputError, UnknownName
from handlcp.hand.stiffness import per_name

__all__ = ["Given", "given_rows", "read_rows", "read_springs"]

Given = Array | dict[str, dict[str, float]]


def given_rows(argument: str, value: Any) -> Given:
    """What can be checked before the joints are known: numbers, and that there is one actuator or more."""
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


def read_springs(argument: str, value: Any, kind: str, names: Sequence[str], rigid: bool) -> Array:
    """(m, m) stiffness of the actuators from a number, a mapping by name (all of them), (m,) or an SPD matrix.

    rigid : whether inf is welcome. Raises InputError, UnknownName.
    """
    m = len(names)
    if isinstance(value, Mapping):
        unknown = [str(name) for name in value if name not in names]
        if unknown:
            raise UnknownName(argument, f"a {kind}", unknown, names)
        if missing := [name for name in names if name not in value]:
            raise InputError(argument, f"a stiffness for every {kind}, {', '.join(missing)} included", sorted(value))
        return np.diag([number(f"{argument}[{n!r}]", value[n], above=0.0, finite=not rigid) for n in names])
    if dimensions(value) == 0:
        return np.diag(np.full(m, number(argument, value, above=0.0, finite=not rigid)))
    if dimensions(value) == 1:
        if len(value) != m:
            raise InputError(argument, f"{m} values, one for each of {', '.join(names)}", f"{len(value)} of them")
        each = [number(f"{argument}[{i}]", k, above=0.0, finite=not rigid) for i, k in enumerate(value)]
        return np.diag(each)
    return spd(argument, array(argument, value, (m, m)))
