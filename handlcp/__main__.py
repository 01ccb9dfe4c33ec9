"""The `handlcp` command, also `python -m handlcp`: the first lines that run, so that Ctrl-C ends it at any moment."""

from __future__ import annotations

import os
import signal
import sys
import threading
from contextlib import suppress

EXIT_INTERRUPTED = 130  # as a shell reports a program that Ctrl-C ended
MAX_CLEANUP_SECONDS = 1.0  # how long that may take at most [s]


def main() -> None:
    """Run the command line. Exit status: see `handlcp.cli.app`; 130 after Ctrl-C; 141 where the output was closed."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # a shell may have it ignored
        signal.signal(signal.SIGINT, _exit_on_interrupt)
    from handlcp.cli import main as run  # a second of imports

    run()


def _exit_on_interrupt(*_: object) -> None:
    """End this program at once; an exception would be swallowed, or printed, wherever it happens to arrive."""
    if os.isatty(2):
        os.write(2, b"\x1b[?25h\n")  # a progress bar hides the cursor
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)  # other threads may write to processes that are gone now
    children = getattr(sys.modules.get("multiprocessing"), "active_children", list)  # imported, where any were started
    for process in children():
        with suppress(OSError):  # it ended by itself
            os.kill(process.pid, getattr(signal, "SIGKILL", signal.SIGTERM))  # else it would compute on
    if "multiprocessing.util" in sys.modules:
        tidying = threading.Thread(target=_unlink_semaphores, daemon=True)
        tidying.start()
        tidying.join(MAX_CLEANUP_SECONDS)
    os._exit(EXIT_INTERRUPTED)


def _unlink_semaphores() -> None:
    """Unlink named semaphores of processes that compute, as the end of a program does; else the process that tracks
    them says on stderr that they leaked. In a thread, because whoever was interrupted may hold a lock that this needs.
    """
    with suppress(Exception):
        finalizers = sys.modules["multiprocessing.util"]._finalizer_registry
        for finalizer in list(finalizers.values()):
            if getattr(finalizer._callback, "__qualname__", "") == "SemLock._cleanup":
                finalizer()


if __name__ == "__main__":
    main()
