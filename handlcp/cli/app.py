"""The app that commands join, and what they share.

Exit status: 0 for the verdict HELD; 1 for any other; 2 bad input, or output that cannot be written, with one message on
stderr; 130 after Ctrl-C; 141 where the reader of the output closed it, as `head` does.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text
from typer.core import TyperGroup

from handlcp.errors import HandLCPError, InputError, brief
from handlcp.record import json_text
from handlcp.version import VERSION


class _Commands(TyperGroup):
    """Bad input, be it an option or a file, becomes one message on stderr and exit status 2."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args:  # the help
            return super().parse_args(ctx, args)
        with _refusals():
            if "" in args:  # as a path it would mean this folder
                raise InputError("an argument", "a file, a name or a number", "'', which is empty")
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        with _refusals():
            return super().invoke(ctx)


@contextmanager
def _refusals() -> Iterator[None]:
    try:
        yield
    except HandLCPError as error:
        _refuse(str(error))
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise
        what = "output" if error.filename is None else brief(repr(error.filename))
        _refuse(f"{what}: {error.strerror or error}")
    except Exception as error:
        # Typer's own refusals of options; which class they have differs with its version
        if (message := getattr(error, "format_message", None)) is None:
            raise
        path = getattr(getattr(error, "ctx", None), "command_path", "handlcp")
        _refuse(f"{brief(message().strip().rstrip('.'))}; `{path} --help` says what it takes")


def _refuse(message: str) -> NoReturn:
    """One message on stderr, exit status 2."""
    Console(stderr=True, soft_wrap=True).print(Text.assemble(("Error: ", "bold red"), message))
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

SceneFile = Annotated[Path, typer.Argument(help="A scene file (TOML); `handlcp keys` lists what it may hold.")]
Faces = Annotated[str | None, typer.Option(help='Faces of the friction pyramids, or "cone", over the file\'s.')]
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
def progress_bar() -> Iterator[Callable[[int, int | None, str], None]]:
    """A bar on stderr if that is a terminal, drawn between steps: a drawing thread would disturb the measured times."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    bar = Progress(*columns, console=console, auto_refresh=False, transient=True, disable=not console.is_terminal)
    with bar:
        task = bar.add_task("", total=None)
        yield lambda done, total, text: bar.update(task, completed=done, total=total, description=text, refresh=True)


def print_json(value: dict[str, Any]) -> None:
    """One object on stdout; numbers that are not finite become null. In ASCII where stdout has no other characters."""
    text = json_text(value)
    try:
        text.encode(getattr(sys.stdout, "encoding", None) or "utf-8")
    except UnicodeEncodeError:
        text = json_text(value, ascii_only=True)
    typer.echo(text)


def titled(title: str) -> Console:
    """The console, with the scene's title printed on it."""
    out = Console()
    if title:
        out.print(Text(title, style="bold"), end="\n\n")
    return out


def print_tables(out: Console, tables: Iterable[Table]) -> None:
    """One below the other, with an empty line after each, which a table without a caption brings itself."""
    for table in tables:
        out.print(table)
        if table.caption:
            out.print()


def print_files(out: Console, pictures: Iterable[Path | None], page: Path | None = None) -> None:
    """The names of the files that were written; None for one that was not asked for."""
    for what, path in (*(("Picture", picture) for picture in pictures), ("Page", page)):
        if path is not None:
            out.print(Text(f"{what}: {path}", style="dim"))


def sides_of(own: Any, faces: str | None) -> Any:
    """Faces of the friction pyramids, or "cone", from --faces over the scene file's own. Raises InputError."""
    if faces is None or faces == "cone":
        return own if faces is None else faces
    if not (faces.isascii() and faces.isdecimal()) or len(faces) > 9 or int(faces) < 3:
        raise InputError("--faces", 'an integer ≥ 3 or "cone"', brief(repr(faces)))
    return int(faces)


def say(out: Console, word: str, style: str, sentence: str) -> None:
    """Print a sentence after a coloured word."""
    out.print(Text.assemble((f"{word}: ", style), f"{sentence}."))
