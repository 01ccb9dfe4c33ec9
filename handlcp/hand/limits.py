"""Joint ranges and torque limits of the independent joints: from the URDF, with what the user knows better on top."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, dimensions, number, read_only
from handlcp.errors import InputError
from handlcp.hand.joints import Coupling, JointFacts
from handlcp.hand.stiffness import per_name

__all__ = ["TorqueLimits", "read_ranges", "read_torque_limits"]


def read_ranges(names: Sequence[str], facts: Mapping[str, JointFacts], coupling: Coupling) -> tuple[Array, Array]:
    """(nv,) lower and upper positions of the independent joints [rad, m].

    A mimic joint's own limits narrow the range of the joint it follows. No limits: ±inf.
    """
    lower, upper = np.full(len(coupling.independent), -np.inf), np.full(len(coupling.independent), np.inf)
    for i, name in enumerate(names):
        fact = facts[name]
        k = int(np.argmax(abs(coupling.C[i])))
        factor, offset = float(coupling.C[i, k]), float(coupling.offset[i])  # Python's divide without a warning
        if fact.kind == "continuous" or factor == 0.0 or np.isnan(fact.lower) or np.isnan(fact.upper):
            continue
        ends = sorted(((fact.lower - offset) / factor, (fact.upper - offset) / factor))
        if fact.lower > fact.upper:  # left as it is: the audit says so
            ends.reverse()
        lower[k], upper[k] = max(lower[k], ends[0]), min(upper[k], ends[1])
    return read_only(lower), read_only(upper)


@dataclass(frozen=True, slots=True)
class TorqueLimits:
    """limits : (nv,) [N·m], inf for none. known : nv booleans. given : the joints whose limit the user passed."""

    limits: Array
    known: tuple[bool, ...]
    given: tuple[str, ...]


def read_torque_limits(value: Any, joints: Sequence[str], facts: Mapping[str, JointFacts]) -> TorqueLimits:
    """None (the URDF's efforts), a number, a mapping by joint name (over the URDF's), or (nv,) [N·m].

    A URDF effort that is zero, negative, infinite or absent counts as unknown; an inf that the user gives is known:
    no limit. Raises InputError for limits that are not positive; UnknownName.
    """
    argument, given = "torque_limits", dict[str, float]()
    if isinstance(value, Mapping):
        named = per_name(argument, value, joints, "a joint")
        given = {joint: number(f"{argument}[{joint!r}]", v, above=0.0, finite=False) for joint, v in named.items()}
    elif isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str) and dimensions(value):
        if dimensions(value) != 1 or len(value) != len(joints):
            raise InputError(argument, f"{len(joints)} values, one for each of {', '.join(joints)}", repr(value))
        given = {
            j: number(f"{argument}[{j!r}]", v, above=0.0, finite=False) for j, v in zip(joints, value, strict=True)
        }
    elif value is not None:
        given = dict.fromkeys(joints, number(argument, value, above=0.0, finite=False))
    efforts = {joint: facts[joint].effort for joint in joints}
    written = {joint: effort if np.isfinite(effort) and effort > 0 else np.inf for joint, effort in efforts.items()}
    limits = np.array([given.get(joint, written[joint]) for joint in joints], dtype=float)
    known = tuple(joint in given or bool(np.isfinite(written[joint])) for joint in joints)
    return TorqueLimits(read_only(limits), known, tuple(given))
