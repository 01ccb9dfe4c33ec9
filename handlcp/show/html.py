"""A solution for notebooks: the verdict, the contacts and the joints as one piece of HTML with its style in it."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from handlcp.grasp import GraspSolution
from handlcp.grasp.solution.solution import contact_text_table
from handlcp.text_table import TextTable

_COLOURS = {"HELD": "#00734d", "UNDECIDED": "#8a6100"}  # the rest is red
_BAD = "#b03a00"
_CELL = "padding:2px 10px 2px 0;border:none;background:none;white-space:nowrap"
_RULE = "border-bottom:1px solid #8886"


def html(solution: GraspSolution) -> str:
    """A solution as one piece of HTML: verdict, contacts and joint torques, as a notebook shows it.

    Colours are readable on white and on black.
    """
    (word, text), *rest = solution.verdict.paragraphs
    colour = _COLOURS.get(word, _BAD)
    parts = [f'<p style="margin:0 0 6px"><b style="color:{colour}">{escape(word)}</b>: {escape(text)}.</p>']
    parts += [f'<p style="margin:0 0 6px"><b>{escape(head)}</b>: {escape(said)}.</p>' for head, said in rest]
    if solution.held:
        parts.append(_table(contact_text_table(solution), [""] * len(solution.names)))
        if (check := getattr(solution, "torque_check", None)) is not None:
            parts.append(_table(check.table, [_bar(r) for r in check]))
    return f'<div style="max-width:46em">{"".join(parts)}</div>'


def table_html(table: TextTable) -> str:
    """A text table as a table in HTML, for notebooks."""
    return _table(table, [""] * len(table.rows))


def text_html(value: Any) -> str:
    """The printed text of a value, line by line, as HTML."""
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
