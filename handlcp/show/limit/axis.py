"""The axis of a load limit: the size of the load, from nothing to somewhat beyond the limit."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp.limits.result import LoadLimit
from handlcp.show.axes import SMALL, TEXT
from handlcp.show.style import INK

_BEYOND = 1.06  # of the limit: where the axis ends


class LoadAxis:
    """Sizes of the load [N], or [N·m] of a torque alone. at (m,) : of the path's points. unit : of a factor of 1."""

    def __init__(self, limit: LoadLimit) -> None:
        force, torque = float(np.linalg.norm(limit.wrench[:3])), float(np.linalg.norm(limit.wrench[3:]))
        self.unit, self._name = (force, "N") if force > 0.0 else (torque, "N·m")
        self.at: Array = self.unit * limit.path.factors
        self.lost: float | None = self.unit * limit.factor if np.isfinite(limit.factor) else None
        self.called = "limit"

    @property
    def end(self) -> float:
        """Somewhat beyond the last point."""
        return _BEYOND * float(self.at[-1]) or 1.0

    def text(self, factor: float) -> str:
        """Such as "2.54 N"."""
        return f"{self.unit * factor:.4g} {self._name}"

    def ticks(self, ax: Any, named: bool) -> None:
        """Round sizes of the load, with their names below the lowest panel."""
        from matplotlib.ticker import MaxNLocator

        ax.set_xlim(0.0, self.end)
        ax.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]))
        ax.tick_params(labelbottom=named, labelsize=SMALL)
        if named:
            what = "load beside the weight" if self._name == "N" else "torque beside the weight"
            ax.set_xlabel(f"{what} [{self._name}]", fontsize=TEXT, color=INK, weight="bold", labelpad=3)
