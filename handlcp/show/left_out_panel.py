"""What an effect left out does to forces, torques and slips: one line an effect."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.show.overlay import INK
from handlcp.show.study_axes import FORCE, GREY, SLIP, SMALL, TORQUE, number_ticks, panel
from handlcp.study.accuracy.left_out import UNDETERMINED
from handlcp.study.accuracy.result import AccuracyCost

__all__ = ["left_out_panel"]

_ERRORS = {
    "force_error": ("force", FORCE, "o", FORCE, 6.0),
    "torque_error": ("torque", TORQUE, "D", "none", 8.5),
    "slip_error": ("slip", SLIP, "^", SLIP, 6.5),
}
_LEAST, _MOST = 0.08, 4000.0  # [%] shown


def left_out_panel(ax: Any, cost: AccuracyCost) -> None:
    """One line an effect: its name, and points for the errors of force, torque and slip [%]."""
    panel(ax, "An effect left out", "error [%]", "")
    ax.set_xscale("log")
    ax.grid(False, axis="y")
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    ax.set_xlim(_LEAST, _MOST)
    rows = sorted(cost.left_out, key=lambda e: -(e.force_error if e.force_error is not None else np.inf))
    lines, across = max(len(rows), 6), ax.get_yaxis_transform()
    for k, effect in enumerate(rows):
        y, free = lines - 1 - k, effect.status == UNDETERMINED
        ax.axhline(y, color="#DADADA", linewidth=0.8, zorder=1)
        name = f"{effect.effect} †" if free else effect.effect
        ax.text(0.0, y + 0.15, name, transform=across, fontsize=SMALL, color=INK, va="bottom", zorder=3)
        if effect.force_error is None:
            ax.text(0.5, y, effect.status, transform=across, fontsize=SMALL, color="#8A3A00", ha="center", va="center",
                    style="italic", zorder=2, bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})  # fmt: skip
        for field, style in _ERRORS.items():
            value = getattr(effect, field)
            if value is not None and 100 * value > _LEAST:
                ax.plot([min(100 * value, _MOST)], [y], linestyle="none", zorder=4, clip_on=False, **_mark(style))
    dagger = any(e.status == UNDETERMINED for e in rows)
    ax.set_ylim(-1.25 if dagger else -0.8, lines - 0.2)
    for field, style in _ERRORS.items():
        if any(getattr(e, field) is not None for e in rows):
            ax.plot([], [], linestyle="none", label=style[0], **_mark(style))
    if dagger:
        ax.text(0.0, -1.15, "† not unique; the smallest", transform=across, fontsize=SMALL - 0.5, color=GREY)
    if not any(e.force_error is not None or e.slip_error is not None or e.torque_error is not None for e in rows):
        return number_ticks(ax.xaxis, (0.1, 1, 10, 100, 1000))
    ax.legend(loc="lower left", bbox_to_anchor=(-0.05, 0.07 if dagger else 0.0), ncols=3, fontsize=SMALL, frameon=False,
              handletextpad=0.0, columnspacing=0.6, borderaxespad=0.0)  # fmt: skip
    number_ticks(ax.xaxis, (0.1, 1, 10, 100, 1000))


def _mark(style: tuple[str, str, str, str, float]) -> dict[str, Any]:
    _, colour, marker, face, size = style
    return {
        "marker": marker,
        "markersize": size,
        "markerfacecolor": face,
        "markeredgecolor": colour,
        "markeredgewidth": 1.1,
    }
