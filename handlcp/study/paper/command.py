"""The command `handlcp paper`."""

from __future__ import annotations

from rich.console import Console

from handlcp.study.paper.render import render
from handlcp.study.paper.report import run

__all__ = ["paper_command"]


def paper_command(console: Console, json: bool = False) -> int:
    """Print the report, or write it as JSON to the console's file. 0 if all golden numbers match."""
    report = run()
    if json:
        console.file.write(report.to_json() + "\n")
    else:
        render(report, console)
    return 0 if report.ok else 1
