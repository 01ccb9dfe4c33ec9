"""`track_progress`: how far a long call has come: one line on the terminal, the same for Python and for commands.

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

SILENT_SECONDS = 2.0  # what ends within this time gets no line [s]
REDRAW_SECONDS = 0.1  # between two drawings [s]
_NEVER = float("inf")
_thread_state = threading.local()  # its `line` : of the outermost call of this thread
clock = time.monotonic


@contextmanager
def track_progress(
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
    outer: _ProgressLine | None = getattr(_thread_state, "line", None)
    if outer is not None and not callable(asked):
        inner = _ProgressCount(what, total, begun)
        line = outer
        yield lambda more: line.set_detail(str(inner.add(more)))
        return
    count = _ProgressCount(what, total, begun)
    line = _ProgressLine(count, _NEVER if callable(asked) else _line_delay(asked), asked is True)
    _thread_state.line = line
    try:
        if not callable(asked):
            yield line.advance
        else:
            if not total:
                asked(0, 0)
            yield lambda more: asked(count.add(more).done, total or 0)
    finally:
        _thread_state.line = outer
        line.end()


@contextmanager
def track_steps(patience: float = SILENT_SECONDS) -> Iterator[Callable[[int, int | None, str], None]]:
    """Show how many steps of a study are done: yields what to call with that number, of how many, and what comes next.

    Nothing is drawn within a step, which may be measuring times.

    patience : how long the study may take without a line [s].
    """
    outer = getattr(_thread_state, "line", None)
    line = _ProgressLine(_ProgressCount("", None), _line_delay(None, patience), False)
    _thread_state.line = _ProgressLine(_ProgressCount("", None), _NEVER, False)
    try:
        yield line.update
    finally:
        _thread_state.line = outer
        line.end()


_CLOCK_CHECK_SECONDS = 0.02  # [s] between two looks at a thread's computing time, which cost up to a millisecond each


class TimeBudgetError(Exception):
    """A call took longer than its time budget allows."""


@contextmanager
def time_budget(seconds: float) -> Iterator[None]:
    """End calls in this block at their first step after so much computing time of this thread [s], with an error."""
    outer = getattr(_thread_state, "until", _NEVER)
    _thread_state.until, _thread_state.look = min(outer, _budgeted_time() + seconds), 0.0
    try:
        yield
    finally:
        _thread_state.until = outer


@contextmanager
def exclude_from_budget() -> Iterator[None]:
    """Keep what this block computes out of the time budget, such as compiling, which serves all calls."""
    before = _budgeted_time()
    try:
        yield
    finally:
        _thread_state.free = getattr(_thread_state, "free", 0.0) + _budgeted_time() - before


def _budgeted_time() -> float:
    """Computing time of this thread [s]."""
    return time.thread_time() - float(getattr(_thread_state, "free", 0.0))


def report_progress(detail: str) -> None:
    """Say that a step of whatever is going on is done.

    detail : how far it has come, such as "stage 'load' at 40 %".

    Raises an error where the time budget of the calls around it is used up.
    """
    until = getattr(_thread_state, "until", _NEVER)
    if until < _NEVER and (now := time.perf_counter()) >= _thread_state.look:
        _thread_state.look = now + _CLOCK_CHECK_SECONDS
        if _budgeted_time() > until:
            raise TimeBudgetError
    line: _ProgressLine | None = getattr(_thread_state, "line", None)
    if line is not None:
        line.set_detail(detail)


def _line_delay(asked: bool | None, patience: float = SILENT_SECONDS) -> float:
    """How long a call may take until there is a line [s]. Raises InputError for a wrong HANDLCP_PROGRESS."""
    said = os.environ.get("HANDLCP_PROGRESS") or "auto"
    if said not in ("auto", "off"):
        raise InputError("HANDLCP_PROGRESS", '"auto" or "off"', repr(said))
    if asked is not None:
        return 0.0 if asked else _NEVER
    alone = threading.current_thread() is threading.main_thread() and multiprocessing.parent_process() is None
    terminal = sys.stderr is not None and sys.stderr.isatty()
    return patience if said == "auto" and alone and terminal else _NEVER


class _ProgressCount:
    """How many of something are done.

    begun : how many were done before, in a call that goes on with another's work; None: it does not.
    """

    def __init__(self, what: str, total: int | None, begun: int | None = None) -> None:
        self.what, self.total, self.done = what, total, begun or 0
        self.done_before, self.started_at = begun, clock()

    def add(self, more: int) -> _ProgressCount:
        """Add so many that are done."""
        self.done += more
        return self

    def __str__(self) -> str:
        if self.total is not None:
            return f"{self.what} {self.done}/{self.total}{self._pace()}"
        return f"{self.what} {self.done}" if self.done else self.what

    def _pace(self) -> str:
        """The time of each and what is left, such as ", 0.42 s each, 0:12:30 left"; "" where not known or asked for."""
        if self.done_before is None or self.total is None or self.done <= self.done_before:
            return ""
        each = (clock() - self.started_at) / (self.done - self.done_before)
        left = timedelta(seconds=round(each * (self.total - self.done)))
        return f", {each:.2g} s each, {left} left"


class _ProgressLine:
    """The line of one call.

    after : how long the call may take without one [s].
    stays : whether it stays when the call has ended.
    """

    def __init__(self, count: _ProgressCount, after: float, stays: bool) -> None:
        self.count, self.stays, self.detail = count, stays, ""
        self.next_draw = clock() + after  # when it is drawn next
        self.bar: Any = None

    def advance(self, more: int) -> None:
        """Draw that so many more are done."""
        self.count.add(more)
        self._draw()

    def update(self, done: int, total: int | None, what: str) -> None:
        """Draw how many are done, of how many, and what is next."""
        self.count.done, self.count.total, self.count.what = done, total, what
        self._draw()

    def set_detail(self, detail: str) -> None:
        """Draw how far the current one has come."""
        self.detail = detail
        self._draw()

    def end(self) -> None:
        """End the line with its call."""
        if self.stays and self.next_draw < _NEVER:
            self.next_draw = 0.0
            self._draw()
        if self.bar is not None:
            self.bar.stop()

    def _draw(self) -> None:
        now = clock()
        if now < self.next_draw:
            return
        self.next_draw = now + REDRAW_SECONDS
        if self.bar is None:
            self.bar = _make_bar(self.stays, self.count.total)
            self.bar.start()
        text = ", ".join(part for part in (str(self.count), self.detail) if part)
        task = self.bar.task_ids[0]
        self.bar.update(task, completed=self.count.done, total=self.count.total, description=text, refresh=True)


def _make_bar(stays: bool, total: int | None) -> Any:
    """What rich draws on stderr."""
    from rich.console import Console  # rich takes a while to import, and most calls end before they need it
    from rich.progress import BarColumn, Progress as Bar, TextColumn, TimeElapsedColumn
    from rich.table import Column

    text = TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis"), markup=False)
    columns = [text, *([] if total is None else [BarColumn()]), TimeElapsedColumn()]
    bar = Bar(*columns, console=Console(stderr=True), auto_refresh=False, transient=not stays, get_time=clock)
    bar.add_task("", total=total)
    return bar
