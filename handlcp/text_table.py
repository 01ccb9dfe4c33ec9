"""Tables as plain text, and the width that everything printed keeps to."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

WIDTH = 80  # columns of what is printed
_GAP, _LEAST = "  ", 8  # between columns; the narrowest that the first one becomes


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table that prints as plain text within 80 columns; a first column that is too wide goes on in further lines.

    heads : of the columns; a unit stands in a second line.
    rows : as many cells each.
    align : "<" or ">" for each column.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str

    def __str__(self) -> str:
        heads = [head.split("\n") for head in self.heads]
        tall = max(len(head) for head in heads)
        top = [[head[k] if k < len(head) else "" for head in heads] for k in range(tall)]
        widths = [max(len(line[j]) for line in (*top, *self.rows)) for j in range(len(heads))]
        others = sum(widths[1:]) + len(_GAP) * (len(widths) - 1)
        widths[0] = max(min(widths[0], WIDTH - others), _LEAST)
        lines = [self._line(cells, widths) for cells in top]
        for first, *rest in self.rows:
            pieces = textwrap.wrap(first, widths[0], break_on_hyphens=False) or [""]
            lines += [self._line([pieces[0], *rest], widths), *pieces[1:]]
        return "\n".join(lines)

    def _line(self, cells: Sequence[str], widths: Sequence[int]) -> str:
        placed = [f"{cell:{way}{width}}" for cell, way, width in zip(cells, self.align, widths, strict=True)]
        return _GAP.join(placed).rstrip()


def wrapped(text: str, indent: str = "", first: str = "") -> str:
    """The text in lines of at most 80 columns; words that are longer are cut.

    first, indent : what the first line begins with, and all others.
    """
    short = textwrap.TextWrapper(WIDTH, initial_indent=first, subsequent_indent=indent, break_on_hyphens=False)
    return "\n".join(short.wrap(text))
