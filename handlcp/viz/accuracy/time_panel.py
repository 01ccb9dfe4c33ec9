"""`time_panel`: error against time, all settings as points and the best of each method as a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.studies.accuracy.result import AccuracyCost, Row
from handlcp.viz.style import (
    BLUE,
    PURPLE,
    RED,
    SMALL_SIZE,
    set_error_ticks,
    set_time_ticks,
    style_panel,
    write_in_middle,
)

# ----------------------------------------------------------------
# Names written beside the curves they belong to, where they cover neither points nor each other.

_GAP = 5.0  # between a point and its name [points]
_TURNS = (0, 8, -4, 4, 2, -2, 6, -6, 1, -1, 7, -7, 3, -3, 5, -5)  # where names are tried, in 1/16 of a turn
_DISTANCES = (1.0, 2.5, 5.0, 8.0, 12.0, 17.0)  # where they are tried, in gaps from the point
_LIFT = 9.0  # of the lowest name of a ladder above its point [points]
_RUNGS = 14  # of a ladder, at most
_DENSE = 5.0  # pixels between the samples of a curve that names should not cover


@dataclass(frozen=True, slots=True)
class CurveLabel:
    """A name, its colour, and the curve's points (k, 2) in data coordinates, in their order."""

    text: str
    colour: str
    points: Array


def ladder(ax: Any, points: Sequence[CurveLabel], size: float, curves: Sequence[CurveLabel]) -> list[Any]:
    """Write names above single points of equal height, each at the end of an upright line; returns texts and lines.

    The leftmost name is the highest, so that no name crosses another's line, nor covers one of `curves` if possible.
    """
    scale, back = ax.figure.dpi / 72.0, ax.transData.inverted()
    own = [ax.transData.transform(c.points)[0] for c in points]
    ink = np.vstack([np.zeros((0, 2)), *(_sample_lines(ax.transData.transform(c.points)) for c in curves)])
    taken: list[Any] = []
    lines: list[tuple[float, float]] = []
    out = []
    for c, (x, y) in sorted(zip(points, own, strict=True), key=lambda pair: -float(pair[1][0])):
        text, drawn = _text(ax, c, size)
        bottom = y + _LIFT * scale + np.arange(_RUNGS) * (drawn.height + 1.0)
        rungs = [_move_corner(drawn, x + 3.0 * scale, b) for b in bottom]
        costs = []
        for k, box in enumerate(rungs):
            wide = box.padded(3.0, 0.0)
            crossed = wide.count_overlaps(taken) + sum(wide.x0 < at < wide.x1 and wide.y0 < top for at, top in lines)
            costs.append(1e4 * crossed + 10.0 * wide.count_contains(ink) + 20.0 * k)
        rung = int(np.argmin(costs))
        taken.append(rungs[rung])
        lines.append((float(x), bottom[rung]))
        text.set_position(back.transform(rungs[rung].min))
        ends = back.transform([(x, y), (x, bottom[rung] + 0.8 * drawn.height)])
        below = 4 - 0.01 * rung  # the shorter of two lines at the same place is drawn over the longer one
        out += [text, *ax.plot(*ends.T, "-", color=c.colour, linewidth=0.7, zorder=below)]
    return out


def write(ax: Any, curves: Sequence[CurveLabel], size: float, others: Array, written: Sequence[Any]) -> None:
    """Write the name of every curve beside it, the shortest curve first. Limits and scales of `ax` must be final.

    others : (k, 2) further points to keep clear of. written : texts and lines that are there already. Each name
    stands beside a point of its curve, at the place whose box covers least; a line leads to it where that is far.
    """
    gap, back, frame = _GAP * ax.figure.dpi / 72.0, ax.transData.inverted(), ax.get_window_extent()
    own = [ax.transData.transform(c.points) for c in curves]
    ink = np.vstack([*map(_sample_lines, own), ax.transData.transform(others.reshape(-1, 2))])
    taken = [a.get_window_extent().padded(1.0) for a in written]
    lines: list[Array] = []
    for c, points in sorted(zip(curves, own, strict=True), key=lambda pair: len(pair[1])):
        text, drawn = _text(ax, c, size)
        best, least, where = drawn, np.inf, points[0]
        for k, point in enumerate(points):
            for far, distance in enumerate(_DISTANCES):
                for place, box in enumerate(_places(point, drawn, distance * gap)):
                    outside = frame.count_contains([box.min, box.max]) < 2
                    cost = 1e6 * outside + 1e4 * box.count_overlaps(taken) + 60.0 * box.padded(2, 1).count_contains(ink)
                    # Better near an end of the curve, near the point, and on its right
                    cost += 2.0 * min(k, len(points) - 1 - k) + 8.0 * far + 0.4 * place
                    if far and cost < least:
                        cost += _line_cost(_between(point, box), box, ink, taken, lines)
                    if cost < least:
                        best, least, where = box, cost, point
        taken.append(best)
        text.set_position(back.transform(best.min))
        line = _between(where, best)
        if np.hypot(*(line[-1] - where)) > 2.0 * gap:
            lines.append(line)
            ax.plot(*back.transform(line[[0, -1]]).T, "-", color=c.colour, linewidth=0.7, zorder=7)


def _text(ax: Any, c: CurveLabel, size: float) -> tuple[Any, Any]:
    """The text, somewhere, and its box in pixels; where it covers a curve it stands on white."""
    from matplotlib import patheffects

    text = ax.text(0, 0, c.text, fontsize=size, color=c.colour, va="bottom", ha="left", zorder=8)
    text.set_path_effects([patheffects.withStroke(linewidth=2.5, foreground="white")])
    return text, text.get_window_extent()


def _move_corner(box: Any, left: float, bottom: float) -> Any:
    """The box with its corner elsewhere."""
    return box.translated(left - box.x0, bottom - box.y0)


def _places(point: Array, box: Any, gap: float) -> list[Any]:
    """Boxes of this size all around a point, `gap` away; the right one first."""
    turns = np.pi / 8 * np.array(_TURNS)
    way = np.column_stack([np.cos(turns), np.sin(turns)])
    # Beside the point the box is centred on its height, above and below on its width
    corners = point + gap * way - box.size * (1.0 - np.clip(1.6 * way, -1.0, 1.0)) / 2
    return [_move_corner(box, left, bottom) for left, bottom in corners]


def _line_cost(line: Array, box: Any, ink: Array, taken: list[Any], lines: list[Array]) -> float:
    """What a line to a name in `box` crosses: names, other names' lines, points."""
    covered = sum(b.count_contains(line) for b in taken) + box.count_contains(line[1:-1])
    near_points = (abs(ink[:, None] - line[4:]).max(axis=2) < 4.0).any(axis=0).sum()
    return float(200.0 * covered + 40.0 * (sum(box.count_contains(led) for led in lines) + near_points))


def _between(point: Array, box: Any) -> Array:
    """(20, 2) points from a point to the nearest one of a box."""
    return np.linspace(point, np.clip(point, box.min, box.max), 20)


def _sample_lines(points: Array) -> Array:
    """The points, and more on the lines between them."""
    parts = [np.linspace(a, b, 2 + int(np.hypot(*(b - a)) / _DENSE)) for a, b in pairwise(points)]
    return np.vstack([points, *parts])


# ----------------------------------------------------------------

FLOOR = 1e-16  # where errors below ROUNDING are drawn
ROUNDING = 1e-13
COARSE, STRETCH = 1e-4, 2.6  # above COARSE, where pyramids differ, a decade is drawn STRETCH times as high

# Okabe and Ito's palette, darker where text in it would be hard to read; a marker each, for print in grey
STYLE: dict[str, tuple[str, str]] = {
    "grasp.solve()": ("#4D4D4D", "X"),
    "cone, Newton": ("#000000", "*"),
    "cone, NSNGRK": (BLUE, "o"),
    "NSNGRK polished": ("#3A9BD8", "s"),
    "Newton": (PURPLE, "P"),
    "Lemke": ("#00805C", "D"),
    "NSNGRK scaled": ("#C687AA", "^"),
    "as printed, scaled": ("#C98700", "v"),
    "NSNGRK as printed": (RED, "h"),
}
SIZES = {"*": 15.0, "X": 7.5, "P": 7.0}  # of the markers that would look small at 5.5 points


def time_panel(ax: Any, cost: AccuracyCost) -> None:
    """All settings as points; each method's best ones as a line, with the quartiles of their times."""
    style_panel(ax, "Force error against time", "time of one call", "force error, of the largest force")
    ax.set_xscale("log")
    ax.set_yscale("function", functions=(_stretch, _shrink))
    shown = [r for r in cost.rows if r.comparable]
    curves = []
    for method in reversed(cost.methods):
        if front := cost.front(method):
            colour, marker = STYLE.get(method, ("#4D4D4D", "o"))
            every = _points([r for r in shown if r.method == method])
            ax.plot(*every.T, marker, color=colour, markersize=2.6, alpha=0.35, markeredgewidth=0, zorder=3)
            best = _points(front)
            quartiles = np.array([(r.seconds_low or 0, r.seconds_high or 0) for r in front])
            spread = abs(quartiles - best[:, :1]).T
            ax.errorbar(*best.T, xerr=spread, fmt="none", ecolor=colour, elinewidth=0.9, zorder=4)
            above = 5.5 if marker == "P" else 5  # crosses on top
            look = {"marker": marker, "markersize": SIZES.get(marker, 5.5), "markeredgecolor": "white"}
            ax.plot(*best.T, "-", color=colour, linewidth=1.5, zorder=above, markeredgewidth=0.7, **look)
            curves.append(CurveLabel(method, colour, best))
    if not curves:
        return write_in_middle(ax, "nothing ran within the budget")
    times, errors = _points(shown).T
    ax.set_xlim(float(times.min()) / 2.5, float(times.max()) * 4.0)
    ax.set_ylim(FLOOR / 8, min(max(20.0, 4.0 * float(errors.max())), 1e3))
    ax.axhspan(FLOOR / 8, ROUNDING, color="#F0F0F0", zorder=0)
    ax.axhline(COARSE, color="#B5B5B5", linewidth=0.8, linestyle=(0, (1, 2)), zorder=1)
    corner = {"transform": ax.transAxes, "ha": "right", "va": "bottom"}
    ax.text(0.985, 0.02, "rounding", fontsize=SMALL_SIZE, color="#666666", **corner)
    set_time_ticks(ax)
    set_error_ticks(ax)
    exact = [c for c in curves if len(c.points) == 1 and c.points[0, 1] == FLOOR]
    curved = [c for c in curves if not any(c is e for e in exact)]
    written = ladder(ax, exact, SMALL_SIZE, curved)
    ends = [(t, e) for r, (_, e) in zip(shown, _points(shown), strict=True) for t in (r.seconds_low, r.seconds_high)]
    write(ax, curved, SMALL_SIZE, np.array(ends, dtype=float), written)


def _stretch(error: Array) -> Array:
    """Height of an error: its logarithm, with higher decades above `COARSE`."""
    e = np.log10(np.maximum(error, 1e-30) / COARSE)
    return np.asarray(np.where(e > 0, STRETCH * e, e))


def _shrink(height: Array) -> Array:
    """The error at a height."""
    h = np.asarray(height)
    return np.asarray(COARSE * 10.0 ** np.where(h > 0, h / STRETCH, h))


def _points(rows: Sequence[Row]) -> Array:
    """(k, 2) seconds and force errors; errors below `ROUNDING` are put at `FLOOR`."""
    found = np.array([(r.seconds, r.force_error) for r in rows], dtype=float).reshape(-1, 2)
    found[found[:, 1] < ROUNDING, 1] = FLOOR
    return found
