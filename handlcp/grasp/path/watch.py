"""What is watched while a grasp is loaded: states of contacts, torque limits, ends of joint ranges, and how fast the
object gives way.

While something that presses sticks, fingers hold the object, and the fastest that it gives way then is what they allow.
Once nothing sticks, all that it goes beyond `FASTER` times that rate adds up, and what it falls short of that is taken
off again; at `RUNS` it slides through. A short burst of speed, as where a contact's slip turns to the next face of its
friction pyramid, goes nowhere, and does not count.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handlcp.grasp.cause.judge import Limits, exceeded, limits_of, used
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.geometry import Geometry
from handlcp.grasp.path.state import State
from handlcp.tolerances import FASTER, RUNS

_NEAR = 1e-6  # of the contacts' distances from their centre: fingertips no farther than this touch already
_BEGINS = ("over limit", "yields", "range end")
_ENDS = ("within limit", "holds", "range")


@dataclass(frozen=True, slots=True)
class Watch:
    """limits : of torques and ranges. torques (nv,) : limits at which joints yield, too. near : gaps up to this are
    none [m].
    """

    limits: Limits
    near: float

    def events(self, a: State, b: State, stage: str, number: int, share: float) -> list[Event]:
        """What happens from one state to the next."""
        return [Event(kind, who, stage, share, number) for kind, who in self._between(a, b)]

    def _between(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """(kind, who)."""
        gaps = a.read.motion[:, 2] if len(a.start) else a.loads.base[:, 2]
        for name, before, now, gap in zip(self.limits.names, a.kinds, b.kinds, gaps.tolist(), strict=True):
            if before == now:
                continue
            if now == "separated":
                yield "opens", name
            elif before == "separated" and gap > self.near:
                yield "touches", name
            if now == "sliding" or (now == "sticking" and before == "sliding"):
                yield "slips" if now == "sliding" else "sticks", name
        yield from self._joints(a, b)

    def _joints(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """What joints do."""
        limits, nv = self.limits, len(self.limits.joints)
        if not nv:
            return
        marks = []
        for s in (a, b):
            beyond = exceeded(used(limits, s.read.torque, s.where.q))
            marks.append((beyond[:nv], s.yielded != 0.0, beyond[nv:]))
        for ends, begins, before, now in zip(_ENDS, _BEGINS, *marks, strict=True):
            for j in np.flatnonzero(before != now).tolist():
                yield (begins if now[j] else ends), limits.joints[j]


def watch_of(spec: GraspSpec, geometry: Geometry) -> Watch:
    """All contacts and joints of a grasp."""
    near = _NEAR * float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
    return Watch(limits_of(spec, ranges=geometry.follows), near)  # elsewhere joints are measured from the posture


class Rate:
    """Of a stage. least : the shortest step that tells, a shorter one lies between changes at one load. loads : whether
    a load changes in the stage. stuck : the fastest while something stuck. last : of the last step; 0 at the beginning
    and after a snap. beyond : how far the object has gone too far, as `Stepper.far` has it.
    """

    def __init__(self, least: float, loads: bool) -> None:
        self.least, self.loads, self.stuck, self.last, self.beyond = least, loads, 0.0, 0.0, 0.0

    def sticks(self, rate: float, size: float) -> None:
        """Note the rate of a step of this size in which something sticks."""
        self.beyond = 0.0
        if size >= self.least:
            self.stuck = max(self.stuck, rate)

    def runs(self, rate: float, size: float) -> float | None:
        """The part of a step of this size in which nothing sticks at which the object slides through; None: none."""
        more = (rate - FASTER * self.stuck) * size
        before, self.beyond = self.beyond, max(self.beyond + more, 0.0)
        return None if self.beyond < RUNS else min(max((RUNS - before) / more, 0.0), 1.0)

    def snaps(self, far: float) -> None:
        """The object has moved so far at one load."""
        self.last = 0.0
        self.beyond += far


def reached(first: float, second: float, a: float, b: float) -> float:
    """The rate at the end of a step, 1, on the exponential through those at a and b; no more than twice the second."""
    if not 0.0 < first < second:
        return second
    return float(second * min((second / first) ** ((1.0 - b) / (b - a)), 2.0))
