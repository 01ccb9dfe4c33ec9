"""Finger labels in two columns beside the picture, with lines to their contacts; none over another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from handlcp.check import Array
from handlcp.show.camera import Frame
from handlcp.show.overlay import INK

__all__ = ["Label", "place", "width"]

LINE = 0.50  # inches from one label to the next
NAME, DETAIL = 10.5, 9.5  # points


@dataclass(frozen=True, slots=True)
class Label:
    """at : (2,) screen point it belongs to. text, detail : two lines. colour : of the first."""

    at: Array
    text: str
    detail: str
    colour: str


def width(figure: Any, names: Sequence[str], details: Sequence[str]) -> float:
    """Inches that the widest line takes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(figure).get_renderer()
    widest = 0.0
    lines = [(n, NAME, "bold") for n in names] + [(d, DETAIL, "normal") for d in details]
    for line, size, weight in lines:
        text = figure.text(0, 0, line, fontsize=size, weight=weight)
        widest = max(widest, text.get_window_extent(renderer).width / figure.dpi)
        text.remove()
    return widest


def place(ax: Any, labels: Sequence[Label], frame: Frame) -> None:
    """Each in the nearer column, as close to its contact's height as its neighbours allow."""
    _, _, y0, y1 = frame.box
    left, right = frame.inner[0] - 0.10 * frame.inch, frame.inner[1] + 0.10 * frame.inch
    line, low, high = LINE * frame.inch, y0 + 0.75 * frame.inch, y1 - 0.05 * frame.inch
    room = max(1, int((high - low) / line))
    middle = sum(float(m.at[0]) for m in labels) / max(len(labels), 1)
    sides: tuple[list[Label], list[Label]] = ([], [])
    for label in sorted(labels, key=lambda m: float(m.at[0])):
        sides[int(label.at[0] > middle)].append(label)
    while len(sides[0]) > room:
        sides[1].append(sides[0].pop())
    while len(sides[1]) > room:
        sides[0].append(sides[1].pop(0))
    for side, x in zip(sides, (left, right), strict=True):
        side.sort(key=lambda m: -float(m.at[1]))
        heights = _spread([float(m.at[1]) for m in side], low + line / 2, high - line / 2, line)
        for label, y in zip(side, heights, strict=True):
            _one(ax, label, x, y, -1.0 if x == left else 1.0, frame.inch)


def _one(ax: Any, label: Label, x: float, y: float, way: float, inch: float) -> None:
    from matplotlib import patheffects

    casing = [patheffects.withStroke(linewidth=2.6, foreground="white", alpha=0.85)]
    ax.plot(
        [x, x - way * 0.12 * inch, label.at[0]],
        [y, y, label.at[1]],
        path_effects=casing,
        color=label.colour,
        linewidth=0.9,
        zorder=5,
        solid_capstyle="round",
    )
    ha, x = ("right" if way < 0 else "left"), x + way * 0.06 * inch
    ax.text(
        x, y + 0.01 * inch, label.text, ha=ha, va="bottom", color=label.colour, fontsize=NAME, weight="bold", zorder=9
    )
    ax.text(x, y - 0.02 * inch, label.detail, ha=ha, va="top", color=INK, fontsize=DETAIL, zorder=9)


def _spread(wanted: list[float], low: float, high: float, line: float) -> list[float]:
    """Falling heights near the wanted (falling) ones, at least a line apart, inside the room."""
    y = list(wanted)
    for k in range(len(y)):
        y[k] = min(y[k], high if k == 0 else y[k - 1] - line)
    floor = low
    for k in reversed(range(len(y))):
        y[k] = max(y[k], floor)
        floor = y[k] + line
    return y
