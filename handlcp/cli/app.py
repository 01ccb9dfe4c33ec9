"""The app that commands join, and what they share.

Exit status: 0 for the verdict HELD; 1 for any other; 2 bad input, with one message on stderr.
"""

from __future__ import annotations

import json as jsonlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text
from typer.core import TyperGroup

from handlcp.errors import HandLCPError, InputError
from handlcp.study.plain import plain
from handlcp.version import VERSION

__all__ = ["Json", "app", "print_json", "print_tables", "progress_bar", "say", "sides_of", "titled"]


class _Commands(TyperGroup):
    """Any HandLCPError becomes one message on stderr and exit status 2."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except HandLCPError as error:
            Console(stderr=True, soft_wrap=True).print(Text.assemble(("Error: ", "bold red"), str(error)))
            raise typer.Exit(2) from None


app = typer.Typer(
    cls=_Commands,
    name="handlcp",
    help="Does this hand hold this object under this load, with which grasp forces, what slips, which joint gives out?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, nothing else.")]


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"handlcp {VERSION}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Grasp forces, slips and joint torques of robot hands."""


@contextmanager
def progress_bar() -> Iterator[Callable[[int, int, str], None]]:
    """A bar on stderr if that is a terminal, drawn between steps: a drawing thread would disturb the measured times."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    bar = Progress(*columns, console=console, auto_refresh=False, transient=True, disable=not console.is_terminal)
    with bar:
        task = bar.add_task("", total=None)
        yield lambda done, total, text: bar.update(task, completed=done, total=total, description=text, refresh=True)


def print_json(value: dict[str, Any]) -> None:
    """One object on stdout; numbers that are not finite become null."""
    typer.echo(jsonlib.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def titled(title: str) -> Console:
    """The console, with the scene's title printed on it."""
    out = Console()
    if title:
        out.print(Text(title, style="bold"), end="\n\n")
    return out


def print_tables(out: Console, tables: Iterable[Table]) -> None:
    """One below the other, with an empty line after each, which a table without a caption brings itself."""
    for table in tables:
        out.print(table, end="\n\n" if table.caption else "\n")


def sides_of(own: Any, faces: str | None) -> Any:
    """Faces of the friction pyramids, or "cone", from --faces over the scene file's own. Raises InputError."""
    if faces is None or faces == "cone":
        return own if faces is None else faces
    if not faces.isdecimal() or int(faces) < 3:
        raise InputError("--faces", 'an integer ≥ 3 or "cone"', repr(faces))
    return int(faces)


def say(out: Console, word: str, style: str, sentence: str) -> None:
    """Print a sentence after a coloured word."""
    out.print(Text.assemble((f"{word}: ", style), f"{sentence}."))
