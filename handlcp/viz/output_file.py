"""Pictures and pages as files: where they may go, and what draws them."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Callable, Mapping
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, as_path, missing_library
from handlcp.version import VERSION
from handlcp.write_file import check_destination, write_file

Figure = Any  # matplotlib's, which is imported only when something is drawn

FILE_DPI = 160  # dots an inch
_PICTURE_FORMATS, _PAGE_FORMATS = (".png", ".svg", ".pdf", ".jpg"), (".html", ".htm")
_PAGE_EXPECTED = "the name of a file that ends in .html"


def check_picture_path(path: Any) -> Path:
    """The file to draw into, checked before a long computation.

    Raises InputError for an unknown format or a file that cannot be written; Unsupported without matplotlib.
    """
    new_figure()
    expected = "a file name that ends in " + ", ".join(_PICTURE_FORMATS)
    return _check_path("plot", path, expected, expected, _PICTURE_FORMATS)


def new_figure(**style: Any) -> Figure:
    """An empty figure that pyplot does not know about. Raises Unsupported when matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise missing_library("pictures need matplotlib", "matplotlib") from None
    return Figure(**style)


def draw_or_save(path: Any, draw: Callable[..., Figure], *what: Any) -> Any:
    """The figure that `draw` makes of these arguments; or the file that it was written to, where there is a path."""
    if path is None:
        return draw(*what)
    file = check_picture_path(path)
    made = io.BytesIO()
    draw(*what).savefig(made, dpi=FILE_DPI, facecolor="white", format=file.suffix[1:].lower())
    return write_file("plot", file, made.getvalue())


# ----------------------------------------------------------------
# Pages, and three.js that draws them, out of the package that bundles it: nothing is downloaded.

_VIEWER_BUNDLE = ("resources", "templates", "viewer.zip")  # within trimesh
_THREE_JS_PATTERN = re.compile(
    r"/\*\*\s+\* @license\s+\* Copyright[^*]*Three\.js.*?\"__esModule\",\{value:!0\}\)\}\)\);", re.S
)


def read_three_js() -> str:
    """Its code, with its licence on top. Raises Unsupported where trimesh is not installed, or comes without it."""
    spec = find_spec("trimesh")
    if spec is None or not spec.submodule_search_locations:
        raise missing_library("pages need trimesh, which brings their viewer", "trimesh")
    file = Path(spec.submodule_search_locations[0]).joinpath(*_VIEWER_BUNDLE)
    try:
        with zipfile.ZipFile(file) as bundle:
            texts = [bundle.read(name).decode("utf-8") for name in bundle.namelist()]
    except (OSError, zipfile.BadZipFile, UnicodeDecodeError):
        texts = []
    found = next((m.group() for text in texts if (m := _THREE_JS_PATTERN.search(text))), "")
    if not found or "</script" in found.lower():
        raise missing_library("pages need three.js as a newer trimesh brings it", "trimesh")
    return found


def check_page_path(path: Any) -> Path:
    """The page to write, checked before a long computation.

    Raises InputError for another format, or a file that cannot be written; Unsupported without the viewer's package.
    """
    read_three_js()
    formats = "a file name that ends in " + " or ".join(_PAGE_FORMATS)
    return _check_path("page", path, _PAGE_EXPECTED, formats, _PAGE_FORMATS)


def check_report_path(path: Any) -> Path:
    """The page without a viewer to write. Raises InputError as `check_page_path`."""
    return _check_path("path", path, _PAGE_EXPECTED, _PAGE_EXPECTED, _PAGE_FORMATS)


def _check_path(argument: str, path: Any, expected: str, formats: str, suffixes: tuple[str, ...]) -> Path:
    """A file that can be written. expected, formats : what the error says of no path, and of another suffix."""
    file = as_path(argument, path, expected)
    if file.suffix.lower() not in suffixes:
        raise InputError(argument, formats, repr(str(path)))
    return check_destination(argument, file)


# ----------------------------------------------------------------
# Pages as files: HTML that needs nothing else. What all kinds of pages share: their texts, their data.


def read_web_files(*names: str, package: str = "handlcp.viz.page") -> list[str]:
    """Texts of files in the folder `web` of a package."""
    web = files(package).joinpath("web")
    return [web.joinpath(name).read_text(encoding="utf-8") for name in names]


def write_page(target: Path, frame: str, title: str, style: str, parts: Mapping[str, str]) -> Path:
    """Fill in the frame of a page, in which each {{name}} stands for a part, write it and return the file.

    title : not yet HTML. style : CSS that comes after that of all pages. parts : by name, as HTML; what `script_data`
    gives is safe, too.

    Raises InputError for a file that cannot be written.
    """
    style = read_web_files("style.css")[0] + style
    every = {"title": escape(title), "style": style, "made": f"handlcp {escape(VERSION)}", **parts}
    text = re.sub(r"\{\{(\w+)\}\}", lambda m: every[m[1]], frame)
    return write_file("page", target, text)


def word_class(word: str) -> str:
    """The class of the style sheet for a verdict's word."""
    return {"HELD": "good", "UNDECIDED": "doubt"}.get(word, "bad")


def script_data(found: Any) -> str:
    """Numbers and texts as JSON that may stand in a script: none of it can end that, or a line of it."""
    data = json.dumps(found, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return data.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
