"""`Record`: an answer that says once what it holds, and so goes into dictionaries, JSON and tables.

A record lists its `entries`, one line each, in words such as

    "load_N_Nm (6,) = wrench"

the key; the shape, where it is an array; the attribute, where its name is not the key without the unit. The end of the
key is the unit, always SI. In a shape a letter stands for a number that is the same all over the record, and
`twist` for a motion (6,), which is told apart as linear_m and angular_rad. A key with dots lies within another, an
attribute with dots, or with the number of one of several, within another's. Entries that are records tell their own.
"""

from __future__ import annotations

import json
import math
import platform
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from html import escape
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from handlcp.check import check_method_calls
from handlcp.errors import missing_library
from handlcp.version import VERSION
from handlcp.write_file import write_file

UNIT_SUFFIXES = {
    "Nm_per_rad": "N·m/rad",
    "m_per_s2": "m/s²",
    "N_Nm": "N, N·m",
    "m_rad": "m, rad",
    "Nm": "N·m",
    "N": "N",
    "kg": "kg",
    "rad": "rad",
    "m": "m",
    "s": "s",
}
_ENTRY_PATTERN = re.compile(r"(?P<key>\S+)(?: \((?P<shape>[^)]*)\))?(?: = (?P<path>\S+))?")
_UNIT_PATTERN = re.compile(rf"_({'|'.join(UNIT_SUFFIXES)})$")


class RecordEntry(NamedTuple):
    """One entry of a record, read off its line.

    key : in dictionaries.
    unit : SI, "" for a word or a bare number.
    shape : of an array, by letters and numbers; () for anything else.
    path : the attribute, with dots.
    """

    key: str
    unit: str
    shape: tuple[str, ...]
    path: str

    def value_in(self, source: Any) -> Any:
        """The value of this entry in a record, as it stands there; None where something on the way is None."""
        for name in self.path.split("."):
            if source is not None:
                source = source[int(name)] if name.isdigit() else getattr(source, name)
        return source


@cache
def parse_entry(line: str) -> RecordEntry:
    """The entry that a line describes."""
    found = _ENTRY_PATTERN.fullmatch(line)
    assert found is not None, line  # a test reads them all
    unit = _UNIT_PATTERN.search(found["key"])
    shape = tuple(re.findall(r"\w+", found["shape"] or ""))
    path = found["path"] or found["key"][: unit and unit.start()]
    return RecordEntry(found["key"], UNIT_SUFFIXES[unit[1]] if unit else "", shape, path)


def pick_entries(source: Any, *lines: str) -> dict[str, Any]:
    """The entries that these lines describe, of anything with these attributes, as plain data."""
    found: dict[str, Any] = {}
    for one in map(parse_entry, lines):
        *outer, key = one.key.split(".")
        within = found
        for name in outer:
            within = within.setdefault(name, {})
        within[key] = (
            twist_to_plain(one.value_in(source)) if one.shape == ("twist",) else to_plain(one.value_in(source))
        )
    return found


def to_plain(value: Any) -> Any:
    """Records, dataclasses and named tuples as dictionaries, arrays as lists, enumerations by name, numpy's numbers as
    Python's, and None for numbers that are not finite.
    """
    if isinstance(value, Record):
        return value.to_dict()
    if is_dataclass(value):
        return {f.name: to_plain(getattr(value, f.name)) for f in fields(value)}
    if hasattr(value, "_fields"):
        return to_plain(value._asdict())
    if isinstance(value, Mapping):
        return {str(k): to_plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(v) for v in value]
    if isinstance(value, Enum):
        return value.name
    if hasattr(value, "tolist"):
        return to_plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def twist_to_plain(motion: Any) -> dict[str, Any] | None:
    """A motion (6,) [m, rad] as a dictionary of its two halves; None where there is none."""
    return None if motion is None else {"linear_m": to_plain(motion[:3]), "angular_rad": to_plain(motion[3:])}


def to_json_text(value: Any, ascii_only: bool = False) -> str:
    """The value as JSON; numbers that are not finite are null."""
    return json.dumps(to_plain(value), indent=2, ensure_ascii=ascii_only, allow_nan=False)


def package_versions(*packages: str) -> dict[str, str | None]:
    """The versions of handlcp, of Python and of these packages; None for one that is not installed."""
    from importlib.metadata import PackageNotFoundError, version  # for JSON alone

    found: dict[str, str | None] = {"handlcp": VERSION, "python": platform.python_version()}
    for name in packages:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


@check_method_calls
class Record:
    """Base of answers that are plain data.

    entries : one line for each of them, see the top of this file; None: every field of the dataclass, under its name.
    """

    __slots__ = ()
    entries: ClassVar[tuple[str, ...] | None] = None

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as plain data: SI units in the key names, None for what is not a finite number."""
        return pick_entries(self, *self._entry_lines())

    def to_row(self) -> dict[str, Any]:
        """`to_dict` without dictionaries in it, for a row of a table: keys within keys are joined by dots."""
        return dict(_flatten("", self.to_dict()))

    def to_json(self, path: Any = None) -> str | Path:
        """What `to_dict` gives as JSON: the text, or the file that it was written to.

        path : of the file; None: the text is returned. Raises InputError for a file that cannot be written.
        """
        text = to_json_text(self.to_dict())
        if path is None:
            return text
        return write_file("path", path, text + "\n")

    def _repr_html_(self) -> str:
        """What a notebook shows is what prints."""
        return f'<pre style="margin:0;background:none">{escape(str(self))}</pre>'

    def __rich__(self) -> Any:
        """What rich shows is what prints, brackets and all."""
        from rich.text import Text

        return Text(str(self))

    def _entry_lines(self) -> tuple[str, ...]:
        if self.entries is not None:
            return self.entries
        return tuple([f"{f.name} = {f.name}" for f in fields(self)])  # type: ignore[arg-type]


def _flatten(key: str, value: Any) -> Iterable[tuple[str, Any]]:
    """(key, value) of everything in dictionaries, and in lists of dictionaries; other lists stay."""
    within: Iterable[tuple[Any, Any]] = ()
    if isinstance(value, dict):
        within = value.items()
    elif isinstance(value, list) and value and all(isinstance(v, dict) for v in value):
        within = enumerate(value)
    else:
        yield key, value
    for name, v in within:
        yield from _flatten(f"{key}.{name}" if key else str(name), v)


def make_data_frame(columns: Mapping[str, Any], index: Any = None) -> Any:
    """A `pandas.DataFrame`; pandas is imported here alone. Raises Unsupported without it."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise missing_library("tables need pandas", "pandas") from None
    return DataFrame(dict(columns), index=index)


def columns_from_arrays(source: Any, *lines: str) -> dict[str, Any]:
    """A column for each line: an array of the source, as it stands there."""
    return {one.key: one.value_in(source) for one in map(parse_entry, lines)}


def rows_from_columns(columns: Mapping[str, Any]) -> list[dict[str, Any]]:
    """A dictionary for each row of a table."""
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def columns_from_rows(rows: Iterable[Any], *lines: str) -> dict[str, Any]:
    """A column for each line, with what it is in each of the rows."""
    every = list(rows)
    return {one.key: [one.value_in(row) for row in every] for one in map(parse_entry, lines)}
