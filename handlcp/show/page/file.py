"""Where a page may be written, and writing it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handlcp.errors import InputError, writing
from handlcp.show.file import writable
from handlcp.show.page.library import three_js

_FORMATS = (".html", ".htm")


def checked(path: Any) -> Path:
    """The file to write, checked before a long computation.

    Raises InputError for another format, or a file that cannot be written; Unsupported without the viewer's package.
    """
    three_js()
    try:
        file = Path(path)
    except TypeError:
        raise InputError("page", "the name of a file that ends in .html", repr(path)[:80]) from None
    if file.suffix.lower() not in _FORMATS:
        raise InputError("page", "a file name that ends in " + " or ".join(_FORMATS), repr(str(path)))
    return writable("page", file)


def write(text: str, file: Path) -> Path:
    """Write the page. Raises InputError for a file that cannot be written."""
    with writing("page", file):
        file.write_text(text, encoding="utf-8", newline="\n")
    return file
