"""The rows of a sweep that is under way, in a file beside its table: what is written there is there.

    study.parquet.rows      one line of JSON: what the sweep is; then one for each design

Lines are appended and handed to the disk at once. Whatever stops the program, at any byte, leaves whole lines and at
most one that is torn, which is cut off when the sweep goes on. Numbers are written so that they are read as the same
bits. A Parquet file cannot do this: it is unreadable until it is closed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from handlcp.errors import InputError, writing

Row = dict[str, Any]


def beside(table: Path) -> Path:
    """The journal of a table."""
    return table.with_name(f"{table.name}.rows")


def read(file: Path) -> tuple[Row | None, list[Row], int]:
    """What the sweep is, its rows, and how many bytes these take up; None and no rows where not even that was written.

    Raises InputError for a file that is no journal.
    """
    text = file.read_bytes()
    whole = text[: text.rfind(b"\n") + 1]
    found = list[Row]()
    for number, line in enumerate(whole.splitlines(), 1):
        try:
            found.append(dict(json.loads(line)))
        except (ValueError, TypeError):  # no JSON, or no dictionary
            raise InputError("out", "whole rows in its journal", f"{str(file)!r}, damaged in line {number}") from None
    return (found[0], found[1:], len(whole)) if found else (None, [], 0)


class Journal:
    """Appends rows. `rows` : all that it has. `sweep` : what the sweep is that it was begun with."""

    def __init__(self, file: Path, sweep: Mapping[str, Any]) -> None:
        """With what the sweep is. Raises InputError for a file that cannot be written, or is no journal; whether it is
        the same sweep is for the caller to see.
        """
        self.file, self.rows = file, list[Row]()
        self.sweep: Row = dict(sweep)
        end = 0
        if file.exists():
            before, self.rows, end = read(file)
            self.sweep = self.sweep if before is None else before
        with writing("out", file):
            self._out: BinaryIO = file.open("r+b" if file.exists() else "w+b")
            self._out.truncate(end)
            self._out.seek(end)
        if not end:
            self._write([self.sweep])

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._out.close()

    def append(self, rows: Sequence[Row]) -> None:
        """To the disk, before this returns. Raises InputError where that fails."""
        self._write(rows)
        self.rows += rows

    def _write(self, lines: Sequence[Mapping[str, Any]]) -> None:
        text = "".join(f"{json.dumps(line, allow_nan=False)}\n" for line in lines)
        with writing("out", self.file):
            self._out.write(text.encode())
            self._out.flush()
            os.fsync(self._out.fileno())
