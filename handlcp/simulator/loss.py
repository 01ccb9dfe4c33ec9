"""What a simulated object has done so far: whether it moves slowly, rests, or is lost.

Loads wait while the object moves fast, so that damping takes up no more than a small part of them. An object that is
lost ends far away, under the load at which it began to move fast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.simulator.probe import Reading

_FAR = 2.0  # times the reach of the contacts: an object that has moved this far is lost


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
        return max(swiftness(r.speed, reach) for r in self.readings[-last:])

    def record(self) -> Record:
        """All of them, as arrays."""
        names = ("forces", "friction", "motion", "speed", "torques")
        parts = {name: read_only(np.array([getattr(r, name) for r in self.readings])) for name in names}
        return Record(stages=tuple(self.stages), shares=read_only(np.array(self.shares)), period=self.period, **parts)


def escaped(reading: Reading, reach: float) -> bool:
    """Whether the object is far from where it started. An object that turns between fingertips is still held."""
    return math.hypot(*reading.motion[:3]) > _FAR * reach


def swiftness(vector: Any, reach: float) -> float:
    """[m, m/s] of a translation and a turn, the turn counted at the contacts."""
    return math.hypot(*vector[:3]) + reach * math.hypot(*vector[3:])
