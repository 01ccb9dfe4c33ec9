"""Where a page may be written, and writing it."""

from __future__ import annotations

import re
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, Unsupported, writing
from handlcp.show.file import writable

# ----------------------------------------------------------------
# three.js, the drawing library of the page, out of the package that bundles it: nothing is downloaded.

_BUNDLE = ("resources", "templates", "viewer.zip")  # within trimesh
_LIBRARY = re.compile(r"/\*\*\s+\* @license\s+\* Copyright[^*]*Three\.js.*?\"__esModule\",\{value:!0\}\)\}\)\);", re.S)


def three_js() -> str:
    """Its code, with its licence on top. Raises Unsupported where trimesh is not installed, or comes without it."""
    spec = find_spec("trimesh")
    if spec is None or not spec.submodule_search_locations:
        raise Unsupported("pages need trimesh, which brings their viewer: pip install 'handlcp[page]'")
    file = Path(spec.submodule_search_locations[0]).joinpath(*_BUNDLE)
    try:
        with zipfile.ZipFile(file) as bundle:
            texts = [bundle.read(name).decode("utf-8") for name in bundle.namelist()]
    except (OSError, zipfile.BadZipFile, UnicodeDecodeError):
        texts = []
    found = next((m.group() for text in texts if (m := _LIBRARY.search(text))), "")
    if not found or "</script" in found.lower():
        raise Unsupported("pages need three.js as a newer trimesh brings it: pip install --upgrade 'handlcp[page]'")
    return found


# ----------------------------------------------------------------

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
