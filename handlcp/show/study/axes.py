"""What the axes of a study's pictures say: parameters at their unit coordinates, outcomes with their units."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.design.space import Choices
from handlcp.design.study import Study
from handlcp.hand.vary.vary import ARGUMENT_NUMBERS, NUMBER_UNITS as OF_HANDS
from handlcp.record import UNITS

_NUMBERS = {"palm_radius": "m", "link_radius": "m", "tilt": "rad"}  # of `finger_hand`
_BRIEF = {
    "acceleration": "m/s²",
    "motion": "m",
    "most_force": "N",
    "squeeze": "m",
    "grip_force": "N",
    "closing_torque": "N·m",
}
_MANY = 6  # choices of which each has its own tick


def label(column: str) -> str:
    """Of a column, such as "payload [kg]" for "payload_kg"; a minus, which says that less is better, is left out."""
    name, _, end = column.removeprefix("-").rpartition("_")
    unit = UNITS.get(end, "") if name else ""
    return f"{name.replace('_', ' ')} [{unit}]" if unit else column.removeprefix("-").replace("_", " ")


def parameter(name: str) -> tuple[str, str]:
    """What a parameter is called, and its unit: of one that is called as in `Hand.vary`, in `finger_hand` or
    "brief.motion", or by a name that ends in its unit, such as "length_m"; "" of others.
    """
    if name.startswith("brief."):
        return name, _BRIEF.get(name.removeprefix("brief."), "")
    what = name.rpartition(".")[2] if "." in name else ARGUMENT_NUMBERS.get(name, "")
    if unit := OF_HANDS.get(what, "") or _NUMBERS.get(name, ""):
        return name, unit
    unit = label(name).partition(" [")[2].rstrip("]")
    return (name.rpartition("_")[0], unit) if unit else (name, "")


def places(study: Study) -> Array:
    """(n, d) unit coordinates of the designs."""
    space, names = study.space, study.names
    rows = zip(*[study.columns[name] for name in names], strict=True) if len(study) else ()
    return np.array([space.unit(dict(zip(names, row, strict=True))) for row in rows]).reshape(len(study), len(space))


def ticks(entry: Any) -> tuple[list[float], list[str]]:
    """Where along a free parameter's unit coordinate which value stands: ends and middle, or the choices."""
    if isinstance(entry, Choices):
        at = range(len(entry.values)) if len(entry.values) <= _MANY else (0, len(entry.values) - 1)
        return [entry.middle(i) for i in at], [_short(entry.values[i]) for i in at]
    where = [0.0, 0.5, 1.0]
    return where, [f"{entry.at(u):.3g}" for u in where]


def _short(value: Any) -> str:
    text = f"{value:.3g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 12 else f"{text[:11]}…"
