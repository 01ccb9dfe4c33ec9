"""Pictures and pages as files: where they may go, and what draws them."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, as_path
from handlcp.extras import missing
from handlcp.write_file import check_destination, write_file

Figure = Any  # matplotlib's, which is imported only when something is drawn

DPI = 160  # dots an inch
_FORMATS, _PAGES = (".png", ".svg", ".pdf", ".jpg"), (".html", ".htm")


def checked(path: Any) -> Path:
    """The file to draw into, checked before a long computation.

    Raises InputError for an unknown format or a file that cannot be written; Unsupported without matplotlib.
    """
    new_figure()
    file = as_path("plot", path, "a file name that ends in " + ", ".join(_FORMATS))
    if file.suffix.lower() not in _FORMATS:
        raise InputError("plot", "a file name that ends in " + ", ".join(_FORMATS), repr(str(path)))
    return check_destination("plot", file)


def new_figure(**style: Any) -> Figure:
    """An empty figure that pyplot does not know about. Raises Unsupported when matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise missing("pictures need matplotlib", "matplotlib") from None
    return Figure(**style)


def drawn(path: Any, draw: Callable[..., Figure], *what: Any) -> Any:
    """The figure that `draw` makes of these arguments; or the file that it was written to, where there is a path."""
    if path is None:
        return draw(*what)
    file = checked(path)
    made = io.BytesIO()
    draw(*what).savefig(made, dpi=DPI, facecolor="white", format=file.suffix[1:].lower())
    return write_file("plot", file, made.getvalue())


# ----------------------------------------------------------------
# Pages, and three.js that draws them, out of the package that bundles it: nothing is downloaded.

_BUNDLE = ("resources", "templates", "viewer.zip")  # within trimesh
_LIBRARY = re.compile(r"/\*\*\s+\* @license\s+\* Copyright[^*]*Three\.js.*?\"__esModule\",\{value:!0\}\)\}\)\);", re.S)


def three_js() -> str:
    """Its code, with its licence on top. Raises Unsupported where trimesh is not installed, or comes without it."""
    spec = find_spec("trimesh")
    if spec is None or not spec.submodule_search_locations:
        raise missing("pages need trimesh, which brings their viewer", "trimesh")
    file = Path(spec.submodule_search_locations[0]).joinpath(*_BUNDLE)
    try:
        with zipfile.ZipFile(file) as bundle:
            texts = [bundle.read(name).decode("utf-8") for name in bundle.namelist()]
    except (OSError, zipfile.BadZipFile, UnicodeDecodeError):
        texts = []
    found = next((m.group() for text in texts if (m := _LIBRARY.search(text))), "")
    if not found or "</script" in found.lower():
        raise missing("pages need three.js as a newer trimesh brings it", "trimesh")
    return found


def checked_page(path: Any) -> Path:
    """The page to write, checked before a long computation.

    Raises InputError for another format, or a file that cannot be written; Unsupported without the viewer's package.
    """
    three_js()
    file = as_path("page", path, "the name of a file that ends in .html")
    if file.suffix.lower() not in _PAGES:
        raise InputError("page", "a file name that ends in " + " or ".join(_PAGES), repr(str(path)))
    return check_destination("page", file)
