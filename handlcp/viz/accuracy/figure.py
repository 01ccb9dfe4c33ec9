"""`draw`: what accuracy costs, as a picture: error against time, error against faces, and what an effect left out does.

Each scene is a row of panels.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.errors import InputError
from handlcp.studies.accuracy.cost import UNDETERMINED
from handlcp.studies.accuracy.on_paths import FOLLOW, LIMIT, PathCost
from handlcp.studies.accuracy.result import AccuracyCost
from handlcp.viz.accuracy.time_panel import FLOOR, ROUNDING, time_panel
from handlcp.viz.output_file import Figure, draw_or_save, new_figure
from handlcp.viz.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    RED,
    SMALL_SIZE,
    TEXT_SIZE,
    capitalise,
    set_error_ticks,
    set_number_ticks,
    set_time_ticks,
    style_panel,
    write_in_middle,
)

WIDTH, ROW, FOOT = 9.5, 4.2, 0.42  # inches
HEAD_STYLE: dict[str, Any] = {"fontsize": 12.5, "weight": "bold", "color": INK, "va": "top", "parse_math": False}
NOTE_STYLE: dict[str, Any] = {"fontsize": SMALL_SIZE, "color": GREY, "va": "bottom"}

Costs = AccuracyCost | tuple[str, AccuracyCost] | Sequence[tuple[str, AccuracyCost]]


def save(costs: Costs, path: Any) -> Path:
    """Draw and write a file; see `draw`. Raises InputError for an unknown format or a folder that does not exist."""
    file: Path = draw_or_save(path, draw, costs)
    return file


def draw(costs: Costs) -> Figure:
    """Draw what accuracy costs, one row a study.

    costs : one study, (title, study), or several. Raises InputError; Unsupported without matplotlib.
    """
    scenes = _scenes(costs)
    inches = ROW * len(scenes) + FOOT
    figure = new_figure(figsize=(WIDTH, inches), dpi=100)
    for k, (title, cost) in enumerate(scenes):
        top = inches - ROW * k
        figure.text(0.012, (top - 0.08) / inches, title, **HEAD_STYLE)
        figure.text(0.012, (top - 0.36) / inches, f"{cost.summary}.", fontsize=TEXT_SIZE, color=INK, va="top")
        _row(figure, cost, (top - 3.72) / inches, 2.95 / inches)
    c = scenes[0][1].conditions
    note = (
        "Lines: each method's best settings, with quartiles; faint: all faces and tolerances. "
        "Above the dotted line decades are drawn higher.\n"
        "Errors are against the certified equilibrium on the exact cone. "
        f"handlcp {c.handlcp}, Python {c.python}, {c.machine}, {c.processors} processors, {c.date[:10]}."
    )
    figure.text(0.012, 0.06 / inches, note, linespacing=1.3, **NOTE_STYLE)
    return figure


def _row(figure: Any, cost: AccuracyCost, bottom: float, height: float) -> None:
    """The panels of one scene, as far as it has data for them."""
    effects, pyramids = bool(cost.left_out), any(r.section != "exact" for r in cost.rows)
    end = (0.507 if effects else 0.597) if pyramids else (0.735 if effects else 0.98)
    time_panel(figure.add_axes((0.082, bottom, end - 0.082, height)), cost)
    if pyramids:
        right = 0.689 if effects else 0.909
        faces_panel(figure.add_axes((end + 0.071, bottom, right - end, height)), cost)
    if effects:
        left_out_panel(figure.add_axes((0.785, bottom, 0.2, height)), cost)


def _scenes(costs: Any) -> list[tuple[str, AccuracyCost]]:
    """The title and the study of each row of the figure. Raises InputError."""
    if isinstance(costs, AccuracyCost):
        return [("", costs)]
    found = [costs] if isinstance(costs, tuple) and costs and isinstance(costs[0], str) else costs
    pairs = isinstance(found, (list, tuple)) and all(isinstance(c, tuple) and len(c) == 2 for c in found)
    if not found or not pairs or not all(isinstance(cost, AccuracyCost) for _, cost in found):
        raise InputError("costs", "an AccuracyCost, (title, AccuracyCost), or a list of these", repr(costs)[:80])
    return [(str(title), cost) for title, cost in found]


# ----------------------------------------------------------------
# Error against the number of faces of the friction pyramid.

GUIDE = "#8C8C8C"
LOOK = {
    "inscribed": {"color": BLUE, "marker": "o", "markerfacecolor": BLUE},
    "circumscribed": {"color": RED, "marker": "s", "markerfacecolor": "white"},
}
LEGEND_SHARE = 0.42  # of the panel's height, below all curves
LEGEND = {"frameon": False, "handlelength": 1.5, "borderaxespad": 0.1, "handletextpad": 0.4, "labelspacing": 0.2}


def faces_panel(ax: Any, cost: AccuracyCost) -> None:
    style_panel(ax, "… against faces", "faces of the pyramid", "")
    ax.set_xscale("log")
    ax.set_yscale("log")
    found = {section: np.array(cost.pyramids(section)) for section in LOOK if cost.pyramids(section)}
    if not found:
        return write_in_middle(ax, "no pyramid was solved\nwithin the budget")
    every = np.concatenate(list(found.values()))
    faces, lowest, highest = np.unique(every[:, 0]), float(every[:, 1].min()), float(every[:, 1].max())
    ax.set_xlim(faces[0] / 1.25, faces[-1] * 1.35)
    for section, points in found.items():
        heights = np.where(points[:, 1] < ROUNDING, FLOOR, points[:, 1])
        look = LOOK[section] | {"markersize": 5.5, "markeredgecolor": LOOK[section]["color"]}
        ax.plot(points[:, 0], heights, "-", linewidth=1.1, label=section, zorder=4, **look)
    if lowest < ROUNDING:  # some pyramids are exact: no finger slides in them
        ax.set_ylim(FLOOR / 8, 20.0 if highest < ROUNDING else highest * 2.5)
        ax.axhspan(FLOOR / 8, ROUNDING, color="#F0F0F0", zorder=0)
    else:
        span = np.log10(2.5 * highest / lowest) / (1.0 - LEGEND_SHARE)
        ax.set_ylim(lowest / 10.0 ** (LEGEND_SHARE * span), highest * 2.5)
    if highest < ROUNDING:
        write_in_middle(ax, "Faces make no\ndifference here:\neach pyramid is as\nexact as the cone.")
    else:
        if (law := cost.law()) is not None:
            # Lines for 1/m and 1/m² from the start of the fitted law down, and the law's exponent
            begin, low = law.factor * float(faces[0]) ** -law.exponent, lowest / 1.5
            for power, dash in ((1, (0, (5, 2))), (2, (0, (1.2, 1.6)))):
                label = f"∝ 1/m{'²' if power == 2 else ''}"
                longest = float(faces[0]) * max(begin / low, 1.0) ** (1.0 / power)
                ends = np.array([faces[0], min(float(faces[-1]), longest)])
                heights = begin * (ends / faces[0]) ** -power
                ax.plot(ends, heights, color=GUIDE, linewidth=1.2, linestyle=dash, label=label)
            fit, at = f"fitted: 1/m$^{{{law.exponent:.1f}}}$", {"transform": ax.transAxes, "ha": "right", "va": "top"}
            ax.text(0.985, 0.97, fit, fontsize=SMALL_SIZE, color=BLUE, **at)
        if any(r.section == "exact" and r.status == "certified" for r in cost.rows):
            power = int(np.floor(np.log10(max(cost.reference.residual, FLOOR))))
            words = f"exact cone: 10$^{{{power}}}$"
            ax.plot([], [], "*", color="black", markersize=11, linestyle="none", label=words)
    ax.legend(loc="upper right" if lowest < ROUNDING else "lower left", fontsize=SMALL_SIZE, **LEGEND)
    set_number_ticks(ax.xaxis, [m for m in (4, 8, 16, 32, 64, 128, 256, 512, 1024) if m in faces] or faces)
    set_error_ticks(ax)


# ----------------------------------------------------------------
# The error of leaving an effect out: for each a line with points for forces, torques and slips [%].

MARKERS: dict[str, dict[str, Any]] = {
    "force": {"marker": "o", "markersize": 6.0, "markerfacecolor": BLUE, "markeredgecolor": BLUE},
    "torque": {"marker": "D", "markersize": 8.5, "markerfacecolor": "none", "markeredgecolor": RED},
    "slip": {"marker": "^", "markersize": 6.5, "markerfacecolor": GREEN, "markeredgecolor": GREEN},
}
LEAST, MOST = 0.08, 4000.0  # [%] shown


def left_out_panel(ax: Any, cost: AccuracyCost) -> None:
    style_panel(ax, "An effect left out", "error [%]", "")
    ax.set_xscale("log")
    ax.grid(False, axis="y")
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    ax.set_xlim(LEAST, MOST)
    set_number_ticks(ax.xaxis, (0.1, 1, 10, 100, 1000))
    rows = sorted(cost.left_out, key=lambda e: -(e.force_error if e.force_error is not None else np.inf))
    lines, across = max(len(rows), 6), ax.get_yaxis_transform()
    for k, effect in enumerate(rows):
        y = lines - 1 - k
        ax.axhline(y, color="#DADADA", linewidth=0.8, zorder=1)
        name = f"{effect.effect} †" if effect.status == UNDETERMINED else effect.effect
        ax.text(0.0, y + 0.15, name, transform=across, fontsize=SMALL_SIZE, color=INK, va="bottom", zorder=3)
        if effect.force_error is None:
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
            style = {"fontsize": SMALL_SIZE, "color": "#8A3A00", "style": "italic", "ha": "center", "va": "center"}
            ax.text(0.5, y, effect.status, transform=across, zorder=2, bbox=box, **style)
    measured = []
    for what, look in MARKERS.items():
        errors = [(lines - 1 - k, getattr(effect, f"{what}_error")) for k, effect in enumerate(rows)]
        for y, error in errors:
            if error is not None and 100 * error > LEAST:
                x = min(100 * error, MOST)
                ax.plot([x], [y], linestyle="none", markeredgewidth=1.1, zorder=4, clip_on=False, **look)
        if any(error is not None for _, error in errors):
            measured += ax.plot([], [], linestyle="none", markeredgewidth=1.1, label=what, **look)
    dagger = any(e.status == UNDETERMINED for e in rows)
    ax.set_ylim(-1.25 if dagger else -0.8, lines - 0.2)
    if dagger:
        ax.text(0.0, -1.15, "† not unique; the smallest", transform=across, fontsize=SMALL_SIZE - 0.5, color=GREY)
    if measured:
        spacing = {"handletextpad": 0.0, "columnspacing": 0.6, "borderaxespad": 0.0}
        place = {"loc": "lower left", "bbox_to_anchor": (-0.05, 0.07 if dagger else 0.0)}
        ax.legend(ncols=3, fontsize=SMALL_SIZE, frameon=False, **place, **spacing)


# ----------------------------------------------------------------
# What accuracy costs on a path: error against time for each question, and its estimate.

PATH_WIDTH, PATH_HEIGHT = 10.0, 4.6  # inches
PATH_PANELS = (
    (FOLLOW, "follow: forces at the end", "error, of the largest force", BLUE),
    (LIMIT, "load_limit: the factor", "error, of the factor", RED),
)


def draw_path_cost(cost: PathCost, title: str = "") -> Figure:
    """Draw both panels of error against time. Raises Unsupported without matplotlib."""
    made = new_figure(figsize=(PATH_WIDTH, PATH_HEIGHT), dpi=100)
    made.text(0.012, 0.975, title, **HEAD_STYLE)
    made.text(0.012, 0.905, capitalise(cost.summary), fontsize=TEXT_SIZE, color=INK, va="top")
    for k, (question, name, error, colour) in enumerate(PATH_PANELS):
        ax, rows = made.add_axes((0.085 + 0.5 * k, 0.19, 0.4, 0.58)), cost.of(question)
        style_panel(ax, name, "time of one call", error)
        ax.set_xscale("log")
        ax.set_yscale("log")
        seconds = np.array([r.seconds for r in rows])
        off, estimate = np.array([(max(r.error, 1e-16), np.maximum(r.estimate, 1e-16)) for r in rows]).T
        ax.plot(seconds, estimate, color=colour, linewidth=1.2, linestyle=(0, (4, 2.5)), alpha=0.8)
        ax.plot(seconds, off, "o-", color=colour, linewidth=1.5, markersize=5.5, markeredgecolor="white")
        first, end, last = float(seconds.min()) / 2.0, float(seconds.max()) * 1.6, 0.0
        for row, x, y in zip(rows, seconds, off, strict=True):
            if x < last * (end / first) ** 0.06:  # no room for another number
                continue
            last = x
            style = {"fontsize": SMALL_SIZE, "color": INK, "ha": "right", "va": "top"}
            ax.annotate(f"{row.steps}", (x, y), (-3, -5), textcoords="offset points", **style)
        ax.set_xlim(first, end)
        both = np.concatenate([off, estimate[np.isfinite(estimate)]])
        ax.set_ylim(float(both.min()) / 4.0, float(both.max()) * 2.5)
        set_time_ticks(ax)
        set_error_ticks(ax)
    note = (
        "Full: against the finest accuracy. Dashed: the largest error of a step that the path estimates. "
        "Numbers: steps taken."
    )
    made.text(0.012, 0.02, note, **NOTE_STYLE)
    return made
