"""How far a long call has come: one line on the terminal, the same for Python and for commands.

It appears where stderr is a terminal and a call takes longer than two seconds, and it is gone when the call ends. Calls
inside calls share the line of the outermost one. `HANDLCP_PROGRESS=off` silences all of them; so does `progress=False`
where a call has that argument. The line is drawn in the thread that computes, between its steps: a thread of its own
would disturb times that are measured.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from typing import Any

from handlcp.errors import InputError

Progress = bool | Callable[[int, int], None] | None

PATIENCE = 2.0  # what ends within this time gets no line [s]
EVERY = 0.1  # between two drawings [s]
_NEVER = float("inf")
_here = threading.local()  # its `line` : of the outermost call of this thread
clock = time.monotonic


@contextmanager
def told(
    what: str, total: int | None = None, asked: Any = None, begun: int | None = None
) -> Iterator[Callable[[int], None]]:
    """Show how far a long call has come, around it or as its decorator.

    Yields a function to call with how many more are done.

    what : is counted, or done, such as "directions".
    total : how many there are; None: not known.
    asked : the `progress` that a user gave: None: a line as this file has it; False: nothing; True: a line on stderr
        from the beginning on, be it a terminal or not, that stays; a function: called with (done, total), in place of a
        line. Raises InputError for anything else.
    begun : how many were done before, in a call that goes on with another's work and may take hours: the line then says
        how long each takes, and how long the rest will. None: neither.
    """
    if not (asked is None or isinstance(asked, bool) or callable(asked)):
        raise InputError("progress", "True, False, None, or a function of (done, total)", repr(asked)[:80])
    outer: _Line | None = getattr(_here, "line", None)
    if outer is not None and not callable(asked):
        inner = _Count(what, total, begun)
        line = outer
        yield lambda more: line.tick(str(inner.plus(more)))
        return
    line = _Line(_Count(what, total, begun), _NEVER if callable(asked) else _after(asked), asked is True)
    _here.line = line
    try:
        if callable(asked):
            yield _calling(asked, total or 0, begun)
        else:
            yield line.say
    finally:
        _here.line = outer
        line.end()


@contextmanager
def steps(patience: float = PATIENCE) -> Iterator[Callable[[int, int | None, str], None]]:
    """Show how many steps of a study are done: yields what to call with that number, of how many, and what comes next.

    Nothing is drawn within a step, which may be measuring times.

    patience : how long the study may take without a line [s].
    """
    outer, line = getattr(_here, "line", None), _Line(_Count("", None), _after(None, patience), False)
    _here.line = _Line(_Count("", None), _NEVER, False)
    try:
        yield line.at
    finally:
        _here.line = outer
        line.end()


_BETWEEN = 0.02  # [s] between two looks at a thread's computing time, which cost up to a millisecond each


class OutOfTime(Exception):
    """A call took longer than its time budget allows."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """End calls in this block at their first step after so much computing time of this thread [s], with an error."""
    outer = getattr(_here, "until", _NEVER)
    _here.until, _here.look = min(outer, _counted() + seconds), 0.0
    try:
        yield
    finally:
        _here.until = outer


@contextmanager
def uncounted() -> Iterator[None]:
    """Keep what this block computes out of the time budget, such as compiling, which serves all calls."""
    before = _counted()
    try:
        yield
    finally:
        _here.free = getattr(_here, "free", 0.0) + _counted() - before


def _counted() -> float:
    """Computing time of this thread [s]."""
    return time.thread_time() - float(getattr(_here, "free", 0.0))


def tick(detail: str) -> None:
    """Say that a step of whatever is going on is done.

    detail : how far it has come, such as "stage 'load' at 40 %".

    Raises an error where the time budget of the calls around it is used up.
    """
    until = getattr(_here, "until", _NEVER)
    if until < _NEVER and (now := time.perf_counter()) >= _here.look:
        _here.look = now + _BETWEEN
        if _counted() > until:
            raise OutOfTime
    line: _Line | None = getattr(_here, "line", None)
    if line is not None:
        line.tick(detail)


def _after(asked: bool | None, patience: float = PATIENCE) -> float:
    """How long a call may take until there is a line [s]. Raises InputError for a wrong HANDLCP_PROGRESS."""
    said = os.environ.get("HANDLCP_PROGRESS") or "auto"
    if said not in ("auto", "off"):
        raise InputError("HANDLCP_PROGRESS", '"auto" or "off"', repr(said))
    if asked is not None:
        return 0.0 if asked else _NEVER
    alone = threading.current_thread() is threading.main_thread() and multiprocessing.parent_process() is None
    terminal = sys.stderr is not None and sys.stderr.isatty()
    return patience if said == "auto" and alone and terminal else _NEVER


def _calling(function: Callable[[int, int], None], total: int, begun: int | None) -> Callable[[int], None]:
    count = _Count("", total, begun)

    def say(more: int) -> None:
        function(count.plus(more).done, total)

    if not total:
        function(0, 0)
    return say


class _Count:
    """How many of something are done.

    begun : how many were done before, in a call that goes on with another's work; None: it does not.
    """

    def __init__(self, what: str, total: int | None, begun: int | None = None) -> None:
        self.what, self.total, self.done = what, total, begun or 0
        self.begun, self.since = begun, clock()

    def plus(self, more: int) -> _Count:
        """Add so many that are done."""
        self.done += more
        return self

    def __str__(self) -> str:
        if self.total is not None:
            return f"{self.what} {self.done}/{self.total}{self._pace()}"
        return f"{self.what} {self.done}" if self.done else self.what

    def _pace(self) -> str:
        """The time of each and what is left, such as ", 0.42 s each, 0:12:30 left"; "" where not known or asked for."""
        if self.begun is None or self.total is None or self.done <= self.begun:
            return ""
        each = (clock() - self.since) / (self.done - self.begun)
        left = timedelta(seconds=round(each * (self.total - self.done)))
        return f", {each:.2g} s each, {left} left"


class _Line:
    """The line of one call.

    after : how long the call may take without one [s].
    stays : whether it stays when the call has ended.
    """

    def __init__(self, count: _Count, after: float, stays: bool) -> None:
        self.count, self.stays, self.detail = count, stays, ""
        self.due = clock() + after  # when it is drawn next
        self.bar: Any = None

    def say(self, more: int) -> None:
        """Draw that so many more are done."""
        self.count.plus(more)
        self._draw()

    def at(self, done: int, total: int | None, what: str) -> None:
        """Draw how many are done, of how many, and what is next."""
        self.count.done, self.count.total, self.count.what = done, total, what
        self._draw()

    def tick(self, detail: str) -> None:
        """Draw how far the current one has come."""
        self.detail = detail
        self._draw()

    def end(self) -> None:
        """End the line with its call."""
        if self.stays and self.due < _NEVER:
            self.due = 0.0
            self._draw()
        if self.bar is not None:
            self.bar.stop()

    def _draw(self) -> None:
        now = clock()
        if now < self.due:
            return
        self.due = now + EVERY
        if self.bar is None:
            self.bar = _bar(self.stays, self.count.total)
            self.bar.start()
        text = ", ".join(part for part in (str(self.count), self.detail) if part)
        task = self.bar.task_ids[0]
        self.bar.update(task, completed=self.count.done, total=self.count.total, description=text, refresh=True)


def _bar(stays: bool, total: int | None) -> Any:
    """What rich draws on stderr."""
    from rich.console import Console  # rich takes a while to import, and most calls end before they need it
    from rich.progress import BarColumn, Progress as Bar, TextColumn, TimeElapsedColumn
    from rich.table import Column

    text = TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis"), markup=False)
    columns = [text, *([] if total is None else [BarColumn()]), TimeElapsedColumn()]
    bar = Bar(*columns, console=Console(stderr=True), auto_refresh=False, transient=not stays, get_time=clock)
    bar.add_task("", total=total)
    return bar
