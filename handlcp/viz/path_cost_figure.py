"""The figure of what accuracy costs on a path: error against time for each question, and its estimate."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.studies.accuracy.on_paths import FOLLOW, LIMIT, PathCost, PathRow
from handlcp.viz.output_file import Figure, new_figure
from handlcp.viz.style import BLUE, GREY, INK, RED, SMALL_SIZE, TEXT_SIZE, set_error_ticks, set_time_ticks, style_panel

WIDTH, HEIGHT, HEAD = 10.0, 4.6, 12.5  # inches, points
DASHED = (0, (4, 2.5))
PANELS = (
    (FOLLOW, "follow: forces at the end", "error, of the largest force", BLUE),
    (LIMIT, "load_limit: the factor", "error, of the factor", RED),
)


def draw_path_cost(cost: PathCost, title: str = "") -> Figure:
    """Draw both panels of error against time. Raises Unsupported without matplotlib."""
    made = new_figure(figsize=(WIDTH, HEIGHT), dpi=100)
    made.text(0.012, 0.975, title, fontsize=HEAD, weight="bold", color=INK, va="top", parse_math=False)
    made.text(0.012, 0.905, f"{cost.summary[0].upper()}{cost.summary[1:]}.", fontsize=TEXT_SIZE, color=INK, va="top")
    for k, (question, name, error, colour) in enumerate(PANELS):
        _panel(made.add_axes((0.085 + 0.5 * k, 0.19, 0.4, 0.58)), cost.of(question), name, error, colour)
    note = (
        "Full: against the finest steps. Dashed: the estimate beside the answer, 1.5 × the change since half as many. "
        "Numbers: steps taken."
    )
    made.text(0.012, 0.02, note, fontsize=SMALL_SIZE, color=GREY, va="bottom")
    return made


def _panel(ax: Any, rows: tuple[PathRow, ...], name: str, error: str, colour: str) -> None:
    style_panel(ax, name, "time of one call", error)
    ax.set_xscale("log")
    ax.set_yscale("log")
    seconds = np.array([r.seconds for r in rows])
    off, estimate = np.array([(max(r.error, 1e-16), np.maximum(r.estimate, 1e-16)) for r in rows]).T
    ax.plot(seconds, estimate, color=colour, linewidth=1.2, linestyle=DASHED, alpha=0.8)
    ax.plot(seconds, off, "o-", color=colour, linewidth=1.5, markersize=5.5, markeredgecolor="white")
    left = float(seconds.min()) / 2.0, float(seconds.max()) * 1.6
    last = 0.0
    for row, x, y in zip(rows, seconds, off, strict=True):
        if x < last * (left[1] / left[0]) ** 0.06:  # no room for another number
            continue
        last = x
        style = {"fontsize": SMALL_SIZE, "color": INK, "ha": "right", "va": "top"}
        ax.annotate(f"{row.steps}", (x, y), (-3, -5), textcoords="offset points", **style)
    ax.set_xlim(*left)
    both = np.concatenate([off, estimate[np.isfinite(estimate)]])
    ax.set_ylim(float(both.min()) / 4.0, float(both.max()) * 2.5)
    set_time_ticks(ax)
    set_error_ticks(ax)
