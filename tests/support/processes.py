"""Programs that tests start: what they hear, and what disks they see."""

from __future__ import annotations

import os
import signal
from typing import Any

__all__ = ["hears_ctrl_c"]


def hears_ctrl_c() -> dict[str, Any]:
    """Arguments of `subprocess.Popen` for a program that Ctrl-C ends, as one that a shell starts in the foreground.

    Who runs the tests in the background of a script, or under nohup, ignores it, and so would all that they start.
    """
    return {"preexec_fn": _hear} if os.name == "posix" else {}


def _hear() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
