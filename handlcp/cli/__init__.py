"""The command line: parse, call, print."""

from __future__ import annotations

import os
import sys

from handlcp.cli.app import app

from handlcp.cli.solve import solve  # isort: skip  commands are listed in this order
from handlcp.cli.follow import follow  # isort: skip
from handlcp.cli.accuracy import accuracy  # isort: skip
from handlcp.cli.compare import compare  # isort: skip
from handlcp.cli.lists import audit, effects, hands, keys, paper  # isort: skip
from handlcp.cli.gallery import gallery  # isort: skip
from handlcp.cli.warm import warm  # isort: skip

__all__ = [
    "accuracy", "app", "audit", "compare", "effects", "follow", "gallery", "hands", "keys", "main", "paper", "solve",
    "warm",
]  # fmt: skip


def main() -> None:
    """The entry point of the `handlcp` command."""
    if sys.stdout is not None and sys.stdout is sys.__stdout__:
        _keep_stdout()
    app()


def _keep_stdout() -> None:
    """Discard what C code prints on stdout, such as a stray line of HiGHS; what Python prints still arrives."""
    ours, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = open(ours, "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors)  # noqa: SIM115
