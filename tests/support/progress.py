"""A terminal that keeps what is drawn on it, and a clock that goes on when it is told to."""

import io
import re

from handlcp import progress

# A program that takes nine seconds of a clock that runs ahead
NINE_SECONDS = """
import itertools
import handlcp.progress as progress

ahead = itertools.count()
progress.clock = lambda: float(next(ahead))
with progress.track_progress("parts", 9) as say:
    for _ in range(9):
        say(1)
"""
_CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


class Terminal(io.StringIO):
    """Of so many columns, and of the kind that moves its cursor."""

    def isatty(self):
        return True

    @property
    def text(self):
        """What was written, without control sequences."""
        return _CONTROL.sub("", self.getvalue())

    @property
    def left(self):
        """What is still to be seen: the lines after the last one that was erased."""
        shown, column = [""], 0
        for part in re.split(r"(\x1b\[[0-9;?]*[A-Za-z]|\r|\n)", self.getvalue()):
            if part == "\n":
                shown.append("")
                column = 0
            elif part == "\r":
                column = 0
            elif part == "\x1b[2K":
                shown[-1] = ""
            elif part == "\x1b[1A" and len(shown) > 1:
                shown.pop()
            elif part and not part.startswith("\x1b"):
                shown[-1] = shown[-1][:column] + part + shown[-1][column + len(part) :]
                column += len(part)
        return "\n".join(shown)


class Clock:
    """In seconds. each : how far it goes on whenever it is read."""

    def __init__(self, each=0.0):
        self.now, self.each = 100.0, each

    def __call__(self):
        self.now += self.each
        return self.now


def terminal_with(monkeypatch, clock, kind=Terminal):
    """Stderr from now on."""
    made = kind()
    monkeypatch.setattr("sys.stderr", made)
    monkeypatch.setattr(progress, "clock", clock)
    for name, value in {"TERM": "xterm", "COLUMNS": "100", "HANDLCP_PROGRESS": ""}.items():
        monkeypatch.setenv(name, value)
    return made
