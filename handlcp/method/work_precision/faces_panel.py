"""Error against the number of faces of the friction pyramid."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.method.accuracy.result import AccuracyCost, FaceLaw
from handlcp.method.work_precision.time_panel import FLOOR, ROUNDING
from handlcp.show.style import BLUE, RED, SMALL, error_ticks, number_ticks, panel, say

GUIDE = "#8C8C8C"
LOOK = {
    "inscribed": {"color": BLUE, "marker": "o", "markerfacecolor": BLUE},
    "circumscribed": {"color": RED, "marker": "s", "markerfacecolor": "white"},
}
LEGEND_SHARE = 0.42  # of the panel's height, below all curves
LEGEND = {"frameon": False, "handlelength": 1.5, "borderaxespad": 0.1, "handletextpad": 0.4, "labelspacing": 0.2}


def faces_panel(ax: Any, cost: AccuracyCost) -> None:
    panel(ax, "… against faces", "faces of the pyramid", "")
    ax.set_xscale("log")
    ax.set_yscale("log")
    found = {section: np.array(cost.pyramids(section)) for section in LOOK if cost.pyramids(section)}
    if not found:
        return say(ax, "no pyramid was solved\nwithin the budget")
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
        say(ax, "Faces make no\ndifference here:\neach pyramid is as\nexact as the cone.")
    else:
        if (law := cost.law()) is not None:
            _guides(ax, law, faces, lowest / 1.5)
        if any(r.section == "exact" and r.status == "certified" for r in cost.rows):
            power = int(np.floor(np.log10(max(cost.reference.residual, FLOOR))))
            words = f"exact cone: 10$^{{{power}}}$"
            ax.plot([], [], "*", color="black", markersize=11, linestyle="none", label=words)
    ax.legend(loc="upper right" if lowest < ROUNDING else "lower left", fontsize=SMALL, **LEGEND)
    number_ticks(ax.xaxis, [m for m in (4, 8, 16, 32, 64, 128, 256, 512, 1024) if m in faces] or faces)
    error_ticks(ax)


def _guides(ax: Any, law: FaceLaw, faces: Array, low: float) -> None:
    """Lines for 1/m and 1/m² from the start of the fitted law down to an error `low`, and the law's exponent."""
    begin = law.factor * float(faces[0]) ** -law.exponent
    for power, dash in ((1, (0, (5, 2))), (2, (0, (1.2, 1.6)))):
        label = f"∝ 1/m{'²' if power == 2 else ''}"
        last = min(float(faces[-1]), float(faces[0]) * (begin / low) ** (1.0 / power)) if begin > low else faces[0]
        ends = np.array([faces[0], last])
        ax.plot(ends, begin * (ends / faces[0]) ** -power, color=GUIDE, linewidth=1.2, linestyle=dash, label=label)
    fit = f"fitted: 1/m$^{{{law.exponent:.1f}}}$"
    ax.text(0.985, 0.97, fit, transform=ax.transAxes, fontsize=SMALL, color=BLUE, ha="right", va="top")
