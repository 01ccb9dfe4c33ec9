"""One panel of a loading: its curves, and their names at the right edge."""

from __future__ import annotations

import textwrap
from typing import Any, Protocol

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.follow import Loading
from handlcp.show.loading.series import Curve, Panel
from handlcp.show.style import INK, SMALL, TEXT, panel as frame, spread

# ----------------------------------------------------------------
# The axis that all panels share: stages side by side, each from 0 to 100 %; and what any such axis has.

_CROWDED = 5  # stages from which on only their ends have a tick
_QUARTERS = 2  # stages up to which every quarter has one


class Axis(Protocol):
    """What panels need of the axis along x, which begins at 0.

    at (m,) : place of each point of the curves.
    lost : where the path ends before the axis does; None where it does not.
    called : how that is marked.
    end : where the axis ends.
    """

    at: Array
    lost: float | None
    called: str
    end: float

    def ticks(self, ax: Any, named: bool) -> None:
        """Ticks along x, with their names below them if asked for."""


class StageAxis:
    """The axis of a loading: stage k lies from k to k + 1.

    at (m,) : place of each step.
    lost : where the object is lost; None where it is not.
    called : how that is marked.
    end : where the last stage ends.
    """

    def __init__(self, loading: Loading) -> None:
        self.stages = loading.stages
        self.at: Array = loading.steps.stage + loading.steps.share
        lost = [e.number + e.share for e in loading.events if e.kind == "lost"]
        self.lost: float | None = lost[0] if lost else None
        self.called, self.end = "lost", float(len(self.stages))

    def ticks(self, ax: Any, named: bool) -> None:
        """Shares of the stages along x, with their names below them if asked for."""
        from matplotlib.ticker import FixedFormatter, FixedLocator

        n = len(self.stages)
        shares = (0.25, 0.5, 0.75) if n <= _QUARTERS else (0.5,) if n < _CROWDED else ()
        places = [0.0, *(k + share for k in range(n) for share in (*shares, 1.0))]
        ax.set_xlim(0.0, self.end)
        ax.xaxis.set_major_locator(FixedLocator(places))
        ax.xaxis.set_major_formatter(FixedFormatter([_percent(x) for x in places]))
        ax.tick_params(labelbottom=named, labelsize=SMALL)
        for k in range(1, n):
            ax.axvline(k, color="#9A9A9A", linewidth=0.9, zorder=1.5)
        for k, name in enumerate(self.stages if named else ()):
            style = {"fontsize": TEXT, "weight": "bold", "color": INK, "ha": "center", "va": "top"}
            across = (ax.transAxes.inverted().transform(ax.transData.transform((k + 0.5, 0.0))))[0]
            ax.annotate(name, (across, 0.0), (0.0, -19.0), "axes fraction", textcoords="offset points", **style)


def _percent(x: float) -> str:
    """Of the stage that ends or goes on there."""
    share = x % 1.0
    return "0" if x == 0.0 else "100 %" if share == 0.0 else f"{100 * share:.0f} %"


# ----------------------------------------------------------------

LETTERS = 29  # of a line of names
ALIKE = 0.01  # of the panel's height: curves no further apart than this share a name
ROW = 0.165  # inches of a line of a name
ASIDE = 0.12  # inches from the panel to the names


def draw_panel(ax: Any, axis: Axis, panel: Panel, last: bool) -> None:
    """Draw the curves of one panel, the line of its limit, and the names of the curves at the right edge.

    last : whether it is the lowest panel, below which the stages have their names.
    """
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
