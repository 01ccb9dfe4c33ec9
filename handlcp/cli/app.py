"""The app that commands join, and what they share, such as `print_tables`.

Exit status: 0 for the verdict HELD; 1 for any other; 2 bad input, or output that cannot be written, with one message on
stderr; 130 after Ctrl-C; 141 where the reader of the output closed it, as `head` does.
"""

from __future__ import annotations

import codecs
import errno
import math
import os
import signal
import stat
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text
from typer.core import TyperGroup

from handlcp.errors import HandLCPError, InputError, shorten_text
from handlcp.grasp import Grasp
from handlcp.record import to_json_text
from handlcp.version import VERSION
from handlcp.viz.output_file import check_page_path, check_picture_path

if TYPE_CHECKING:
    from handlcp.scene import SceneFile


class _CommandGroup(TyperGroup):
    """Bad input, be it an option or a file, becomes one message on stderr and exit status 2."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args:  # the help
            return super().parse_args(ctx, args)
        with _report_refusals():
            if "" in args:  # as a path it would mean this folder
                raise InputError("an argument", "a file, a name or a number", "'', which is empty")
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        with _report_refusals():
            return super().invoke(ctx)


@contextmanager
def _report_refusals() -> Iterator[None]:
    try:
        yield
    except HandLCPError as error:
        _refuse(str(error))
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise
        what = "output" if error.filename is None else shorten_text(repr(error.filename))
        _refuse(f"{what}: {error.strerror or error}")
    except Exception as error:
        # Typer's own refusals of options; which class they have differs with its version
        if (message := getattr(error, "format_message", None)) is None:
            raise
        path = getattr(getattr(error, "ctx", None), "command_path", "handlcp")
        _refuse(f"{shorten_text(message().strip().rstrip('.'))}; `{path} --help` says what it takes")


def _refuse(message: str) -> NoReturn:
    """One message on stderr, exit status 2."""
    Console(stderr=True, soft_wrap=True).print(Text.assemble(("Error: ", "bold red"), message))
    raise typer.Exit(2) from None


app = typer.Typer(
    cls=_CommandGroup,
    name="handlcp",
    help="Does this hand hold this object under this load, with which grasp forces, what slips, which joint gives out?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

SceneArgument = Annotated[Path, typer.Argument(help="A scene file (TOML); `handlcp keys` lists what it may hold.")]
FacesOption = Annotated[str | None, typer.Option(help='Faces of the friction pyramids, or "cone", over the file\'s.')]
MotionOption = Annotated[
    float | None, typer.Option(help="How far the load may move the object, in m, such as 0.002; without: any distance.")
]
TurnOption = Annotated[
    float | None, typer.Option(help="How far the load may turn the object, in rad, such as 0.05; without: any angle.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, nothing else.")]


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"handlcp {VERSION}")
        raise typer.Exit


@app.callback()
def common_options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Grasp forces, slips and joint torques of robot hands."""


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object on stdout; numbers that are not finite become null. ASCII where stdout has nothing else."""
    text = to_json_text(value)
    try:
        text.encode(getattr(sys.stdout, "encoding", None) or "utf-8")
    except UnicodeEncodeError:
        text = to_json_text(value, ascii_only=True)
    typer.echo(text)


def open_console(title: str) -> Console:
    """The console, with the scene's title printed on it."""
    out = Console()
    if title:
        out.print(Text(title, style="bold"), end="\n\n")
    return out


def print_tables(out: Console, tables: Iterable[Table]) -> None:
    """Print tables one below the other, with an empty line after each.

    A table without a caption brings its empty line itself.
    """
    for table in tables:
        out.print(table)
        if table.caption:
            out.print()


def load_scene(path: Path) -> SceneFile:
    """The scene of a file. Raises SceneFileError."""
    from handlcp import scene  # pydantic, a third of a second that other commands do not pay

    return scene.load(path)


def choose_faces(own: Any, faces: str | None) -> Any:
    """Faces of the friction pyramids, or "cone", from --faces over the scene file's own. Raises InputError."""
    if faces is None or faces == "cone":
        return own if faces is None else faces
    if not (faces.isascii() and faces.isdecimal()) or len(faces) > 9 or int(faces) < 3:
        raise InputError("--faces", 'an integer ≥ 3 or "cone"', shorten_text(repr(faces)))
    return int(faces)


def follow_option(neither: str) -> Any:
    """The option --followed/--fixed, which says whether contacts follow hand and object.

    neither : what happens where neither is given, as the help says it.
    """
    sentence = "Follow hand and object as they move, or leave contacts where they are; neither"
    return typer.Option("--followed/--fixed", help=f"{sentence}: {neither}.")


def choose_geometry(followed: bool | None) -> str | None:
    """The geometry that --followed/--fixed asks for; None where neither was said."""
    return {None: None, True: "followed", False: "fixed"}[followed]


def check_motion_limits(grasp: Grasp, motion: float | None, turn: float | None = None) -> None:
    """Check that --motion is less than the size of the grasp, and --turn no more than half a turn.

    motion : [m]; None: not given.
    turn : [rad]; None: not given.

    Raises InputError, which asks whether millimetres or degrees were meant.
    """
    size = grasp.scene.units.length_unit
    if motion is not None and motion > size:
        meant = f"{motion:g} (millimetres? They are {1e-3 * motion:g} m)"
        raise InputError("--motion", f"m, less than the size of the grasp, {size:.3g} m", meant)
    if turn is not None and turn > math.pi:
        meant = f"{turn:g} (degrees? They are {math.radians(turn):.3g} rad)"
        raise InputError("--turn", "rad, no more than half a turn", meant)


def check_output_files(*pictures: Path | None, page: Path | None = None) -> None:
    """Check before a long computation that pictures and page can be written. Raises InputError, Unsupported."""
    for file in pictures:
        if file is not None:
            check_picture_path(file)
    if page is not None:
        check_page_path(page)


def print_files(out: Console, **written: Sequence[Path | None]) -> None:
    """Print which files were written, by what they are, such as Picture=[...]."""
    for what, files in written.items():
        for file in files:
            if file is not None:
                out.print(Text(f"{what}: {file}", style="dim"))


def print_sentence(out: Console, word: str, style: str, sentence: str) -> None:
    """Print a sentence after a coloured word."""
    out.print(Text.assemble((f"{word}: ", style), f"{sentence}."))


# ----------------------------------------------------------------
# Where the output goes: pipes that close, full disks, terminals without UTF-8, and libraries that print.

# What the package's words and tables use beyond ASCII, for terminals that cannot show it: a spelling, and after it the
# characters that are written so
_SPELLINGS = """
    - –—−─━   ... …   . ·    * •     # █     | │┃‖   x ×   / ÷   +- ±   ~ ≈∝∼   <= ≤   >= ≥   != ≠   << ≪   >> ≫   inf ∞
    u µ       _|_ ⟂   -> →   <- ←    ^ ↑     v ↓     ok ✓  no ✗  in ∈   d ∂     " “”„  ' ‘’   ss ß
"""
_spelling_words = iter(_SPELLINGS.split())
_ASCII_SPELLINGS = {"√": "sqrt ", "Σ": "sum ", "°": " deg"}
_ASCII_SPELLINGS |= {
    character: plain for plain, every in zip(_spelling_words, _spelling_words, strict=True) for character in every
}


def prepare_streams() -> None:
    """Make stdout this program's own, and both streams able to print anything. Ends the program where stdout has no
    room.

    What C code prints on stdout, such as a stray line of HiGHS, is discarded. A reader that closes the pipe, such as
    `head`, ends the program without a word, as it does others (141 in the shell).
    """
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    codecs.register_error("spelt", spell_in_ascii)
    out = sys.stdout
    for stream in (out, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="spelt")
    if not isinstance(out, TextIOWrapper) or out is not sys.__stdout__:
        return
    if is_full_device(1):
        report_lost_output()
        raise SystemExit(2)
    ours, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = open(ours, "w", encoding=out.encoding, errors="spelt")  # noqa: SIM115


def is_full_device(descriptor: int) -> bool:
    """Whether a descriptor leads to a device that takes nothing, such as /dev/full.

    This is asked before the work; whether a disk is full is known afterwards.
    """
    if not stat.S_ISCHR(os.fstat(descriptor).st_mode) or os.isatty(descriptor):
        return False
    try:
        os.write(descriptor, b"\n")  # such a device keeps nothing
    except OSError:
        return True
    return False


def report_lost_output(why: str = "No space left on device") -> None:
    """Say on stderr that stdout took no output, and keep quiet about what is still in its buffer."""
    print(f"Error: output: expected a stream that takes it, got {why}", file=sys.stderr)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def spell_in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Spell characters that an encoding lacks in ASCII: an error handler as `codecs.register_error` takes it."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_spell_character(c) for c in error.object[error.start : error.end]), error.end


def _spell_character(character: str) -> str:
    if (known := _ASCII_SPELLINGS.get(character)) is not None:
        return known
    if unicodedata.combining(character):
        return ""
    name = unicodedata.name(character, "")
    if name.startswith(("GREEK SMALL LETTER ", "GREEK CAPITAL LETTER ")):
        letter = name.split()[3].lower()
        return letter if "SMALL" in name else letter.capitalize()
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return plain or "?"
