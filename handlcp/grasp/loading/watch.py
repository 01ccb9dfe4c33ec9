"""What is watched while a grasp is loaded: states of contacts, torque limits, ends of joint ranges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.loading.events import Event
from handlcp.grasp.loading.geometry import Geometry
from handlcp.grasp.loading.state import State
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["Watch", "watch_of"]

_NEAR = 1e-6  # of the contacts' distances from their centre: fingertips no farther than this touch already
_BEGINS = ("over limit", "yields", "range end")
_ENDS = ("within limit", "holds", "range")


@dataclass(frozen=True, slots=True)
class Watch:
    """names (n,) : of the contacts. joints (nv,) : names; limits (nv,) : of their torques [N·m]; lower, upper (nv,) :
    ends of their ranges [rad, m]; all empty without a hand. near : gaps up to this are none [m].
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]
    limits: Array
    lower: Array
    upper: Array
    near: float

    def marks(self, q: Array, torque: Array, yielded: Array) -> tuple[bytes, bytes, bytes]:
        """(nv,) truth values each: which joints need more than their limit, yield there, or are out of their range."""
        outside = (q < self.lower) | (q > self.upper)
        return (abs(torque) > self.limits).tobytes(), (yielded != 0.0).tobytes(), outside.tobytes()

    def changed(self, a: State, b: State) -> bool:
        """Whether anything happens between two states."""
        same = a.kinds == b.kinds and a.marks == b.marks
        return not same and next(self._between(a, b), None) is not None

    def events(self, a: State, b: State, stage: str, number: int, share: float) -> list[Event]:
        """What happens from one state to the next."""
        return [Event(kind, who, stage, share, number) for kind, who in self._between(a, b)]

    def _between(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """(kind, who)."""
        gaps = a.read.motion[:, 2] if len(a.start) else a.loads.base[:, 2]
        for name, before, now, gap in zip(self.names, a.kinds, b.kinds, gaps.tolist(), strict=True):
            if before == now:
                continue
            if now == "separated":
                yield "opens", name
            elif before == "separated" and gap > self.near:
                yield "touches", name
            if now == "sliding" or (now == "sticking" and before == "sliding"):
                yield "slips" if now == "sliding" else "sticks", name
        for ends, begins, before_, now_ in zip(_ENDS, _BEGINS, a.marks, b.marks, strict=True):
            for joint, was, is_now in zip(self.joints, before_, now_, strict=True):
                if was != is_now:
                    yield (begins if is_now else ends), joint


def watch_of(spec: GraspSpec, geometry: Geometry) -> Watch:
    """All contacts and joints of a grasp."""
    mechanism = spec.mechanism
    near = _NEAR * float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
    if mechanism is None:
        none = np.zeros(0)
        return Watch(spec.names, (), none, none, none, near)
    ranges = mechanism.ranges if geometry.follows else None  # elsewhere joints are measured from the posture
    lower, upper = ranges or (np.full(len(mechanism.names), -np.inf), np.full(len(mechanism.names), np.inf))
    return Watch(spec.names, mechanism.names, mechanism.limits, lower, upper, near)
