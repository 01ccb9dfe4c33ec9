"""Whether a simulated object is lost, and since when.

An object that is lost ends far away. It was last in balance where it was slow, and its acceleration took up no more
than a small part of the load.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.simulator.probe import Reading

__all__ = ["Record", "Track", "escaped", "lost_at"]

_FAR = 1.0  # times the reach of the contacts: an object that has moved this far is lost
_FAST = 0.02  # [m/s] faster than any quasi-static motion
_UNBALANCED = 0.01  # of the load, taken up by acceleration
_LEAST = 0.05  # of the contact forces: the load counts as at least this much


@dataclass(frozen=True, eq=False)
class Record:
    """m moments of a simulation, one every `period` [s]; world axes.

    stages (m,) names, and shares (m,) of the stage. forces (m, n, 3) [N] of the contacts on the object. friction (m, n)
    share of its limit that each contact uses, 0 without force. motion (m, 6) [m, rad] of the object since the start.
    speed (m, 6). torques (m, nv) [N·m].
    """

    stages: tuple[str, ...]
    shares: Array
    forces: Array
    friction: Array
    motion: Array
    speed: Array
    torques: Array
    period: float


@dataclass(eq=False)
class Track:
    """Readings as they come, one every `period` [s]."""

    period: float
    stages: list[str] = field(default_factory=list)
    shares: list[float] = field(default_factory=list)
    readings: list[Reading] = field(default_factory=list)

    def add(self, stage: str, share: float, reading: Reading) -> None:
        """The next one."""
        self.stages.append(stage)
        self.shares.append(share)
        self.readings.append(reading)

    def fastest(self, last: int, reach: float) -> float:
        """[m/s] of the last readings, turning counted at the contacts."""
        return max(_swiftness(r.speed, reach) for r in self.readings[-last:])

    def record(self) -> Record:
        """All of them, as arrays."""
        names = ("forces", "friction", "motion", "speed", "torques")
        parts = {name: read_only(np.array([getattr(r, name) for r in self.readings])) for name in names}
        return Record(stages=tuple(self.stages), shares=read_only(np.array(self.shares)), period=self.period, **parts)


def escaped(reading: Reading, reach: float) -> bool:
    """Whether the object is far from where it started."""
    return _swiftness(reading.motion, reach) > _FAR * reach


def lost_at(record: Record, reach: float, mass: float, load: float) -> tuple[str, float]:
    """Stage, and share of it, when an object that is lost at the end of the record was last in balance.

    reach : [m] of the contacts. mass : [kg] that is accelerated. load : [N] the size of all of the load.
    """
    change = np.diff(record.speed, axis=0, prepend=record.speed[:1]) / record.period
    unbalanced = mass * np.array([_swiftness(a, 0.4 * reach) for a in change])  # 0.4: a ball's inertia
    carried = np.linalg.norm(record.forces, axis=2).sum(axis=1)
    loading = np.array([0.0 if s == "squeeze" else x for s, x in zip(record.stages, record.shares, strict=True)])
    allowed = _UNBALANCED * np.maximum(load * loading, _LEAST * carried)
    fast = np.array([_swiftness(v, reach) for v in record.speed]) > _FAST
    still = np.flatnonzero(~fast & (unbalanced <= allowed))
    k = int(still[-1]) if len(still) else 0
    stage = record.stages[min(k + 1, len(record.stages) - 1)]  # at rest at the end of a stage: lost in the next one
    return stage, float(record.shares[k]) if record.stages[k] == stage else 0.0


def _swiftness(vector: Any, reach: float) -> float:
    """Of a translation and a turn, the turn counted at the contacts."""
    return float(np.linalg.norm(vector[:3]) + reach * np.linalg.norm(vector[3:]))
