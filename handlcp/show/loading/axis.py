"""The axis that all panels share: stages side by side, each from 0 to 100 %; and what any such axis has."""

from __future__ import annotations

from typing import Any, Protocol

from handlcp.check import Array
from handlcp.grasp.path.follow import Loading
from handlcp.show.axes import SMALL, TEXT
from handlcp.show.style import INK

_CROWDED = 5  # stages from which on only their ends have a tick
_QUARTERS = 2  # stages up to which every quarter has one


class Axis(Protocol):
    """What panels need of the axis along x. at (m,) : places of the points of all curves. lost : where the path ends
    before the axis does, None where it does not; called : how that is marked.
    """

    at: Array
    lost: float | None
    called: str

    @property
    def end(self) -> float:
        """Of the axis, which begins at 0."""

    def ticks(self, ax: Any, named: bool) -> None:
        """Ticks along x, with their names below them if asked for."""


class StageAxis:
    """Stage k of a loading lies from k to k + 1. at (m,) : of the steps. lost : where the object is lost; None: it
    is not.
    """

    def __init__(self, loading: Loading) -> None:
        self.stages = loading.stages
        self.at: Array = loading.steps.stage + loading.steps.share
        lost = [e.number + e.share for e in loading.events if e.kind == "lost"]
        self.lost: float | None = lost[0] if lost else None
        self.called = "lost"

    @property
    def end(self) -> float:
        """Of the last stage."""
        return float(len(self.stages))

    def ticks(self, ax: Any, named: bool) -> None:
        """Shares of the stages along x, with their names below them if asked for."""
        from matplotlib.ticker import FixedFormatter, FixedLocator

        n = len(self.stages)
        shares = (0.25, 0.5, 0.75) if n <= _QUARTERS else (0.5,) if n < _CROWDED else ()
        places = [0.0, *(k + share for k in range(n) for share in (*shares, 1.0))]
        ax.set_xlim(0.0, self.end)
        ax.xaxis.set_major_locator(FixedLocator(places))
        ax.xaxis.set_major_formatter(FixedFormatter([_percent(x) for x in places]))
        ax.tick_params(labelbottom=named, labelsize=SMALL)
        for k in range(1, n):
            ax.axvline(k, color="#9A9A9A", linewidth=0.9, zorder=1.5)
        for k, name in enumerate(self.stages if named else ()):
            style = {"fontsize": TEXT, "weight": "bold", "color": INK, "ha": "center", "va": "top"}
            across = (ax.transAxes.inverted().transform(ax.transData.transform((k + 0.5, 0.0))))[0]
            ax.annotate(name, (across, 0.0), (0.0, -19.0), "axes fraction", textcoords="offset points", **style)


def _percent(x: float) -> str:
    """Of the stage that ends or goes on there."""
    share = x % 1.0
    return "0" if x == 0.0 else "100 %" if share == 0.0 else f"{100 * share:.0f} %"
