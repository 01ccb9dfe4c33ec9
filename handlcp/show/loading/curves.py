"""One panel of a loading: its curves, and their names at the right edge."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.show.axes import TEXT
from handlcp.show.axes import panel as frame
from handlcp.show.loading.axis import Axis
from handlcp.show.loading.series import Curve, Panel
from handlcp.show.style import INK, spread

LETTERS = 29  # of a line of names
ALIKE = 0.01  # of the panel's height: curves no further apart than this share a name
ROW = 0.165  # inches of a line of a name
ASIDE = 0.12  # inches from the panel to the names


def draw_panel(ax: Any, axis: Axis, panel: Panel, last: bool) -> None:
    """Curves, limit, names. last : whether it is the lowest one, which names the stages."""
    frame(ax, panel.title, "", "")
    axis.ticks(ax, last)
    for c in panel.curves:
        ax.plot(axis.at, c.values, color=c.colour, linewidth=1.6 if c.name else 0.9, zorder=3 if c.name else 2.5)
        if np.isfinite(c.values[-1]):
            ax.plot(axis.at[-1:], c.values[-1:], "o", color=c.colour, markersize=3.2, clip_on=False, zorder=5)
    _limits(ax, panel)
    if panel.limit is not None:
        ax.axhline(panel.limit, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)), zorder=1.7)
    _write(ax, axis, _labels(ax, panel))


def _limits(ax: Any, panel: Panel) -> None:
    """Room above and below the curves; zero is always shown."""
    also = [0.0] if panel.limit is None else [0.0, panel.limit]
    every = np.concatenate([*(c.values for c in panel.curves), also])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    if high - low < panel.least:
        low, high = 0.0, 1.0
    span = high - low
    ax.set_ylim(low - (0.08 * span if low < 0.0 else 0.0), high + 0.08 * span)
    ax.ticklabel_format(axis="y", style="plain", useOffset=False)


Label = tuple[float, str, str]  # height of the curve's end as a share of the panel's, name, colour


def _labels(ax: Any, panel: Panel) -> list[Label]:
    """One for each group of curves that lie on each other, from below; none for curves that end before the last step,
    such as the friction of a finger that has let go.
    """
    low, high = ax.get_ylim()
    groups = list[list[Curve]]()
    for c in panel.curves:
        if not c.name or not np.isfinite(c.values[-1]):
            continue
        for group in groups:
            if _same(group[0].values, c.values, ALIKE * (high - low)):
                group.append(c)
                break
        else:
            groups.append([c])
    out = []
    for group in reversed(groups):
        first, *rest = [c.name for c in group]
        alike = f"{first} and {len(rest)} alike" if len(rest) > 1 else ", ".join([first, *rest])
        name = panel.every if len(group) == len(panel.curves) > 1 else alike
        top = group[-1]  # the curve that is drawn over the others
        out.append((float((top.values[-1] - low) / (high - low)), name, top.colour))
    return sorted(out, key=lambda label: round(label[0], 3))


def _same(a: Array, b: Array, near: float) -> bool:
    both = np.isfinite(a) & np.isfinite(b)
    return bool((np.isfinite(a) == np.isfinite(b)).all() and (abs(a - b)[both] <= near).all())


def _write(ax: Any, axis: Axis, labels: list[Label]) -> None:
    """Names at the right edge, as near to the ends of their curves as there is room, each with a line to there."""
    box, dpi = ax.get_window_extent(), ax.figure.dpi
    texts = [textwrap.fill(name, LETTERS, break_long_words=False) for _, name, _ in labels]
    row = ROW * dpi / box.height
    sizes = [row * (1 + text.count("\n")) for text in texts]
    wanted = [height - size / 2 for (height, _, _), size in zip(labels, sizes, strict=True)]
    places = spread(wanted, sizes, -np.inf, 1.25)
    inch = dpi / box.width
    x, bend, text_at = float(axis.at[-1] / axis.end), 1.0 + 0.03 * inch, 1.0 + ASIDE * inch
    for (height, _, colour), text, size, low in zip(labels, texts, sizes, places, strict=True):
        middle = low + size / 2
        leader = [x, bend, text_at - 0.04 * inch], [height, height, middle]
        ax.plot(*leader, transform=ax.transAxes, color=colour, linewidth=0.7, clip_on=False, zorder=2.2)
        style = {"fontsize": TEXT - 0.5, "color": colour, "va": "center", "linespacing": 1.1}
        ax.text(text_at, middle, text, transform=ax.transAxes, **style)
