"""Pictures as files: where they may go, and what draws them."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, Unsupported, writing

Figure = Any  # matplotlib's, which is imported only when something is drawn

DPI = 160  # dots an inch
_FORMATS = (".png", ".svg", ".pdf", ".jpg")


def checked(path: Any) -> Path:
    """The file to draw into, checked before a long computation.

    Raises InputError for an unknown format or a file that cannot be written; Unsupported without matplotlib.
    """
    new_figure()
    file = Path(path)
    if file.suffix.lower() not in _FORMATS:
        raise InputError("plot", "a file name that ends in " + ", ".join(_FORMATS), repr(str(path)))
    return writable("plot", file)


def writable(argument: str, file: Path) -> Path:
    """The same file, checked before a long computation. Raises InputError where it cannot be written.

    What it holds stays as it is, and a file that did not exist does not exist afterwards.
    """
    try:
        if not file.absolute().parent.is_dir():
            raise InputError(argument, "a file in a folder that exists", repr(str(file)))
        is_new = not file.exists()
        with file.open("ab") as out:
            if stat.S_ISCHR(os.fstat(out.fileno()).st_mode) and not out.isatty():
                out.write(b"\n")  # /dev/full takes nothing, and such devices keep nothing
        if is_new:
            file.unlink()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        why = getattr(error, "strerror", None) or error
        raise InputError(argument, "a file that can be written", f"{str(file)!r}: {why}") from None
    return file


def new_figure(**style: Any) -> Figure:
    """An empty figure that pyplot does not know about. Raises Unsupported when matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise Unsupported("pictures need matplotlib: pip install 'handlcp[plot]'") from None
    return Figure(**style)


def write(figure: Figure, file: Path, dpi: int) -> Path:
    """Write the figure. Raises InputError for a file that cannot be written."""
    with writing("plot", file):
        figure.savefig(file, dpi=dpi, facecolor="white")
    return file


def drawn(figure: Callable[[Any, str], Any], answer: Any, path: Any, title: str) -> Any:
    """A figure, or the file that it was written to."""
    if path is None:
        return figure(answer, title)
    file = checked(path)
    return write(figure(answer, title), file, DPI)
