"""What the panels of a study have in common: frames, grids, ticks with units."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from handlcp.show.style import INK

SMALL, TEXT = 9.5, 10.0  # points


def panel(ax: Any, title: str, x: str, y: str) -> None:
    """Title, labels, a light grid and frame."""
    ax.set_title(title, fontsize=TEXT + 0.5, color=INK, loc="left", weight="bold")
    ax.set_xlabel(x, fontsize=TEXT, color=INK, labelpad=2)
    ax.set_ylabel(y, fontsize=TEXT, color=INK, labelpad=2)
    ax.tick_params(labelsize=SMALL, colors=INK, length=3, pad=2)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color("#9A9A9A")
    ax.grid(True, which="major", color="#E6E6E6", linewidth=0.7)
    ax.set_axisbelow(True)


def say(ax: Any, text: str) -> None:
    """A sentence in the middle of a panel."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, fontsize=TEXT, color=INK, ha="center", va="center")


def time_ticks(ax: Any) -> None:
    """Along x, seconds as µs, ms and s: decades, and 2 and 5 times them where few are in sight."""
    from matplotlib.ticker import EngFormatter

    first, last = ax.get_xlim()
    low, high = np.log10((first, last))
    within = (1.0,) if high - low > 2.0 else (1.0, 2.0, 5.0)
    every = (k * 10.0**e for e in range(int(np.floor(low)), int(np.floor(high)) + 1) for k in within)
    _ticks(ax.xaxis, (x for x in every if first <= x <= last), EngFormatter("s"))


def error_ticks(ax: Any) -> None:
    """Along y, shares as percents down to 0.01 %, as powers of ten below."""
    low, high = np.log10(ax.get_ylim())
    step = 1 if high - low < 8 else 2

    def name(e: float) -> str:
        power = round(np.log10(e))
        return f"{100 * e:.10g} %" if power >= -4 else f"$10^{{{power}}}$"

    _ticks(ax.yaxis, (10.0**e for e in range(-16, 5) if low <= e <= high and e % step == 0), name)


def number_ticks(axis: Any, wanted: Iterable[float]) -> None:
    """Plain numbers at these places."""
    _ticks(axis, wanted, lambda x: f"{x:g}")


def _ticks(axis: Any, places: Iterable[float], name: Callable[[float], str]) -> None:
    """Ticks at these places and no others."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axis.set_major_locator(FixedLocator(list(places)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda x, _: name(x)))
