"""The table of a complete sweep: Parquet with what the sweep was in it, or CSV with that in a file beside it."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import suppress
from pathlib import Path
from typing import Any

from handlcp.design.space import Space
from handlcp.errors import InputError, as_path, missing_library, why_unreadable
from handlcp.read_file import MAX_TABLE_BYTES, MAX_TABLE_CELLS, parse_json, read_bytes, read_text
from handlcp.write_file import write_file

PARQUET, CSV = ".parquet", ".csv"
_KEY = b"handlcp.sweep"
_TABLE = "the table of a sweep"
DESCRIBED = "space", "sampling", "samples", "seed", "make", "brief"  # what is known of every sweep
_NUMBERS = "payload_kg", "factor", "force_N", "torque_Nm", "torque_used", "motion_m"  # columns of nothing else
_HOLDS = "holds"  # a column of true and false
_AS_JSON = {"": "null", "TRUE": "true", "FALSE": "false"}  # the last two as Excel writes them
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
        text = _csv_text(columns)
        write_file("out", _described(file), said + "\n")
        write_file("out", file, text)
        return
    arrow, parquet = _arrow()
    made = arrow.table({name: arrow.array(column) for name, column in columns.items()})
    made = made.replace_schema_metadata({_KEY: said.encode()})
    out = arrow.BufferOutputStream()
    parquet.write_table(made, out)
    write_file("out", file, out.getvalue().to_pybytes())


def read_table(file: Path) -> tuple[Row, list[Row]]:
    """What the sweep was, and its rows. Raises InputError for a file that is none of a sweep."""
    if file.suffix.lower() == CSV:
        text = read_text("out", file, _TABLE, MAX_TABLE_BYTES)
        if why_unreadable(_described(file)):
            raise none_of_a_sweep(file)
        said = read_text("out", _described(file), _TABLE, MAX_TABLE_BYTES)
        if text.count(",") + text.count("\n") > MAX_TABLE_CELLS:
            raise InputError("out", f"a table of at most {MAX_TABLE_CELLS} cells", f"{str(file)!r} with more")
        return _sound(file, said, lambda words: _read_csv(text, words))
    _arrow()
    data = read_bytes("out", file, _TABLE, MAX_TABLE_BYTES)
    try:
        described, rows = _read_parquet(data)
    except Exception:  # Arrow raises errors of its own and of Python's
        raise none_of_a_sweep(file) from None
    return _sound(file, described, lambda words: rows)


def none_of_a_sweep(file: Path) -> InputError:
    """The error for a file with something else in it."""
    return InputError("out", _TABLE, f"{str(file)!r}, which is another file, or damaged")


def check_rows(file: Path, sweep: Any, rows: Any) -> None:
    """Raises InputError unless these are what a sweep was, and rows with a number each."""
    try:
        Space(sweep["space"])
        sound = all(map(_is_row, rows))
    except (InputError, TypeError, KeyError, IndexError):
        sound = False
    if not sound:
        raise none_of_a_sweep(file)


def _is_row(row: Any) -> bool:
    """Whether it has a design's number, cells that are numbers and words, and numbers where it has to have them."""
    for name, value in row.items():
        whole = isinstance(value, int) and -(2**63) <= value < 2**63
        if not (whole or value is None or isinstance(value, float | str)) or not isinstance(name, str):
            return False
        if name in _NUMBERS and isinstance(value, str | bool):
            return False
        if name == _HOLDS and not isinstance(value, bool | None):
            return False
    number = row["design"]
    return isinstance(number, int) and not isinstance(number, bool)


def _sound(file: Path, said: str | bytes, read: Callable[[set[str]], list[Row]]) -> tuple[Row, list[Row]]:
    """What the sweep was, and what is read of its rows, which needs the parameters that are words."""
    try:
        sweep = parse_json(said)
        rows = read({name for name, entry in sweep["space"].items() if _wordy(entry)})
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, csv.Error):
        raise none_of_a_sweep(file) from None
    check_rows(file, sweep, rows)
    if len({row["design"] for row in rows}) < len(rows):
        raise none_of_a_sweep(file)
    return sweep, rows


def _read_parquet(data: bytes) -> tuple[bytes, list[Row]]:
    """What the sweep was, and the rows. Raises ValueError for more cells, or larger ones, than a sweep writes."""
    _, parquet = _arrow()
    import pyarrow

    file = parquet.ParquetFile(pyarrow.BufferReader(data))
    if file.metadata.num_rows * max(1, file.metadata.num_columns) > MAX_TABLE_CELLS:
        raise ValueError("too many cells")
    rows, left = list[Row](), MAX_TABLE_BYTES
    each = max(
        1, min(65_536, MAX_TABLE_BYTES // len(data))
    )  # a word is as long as the file at most, and may be in each row
    for batch in file.iter_batches(each):
        left -= batch.nbytes
        if left < 0:
            raise ValueError("too large when it is unpacked")
        rows += batch.to_pylist()
    return file.schema_arrow.metadata[_KEY], rows


def _arrow() -> tuple[Any, Any]:
    """Pyarrow and its Parquet. Raises Unsupported without it."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise missing_library("Parquet needs pyarrow", "pyarrow", "; a .csv needs nothing") from None
    return pyarrow, parquet


# ----------------------------------------------------------------


def _described(file: Path) -> Path:
    """What a CSV cannot say of itself stands beside it."""
    return file.with_name(f"{file.name}.json")


def _csv_text(columns: Mapping[str, list[Any]]) -> str:
    out = io.StringIO(newline="")
    made = csv.writer(out)
    made.writerow(columns)
    made.writerows(zip(*[map(_cell, column) for column in columns.values()], strict=True))
    return out.getvalue()


def _cell(value: Any) -> str:
    """None is nothing; words are themselves; numbers are read as the same bits."""
    return "" if value is None else value if isinstance(value, str) else json.dumps(value)


def _read_csv(text: str, words: Set[str]) -> list[Row]:
    """A column of which every cell is a number, or every cell true or false, is that; others are words. words : names
    of columns that are words in any case, such as "3" and "". Raises ValueError for rows of different lengths.
    """
    names, *rows = csv.reader(io.StringIO(text, newline=""))
    named = zip(names, zip(*rows, strict=True), strict=True)
    columns = [list(cells) if name in words else _values(cells) for name, cells in named]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _wordy(entry: Any) -> bool:
    """Whether a parameter of the space is a word."""
    return isinstance(entry, str) or (isinstance(entry, list) and isinstance(entry[0], str))


def _values(cells: Sequence[str]) -> list[Any]:
    with suppress(ValueError):
        said = [_AS_JSON.get(cell, cell) for cell in cells]
        found = parse_json(f"[{','.join(said)}]")  # at once: ten times as fast as each
        if len(found) == len(cells) and all(value is None or isinstance(value, bool | int | float) for value in found):
            return list(found)
    return [cell or None for cell in cells]
