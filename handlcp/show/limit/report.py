"""Load limits for the terminal, and for machines."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.limits.result import EQUILIBRIUM, MOTION, OPENS, RANGE, SLIPS, TORQUE, Bind, LoadLimit
from handlcp.show import tables
from handlcp.study.plain import plain
from handlcp.version import VERSION

__all__ = ["cause", "limit_table", "record", "share_of_bound", "size", "way"]

_CAUSES = {  # of one, of several
    SLIPS: ("slips", "slip"), OPENS: ("lets go", "let go"), TORQUE: ("at its torque limit", "at their torque limits"),
    RANGE: ("at the end of its range", "at the ends of their ranges"),
}  # fmt: skip
_AXES = ("x", "y", "z")


def cause(binds: Sequence[Bind]) -> str:
    """What gives out, such as "finger_1_tip slips"; "nothing" where the load may grow without end."""
    if not binds:
        return "nothing"
    kind = binds[0].kind
    if kind == EQUILIBRIUM:
        return "no contact forces balance the load"
    if kind == MOTION:
        return "the object has moved too far"
    who = words.listed([b.who for b in binds])
    return f"{who} {_CAUSES[kind][len(binds) > 1]}"


def size(wrench: Array, factor: float) -> str:
    """Of the load at a factor, such as "2.54 N"; "no limit" where it is infinite."""
    if not np.isfinite(factor):
        return "no limit"
    force, torque = float(np.linalg.norm(wrench[:3])), float(np.linalg.norm(wrench[3:]))
    parts = [words.force(factor * force)] * (force > 0.0) + [words.torque(factor * torque)] * (torque > 0.0)
    return ", ".join(parts)


def way(wrench: Array) -> str:
    """Of a load, such as "+x", "force 0.6 0.5 0.62", "torque +z"."""
    parts = []
    for name, part in (("force", wrench[:3]), ("torque", wrench[3:])):
        if part.any():
            parts.append(f"{name} {_direction(part)}")
    return " and ".join(parts)


def _direction(vector: Array) -> str:
    """Along an axis its name, else the numbers."""
    found = np.flatnonzero(vector)
    if len(found) == 1:
        return f"{'-' if vector[found[0]] < 0 else '+'}{_AXES[found[0]]}"
    return " ".join(f"{x:.3g}" for x in vector.tolist())


def share_of_bound(limit: LoadLimit) -> str:
    """The limit as a share of what friction and torque limits alone would allow; "–" where that has no end."""
    if not np.isfinite(limit.factor) or not np.isfinite(limit.bound) or limit.bound <= 0.0:
        return "–"
    return words.percent(limit.factor / limit.bound)


def limit_table(limits: Sequence[LoadLimit], title: str) -> Table:
    """A row for each load: how much is held, what gives out, and how much friction and torque limits alone allow."""
    table = tables.empty(title, "at most: what friction and torque limits alone would allow, whatever the springs")
    table.add_column("load", no_wrap=True)
    tables.numbers(table, "held up to")
    table.add_column("what gives out", overflow="fold")
    tables.numbers(table, "at most")
    for limit in limits:
        row = (Text(way(limit.wrench)), size(limit.wrench, limit.factor), Text(cause(limit.binds)))
        table.add_row(*row, size(limit.wrench, limit.bound), style="bold red" if limit.factor == 0.0 else None)
    return table


def record(limits: Sequence[LoadLimit], title: str = "", motion: float | None = None) -> dict[str, Any]:
    """Everything as one JSON object: SI units in the key names, null for what is not a finite number."""
    every = [
        limit.to_dict() | {"some_equilibrium": limit.some_equilibrium, "bound": limit.bound} for limit in limits
    ]  # fmt: skip
    found = {
        "title": title, "motion_m": motion, "limits": every,
        "versions": {"handlcp": VERSION, "python": platform.python_version(), "numpy": np.__version__},
    }  # fmt: skip
    return dict(plain(found))
