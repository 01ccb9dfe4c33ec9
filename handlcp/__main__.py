"""The `handlcp` command, also `python -m handlcp`: the first lines that run, so that Ctrl-C ends it at any moment."""

from __future__ import annotations

import os
import signal
import sys

INTERRUPTED = 130  # as a shell reports a program that Ctrl-C ended


def main() -> None:
    """Run the command line. Exit status: see `handlcp.cli.app`; 130 after Ctrl-C; 141 where the output was closed."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # a shell may have it ignored
        signal.signal(signal.SIGINT, _interrupted)
    from handlcp.cli import main as run  # a second of imports

    run()


def _interrupted(*_: object) -> None:
    """End at once: an exception would be swallowed, or printed, wherever it happens to arrive."""
    if os.isatty(2):
        os.write(2, b"\x1b[?25h\n")  # a progress bar hides the cursor
    children = getattr(sys.modules.get("multiprocessing"), "active_children", list)  # imported, where any were started
    for process in children():
        process.kill()  # else it would compute on
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
