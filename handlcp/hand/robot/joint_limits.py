"""Torque limits as users pass them, and doubts about what a file says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, dimensions, number, per_name, read_only
from handlcp.errors import InputError
from handlcp.hand.robot.joints import Coupling, JointFacts

# ---------------------------------------------------------------- One doubt about a hand, and how much it weighs.

SEVERITIES = ("serious", "minor", "information")  # most important first


@dataclass(frozen=True, slots=True)
class Doubt:
    """One doubt: the joint or link (or several, or "hand"), what is doubtful, and what to pass instead.

    severity : "serious": it can change a verdict, beside which it is said again; "minor": it changes numbers;
    "information": nothing is wrong, and something was read in a way worth knowing. about : a word for what it is
    about, such as "torque limit", "range", "coupling", "geometry".
    """

    joint: str
    what: str
    advice: str
    severity: str = "minor"
    about: str = ""

    @property
    def sentence(self) -> str:
        """For a verdict, where many joints are shortened to four."""
        who = words.listed(self.joint.split(", "))
        if self.about == "torque limit":
            return f"the torque limits of {who} are doubtful: {self.what}; torque_limits= confirms or corrects them"
        return f"{who}: {self.what}; pass {self.advice}"

    def __str__(self) -> str:
        return f"{self.joint}: {self.what} → {self.advice}"


# ----------------------------------------------------------------
# Ranges and torque limits of the independent joints: the URDF's, and what the user passes over them.


def read_ranges(names: Sequence[str], facts: Mapping[str, JointFacts], coupling: Coupling) -> tuple[Array, Array]:
    """(nv,) lower and upper positions of the independent joints [rad, m], narrowed by joints that follow; ±inf: none.

    names : of all movable joints, in the order of the coupling's rows.
    """
    lower, upper = np.full(len(coupling.names), -np.inf), np.full(len(coupling.names), np.inf)
    for i, name in enumerate(names):
        fact = facts[name]
        k = int(np.argmax(abs(coupling.C[i])))
        factor, offset = float(coupling.C[i, k]), float(coupling.offset[i])  # Python's floats divide without a warning
        if fact.kind == "continuous" or factor == 0.0 or np.isnan(fact.lower) or np.isnan(fact.upper):
            continue
        ends = sorted(((fact.lower - offset) / factor, (fact.upper - offset) / factor))
        if fact.lower > fact.upper:  # the audit reports it, and nothing corrects it
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
    """From None (the URDF's efforts), a number, a mapping by joint name (over the URDF's), or (nv,) [N·m].

    A URDF effort that is zero, negative, infinite or absent is unknown. An inf that the user passes is known: no limit.
    Raises InputError for limits that are not positive; UnknownName.
    """
    argument, named = "torque_limits", dict[str, Any]()
    if isinstance(value, Mapping):
        named = per_name(argument, value, joints, "a joint")
    elif dimensions(value) == 1 and len(value) == len(joints):
        named = dict(zip(joints, value, strict=True))
    elif dimensions(value):
        raise InputError(argument, f"{len(joints)} values, one for each of {', '.join(joints)}", repr(value))
    elif value is not None:
        named = dict.fromkeys(joints, number(argument, value, above=0.0, finite=False))
    given = {joint: number(f"{argument}[{joint!r}]", v, above=0.0, finite=False) for joint, v in named.items()}
    known = {joint: facts[joint].effort for joint in joints if 0 < facts[joint].effort < np.inf} | given
    limits = np.array([known.get(joint, np.inf) for joint in joints])
    return TorqueLimits(read_only(limits), tuple(joint in known for joint in joints), tuple(given))
