"""What the panels of a study have in common: frames, grids, ticks with units, colours."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.show.overlay import INK

__all__ = [
    "FORCE",
    "GREY",
    "SLIP",
    "SMALL",
    "TEXT",
    "TORQUE",
    "error_ticks",
    "number_ticks",
    "panel",
    "say",
    "time_ticks",
]

SMALL, TEXT = 9.5, 10.0  # points
FORCE, TORQUE, SLIP, GREY = "#0072B2", "#D55E00", "#009E73", "#5F5F5F"  # of Okabe and Ito's palette


def panel(ax: Any, title: str, x: str, y: str) -> None:
    """Title, labels, a light grid and frame."""
    ax.set_title(title, fontsize=TEXT + 0.5, color=INK, loc="left", weight="bold")
    ax.set_xlabel(x, fontsize=TEXT, color=INK, labelpad=2)
    ax.set_ylabel(y, fontsize=TEXT, color=INK, labelpad=2)
    ax.tick_params(labelsize=SMALL, colors=INK, length=3, pad=2)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_color("#9A9A9A")
    ax.grid(True, which="major", color="#E6E6E6", linewidth=0.7)
    ax.set_axisbelow(True)


def say(ax: Any, text: str) -> None:
    """A sentence in the middle of a panel."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, fontsize=TEXT, color=INK, ha="center", va="center")


def time_ticks(ax: Any) -> None:
    """Along x, seconds as µs, ms and s."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = np.log10(ax.get_xlim())

    def name(t: float, _: Any) -> str:
        return f"{t * 1e6:g} µs" if t < 0.9e-3 else f"{t * 1e3:g} ms" if t < 0.9 else f"{t:g} s"

    ax.xaxis.set_major_locator(FixedLocator([10.0**e for e in range(int(np.ceil(low)), int(np.floor(high)) + 1)]))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_major_formatter(FuncFormatter(name))


def error_ticks(ax: Any) -> None:
    """Along y, shares as percents down to 0.01 %, as powers of ten below."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = np.log10(ax.get_ylim())
    step = 1 if high - low < 8 else 2
    exponents = [e for e in range(-16, 5) if low <= e <= high and e % step == 0]

    def name(e: float, _: Any) -> str:
        power = round(np.log10(e))
        return f"{100 * e:.10g} %" if power >= -4 else f"$10^{{{power}}}$"

    ax.yaxis.set_major_locator(FixedLocator([10.0**e for e in exponents]))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_major_formatter(FuncFormatter(name))


def number_ticks(axis: Any, wanted: Any) -> None:
    """Plain numbers at these places, and no other ticks."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axis.set_major_locator(FixedLocator(list(wanted)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
