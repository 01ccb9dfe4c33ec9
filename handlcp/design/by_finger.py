"""What users pass finger by finger: one value for all, a sequence of as many, or a mapping by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi, radians
from typing import Any, TypeVar

import numpy as np

from handlcp.check import array, dimensions, number, per_name
from handlcp.errors import InputError

_LONGEST = 1.0  # [m] no link, fingertip or palm is larger
T = TypeVar("T")
Read = Callable[[str, Any], T]
Row = tuple[float, ...]
Pairs = tuple[tuple[float, float], ...]


def by_finger(
    argument: str, value: Any, fingers: Sequence[str], default: Sequence[T], read: Read[T], deep: int
) -> list[T]:
    """One value for each finger, from one for all, a sequence of as many, or a mapping by name.

    argument : what the caller calls the value, for messages.
    value : what the user gave; None: `default`.
    fingers : (n,) names.
    default : (n,) values of fingers that a mapping leaves out.
    read : checks the value of one finger.
    deep : number of dimensions that one finger's plainest value has, such as 0 for a number.

    Raises InputError, UnknownName.
    """
    if value is None:
        return list(default)
    if isinstance(value, Mapping):
        named = per_name(argument, value, fingers, "a finger")
        every = zip(fingers, default, strict=True)
        return [read(f"{argument}[{f!r}]", named[f]) if f in named else own for f, own in every]
    if not isinstance(value, (Sequence, np.ndarray)) or isinstance(value, str) or dimensions(value) in (0, deep):
        return [read(argument, value)] * len(fingers)
    if len(value) != len(fingers):
        raise InputError(
            argument, f"one for all {len(fingers)} fingers, or as many, or a mapping by finger", repr(value)[:80]
        )
    return [read(f"{argument}[{i}]", one) for i, one in enumerate(value)]


def positive(argument: str, value: Any) -> float:
    """A length above 0 [m], refused where millimetres seem to be meant. Raises InputError."""
    length = number(argument, value, above=0.0)
    if length > _LONGEST:
        expected = f"a length in metres of at most {_LONGEST:g} (if millimetres are meant, {length / 1e3:g})"
        raise InputError(argument, expected, f"{length:g}")
    return length


def angle(argument: str, value: Any) -> float:
    """An angle of at most one turn [rad], refused where degrees seem to be meant. Raises InputError."""
    turn = number(argument, value)
    if abs(turn) > 2.0 * pi:
        expected = f"an angle in radians of at most one turn (if degrees are meant, {radians(turn):.4g})"
        raise InputError(argument, expected, f"{turn:g}")
    return turn


def lengths(argument: str, value: Any) -> Row:
    """Lengths (k,) of the k ≥ 1 links of a finger [m]. Raises InputError."""
    row = array(argument, value, (-1,), what="lengths of the links of a finger [m]")
    if not len(row):
        raise InputError(argument, "lengths of the links of a finger [m], at least one", "none")
    return tuple([positive(f"{argument}[{i}]", x) for i, x in enumerate(row.tolist())])


def ends(argument: str, value: Any) -> Pairs:
    """Lower and upper end [rad] of each joint of a finger, one pair of all of them. Raises InputError."""
    rows = array(argument, value, (2,), (-1, 2), what="lower and upper ends of the joints' ranges [rad]").reshape(-1, 2)
    if not len(rows) or not (rows[:, 0] < rows[:, 1]).all():
        raise InputError(argument, "a lower end below the upper end [rad]", repr(value)[:80])
    return tuple([(angle(argument, low), angle(argument, high)) for low, high in rows.tolist()])


def followed(argument: str, value: Any) -> Row | None:
    """How far each joint beyond the first turns for each radian of the one before [-], or one number for all of them.

    None: these joints are free. Raises InputError.
    """
    if value is None:
        return None
    return tuple(array(argument, value, (), (-1,)).reshape(-1).tolist())


def for_joints(argument: str, value: tuple[T, ...], count: int, what: str) -> tuple[T, ...]:
    """One value for each of so many joints, from as many or from one of all. Raises InputError."""
    every = value * count if len(value) == 1 else value
    if len(every) != count:
        raise InputError(argument, f"{what}: one for all, or {count} of them", f"{len(value)}")
    return every
