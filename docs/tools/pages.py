"""Pages whose text stands elsewhere in the repository, and the table of keys that the package itself writes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sphinx.errors import ExtensionError

__all__ = ["KEYS", "TEXTS", "keys_table", "relinked", "setup"]

ROOT = Path(__file__).parents[2]
TEXTS = {  # page: the file that it shows
    "theory/effects": "handlcp/grasp/effects/README.md",
    "inside": "handlcp/README.md",
    "contributing": "CONTRIBUTING.md",
    "changelog": "CHANGELOG.md",
}
KEYS = {"<!-- keys of a scene file -->": "scene", "<!-- keys of a brief -->": "brief"}
_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((?!https?:|#|mailto:)([^)#\s]+)(#[^)\s]+)?\)")


def relinked(text: str, file: str, page: str) -> str:
    """Links of a repository file, for the page that shows it: to other pages, or plain text where there is no page."""
    depth = "../" * page.count("/")
    homes = {(ROOT / shown).resolve(): f"{depth}{name}.md" for name, shown in TEXTS.items()}
    homes |= {p.resolve(): depth + p.relative_to(ROOT / "docs").as_posix() for p in (ROOT / "docs").rglob("*.md")}

    def new(link: re.Match[str]) -> str:
        target = ((ROOT / file).parent / link[2]).resolve()
        if not target.exists():
            raise ExtensionError(f"{file}: there is no {link[2]}")
        name = target.relative_to(ROOT.resolve()).as_posix()
        return f"[{link[1]}]({homes[target]}{link[3] or ''})" if target in homes else f"`{name}`"

    return _LINK.sub(new, text)


def keys_table(file: str) -> str:
    """Every key of a "scene" or a "brief", as `handlcp keys` lists them, a table for each part of the file."""
    from handlcp.design.brief_file import BriefTables
    from handlcp.scene import keys

    return "\n".join(_tables(keys() if file == "scene" else keys(BriefTables)))


def _tables(keys: Any) -> Iterator[str]:
    part = None
    for key in keys:
        if key.table != part:
            part = key.table
            head = f"`[{part}]`" if part else "At the top of the file"
            yield f"\n### {head}\n\n| key | what it holds | meaning |\n| --- | --- | --- |"
        cells = (f"`{key.key}`", key.expected, key.meaning)
        yield "| " + " | ".join(cell.replace("|", "\\|").replace("<", "&lt;") for cell in cells) + " |"


def _read(app: Any, page: str, source: list[str]) -> None:
    if page in TEXTS:
        app.env.note_dependency(ROOT / TEXTS[page])
        source[0] = relinked((ROOT / TEXTS[page]).read_text(encoding="utf-8"), TEXTS[page], page)
    elif any(mark in source[0] for mark in KEYS):
        for mark, file in KEYS.items():
            source[0] = source[0].replace(mark, keys_table(file))


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
