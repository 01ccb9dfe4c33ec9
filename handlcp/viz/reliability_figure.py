"""The figure of a reliability: the margins of all samples, and what matters most."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from handlcp.studies.reliability import Reliability
from handlcp.studies.reliability.outcome import NOT_HELD_CODE, UNDECIDED_CODE
from handlcp.viz.output_file import Figure, new_figure
from handlcp.viz.style import (
    BLUE,
    GREY,
    INK,
    RED,
    SMALL_SIZE,
    TEXT_SIZE,
    TITLE_STYLE,
    capitalise,
    set_number_ticks,
    shorten_names,
    style_panel,
    write_in_middle,
)

FIGURE_WIDTH, FIGURE_HEIGHT = 10.0, 4.6  # inches
ORANGE, DARK_ORANGE = "#E69F00", "#A86F00"  # of derivatives, beside the blue of samples: of bars, and of text
MAX_INFLUENCE_ROWS = 8  # of what matters most
MAX_NAME_LETTERS = 26  # of a name
BIN_COUNT_RANGE = 12, 40  # the fewest and the most


def draw_reliability(found: Reliability, title: str = "") -> Figure:
    """Left, how many samples have which margin, and how many nothing holds. Right, the values that vary, with the share
    of the margin's variance that each explains, by the samples and by the derivatives. Raises Unsupported without
    matplotlib.
    """
    made = new_figure(figsize=(FIGURE_WIDTH, FIGURE_HEIGHT), dpi=100)
    title = textwrap.shorten(title, 95, placeholder=" …") or "How sure it is that the object is held"
    made.text(0.012, 0.975, title, color=INK, **TITLE_STYLE)
    made.text(0.012, 0.895, capitalise("; ".join(found.chances)), fontsize=TEXT_SIZE, color=INK, va="top")
    _draw_margins(made.add_axes((0.07, 0.18, 0.37, 0.57)), found)
    _draw_influences(made.add_axes((0.69, 0.18, 0.29, 0.57)), found)
    return made


def _draw_margins(ax: Any, found: Reliability) -> None:
    """The histogram; samples without an answer are a bar of their own, left of all others."""
    across = "margin: friction or torque left, whichever is less [%]"
    style_panel(ax, f"{found.samples:,} samples", across, "share of samples [%]")
    margin = 100 * found.margin[np.isfinite(found.margin)]
    without, bars = found.codes[~np.isfinite(found.margin)], list[tuple[str, float, str]]()
    for what, code, colour in (("not held", NOT_HELD_CODE, RED), ("undecided", UNDECIDED_CODE, GREY)):
        if (without == code).any():
            bars.append((what, 100 * float((without == code).sum() / found.samples), colour))
    # Bins are as wide as each other, and so few that chance moves none far from its neighbours; one of them begins at 0
    # if some margins are below it
    bins = int(np.clip(round(2.0 * found.samples ** (1 / 3)), *BIN_COUNT_RANGE))  # Rice's rule
    low, high = (float(margin.min()), float(margin.max())) if len(margin) else (0.0, 100.0)
    low = 0.0 if 0.0 <= low < 25.0 else low
    width = (max(high, low + 1.0, 1.0 if low < 0.0 else low) - low) / bins
    edges = (np.floor(low / width) + np.arange(bins + 2)) * width
    low, width = float(edges[0]), float(edges[1] - edges[0])
    counts = 100 * np.histogram(margin, edges)[0] / found.samples
    colours = [BLUE if edge >= -1e-9 else RED for edge in edges[:-1]]
    ax.bar(edges[:-1], counts, width, align="edge", color=colours, edgecolor="white", linewidth=0.4)
    top, end = max([float(counts.max(initial=0.0)), *[share for _, share, _ in bars]]), low
    for what, share, colour in bars:
        at, end = end - 4.0 * width, end - 8.0 * width
        ax.bar([at], [share], 2.0 * width, color=colour)
        style = {"ha": "center", "va": "bottom", "fontsize": SMALL_SIZE, "color": colour}
        ax.text(at, share + 0.02 * top, f"{what}\n{share:.2g} %", **style)
    if low < 0.0:
        ax.axvline(0.0, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)))
        ax.text(-0.5 * width, 1.2 * top, "over a limit", ha="right", va="top", fontsize=SMALL_SIZE, color=RED)
    ax.set_xlim(end, edges[-1] + width)
    ax.set_ylim(0.0, 1.22 * top)
    set_number_ticks(ax.xaxis, [x for x in ax.get_xticks() if low <= x <= edges[-1]])  # what is not held has no margin


def _draw_influences(ax: Any, found: Reliability) -> None:
    """Two bars for each value that varies, those that matter most on top."""
    rows = found.influences[:MAX_INFLUENCE_ROWS]
    left = f", {MAX_INFLUENCE_ROWS} of {len(found.influences)}" if len(found.influences) > MAX_INFLUENCE_ROWS else ""
    style_panel(ax, f"What matters most{left}", "share of the margin's variance [%]", "")
    if not any(np.isfinite(f.share) or np.isfinite(f.linear) for f in rows):
        ax.set_yticks([])
        write_in_middle(ax, "all samples are alike")
        return
    y = np.arange(len(rows))[::-1]
    for values, away, colour in (([f.share for f in rows], 0.2, BLUE), ([f.linear for f in rows], -0.2, ORANGE)):
        ax.barh(y + away, 100 * np.nan_to_num(values), 0.36, color=colour)
    short = shorten_names([f.name for f in rows], MAX_NAME_LETTERS)
    ax.set_yticks(y, [f"{name}\n{f.said}" for name, f in zip(short, rows, strict=True)])
    ax.grid(visible=False, axis="y")
    ax.set_ylim(-0.6, len(rows) - 0.4)
    ax.set_xlim(0.0, None)
    names = ((0.665, "by the samples", BLUE, BLUE), (0.80, "by derivatives at the means", ORANGE, DARK_ORANGE))
    for x, name, colour, ink in names:
        ax.figure.text(x, 0.035, "■", ha="right", va="center", fontsize=SMALL_SIZE, color=colour)
        ax.figure.text(x + 0.006, 0.035, name, va="center", fontsize=SMALL_SIZE, color=ink)
    ax.tick_params(axis="y", colors=GREY)
