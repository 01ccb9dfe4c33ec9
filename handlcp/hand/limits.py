"""Joint ranges and torque limits of the independent joints: from the URDF, with what the user knows better on top."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, number, read_only
from handlcp.errors import InputError
from handlcp.hand.joints import Coupling, JointFacts
from handlcp.hand.stiffness import per_name

__all__ = ["read_ranges", "read_torque_limits"]


def read_ranges(names: Sequence[str], facts: Mapping[str, JointFacts], coupling: Coupling) -> tuple[Array, Array]:
    """(nv,) lower and upper positions of the independent joints [rad, m].

    A mimic joint's own limits narrow the range of the joint it follows. No limits: ±inf.
    """
    lower, upper = np.full(len(coupling.independent), -np.inf), np.full(len(coupling.independent), np.inf)
    for i, name in enumerate(names):
        fact = facts[name]
        k = int(np.argmax(abs(coupling.C[i])))
        factor = coupling.C[i, k]
        if fact.kind == "continuous" or factor == 0.0 or np.isnan(fact.lower) or np.isnan(fact.upper):
            continue
        ends = sorted(((fact.lower - coupling.offset[i]) / factor, (fact.upper - coupling.offset[i]) / factor))
        if fact.lower > fact.upper:  # left as it is: the audit says so
            ends.reverse()
        lower[k], upper[k] = max(lower[k], ends[0]), min(upper[k], ends[1])
    return read_only(lower), read_only(upper)


def read_torque_limits(value: Any, joints: Sequence[str], facts: Mapping[str, JointFacts]) -> tuple[Array, tuple[bool, ...], tuple[bool, ...]]:
    """(nv,) torque limits [N·m] (N for a prismatic joint), which of them are known, and which the user gave.

    `value`: None (the URDF's efforts), a number, a mapping by joint name (over the URDF's), or (nv,). A URDF effort that is zero,
    infinite or absent counts as unknown (inf here); an inf that the user gives is known: no limit.
    Raises InputError for limits that are not positive; UnknownName.
    """
    argument = "torque_limits"
    given: dict[str, Any]
    if value is None:
        given = {}
    elif isinstance(value, Mapping):
        given = per_name(argument, value, joints, "a joint")
    elif np.ndim(value) == 0:
        given = dict.fromkeys(joints, value)
    else:
        if np.shape(value) != (len(joints),):
            raise InputError(argument, f"{len(joints)} values, one for each of {', '.join(joints)}", f"shape {np.shape(value)}")
        given = dict(zip(joints, value, strict=True))
    limits = []
    for joint in joints:
        effort = facts[joint].effort
        if joint in given:
            label = f"{argument}[{joint!r}]" if np.ndim(value) or isinstance(value, Mapping) else argument
            limits.append(number(label, given[joint], above=0.0, finite=False))
        else:
            limits.append(effort if np.isfinite(effort) and effort > 0 else np.inf)
    chosen = tuple(joint in given for joint in joints)
    known = tuple(by_user or bool(np.isfinite(limit)) for by_user, limit in zip(chosen, limits, strict=True))
    return read_only(np.array(limits)), known, chosen
