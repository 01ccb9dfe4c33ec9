"""Load limits for the terminal, and for machines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.cause.wording import said
from handlcp.grasp.limits.result import LoadLimit
from handlcp.show import tables

_SAME = 1e-6  # loads that differ by less are the same
_AXES = ("x", "y", "z")


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
    """A row for each load: where a finger slips first, how much is held, what gives out, how far the object has moved
    there, where it is lost, and how much friction and torque limits alone allow.
    """
    note = "at most: what friction and torque limits alone would allow, whatever the springs"
    heads = "load", "first slip", "held up to", "what gives out", "at most"
    table = tables.table(title, heads, "|>><>", note=note)
    for limit in limits:
        held = limit.factor > 0.0
        first = size(limit.wrench, limit.first_slip) if held and limit.first_slip is not None else "–"
        row = (way(limit.wrench), first, size(limit.wrench, limit.factor), _ends(limit))
        table.add_row(*map(Text, row), size(limit.wrench, limit.bound), style=None if held else "bold red")
    return table


def _ends(limit: LoadLimit) -> str:
    """What gives out; how far the object has moved there, and where it is lost."""
    parts = [said(limit.binds, brief=True)]
    if (there := moved(limit)) != "–":
        parts.append(f"moved {there}")
    if limit.lost is not None and limit.lost > limit.factor * (1.0 + _SAME):
        parts.append(f"lost at {size(limit.wrench, limit.lost)}")
    return "; ".join(parts)


def moved(limit: LoadLimit) -> str:
    """How far the object has moved and turned at the limit, such as "4 mm, 4°"; "–" where that is not known."""
    there = [m for m in limit.marks.values() if m.factor == limit.factor > 0.0]
    return f"{words.length(there[0].moved)}, {words.angle(there[0].turned)}" if there else "–"
