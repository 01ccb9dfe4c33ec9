"""The package's docstrings, which are plain text, as reStructuredText.

A paragraph that begins with "name : …" is a list of names; an indented paragraph after a blank line is code, or a
formula; `name` in backticks links to the public name, if it is one. Everything else is text.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from typing import Any

import handlcp

__all__ = ["as_rst", "inline", "setup"]

_NAMES = r"[A-Za-z_]\w*(?:, [A-Za-z_]\w*)*"
_ITEM = re.compile(rf"({_NAMES}) : ")
_LATER = re.compile(rf"(?<=[.;)]) ({_NAMES}) : ")  # a further name on the same line
_CODE = re.compile(r"`([^`]+)`")
_PUBLIC = set(handlcp.__all__)
_BARE = re.compile(r"\b[A-Z][a-zA-Z]*(?:Error|Found|Reached|Name|Unsupported)\b|\bUnsupported\b")
# Values that the package makes: how they are made says nothing to those who read them
_RESULTS = {
    "Accuracy", "AccuracyCost", "Audit", "Candidate", "Doubt", "Equilibria", "Explanation", "Found", "GraspProblem",
    "GraspSolution", "GraspUpdate", "Hand", "HandDescription", "HandGrasp", "HandGraspSolution", "HandState",
    "LCPSolution", "Loading", "Reason", "Required", "Residuals", "Solutions", "Status", "Suggestions", "TorqueCheck",
    "Uniqueness", "Verdict",
}  # fmt: skip


def inline(text: str) -> str:
    """One run of text: backticks become links or literals, characters that mean something to Sphinx are escaped."""
    parts = _CODE.split(text)
    return "".join(_code(part) if k % 2 else _plain(part) for k, part in enumerate(parts))


def _plain(text: str) -> str:
    escaped = re.sub(r"([\\*|_`])", r"\\\1", text)
    return _BARE.sub(lambda m: _code(m[0]) if m[0] in _PUBLIC else m[0], escaped)


def _code(text: str) -> str:
    name, _, member = text.removesuffix("()").partition(".")
    known = name in _PUBLIC and (not member or hasattr(getattr(handlcp, name), member))
    return f"\\ :py:obj:`{text} <handlcp.{text.removesuffix('()')}>`\\ " if known else f"\\ ``{text}``\\ "


def as_rst(lines: Sequence[str]) -> list[str]:
    """A docstring, its indentation taken off, as lines of reStructuredText."""
    out: list[str] = []
    for block in _blocks(lines):
        if all(line.startswith("    ") for line in block):
            out += [f".. code-block:: {'python' if _is_python(block) else 'text'}", "", *block, ""]
        elif len(block) > 1 and set(block[1]) == {"-"}:
            out += [f"**{block[0]}**", "", *_paragraph(block[2:])]
        else:
            out += _paragraph(block)
    return out


def _blocks(lines: Sequence[str]) -> Iterator[list[str]]:
    block: list[str] = []
    for line in [*lines, ""]:
        if block and (not line.strip() or line.startswith("Raises ")):
            yield block
            block = []
        if line.strip():
            block.append(line.rstrip())


def _is_python(block: list[str]) -> bool:
    try:
        tree = ast.parse("\n".join(line[4:] for line in block))
    except SyntaxError:
        return False
    return any(isinstance(node, (ast.Call, ast.Import)) for node in ast.walk(tree))


def _paragraph(block: list[str]) -> list[str]:
    """Text; or from the first line on that begins with names, a list of them."""
    first = next((k for k, line in enumerate(block) if _ITEM.match(line)), len(block))
    out = [inline(" ".join(line.strip() for line in block[:first])), ""] if first else []
    for names, text in _items(block[first:]):
        out += [", ".join(f"``{name}``" for name in names.split(", ")), f"    {inline(text)}", ""]
    return out


def _items(block: list[str]) -> Iterator[tuple[str, str]]:
    whole = ""
    for line in [*block, ""]:
        if whole and (not line or _ITEM.match(line)):
            found = _LATER.split(whole)
            head, text = found[0].split(" : ", 1)
            yield head, text
            yield from zip(found[1::2], found[2::2], strict=True)
            whole = ""
        whole = f"{whole} {line.strip()}".strip()


def _docstring(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = as_rst(lines)


def _signature(app: Any, what: str, name: str, obj: Any, options: Any, args: str | None, returns: str | None) -> Any:
    hidden = what == "class" and name.rpartition(".")[2] in _RESULTS
    return ("", None) if hidden else (args, returns)


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", _docstring)
    app.connect("autodoc-process-signature", _signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
