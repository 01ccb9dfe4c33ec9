"""Labels of contacts in a column on each side of the picture, with lines to their contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from handlcp.check import Array
from handlcp.show.picture.camera import Frame
from handlcp.show.style import INK, spread, width

__all__ = ["Label", "place", "widest"]

LINE = 0.50  # inches from one label to the next
NAME, DETAIL = 10.5, 9.5  # points


@dataclass(frozen=True, slots=True)
class Label:
    """name in `colour`, and `detail` below it. at (2,) : screen point that the label belongs to."""

    at: Array
    name: str
    detail: str
    colour: str


def widest(figure: Any, names: Sequence[str], details: Sequence[str]) -> float:
    """Width of the widest line in inches."""
    widths = [width(figure, name, fontsize=NAME, weight="bold") for name in names]
    widths += [width(figure, detail, fontsize=DETAIL) for detail in details]
    return max(widths, default=0.0) / float(figure.dpi)


def place(ax: Any, labels: Sequence[Label], frame: Frame) -> None:
    """Each label in the nearer column, as close to its contact's height as its neighbours allow."""
    _, _, y0, y1 = frame.box
    line, low, high = LINE * frame.inch, y0 + 0.75 * frame.inch, y1 - 0.05 * frame.inch
    room = max(1, int((high - low) / line))
    middle = sum(float(m.at[0]) for m in labels) / max(len(labels), 1)
    ordered = sorted(labels, key=lambda m: float(m.at[0]))
    left, right = [m for m in ordered if m.at[0] <= middle], [m for m in ordered if m.at[0] > middle]
    while len(left) > room:
        right.append(left.pop())
    while len(right) > room:
        left.append(right.pop(0))
    for column, x, way in ((left, frame.inner[0], -1.0), (right, frame.inner[1], 1.0)):
        column.sort(key=lambda m: -float(m.at[1]))
        # The column is filled from the top, `spread` counts upwards: heights change sign
        depths = spread([-float(m.at[1]) - line / 2 for m in column], [line] * len(column), -high, -low)
        for label, depth in zip(column, depths, strict=True):
            _draw(ax, label, x + way * 0.10 * frame.inch, -depth - line / 2, way, frame.inch)


def _draw(ax: Any, label: Label, x: float, y: float, way: float, inch: float) -> None:
    """The label beside (x, y), and a line from there to its contact. way : -1 in the left column, 1 in the right."""
    from matplotlib import patheffects

    casing = [patheffects.withStroke(linewidth=2.6, foreground="white", alpha=0.85)]
    bend = x - way * 0.12 * inch
    ax.plot([x, bend, label.at[0]], [y, y, label.at[1]], path_effects=casing, color=label.colour, linewidth=0.9,
            zorder=5, solid_capstyle="round")  # fmt: skip
    beside = {"x": x + way * 0.06 * inch, "ha": "right" if way < 0 else "left", "zorder": 9}
    ax.text(y=y + 0.01 * inch, s=label.name, va="bottom", color=label.colour, fontsize=NAME, weight="bold", **beside)
    ax.text(y=y - 0.02 * inch, s=label.detail, va="top", color=INK, fontsize=DETAIL, **beside)
