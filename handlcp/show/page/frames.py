"""Snapshots as what the page's viewer reads: numbers to draw, and words to print beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array
from handlcp.show.page.snapshot import Snapshot
from handlcp.show.picture.content import LONGEST, NO_MOMENT
from handlcp.show.picture.overlay import nice

_STATES = {"sticking": "sticks", "sliding": "slides", "separated": "open"}


class Frames:
    """All frames in the same units and to the same scales.

    per_newton : length of a force arrow [m/N]. slip_factor : by how much slips are magnified; 0: nothing slides.
    """

    def __init__(self, shown: Sequence[Snapshot], size: float, model: Any, kinematics: Any) -> None:
        self.shown, self.size, self._model, self._kinematics = shown, size, model, kinematics
        strongest = max(float(np.linalg.norm(s.forces, axis=1).max(initial=0.0)) for s in shown)
        # A load that nothing balances is often far larger than the forces of the steps
        loads = max((0.6 if s.states[0] or len(shown) == 1 else 0.25) * float(np.linalg.norm(s.load)) for s in shown)
        self.per_newton = LONGEST * size / (max(strongest, loads) or 1.0)
        slips = [float(np.hypot(*s.slip[i])) for s in shown for i, state in enumerate(s.states) if state == "sliding"]
        self.largest_slip = max(slips, default=0.0)
        self.slip_factor = nice(0.45 * size / self.largest_slip) if self.largest_slip > words.NOTHING else 0.0
        self.turns = any((abs(s.torsion) > NO_MOMENT).any() for s in shown)
        self._slip = words.length_unit([x for s in shown for x in np.hypot(*s.slip.T).tolist()])
        self._gap = words.length_unit([x for s in shown for x in s.gap.tolist()])
        self._data: Any = None if model is None else model.createData()

    @property
    def columns(self) -> list[str]:
        """Headings of the table of contacts."""
        moment = ["moment\nmN·m"] if self.turns else []
        slip, gap = f"slip\n{self._slip.name}", f"gap\n{self._gap.name}"
        return ["contact", "state", "normal\nN", "friction\nN", *moment, "of\nlimit", slip, gap]

    def to_list(self) -> list[dict[str, Any]]:
        """Of all snapshots."""
        return [self._frame(s) for s in self.shown]

    def _frame(self, s: Snapshot) -> dict[str, Any]:
        torque = float(np.linalg.norm(s.moment))
        return {
            "label": s.label,
            "joints": None if s.q is None else self._joints(s.q),
            "object": _pose(s.object),
            "contacts": [self._contact(s, i) for i in range(len(s.positions))],
            "load": {
                "at": s.acts_at, "force": s.load, "moment": s.moment if torque > NO_MOMENT else np.zeros(3),
                "says": self._load_says(s.load, torque),
            },
            "torques": s.torques,
        }  # fmt: skip

    def _joints(self, q: Array) -> list[list[float]]:
        """Poses of all joints of the model, the base first."""
        pin.forwardKinematics(self._model, self._data, self._kinematics.configuration(q))
        return [_pose(m) for m in self._data.oMi]

    def _contact(self, s: Snapshot, i: int) -> dict[str, Any]:
        moment = float(s.torsion[i])
        R = s.axes[i]
        return {
            "at": s.positions[i], "axes": R.T, "state": s.states[i], "force": R @ s.forces[i],
            "normal": float(s.forces[i, 2]), "moment": moment if abs(moment) > NO_MOMENT else 0.0,
            "slip": R[:, :2] @ s.slip[i], "says": self._says(s, i), "row": self._row(s, i),
        }  # fmt: skip

    def _says(self, s: Snapshot, i: int) -> str:
        """Below the contact's name in the picture."""
        state, moment = s.states[i], abs(float(s.torsion[i]))
        if state == "":
            return s.friction[i]
        if state == "separated":
            gap = float(s.gap[i])
            return f"open, {words.length(gap)}" if gap > words.NOTHING else "open"
        turned = f", {words.torque(moment)}" if moment > NO_MOMENT else ""
        x, y, normal = s.forces[i].tolist()
        return f"{words.push(normal, float(np.hypot(x, y)))}{turned}, {_STATES[state]}"

    def _row(self, s: Snapshot, i: int) -> list[str]:
        """Of the table of contacts, without the name."""
        x, y, z = s.forces[i].tolist()
        moment = [_number(1e3 * float(s.torsion[i]))] if self.turns else []
        slip, gap = self._slip(float(np.hypot(*s.slip[i]))), self._gap(float(s.gap[i]))
        if s.states[i] == "":
            return ["–"] * (6 + len(moment))
        friction = _number(float(np.hypot(x, y)))
        return [_STATES[s.states[i]], _number(z), friction, *moment, words.percent(float(s.used[i])), slip, gap]

    @staticmethod
    def _load_says(force: Array, torque: float) -> str:
        size = float(np.linalg.norm(force))
        parts = [words.force(size)] if size > 0.0 else []
        return " and ".join([*parts, *([words.torque(torque)] if torque > NO_MOMENT else [])])


def _pose(m: Any) -> list[float]:
    """x, y, z [m] and the quaternion x, y, z, w of a pin.SE3."""
    return [float(x) for x in pin.SE3ToXYZQUAT(m)]


def _number(value: float) -> str:
    """Three digits that matter, as few as two decimals."""
    value = 0.0 if abs(value) < 5e-4 else value
    return f"{value:.3f}" if abs(value) < 10 else f"{value:.2f}" if abs(value) < 100 else f"{value:.1f}"
