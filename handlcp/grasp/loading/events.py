"""What happens while a grasp is loaded: a finger slips or lets go, a joint reaches its limit, the object is lost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools
from handlcp.grasp.loading.state import State
from handlcp.grasp.model.mechanism import JointReading

__all__ = ["Event", "Watch"]

_SENTENCES = {
    "slips": "{who} begins to slip", "sticks": "{who} sticks again", "opens": "{who} loses contact",
    "touches": "{who} touches the object", "over limit": "{who} needs more than its torque limit",
    "within limit": "{who} is within its torque limit again", "yields": "{who} yields at its torque limit",
    "holds": "{who} holds again, below its torque limit", "range end": "{who} passes the end of its range",
    "range": "{who} is within its range again", "lost": "the object is lost: {who}",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Event:
    """kind : "slips", "sticks", "opens", "touches" (a contact), "over limit", "within limit", "yields", "holds",
    "range end", "range" (a joint), "lost". who : the finger or the joint; for "lost" the reason. stage : its name.
    share : of the stage, 0 to 1, when it was there; it came after the step before.
    """

    kind: str
    who: str
    stage: str
    share: float

    def __str__(self) -> str:
        return f"{self.stage}, {words.percent(self.share)}: {_SENTENCES[self.kind].format(who=self.who)}"


@dataclass(frozen=True, slots=True)
class Watch:
    """What is watched. names (n,) : of the contacts. joints (nv,) : names; limits (nv,) : of their torques [N·m];
    lower, upper (nv,) : ends of their ranges [rad, m]; all empty without a hand. near : gaps up to this are none [m].
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]
    limits: Array
    lower: Array
    upper: Array
    near: float

    def changed(self, a: State, b: State) -> bool:
        """Whether anything happens between two states."""
        return next(self._between(a, b), None) is not None

    def events(self, a: State, b: State, stage: str, share: float) -> list[Event]:
        """What happens from one state to the next."""
        return [Event(kind, who, stage, share) for kind, who in self._between(a, b)]

    def _between(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """(kind, who)."""
        if a.kinds != b.kinds:
            for name, before, now, gap in zip(self.names, a.kinds, b.kinds, a.gap.tolist(), strict=True):
                if before == now:
                    continue
                if now == "separated":
                    yield "opens", name
                elif before == "separated" and gap > self.near:
                    yield "touches", name
                if now == "sliding" or (now == "sticking" and before == "sliding"):
                    yield "slips" if now == "sliding" else "sticks", name
        if a.joints is not None and b.joints is not None:
            for ends, begins, was, is_now in self._joints(a, b, a.joints, b.joints):
                for j in np.flatnonzero(was != is_now).tolist():
                    yield (begins if is_now[j] else ends), self.joints[j]

    def _joints(
        self, a: State, b: State, first: JointReading, last: JointReading
    ) -> Iterator[tuple[str, str, Bools, Bools]]:
        """(what it is called when it ends, when it begins, (nv,) whether it was so, whether it is)."""
        yield "within limit", "over limit", abs(first.torque) > self.limits, abs(last.torque) > self.limits
        yield "holds", "yields", first.yielded != 0.0, last.yielded != 0.0
        yield "range", "range end", self._outside(a), self._outside(b)

    def _outside(self, s: State) -> Bools:
        return np.asarray((s.where.q < self.lower) | (s.where.q > self.upper))
