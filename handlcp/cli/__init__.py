"""The command line: parse, call, print."""

from __future__ import annotations

import sys

from handlcp.cli.app import app
from handlcp.cli.streams import lost, open_streams

from handlcp.cli.solve import solve  # isort: skip  commands are listed in this order
from handlcp.cli.follow import follow  # isort: skip
from handlcp.cli.limits import limits  # isort: skip
from handlcp.cli.envelope import envelope  # isort: skip
from handlcp.cli.motors import motors  # isort: skip
from handlcp.cli.reliability import reliability  # isort: skip
from handlcp.cli.accuracy import accuracy  # isort: skip
from handlcp.cli.compare import compare  # isort: skip
from handlcp.cli.lists import audit, effects, hands, keys, paper  # isort: skip
from handlcp.cli.accuracy import gallery  # isort: skip
from handlcp.cli.lists import warm  # isort: skip

__all__ = [
    "accuracy", "app", "audit", "compare", "effects", "envelope", "follow", "gallery", "hands", "keys", "limits",
    "main", "motors", "paper", "reliability", "solve", "warm",
]  # fmt: skip


def main() -> None:
    """The command line without what `handlcp.__main__` does against Ctrl-C."""
    open_streams()
    status: object = 0
    try:
        app()
    except SystemExit as done:
        status = done.code
    if sys.stdout is not None:
        try:
            sys.stdout.flush()
        except OSError as error:
            if status != 2:  # else it has been said
                lost(error.strerror or str(error))
            status = 2
    sys.exit(status)  # type: ignore[arg-type]
