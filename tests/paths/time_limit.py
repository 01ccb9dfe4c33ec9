"""Questions that may take no longer than so much of the processor."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class TookTooLong(Exception):
    """The time is over."""


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raises TookTooLong in the main thread after so many seconds of the processor, once the call comes back from
    compiled code. Where that raises a SystemError of its own, since an exception came while it took its arguments, that
    is the same.
    """

    def over(number: int, frame: FrameType | None) -> None:
        raise TookTooLong(f"more than {seconds:g} s")

    before = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, seconds if math.isfinite(seconds) else 0.0)  # 0 is never
    try:
        yield
    except SystemError as why:
        if isinstance(why.__cause__, TookTooLong):
            raise why.__cause__ from None
        raise
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
