"""The rows of a sweep that is under way, in a file beside its table: what is written there is there.

    study.parquet.rows      one line of JSON: what the sweep is; then one for each design, after a check sum of the line

Lines are appended and handed to the disk at once. Whatever stops the program, at any byte, leaves whole lines and at
most one that is torn, which is cut off when the sweep goes on. Lines that find no room on the disk are cut off at once,
and nothing is left to be written when the file is closed. A line whose sum does not fit was damaged, and counts as
not there. Numbers are written so that they are read as the same bits. A Parquet file cannot do this: it is unreadable
until it is closed. One run writes at a time: it holds a lock of the operating system, which goes with it however it
ends.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from weakref import WeakSet
from zlib import crc32

from handlcp.errors import InputError, refuse_unwritable
from handlcp.read_file import MAX_TABLE_BYTES, parse_json, read_bytes
from handlcp.write_file import write_all

if sys.platform != "win32":
    import fcntl

Row = dict[str, Any]


def beside(table: Path) -> Path:
    """The journal of a table."""
    return table.with_name(f"{table.name}.rows")


def read(file: Path) -> tuple[Row | None, list[Row], int]:
    """What the sweep is, its rows, and how many bytes these take up; None and no rows where not even that was written.

    Raises InputError for a file that is no journal.
    """
    return _parsed(file, read_bytes("out", file, "the journal of a sweep", MAX_TABLE_BYTES))


def _parsed(file: Path, text: bytes) -> tuple[Row | None, list[Row], int]:
    whole = text[: text.rfind(b"\n") + 1]
    first, *lines = whole.split(b"\n")
    if not whole:
        return None, [], 0
    return (
        _mapping(file, first, 1),
        [
            _mapping(file, row, k)
            for k, (said, _, row) in enumerate([line.partition(b" ") for line in lines], 2)
            if said == _sum(row)
        ],
        len(whole),
    )


def _mapping(file: Path, line: bytes, number: int) -> Row:
    """What a line says. Raises InputError for anything but a mapping."""
    try:
        found = parse_json(line)
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise InputError("out", "the journal of a sweep", f"{str(file)!r}, damaged in line {number}")
    return found


def _sum(line: bytes) -> bytes:
    return f"{crc32(line):08x}".encode()


class Journal:
    """Appends rows. `rows` : all that it has. `sweep` : what the sweep is that it was begun with."""

    def __init__(self, file: Path, sweep: Mapping[str, Any]) -> None:
        """With what the sweep is. Raises InputError for a file that cannot be written, that another run is writing, or
        that is no journal; whether it is the same sweep is for the caller to see.
        """
        self.file = file
        with refuse_unwritable("out", file):
            self._out = file.open("a+b", buffering=0)
        try:
            self._lock()
            before, self.rows, end = read(file)
            self.sweep: Row = dict(sweep) if before is None else before
            self._end = end  # of the whole lines [bytes]
            with refuse_unwritable("out", file):
                self._out.truncate(end)
            if before is None:
                self._write([json.dumps(self.sweep).encode()])
        except BaseException:
            with suppress(OSError):
                self._out.close()
            raise
        _OPEN.add(self)

    def _lock(self) -> None:
        """Raises InputError where another run has it."""
        if sys.platform == "win32":  # whose locks keep others from reading
            return
        try:
            fcntl.flock(self._out, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            said = f"{str(self.file)!r}, which another run is writing now"
            raise InputError("out", "a file that no other run writes", said) from None
        except OSError:  # folders of a network that know no locks
            return

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Raises InputError where the file cannot be closed, but not in place of an error that is on its way."""
        with nullcontext() if error is None else suppress(InputError):
            self.close()

    def close(self) -> None:
        """Let go of file and lock. Raises InputError."""
        with refuse_unwritable("out", self.file):
            self._out.close()

    def append(self, rows: Sequence[Row]) -> None:
        """To the disk, before this returns. Raises InputError where that fails."""
        lines = [json.dumps(row).encode() for row in rows]
        self._write([_sum(line) + b" " + line for line in lines])
        self.rows += rows

    def _write(self, lines: Sequence[bytes]) -> None:
        data = b"".join(line + b"\n" for line in lines)
        with refuse_unwritable("out", self.file):
            try:
                write_all(self._out.fileno(), data)
                os.fsync(self._out.fileno())
            except BaseException:
                with suppress(OSError):
                    self._out.truncate(self._end)  # what comes next begins a line
                raise
        self._end += len(data)


_OPEN = WeakSet[Journal]()


def _forked() -> None:
    """Workers that are forked off would hold the lock on when the run is killed."""
    for journal in _OPEN:
        journal.close()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)
