"""A solution for notebooks: the verdict, the contacts and the joints as one piece of HTML with its style in it."""

from __future__ import annotations

import os
import stat
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.errors import InputError, Unsupported, writing
from handlcp.grasp import GraspSolution
from handlcp.grasp.answer.printed import contact_columns
from handlcp.text_table import TextTable

# ----------------------------------------------------------------
# Pictures as files: where they may go, and what draws them.

Figure = Any  # matplotlib's, which is imported only when something is drawn

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


# ----------------------------------------------------------------

_COLOURS = {"HELD": "#00734d", "UNDECIDED": "#8a6100"}  # the rest is red
_BAD = "#b03a00"
_CELL = "padding:2px 10px 2px 0;border:none;background:none;white-space:nowrap"
_RULE = "border-bottom:1px solid #8886"


def html(solution: GraspSolution) -> str:
    """See `GraspSolution._repr_html_`. Colours are readable on white and on black."""
    (word, text), *rest = solution.verdict.paragraphs
    colour = _COLOURS.get(word, _BAD)
    parts = [f'<p style="margin:0 0 6px"><b style="color:{colour}">{escape(word)}</b>: {escape(text)}.</p>']
    parts += [f'<p style="margin:0 0 6px"><b>{escape(head)}</b>: {escape(said)}.</p>' for head, said in rest]
    if solution.held:
        parts.append(_table(contact_columns(solution), [""] * len(solution.names)))
        if (check := getattr(solution, "torque_check", None)) is not None:
            parts.append(_table(check.table, [_bar(r) for r in check]))
    return f'<div style="max-width:46em">{"".join(parts)}</div>'


def table_html(table: TextTable) -> str:
    """A table alone."""
    return _table(table, [""] * len(table.rows))


def text_html(value: Any) -> str:
    """What prints, in its lines."""
    return f'<pre style="margin:0;background:none">{escape(str(value))}</pre>'


def _table(table: TextTable, bars: list[str]) -> str:
    """Every column right or left as in print; bars : what stands behind each row."""
    ways = ["right" if way == ">" else "left" for way in table.align]
    heads = "".join(
        f'<th style="{_CELL};{_RULE};text-align:{way};font-weight:600;vertical-align:bottom">'
        f"{escape(head).replace(chr(10), '<br>')}</th>"
        for head, way in zip(table.heads, ways, strict=True)
    )
    lines = []
    for row, bar in zip(table.rows, bars, strict=True):
        cells = [
            f'<td style="{_CELL};text-align:{way};font-variant-numeric:tabular-nums">{escape(cell)}</td>'
            for cell, way in zip(row, ways, strict=True)
        ]
        lines.append(f"<tr>{''.join(cells[:-1])}{_beside(cells[-1], bar)}</tr>")
    body = "".join(lines)
    return (
        '<table style="border-collapse:collapse;border:none;margin:0 0 8px;font-size:90%">'
        f"<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"
    )


def _beside(cell: str, bar: str) -> str:
    """The last cell, its bar before its words."""
    return cell.replace('">', f'">{bar}', 1) if bar else cell


def _bar(row: Any) -> str:
    """How much of its limit a joint uses; nothing where none is known."""
    if not (row.known and np.isfinite(row.limit)):
        return ""
    share = min(row.utilisation, 1.0)
    colour = _BAD if row.over else "#2a78b8"
    return (
        '<span style="display:inline-block;width:60px;height:8px;background:#8883;margin-right:8px">'
        f'<span style="display:block;width:{60 * share:.0f}px;height:8px;background:{colour}"></span></span>'
    )
