"""What is said about compiling, on stderr, each at most once a process."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterator

from handlcp.lcp.compiler.folders import destination

_PATIENCE = 1.0  # what is compiled within this time is not worth a line [s]

_said: set[str] = set()


def hint(why: str) -> None:
    """That compiled code is not kept, and what to do about it."""
    _say(f"compiled code is not kept ({why}). Set HANDLCP_CACHE_DIR to a folder that can be written, to compile once.")


@contextlib.contextmanager
def waiting(seconds: float) -> Iterator[None]:
    """Around compiling that may take so many seconds: a line once it takes more than one."""
    where = destination()
    text = f"compiling, about {max(seconds, _PATIENCE):.0f} s"
    text += "" if where is None else f", once; kept in {where}"
    timer = threading.Timer(_PATIENCE, _say, (text,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def silent() -> None:
    """Say nothing about compiling in this process: who calls this has a progress bar of its own."""
    _said.add("compiling")


def _say(text: str) -> None:
    """A line on stderr, if there is one, unless one that begins with the same word was there before."""
    kind = text.partition(",")[0].partition(" ")[0]
    if kind not in _said and sys.stderr is not None:
        _said.add(kind)
        with contextlib.suppress(OSError, ValueError):  # closed, or nobody listens any more
            print(f"handlcp: {text}", file=sys.stderr, flush=True)
