"""`Space`: the parameters of a design and where each of them may be, as the unit cube sees them.

    (low, high)           a range          value = low (1 - u) + high u
    (low, high, "log")    a range          value = low (high / low)^u
    a list, range(2, 6)   k choices        value = choices[⌊k u⌋]; in the middle of its part: u = (i + 1/2) / k
    3, "word"             fixed            no coordinate

u in [0, 1] is one coordinate of the cube, in the order of the names. A value depends on its own coordinate alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import scipy

from handlcp.check import Array, check_array, check_flag, check_integer, check_keys, check_number, read_only
from handlcp.errors import InputError, UnknownName

LOG = "log"
_ENTRY_EXPECTED = '(low, high), (low, high, "log"), a list of choices, or one number or word'
_MAX_POINTS = 10_000_000  # points of one sampling: more is a mistake, and fills the memory
ParameterValue = bool | int | float | str


@dataclass(frozen=True, slots=True)
class Range:
    """A range from low to high, in equal steps or, with log, equal ratios."""

    low: float
    high: float
    log: bool = False

    def value_at(self, u: float) -> float:
        """The value at u in [0, 1]; exactly the ends at 0 and 1."""
        if u in (0.0, 1.0):
            return self.high if u else self.low
        value = self.low * (self.high / self.low) ** u if self.log else self.low * (1 - u) + self.high * u
        return min(max(value, self.low), self.high)

    def coordinate_of(self, name: str, value: Any) -> float:
        """The u at which the range has this value. Raises InputError for one outside."""
        x = check_number(name, value)
        if not self.low <= x <= self.high:
            raise InputError(name, f"a number from {self.low:g} to {self.high:g}", x)
        if self.log:
            return float(np.log(x / self.low) / np.log(self.high / self.low))
        return (x - self.low) / (self.high - self.low)


@dataclass(frozen=True, slots=True)
class Choices:
    """One of these, in this order; at least two."""

    values: tuple[ParameterValue, ...]

    def value_at(self, u: float) -> ParameterValue:
        """The choice at u in [0, 1], of which each choice has an equal part."""
        return self.values[min(int(u * len(self.values)), len(self.values) - 1)]

    def coordinate_of(self, name: str, value: Any) -> float:
        """The u in the middle of a choice's part. Raises InputError for what is no choice."""
        if value not in self.values:
            raise InputError(name, f"one of {list(self.values)}", repr(value)[:80])
        return self.coordinate_of_choice(self.values.index(value))

    def coordinate_of_choice(self, i: int) -> float:
        """The u in the middle of the part of choice i."""
        return (i + 0.5) / len(self.values)


class Space:
    """Where the parameters of a design may be. Immutable.

    names : of all parameters, in their order.
    free : those with a range or choices, d of them, one coordinate of the unit cube each.
    fixed : the others, with their values.

    Points of the cube are arrays (n, d).
    """

    def __init__(self, given: Mapping[str, Any]) -> None:
        """Read a space from name → entry, as the top of this file has them. Raises InputError, naming the entry."""
        if not isinstance(given, Mapping) or not given:
            raise InputError("space", f"a mapping of names to {_ENTRY_EXPECTED}; at least one", repr(given)[:80])
        for name in given:
            if not isinstance(name, str) or not name.strip():
                raise InputError("space", "names of parameters that are words", repr(name)[:80])
        read = {name: _read_entry(f"space[{name!r}]", entry) for name, entry in given.items()}
        self.names = tuple(read)
        self.free = {name: e for name, e in read.items() if isinstance(e, Range | Choices)}
        self.fixed: dict[str, ParameterValue] = {n: e for n, e in read.items() if not isinstance(e, Range | Choices)}
        if not self.free:
            raise InputError("space", "at least one parameter with a range or choices", f"{len(read)} fixed ones")

    def __len__(self) -> int:
        """D, the number of coordinates."""
        return len(self.free)

    def __repr__(self) -> str:
        return f"Space({self.to_dict()})"

    def to_dict(self) -> dict[str, Any]:
        """Name → entry, as it may be given: ranges as {"low": 1.0, "high": 2.0, "log": True}, as files have them."""
        return {name: _entry_to_data(self.free.get(name, self.fixed.get(name))) for name in self.names}

    @property
    def ranges(self) -> dict[str, Range]:
        """The parameters that may be any number between two."""
        return {name: entry for name, entry in self.free.items() if isinstance(entry, Range)}

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper ends of the ranges, in the order of `ranges`."""
        rows = [(entry.low, entry.high) for entry in self.ranges.values()]
        low, high = np.array(rows, float).reshape(-1, 2).T
        return read_only(low.copy()), read_only(high.copy())

    def point(self, u: Any) -> dict[str, ParameterValue]:
        """The values of all parameters, by name, at one point (d,) of the cube. Raises InputError."""
        row = check_array("u", u, (len(self),), what="coordinates of the unit cube")
        if not ((row >= 0.0) & (row <= 1.0)).all():
            raise InputError("u", "coordinates from 0 to 1", row.tolist())
        found = {name: entry.value_at(x) for (name, entry), x in zip(self.free.items(), row.tolist(), strict=True)}
        return {name: found[name] if name in found else self.fixed[name] for name in self.names}

    def unit(self, values: Mapping[str, Any]) -> Array:
        """The point (d,) of the cube with these values; fixed ones may be left out. Raises InputError, UnknownName."""
        named = check_keys("values", values, self.names, "a parameter")
        if missing := [name for name in self.free if name not in named]:
            raise InputError("values", f"a value of each of {list(self.free)}", f"none of {', '.join(missing)}")
        return np.array([entry.coordinate_of(f"values[{name!r}]", named[name]) for name, entry in self.free.items()])

    def grid(self, samples: Any) -> Array:
        """Every combination of levels (n, d), the last parameter changing fastest.

        samples : how many levels, at least 2, each range has, its ends among them; or a mapping of the names of the
            ranges to them. Choices have all of theirs. Raises InputError, UnknownName.
        """
        if samples is None and self.ranges:
            raise InputError("samples", "how many levels each range has, such as samples=4", "none")
        counts = dict.fromkeys(self.ranges, samples)
        if isinstance(samples, Mapping):
            if unknown := [str(name) for name in samples if name not in counts]:
                raise UnknownName("samples", "a parameter with a range", unknown, counts)
            if missing := [name for name in counts if name not in samples]:
                raise InputError("samples", f"levels of each of {list(counts)}", f"none of {', '.join(missing)}")
            counts = dict(samples)
        levels, total = list[Any](), 1
        for name, entry in self.free.items():
            if isinstance(entry, Choices):
                levels.append([entry.coordinate_of_choice(i) for i in range(len(entry.values))])
            else:
                argument = f"samples[{name!r}]" if isinstance(samples, Mapping) else "samples"
                k = check_integer(argument, counts[name], 2, _MAX_POINTS)
                levels.append([i / (k - 1) for i in range(k)])
            total *= len(levels[-1])
            if total > _MAX_POINTS:
                raise InputError("samples", f"a grid of at most {_MAX_POINTS} points", f"{total} and more")
        return np.array(list(product(*levels)))

    def sobol(self, samples: int, seed: int = 0) -> Array:
        """The first n points (n, d) of a scrambled Sobol sequence. Raises InputError."""
        n = _check_samples(samples)
        whole = scipy.stats.qmc.Sobol(len(self), scramble=True, seed=check_integer("seed", seed, 0)).random_base2(
            (n - 1).bit_length()
        )
        return np.array(whole[:n])

    def lhs(self, samples: int, seed: int = 0) -> Array:
        """A Latin hypercube of n points (n, d): each of n equal parts of each coordinate has one. Raises InputError."""
        n = _check_samples(samples)
        return np.array(scipy.stats.qmc.LatinHypercube(len(self), seed=check_integer("seed", seed, 0)).random(n))


def _check_samples(samples: Any) -> int:
    """The number of points to sample, checked. Raises InputError."""
    if samples is None:
        raise InputError("samples", "how many designs, such as samples=256", "none")
    return check_integer("samples", samples, 1, _MAX_POINTS)


def _read_entry(argument: str, entry: Any) -> Range | Choices | ParameterValue:
    """One entry of a space, as a range, choices or a fixed value. Raises InputError."""
    if isinstance(entry, Mapping) and {"low", "high"} <= set(entry) <= {"low", "high", LOG}:  # as files have it
        log = check_flag(f"{argument}.{LOG}", entry.get(LOG, False))
        entry = (entry["low"], entry["high"], *([LOG] if log else []))
    if isinstance(entry, tuple):
        return _read_range(argument, entry)
    if isinstance(entry, np.ndarray) and entry.ndim == 1:
        entry = entry.tolist()
    if not isinstance(entry, Sequence) or isinstance(entry, str | bytes):
        return _read_value(argument, entry, _ENTRY_EXPECTED)
    values = tuple([_read_value(f"{argument}[{i}]", one, "a number or a word") for i, one in enumerate(entry)])
    if not values:
        raise InputError(argument, "at least one choice", "none")
    for i, value in enumerate(values):
        if value in values[:i]:
            raise InputError(argument, "choices that differ", f"{value!r} twice")
    if len({float if isinstance(v, int | float) and not isinstance(v, bool) else type(v) for v in values}) > 1:
        raise InputError(argument, "choices that are all numbers, or all words", list(values))
    return Choices(values) if len(values) > 1 else values[0]


def _read_range(argument: str, entry: tuple[Any, ...]) -> Range:
    """The range that (low, high) or (low, high, "log") means. Raises InputError."""
    log = len(entry) == 3 and isinstance(entry[2], str) and entry[2] == LOG
    if len(entry) != 2 and not log:
        raise InputError(
            argument, f"{_ENTRY_EXPECTED}; choices are a list, such as {list(entry)!r}"[:200], repr(entry)[:80]
        )
    low, high = (check_number(f"{argument}[{i}]", entry[i]) for i in (0, 1))
    if not low < high:
        raise InputError(argument, "a low end below the high end", f"({low:g}, {high:g})")
    if log and low <= 0.0:
        raise InputError(argument, "ends above 0 of a range with equal ratios", f"({low:g}, {high:g})")
    return Range(low, high, log)


def _read_value(argument: str, value: Any, expected: str) -> ParameterValue:
    """A number or word as Python has it. Raises InputError."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str | bool):
        return value
    if isinstance(value, int | float):
        return int(value) if isinstance(value, int) else check_number(argument, value)
    raise InputError(argument, expected, repr(value)[:80])


def _entry_to_data(entry: Any) -> Any:
    """An entry as it may be given, of what JSON and TOML have."""
    if isinstance(entry, Range):
        return {"low": entry.low, "high": entry.high} | ({LOG: True} if entry.log else {})
    return list(entry.values) if isinstance(entry, Choices) else entry
