"""The figure of a load limit: forces, friction, motion and joint torques while the load grows, and what gives out."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp import Grasp
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.path.events import Event, summary
from handlcp.grasp.path.trajectory import used_on_path
from handlcp.show.file import Figure
from handlcp.show.limit.report import moved, size, way
from handlcp.show.loading.draw import compose
from handlcp.show.loading.marks import Mark, Marks
from handlcp.show.loading.report import outcome
from handlcp.show.loading.series import Panel, panels_of
from handlcp.show.style import INK, SMALL, TEXT

# ----------------------------------------------------------------
# The axis of a load limit: the size of the load, from nothing to somewhat beyond the limit.

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


# ----------------------------------------------------------------


def figure(limit: LoadLimit, title: str = "") -> Figure:
    """The figure of what `grasp.load_limit` returns.

    Along x, the load from nothing to its limit. One below the other: normal forces; friction as a share of its limit,
    100 % where a finger slides; motion of the object since the load began, world axes; joint torques as a share of
    their limits. Lines with a number are events, listed at the bottom. What lies behind the limit is shaded.
    Raises Unsupported for a grasp that is lost before the load comes, and when matplotlib is not installed.
    """
    if not len(limit.path.factors):
        raise Unsupported(f"there is no load to draw: {limit.why}; `grasp.follow().plot()` draws how it is lost")
    axis, grasp = LoadAxis(limit), _grasp(limit)
    last = float(limit.path.factors[-1]) or 1.0
    until = max(last, limit.factor if np.isfinite(limit.factor) else last)
    events = [Event(e.kind, e.who, "load", e.factor / last, 0, e.moved, e.turned)
              for e in limit.events if e.factor <= until]  # fmt: skip
    told = summary(events, grasp.spec)
    marks = Marks(axis, [Mark(axis.unit * last * s.share, axis.text(last * s.share), s.sentence, s.kind) for s in told])
    return compose(axis, _panels(limit, grasp), marks, lambda drawn: _head(drawn, limit, title))


def _grasp(limit: LoadLimit) -> Grasp:
    """With its contacts and limits."""
    spec = limit.at_limit.spec
    assert spec is not None  # it was solved
    return Grasp(spec)


def _head(drawn: Figure, limit: LoadLimit, title: str) -> float:
    """Title, the limit and what gives out; which load, and what friction and torque limits alone would allow."""
    held = np.isfinite(limit.factor)
    below = f"The load that grows: {way(limit.wrench)}."
    if (there := moved(limit)) != "–":
        below += f" At the limit the object has moved {there}."
    if limit.lost is not None and limit.lost > limit.factor * (1.0 + 1e-6):
        below += f" It is lost at {size(limit.wrench, limit.lost)}."
    if held and np.isfinite(limit.bound) and limit.bound > limit.factor * (1.0 + 1e-6):
        below += f" Friction and torque limits alone would allow {size(limit.wrench, limit.bound)}."
    beyond = limit.some_equilibrium
    if beyond > max(limit.factor, limit.lost or 0.0) * (1.0 + 1e-6) and not np.isclose(beyond, limit.bound, rtol=1e-3):
        most = size(limit.wrench, beyond)
        below += f" Up to {most} there are forces in balance, which a load that grows does not reach."
    return outcome(drawn, title, "LIMIT" if held else "NO LIMIT", f"{limit.why}.", not held, below)


def _panels(limit: LoadLimit, grasp: Grasp) -> list[Panel]:
    """Those that this grasp has; the path knows no moments of soft fingers."""
    path = limit.path
    used = None if grasp.scene.soft else used_on_path(grasp.scene, path.forces, np.zeros(path.forces.shape[:2]))
    return panels_of(grasp, path.forces, used, path.displacement - path.displacement[0], path.torques)
