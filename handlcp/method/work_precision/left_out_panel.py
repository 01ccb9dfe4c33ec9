"""The error of leaving an effect out: for each a line with points for forces, torques and slips [%]."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.method.accuracy.left_out import UNDETERMINED
from handlcp.method.accuracy.result import AccuracyCost
from handlcp.show.style import BLUE, GREEN, GREY, INK, RED, SMALL, number_ticks, panel

LOOK: dict[str, dict[str, Any]] = {
    "force": {"marker": "o", "markersize": 6.0, "markerfacecolor": BLUE, "markeredgecolor": BLUE},
    "torque": {"marker": "D", "markersize": 8.5, "markerfacecolor": "none", "markeredgecolor": RED},
    "slip": {"marker": "^", "markersize": 6.5, "markerfacecolor": GREEN, "markeredgecolor": GREEN},
}
LEAST, MOST = 0.08, 4000.0  # [%] shown


def left_out_panel(ax: Any, cost: AccuracyCost) -> None:
    panel(ax, "An effect left out", "error [%]", "")
    ax.set_xscale("log")
    ax.grid(False, axis="y")
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    ax.set_xlim(LEAST, MOST)
    number_ticks(ax.xaxis, (0.1, 1, 10, 100, 1000))
    rows = sorted(cost.left_out, key=lambda e: -(e.force_error if e.force_error is not None else np.inf))
    lines, across = max(len(rows), 6), ax.get_yaxis_transform()
    for k, effect in enumerate(rows):
        y = lines - 1 - k
        ax.axhline(y, color="#DADADA", linewidth=0.8, zorder=1)
        name = f"{effect.effect} †" if effect.status == UNDETERMINED else effect.effect
        ax.text(0.0, y + 0.15, name, transform=across, fontsize=SMALL, color=INK, va="bottom", zorder=3)
        if effect.force_error is None:
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
            style = {"fontsize": SMALL, "color": "#8A3A00", "style": "italic", "ha": "center", "va": "center"}
            ax.text(0.5, y, effect.status, transform=across, zorder=2, bbox=box, **style)
    measured = []
    for what, look in LOOK.items():
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
        ax.text(0.0, -1.15, "† not unique; the smallest", transform=across, fontsize=SMALL - 0.5, color=GREY)
    if measured:
        spacing = {"handletextpad": 0.0, "columnspacing": 0.6, "borderaxespad": 0.0}
        place = {"loc": "lower left", "bbox_to_anchor": (-0.05, 0.07 if dagger else 0.0)}
        ax.legend(ncols=3, fontsize=SMALL, frameon=False, **place, **spacing)
