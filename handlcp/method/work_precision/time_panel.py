"""Error against time: every setting a faint point, the best settings of each method a line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.method.accuracy.result import AccuracyCost, Row
from handlcp.method.work_precision.curve_labels import CurveLabel, ladder, write
from handlcp.show.style import BLUE, PURPLE, RED, SMALL, error_ticks, panel, say, time_ticks

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
    panel(ax, "Force error against time", "time of one call", "force error, of the largest force")
    ax.set_xscale("log")
    ax.set_yscale("function", functions=(_stretch, _shrink))
    shown = [r for r in cost.rows if r.comparable]
    curves = []
    for method in reversed(cost.methods):
        if front := cost.front(method):
            colour, marker = STYLE.get(method, ("#4D4D4D", "o"))
            every = _points([r for r in shown if r.method == method])
            ax.plot(*every.T, marker, color=colour, markersize=2.6, alpha=0.35, markeredgewidth=0, zorder=3)
            _curve(ax, front, colour, marker)
            curves.append(CurveLabel(method, colour, _points(front)))
    if not curves:
        return say(ax, "nothing ran within the budget")
    times, errors = _points(shown).T
    ax.set_xlim(float(times.min()) / 2.5, float(times.max()) * 4.0)
    ax.set_ylim(FLOOR / 8, min(max(20.0, 4.0 * float(errors.max())), 1e3))
    ax.axhspan(FLOOR / 8, ROUNDING, color="#F0F0F0", zorder=0)
    ax.axhline(COARSE, color="#B5B5B5", linewidth=0.8, linestyle=(0, (1, 2)), zorder=1)
    ax.text(0.985, 0.02, "rounding", transform=ax.transAxes, fontsize=SMALL, color="#666666", ha="right", va="bottom")
    time_ticks(ax)
    error_ticks(ax)
    exact = [c for c in curves if len(c.points) == 1 and c.points[0, 1] == FLOOR]
    curved = [c for c in curves if not any(c is e for e in exact)]
    written = ladder(ax, exact, SMALL, curved)
    ends = [(t, e) for r, (_, e) in zip(shown, _points(shown), strict=True) for t in (r.seconds_low, r.seconds_high)]
    write(ax, curved, SMALL, np.array(ends, dtype=float), written)


def _curve(ax: Any, front: Sequence[Row], colour: str, marker: str) -> None:
    """A method's best settings, with the quartiles of their times."""
    best = _points(front)
    quartiles = np.array([(r.seconds_low or 0, r.seconds_high or 0) for r in front])
    ax.errorbar(*best.T, xerr=abs(quartiles - best[:, :1]).T, fmt="none", ecolor=colour, elinewidth=0.9, zorder=4)
    look = {"marker": marker, "markersize": SIZES.get(marker, 5.5), "markeredgecolor": "white", "markeredgewidth": 0.7}
    ax.plot(*best.T, "-", color=colour, linewidth=1.5, zorder=5.5 if marker == "P" else 5, **look)  # crosses on top


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
