"""How far a batch has come: told to a function, or drawn as a bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from handlcp.errors import InputError

Progress = bool | Callable[[int, int], None] | None


@contextmanager
def told(progress: Progress, total: int) -> Iterator[Callable[[int], None]]:
    """A function to call with how many more are done. Raises InputError."""
    if progress is None or progress is False:
        yield lambda more: None
    elif progress is True:
        from rich.console import Console  # rich takes a while to import, and most batches want no bar
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = TextColumn("grasps"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        with Bar(*columns, console=Console(stderr=True)) as bar:
            task = bar.add_task("", total=total)
            yield lambda more: bar.advance(task, more)
    elif callable(progress):
        done = 0

        def say(more: int) -> None:
            nonlocal done
            done += more
            progress(done, total)

        if not total:
            progress(0, 0)
        yield say
    else:
        raise InputError("progress", "True, False, None, or a function of (done, total)", repr(progress)[:80])
