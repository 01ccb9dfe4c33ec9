"""three.js, the drawing library of the page, out of the package that bundles it: nothing is downloaded."""

from __future__ import annotations

import re
import zipfile
from importlib.util import find_spec
from pathlib import Path

from handlcp.errors import Unsupported

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
