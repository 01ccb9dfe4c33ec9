"""Pages as files: HTML that needs nothing else. What all kinds of pages share: their texts, their data, pictures."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from handlcp.version import VERSION
from handlcp.write_file import write_file


def web_files(*names: str, package: str = "handlcp.show.page") -> list[str]:
    """Texts of files in the folder `web` of a package."""
    web = files(package).joinpath("web")
    return [web.joinpath(name).read_text(encoding="utf-8") for name in names]


def write(target: Path, frame: str, title: str, style: str, parts: Mapping[str, str]) -> Path:
    """Fill in the frame of a page, in which each {{name}} stands for a part, write it and return the file.

    title : not yet HTML. style : CSS that comes after that of all pages. parts : by name, as HTML; what `data_of` gives
    is safe, too.

    Raises InputError for a file that cannot be written.
    """
    style = web_files("style.css")[0] + style
    every = {"title": escape(title), "style": style, "made": f"handlcp {escape(VERSION)}", **parts}
    text = re.sub(r"\{\{(\w+)\}\}", lambda m: every[m[1]], frame)
    return write_file("page", target, text)


def data_of(found: Any) -> str:
    """Numbers and texts as JSON that may stand in a script: none of it can end that, or a line of it."""
    data = json.dumps(found, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return data.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def image(png: bytes, alt: str) -> str:
    """A picture as HTML. alt : what it shows, not yet HTML."""
    code = base64.b64encode(png).decode("ascii")
    return f'<img alt="{escape(alt, quote=True)}" src="data:image/png;base64,{code}">'
