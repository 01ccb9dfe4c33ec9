"""The command line: parse, call, print."""

from __future__ import annotations

import sys

from handlcp.cli.app import app, prepare_streams, report_lost_output

from handlcp.cli.solve import follow, solve  # isort: skip  commands are listed in this order
from handlcp.cli.solve import demo  # isort: skip
from handlcp.cli.limits import envelope, limits  # isort: skip
from handlcp.cli.limits import payload  # isort: skip
from handlcp.cli.design import evaluate  # isort: skip
from handlcp.cli.design import sweep  # isort: skip
from handlcp.cli.motors import motors, reliability  # isort: skip
from handlcp.cli.accuracy import accuracy, compare  # isort: skip
from handlcp.cli.lists import audit, effects, hands, keys, paper, warm  # isort: skip

__all__ = [
    "accuracy",
    "app",
    "audit",
    "compare",
    "demo",
    "effects",
    "envelope",
    "evaluate",
    "follow",
    "hands",
    "keys",
    "limits",
    "main",
    "motors",
    "paper",
    "payload",
    "reliability",
    "solve",
    "sweep",
    "warm",
]


def main() -> None:
    """The command line without what `handlcp.__main__` does against Ctrl-C."""
    prepare_streams()
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
                report_lost_output(error.strerror or str(error))
            status = 2
    sys.exit(status)  # type: ignore[arg-type]
