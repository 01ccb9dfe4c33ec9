"""The table of a complete sweep: Parquet with what the sweep was in it, or CSV with that in a file beside it."""

from __future__ import annotations

import csv
import json
import os
import tempfile
from collections.abc import Mapping, Sequence, Set
from contextlib import suppress
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, Unsupported, as_path, unreadable, writing

PARQUET, CSV = ".parquet", ".csv"
_KEY = b"handlcp.sweep"
Row = dict[str, Any]


def checked_table(out: Any) -> Path:
    """The file of a table. Raises InputError for another kind of file, or a folder that is not there; Unsupported for
    Parquet without pyarrow.
    """
    file = as_path("out", out, f"a file that ends in {PARQUET} or {CSV}")
    if file.suffix.lower() not in (PARQUET, CSV):
        raise InputError("out", f"a file that ends in {PARQUET} or {CSV}", repr(str(out)))
    if not file.absolute().parent.is_dir():
        raise InputError("out", "a file in a folder that exists", repr(str(file)))
    if file.suffix.lower() == PARQUET:
        _arrow()
    return file


def columns_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Name → what it is in each row, None where a row lacks it; in the order in which rows name them first."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _of_one_kind([row.get(name) for row in rows]) for name in names}


def _of_one_kind(column: list[Any]) -> list[Any]:
    """Of numbers and words mixed, which a column of a table cannot be, words."""
    kinds = {type(value) for value in column if value is not None}
    if len(kinds) <= 1 or kinds == {int, float}:
        return [float(v) if isinstance(v, int) and float in kinds else v for v in column]
    return [None if value is None else str(value) for value in column]


def write_table(file: Path, sweep: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> None:
    """Whole or not at all. Raises InputError."""
    columns, said = columns_of(rows), json.dumps(sweep)
    if file.suffix.lower() == CSV:
        _whole(_described(file), lambda beside: beside.write_text(said + "\n", encoding="utf-8"))
        _whole(file, lambda beside: _write_csv(beside, columns))
        return
    arrow, parquet = _arrow()
    made = arrow.table({name: arrow.array(column) for name, column in columns.items()})
    made = made.replace_schema_metadata({_KEY: said.encode()})
    _whole(file, lambda beside: parquet.write_table(made, beside))


def read_table(file: Path) -> tuple[Row, list[Row]]:
    """What the sweep was, and its rows. Raises InputError for a file that is none of a sweep."""
    if why := unreadable(file):
        raise InputError("out", "the table of a sweep", f"{str(file)!r}, which {why}")
    none = InputError("out", "the table of a sweep", f"{str(file)!r}, which is another file, or damaged")
    if file.suffix.lower() == CSV:
        try:
            sweep = json.loads(_described(file).read_text(encoding="utf-8"))
            return sweep, _read_csv(file, {name for name, entry in sweep["space"].items() if _wordy(entry)})
        except (OSError, ValueError):
            raise none from None
    arrow, parquet = _arrow()
    try:
        made = parquet.read_table(file)
    except (OSError, arrow.ArrowException):
        raise none from None
    said = (made.schema.metadata or {}).get(_KEY)
    if said is None:
        raise none
    return json.loads(said), made.to_pylist()


def _arrow() -> tuple[Any, Any]:
    """Pyarrow and its Parquet. Raises Unsupported without it."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise Unsupported("Parquet needs pyarrow: pip install 'handlcp[sweep]'; a .csv needs nothing") from None
    return pyarrow, parquet


# ----------------------------------------------------------------


def _described(file: Path) -> Path:
    """What a CSV cannot say of itself stands beside it."""
    return file.with_name(f"{file.name}.json")


def _write_csv(file: Path, columns: Mapping[str, list[Any]]) -> None:
    with file.open("w", encoding="utf-8", newline="") as out:
        made = csv.writer(out)
        made.writerow(columns)
        made.writerows(zip(*[map(_cell, column) for column in columns.values()], strict=True))


def _cell(value: Any) -> str:
    """None is nothing; words are themselves; numbers are read as the same bits."""
    return "" if value is None else value if isinstance(value, str) else json.dumps(value)


def _read_csv(file: Path, words: Set[str]) -> list[Row]:
    """A column of which every cell is a number, or every cell true or false, is that; others are words. words : names
    of columns that are words in any case, such as "3" and "". Raises ValueError for rows of different lengths.
    """
    with file.open(encoding="utf-8", newline="") as text:
        names, *rows = csv.reader(text)
    named = zip(names, zip(*rows, strict=True), strict=True)
    columns = [list(cells) if name in words else _values(cells) for name, cells in named]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _wordy(entry: Any) -> bool:
    """Whether a parameter of the space is a word."""
    return isinstance(entry, str) or (isinstance(entry, list) and isinstance(entry[0], str))


def _values(cells: Sequence[str]) -> list[Any]:
    with suppress(ValueError):
        found = json.loads(f"[{','.join(cell or 'null' for cell in cells)}]")  # at once: ten times as fast as each
        if len(found) == len(cells) and all(value is None or isinstance(value, bool | int | float) for value in found):
            return list(found)
    return [cell or None for cell in cells]


def _whole(file: Path, write: Any) -> None:
    """Through a file beside it, whatever stops the program. Raises InputError."""
    with writing("out", file):
        handle, beside = tempfile.mkstemp(dir=file.absolute().parent, prefix=".", suffix=file.suffix)
        os.close(handle)
        try:
            write(Path(beside))
            os.chmod(beside, 0o644)  # who may read the folder may read it
            os.replace(beside, file)
        except BaseException:
            os.unlink(beside)
            raise
