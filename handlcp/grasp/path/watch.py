"""What is watched while a grasp is loaded: states of contacts, torque limits, ends of joint ranges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handlcp.grasp.cause.judge import Limits, exceeded, limits_of, used
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.geometry import Geometry
from handlcp.grasp.path.state import State

__all__ = ["Watch", "watch_of"]

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
