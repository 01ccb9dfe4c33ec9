"""What is said about compiling, on stderr: once a process, and again where it takes much longer than was said."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterator

from handlcp.lcp.compiler.folders import destination

_PATIENCE = 1.0  # what is compiled within this time is not worth a line [s]

_said: dict[str, float] = {}  # what a line was about, and how long it said that takes [s]


def hint(why: str) -> None:
    """That compiled code is not kept, and what to do about it."""
    _say(f"compiled code is not kept ({why}). Set HANDLCP_CACHE_DIR to a folder that can be written, to compile once.")


@contextlib.contextmanager
def waiting(seconds: float) -> Iterator[None]:
    """Around compiling that may take so many seconds: a line once it takes more than one."""
    where = destination()
    seconds = max(seconds, _PATIENCE)
    text = f"compiling, about {seconds:.0f} s" + ("" if where is None else f", once; kept in {where}")
    timer = threading.Timer(_PATIENCE, _say, (text, seconds))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def silent() -> None:
    """Say nothing about compiling in this process: who calls this has a progress bar of its own."""
    _said["compiling"] = float("inf")


def _say(text: str, seconds: float = 0.0) -> None:
    """A line on stderr, if there is one, unless one that begins with the same word was there before, and what it is
    about does not take more than twice as long as that one said.
    """
    kind = text.partition(",")[0].partition(" ")[0]
    if sys.stderr is not None and (kind not in _said or seconds > 2.0 * _said[kind]):
        _said[kind] = seconds
        with contextlib.suppress(OSError, ValueError):  # closed, or nobody listens any more
            print(f"handlcp: {text}", file=sys.stderr, flush=True)
