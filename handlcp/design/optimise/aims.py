"""What is optimised, and what must hold, as numbers of a row: more is better, and below zero is too little.

aim            y = payload, or y = -torque
requirement    m = (payload - 1.5) / 1.5,  m = (0.5 - torque) / 0.5     m ≥ 0: it is met
held           m = factor / safety - 1
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.design.brief import Brief
from handlcp.design.evaluation import REQUIREMENT_UNITS, Evaluation, Requirement, parse_requirement
from handlcp.design.study import COLUMN_ALIASES
from handlcp.design.sweep.work import Row
from handlcp.errors import InputError, UnknownName, translate_arguments
from handlcp.record import parse_entry

COLUMN = {one.path: one.key for one in map(parse_entry, Evaluation.entries or ()) if one.path in REQUIREMENT_UNITS}
_NAMES = {column: name for name, column in COLUMN.items()}
_NAMES |= {alias: _NAMES[column] for alias, column in COLUMN_ALIASES.items()}
_MOST = 1e6  # times a limit: what nothing ends is as good as this
HELD = "held"


class Aim(NamedTuple):
    """A number of an evaluation; sign : 1 where more is better, -1 where less is."""

    name: str
    sign: float

    def __str__(self) -> str:
        return self.name if self.sign > 0 else f"-{self.name}"

    def of(self, row: Mapping[str, Any]) -> float:
        """Of a row; NaN where nothing is known."""
        return self.sign * number_of(row, self.name)


def read_aims(objectives: Any) -> tuple[Aim, ...]:
    """Of what a user calls them. Raises InputError, UnknownName."""
    given = [objectives] if isinstance(objectives, str) else objectives
    if not isinstance(given, Sequence) or not given or not all(isinstance(one, str) for one in given):
        raise InputError("objectives", 'a name such as "payload" or "-torque", or several', repr(objectives)[:80])
    found = list[Aim]()
    for text in given:
        bare = text.removeprefix("-")
        name = bare if bare in REQUIREMENT_UNITS else _NAMES.get(bare)
        if name not in REQUIREMENT_UNITS:
            raise UnknownName("objectives", "a number of an evaluation", [text], REQUIREMENT_UNITS)
        if name in {aim.name for aim in found}:
            raise InputError("objectives", "different numbers", f"{name} twice")
        found.append(Aim(name, -1.0 if text.startswith("-") else 1.0))
    return tuple(found)


def read_needs(constraints: Any) -> tuple[Requirement, ...]:
    """Of texts such as "torque<=0.5". Raises InputError, UnknownName."""
    given = [constraints] if isinstance(constraints, str) else constraints
    if not isinstance(given, Sequence):
        raise InputError("constraints", 'a text such as "torque<=0.5", or several', repr(given)[:80])
    with translate_arguments({"requirement": "constraints"}):
        return tuple([parse_requirement(text) for text in given])


def number_of(row: Mapping[str, Any], name: str) -> float:
    """A number of a row, by name; NaN where nothing is known, and of a design without a grasp of every object."""
    value = row.get(COLUMN[name])
    return np.nan if value is None or not row.get("factor") else float(value)


def margin(need: Requirement, value: float) -> float:
    """How far a number is within a limit, as a share of the limit; negative beyond it, NaN where it is not known."""
    size = abs(need.limit) or 1.0
    way = 1.0 if need.comparison.startswith(">") else -1.0
    return float(np.clip(way * (value - need.limit) / size, -_MOST, _MOST))


def brief_needs(brief: Brief) -> tuple[Requirement, ...]:
    """What a brief asks of the numbers: all of it but how far an object may move, at which a factor ends."""
    presses = () if brief.most_force is None else (Requirement("force", "<=", brief.most_force),)
    return (Requirement("factor", ">=", brief.safety), *presses)


def margins(row: Mapping[str, Any], needs: Sequence[Requirement]) -> Array:
    """(1 + k,) whether all is held that the brief asks, 0 or -1; then of each requirement. A design of which nothing
    is known is at -1.
    """
    found = [0.0 if row.get("holds") else -1.0, *[margin(need, number_of(row, need.name)) for need in needs]]
    return np.asarray(np.nan_to_num(found, nan=-1.0))


def meets(row: Row, needs: Sequence[Requirement]) -> bool:
    """Whether a design holds what the brief asks, and meets each requirement."""
    return bool(row.get("holds")) and all(need.is_met(number_of(row, need.name)) for need in needs)
