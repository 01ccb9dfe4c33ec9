"""What accuracy costs, as a picture: error against time, error against faces, and what an effect left out does.

One row of panels a scene. matplotlib's object interface, so that nothing global changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.show import curve_labels
from handlcp.show.file import checked, figure_type, write
from handlcp.show.left_out_panel import left_out_panel
from handlcp.show.overlay import INK
from handlcp.show.study_axes import (
    FORCE,
    GREY,
    SMALL,
    TEXT,
    TORQUE,
    error_ticks,
    number_ticks,
    panel,
    say,
    time_ticks,
)
from handlcp.study.accuracy.result import AccuracyCost, FaceLaw, Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw", "save"]

WIDTH, ROW, FOOT, DPI = 9.5, 4.2, 0.42, 160  # inches
HEAD = 12.5  # points
FLOOR = 1e-16  # errors below are drawn here
ROUNDING = 1e-13  # below is rounding
COARSE, STRETCH = 1e-4, 2.6  # above this error a decade is drawn so many times as high: there pyramids differ

# Okabe and Ito's palette, darker where text in it would be hard to read; a marker each, for print in grey
STYLE: dict[str, tuple[str, str]] = {
    "grasp.solve()": ("#4D4D4D", "X"),
    "cone, Newton": ("#000000", "*"),
    "cone, NSNGRK": ("#0072B2", "o"),
    "NSNGRK polished": ("#3A9BD8", "s"),
    "Newton": ("#A0307A", "P"),
    "Lemke": ("#00805C", "D"),
    "NSNGRK scaled": ("#C687AA", "^"),
    "as printed, scaled": ("#C98700", "v"),
    "NSNGRK as printed": ("#D55E00", "h"),
}
GUIDE = "#8C8C8C"

Costs = AccuracyCost | tuple[str, AccuracyCost] | Sequence[tuple[str, AccuracyCost]]


def save(costs: Costs, path: Any) -> Path:
    """Draw and write a file; see `draw`. Raises InputError for a format or a place that will not do."""
    file = checked(path)
    return write(draw(costs), file, DPI)


def draw(costs: Costs) -> Figure:
    """The figure. costs : one study, (title, study), or several of these.

    Raises InputError for anything else, Unsupported when matplotlib is not installed.
    """
    scenes = _scenes(costs)
    inches = ROW * len(scenes) + FOOT
    figure: Figure = figure_type()(figsize=(WIDTH, inches), dpi=100)
    for k, (title, cost) in enumerate(scenes):
        top = inches - ROW * k

        def place(x: float, width: float, top: float = top) -> Any:
            return figure.add_axes((x, (top - 3.72) / inches, width, 2.95 / inches))

        figure.text(0.012, (top - 0.08) / inches, title, fontsize=HEAD, weight="bold", color=INK, va="top")
        figure.text(0.012, (top - 0.36) / inches, f"{cost}.", fontsize=TEXT, color=INK, va="top")
        effects, pyramids = bool(cost.left_out), any(r.section != "exact" for r in cost.rows)
        end = (0.507 if effects else 0.597) if pyramids else (0.735 if effects else 0.98)
        _time(place(0.082, end - 0.082), cost)
        if pyramids:
            _faces(place(end + 0.071, (0.689 if effects else 0.909) - end), cost)
        if effects:
            left_out_panel(place(0.785, 0.2), cost)
    figure.text(
        0.012, 0.06 / inches, _conditions(scenes[0][1]), fontsize=SMALL, color=GREY, va="bottom", linespacing=1.3
    )
    return figure


def _conditions(cost: AccuracyCost) -> str:
    c = cost.conditions
    return (
        "Lines: each method's best settings, with quartiles; faint: all faces and tolerances. "
        "Above the dotted line decades are drawn higher.\n"
        "Errors are against the certified equilibrium on the exact cone. "
        f"handlcp {c.handlcp}, Python {c.python}, {c.machine}, {c.processors} processors, {c.date[:10]}."
    )


def _scenes(costs: Any) -> list[tuple[str, AccuracyCost]]:
    if isinstance(costs, AccuracyCost):
        return [("", costs)]
    if isinstance(costs, tuple) and len(costs) == 2 and isinstance(costs[1], AccuracyCost):
        return [(str(costs[0]), costs[1])]
    found = list(costs) if isinstance(costs, (list, tuple)) else []
    if not found or not all(isinstance(c, tuple) and len(c) == 2 and isinstance(c[1], AccuracyCost) for c in found):
        raise InputError("costs", "an AccuracyCost, (title, AccuracyCost), or a list of these", repr(costs)[:80])
    return [(str(title), cost) for title, cost in found]


# ---- error against time
def _time(ax: Any, cost: AccuracyCost) -> None:
    """Every setting a faint point; the best of each method a line."""
    panel(ax, "Force error against time", "time of one call", "force error, of the largest force")
    ax.set_xscale("log")
    ax.set_yscale("function", functions=(_stretch, _shrink))
    shown = [r for r in cost.rows if r.comparable]
    curves = []
    for method in reversed(cost.methods):
        colour, marker = STYLE.get(method, ("#4D4D4D", "o"))
        every, front = _points([r for r in shown if r.method == method]), cost.front(method)
        if not front:
            continue
        best = _points(front)
        size = {"*": 15, "X": 7.5, "P": 7}.get(marker, 5.5)
        ax.plot(*every.T, marker, color=colour, markersize=2.6, alpha=0.35, markeredgewidth=0, zorder=3)
        spread = np.array(
            [[(r.seconds or 0) - (r.seconds_low or 0), (r.seconds_high or 0) - (r.seconds or 0)] for r in front]
        )
        ax.errorbar(*best.T, xerr=np.maximum(spread.T, 0), fmt="none", ecolor=colour, elinewidth=0.9, zorder=4)
        ax.plot(*best.T, "-", color=colour, marker=marker, markersize=size, linewidth=1.5, markeredgecolor="white",
                markeredgewidth=0.7, zorder=5.5 if marker == "P" else 5)  # fmt: skip  # a cross covers little
        curves.append(curve_labels.CurveLabel(method, colour, best))
    if not curves:
        return say(ax, "nothing ran within the budget")
    times = np.concatenate([c.points[:, 0] for c in curves] + [_points(shown)[:, 0]])
    ax.set_xlim(float(times.min()) / 2.5, float(times.max()) * 4.0)
    highest = float(_points(shown)[:, 1].max())
    ax.set_ylim(FLOOR / 8, min(max(20.0, 4.0 * highest), 1e3))
    ax.axhspan(FLOOR / 8, ROUNDING, color="#F0F0F0", zorder=0)
    ax.axhline(COARSE, color="#B5B5B5", linewidth=0.8, linestyle=(0, (1, 2)), zorder=1)
    ax.text(0.985, 0.02, "rounding", transform=ax.transAxes, fontsize=SMALL, color="#666666", ha="right", va="bottom")
    time_ticks(ax)
    error_ticks(ax)
    exact = [c for c in curves if len(c.points) == 1 and c.points[0, 1] == FLOOR]
    curved = [c for c in curves if not any(c is e for e in exact)]
    written = curve_labels.ladder(ax, exact, SMALL, curved)
    ends = [(t, e) for r, (_, e) in zip(shown, _points(shown), strict=True) for t in (r.seconds_low, r.seconds_high)]
    curve_labels.write(ax, curved, SMALL, np.array(ends, dtype=float), written)


def _stretch(error: Array) -> Array:
    """Height of an error: its logarithm, whose decades are higher above `COARSE`."""
    e = np.log10(np.maximum(error, 1e-30) / COARSE)
    return np.asarray(np.where(e > 0, STRETCH * e, e))


def _shrink(height: Array) -> Array:
    """The error at a height."""
    h = np.asarray(height)
    return np.asarray(COARSE * 10.0 ** np.where(h > 0, h / STRETCH, h))


def _points(rows: Sequence[Row]) -> Array:
    """(k, 2) seconds and force errors; those that are rounding all at the floor."""
    found = [(r.seconds, r.force_error or 0.0) for r in rows]
    return np.array([(s, FLOOR if e < ROUNDING else e) for s, e in found], dtype=float).reshape(-1, 2)


# ---- error against faces
def _faces(ax: Any, cost: AccuracyCost) -> None:
    panel(ax, "… against faces", "faces of the pyramid", "")
    ax.set_xscale("log")
    ax.set_yscale("log")
    kinds = (("inscribed", FORCE, "o", FORCE), ("circumscribed", TORQUE, "s", "white"))
    found = [(np.array(cost.pyramids(kind[0])), *kind) for kind in kinds if cost.pyramids(kind[0])]
    if not found:
        return say(ax, "no pyramid was solved\nwithin the budget")
    law = cost.law()
    faces = np.unique(np.concatenate([points[:, 0] for points, *_ in found]))
    highest = max(float(points[:, 1].max()) for points, *_ in found)
    lowest = min(float(points[:, 1].min()) for points, *_ in found)
    ax.set_xlim(faces[0] / 1.25, faces[-1] * 1.35)
    for points, name, colour, marker, inner in found:
        heights = np.where(points[:, 1] < ROUNDING, FLOOR, points[:, 1])
        ax.plot(points[:, 0], heights, "-", color=colour, marker=marker, markersize=5.5, linewidth=1.1,
                markerfacecolor=inner, markeredgecolor=colour, label=name, zorder=4)  # fmt: skip
    if highest < ROUNDING:
        ax.set_ylim(FLOOR / 8, 20.0)
        ax.axhspan(FLOOR / 8, ROUNDING, color="#F0F0F0", zorder=0)
        say(ax, "Faces make no\ndifference here:\neach pyramid is as\nexact as the cone.")
        spot: dict[str, Any] = {"loc": "upper right"}
    else:
        exact = lowest < ROUNDING  # some of the pyramids, where no finger slides in them
        ax.set_ylim(FLOOR / 8 if exact else lowest / 60.0, highest * 2.5)
        spot = {"loc": "upper right" if exact else "lower left"}
        if exact:
            ax.axhspan(FLOOR / 8, ROUNDING, color="#F0F0F0", zorder=0)
        if law is not None:
            _guides(ax, law, faces)
        if any(r.section == "exact" and r.status == "certified" for r in cost.rows):
            power = int(np.floor(np.log10(max(cost.reference.residual, FLOOR))))
            words = f"exact cone: 10$^{{{power}}}$"
            ax.plot([], [], "*", color="black", markersize=11, linestyle="none", label=words)
    ax.legend(**spot, fontsize=SMALL, frameon=False, handlelength=1.5, borderaxespad=0.1, handletextpad=0.4,
              labelspacing=0.2)  # fmt: skip
    number_ticks(ax.xaxis, [m for m in (4, 8, 16, 32, 64, 128, 256, 512, 1024) if m in faces] or faces)
    error_ticks(ax)


def _guides(ax: Any, law: FaceLaw, faces: Array) -> None:
    """m^-1 and m^-2 from where the fitted law begins, and its exponent."""
    begin = law.factor * float(faces[0]) ** -law.exponent
    for power, dash in ((1, (0, (5, 2))), (2, (0, (1.2, 1.6)))):
        label = f"∝ 1/m{'²' if power == 2 else ''}"
        ax.plot(faces, begin * (faces / faces[0]) ** -power, color=GUIDE, linewidth=1.2, linestyle=dash, label=label)
    fit = f"fitted: 1/m$^{{{law.exponent:.1f}}}$"
    ax.text(0.985, 0.97, fit, transform=ax.transAxes, fontsize=SMALL, color=FORCE, ha="right", va="top")
