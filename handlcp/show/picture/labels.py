"""Labels of contacts in a column on each side of the picture, with lines to their contacts that do not cross."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.show.picture.camera import Frame
from handlcp.show.style import INK, shortened, spread, width

LINE = 0.46  # inches from one label to the next
NAME, DETAIL = 10.5, 9.5  # points
LETTERS = 24  # of a name
ABOVE = 0.05  # inches from the picture's upper edge to the columns
BELOW_LEFT, BELOW_RIGHT = 1.05, 0.62  # inches from its lower edge, where axes and scales are
ASIDE = 0.10  # inches from the picture to a column
BEND, GAP = 0.12, 0.06  # inches: the level part of a line, from there to the text


@dataclass(frozen=True, slots=True)
class Label:
    """The label of one contact, or of several that share it.

    at (k, 2) : screen points that the label belongs to [m]; its line leads to the nearest one.
    name : written in `colour`. detail : written below it.
    """

    at: Array
    name: str
    detail: str
    colour: str


def room(inches: float) -> int:
    """How many labels there is room for in a picture of this height."""
    return sum(_rows(inches - ABOVE - below) for below in (BELOW_LEFT, BELOW_RIGHT))


def widest(figure: Any, names: Sequence[str], details: Sequence[str]) -> float:
    """Width of the widest line in inches."""
    widths = [width(figure, name, fontsize=NAME, weight="bold") for name in names]
    widths += [width(figure, detail, fontsize=DETAIL) for detail in details]
    return max(widths, default=0.0) / float(figure.dpi)


def place(ax: Any, labels: Sequence[Label], frame: Frame) -> None:
    """Each label in the nearer column where that has room, as close to its contact's height as its neighbours allow."""
    _, _, y0, y1 = frame.box
    line, high = LINE * frame.inch, y1 - ABOVE * frame.inch
    lows = [y0 + below * frame.inch for below in (BELOW_LEFT, BELOW_RIGHT)]
    rooms = [max(1, _rows((high - low) / frame.inch)) for low in lows]
    centres = [float(m.at[:, 0].mean()) for m in labels]
    middle = sum(centres) / max(len(centres), 1)
    ordered = [labels[i] for i in np.argsort(centres, kind="stable")]
    first = sum(c <= middle for c in centres)
    first = min(max(first, len(ordered) - rooms[1]), rooms[0])
    sides = (ordered[:first], frame.inner[0], -1.0), (ordered[first:], frame.inner[1], 1.0)
    short = dict(zip([m.name for m in labels], shortened([m.name for m in labels], LETTERS), strict=True))
    for (column, x, way), low in zip(sides, lows, strict=True):
        start = x + way * ASIDE * frame.inch
        ends = [m.at[int(np.argmin(abs(m.at[:, 0] - start)))] for m in column]
        # The column is filled from the top, `spread` counts upwards: heights change sign
        order = np.argsort([-float(p[1]) for p in ends], kind="stable")
        depths = spread([-float(ends[i][1]) - line / 2 for i in order], [line] * len(column), -high, -low)
        heights = [-depth - line / 2 for depth in depths]
        bend = start - way * BEND * frame.inch
        for i, y in zip(_uncrossed([int(k) for k in order], heights, ends, bend), heights, strict=True):
            _draw(ax, column[i], short[column[i].name], ends[i], (start, bend, y, way * GAP * frame.inch))


def _rows(inches: float) -> int:
    return int(inches / LINE)


def _uncrossed(order: list[int], heights: Sequence[float], ends: Sequence[Array], x: float) -> list[int]:
    """Which label stands at which height, so that no two lines from (x, height) to their ends cross.

    Two labels whose lines cross change places, which shortens the lines: so it comes to an end.
    """
    order, changed = list(order), True
    while changed:
        changed = False
        for i in range(len(order)):
            for j in range(i + 1, len(order)):
                lines = [(np.array([x, heights[k]]), ends[order[k]]) for k in (i, j)]
                if _cross(*lines[0], *lines[1]):
                    order[i], order[j], changed = order[j], order[i], True
    return order


def _cross(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Whether the lines from a to b and from c to d cross."""

    def side(p: Array, q: Array, r: Array) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def _draw(ax: Any, label: Label, name: str, end: Array, where: tuple[float, float, float, float]) -> None:
    """The label, and a line from there to its contact. where : the line's start and bend, its height, and how far the
    text is from it, negative in the left column.
    """
    from matplotlib import patheffects

    start, bend, y, aside = where
    casing = [patheffects.withStroke(linewidth=2.6, foreground="white", alpha=0.85)]
    line: dict[str, Any] = {"path_effects": casing, "linewidth": 0.9, "zorder": 5, "solid_capstyle": "round"}
    ax.plot([start, bend, end[0]], [y, y, end[1]], color=label.colour, **line)
    beside = {"x": start + aside, "ha": "right" if aside < 0 else "left", "zorder": 9}
    gap = abs(aside) / GAP
    ax.text(y=y + 0.01 * gap, s=name, va="bottom", color=label.colour, fontsize=NAME, weight="bold", **beside)
    ax.text(y=y - 0.02 * gap, s=label.detail, va="top", color=INK, fontsize=DETAIL, **beside)
