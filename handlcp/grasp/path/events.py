"""What happens while a grasp is loaded: a finger slips or lets go, a joint reaches its limit, the object is lost.

Several fingers often slip at one place, and a finger near its limit may slip and stick by turns. `summary` says each of
these once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from handlcp import words
from handlcp.grasp.failure.failure_text import BY_TURNS, describe_direction, describe_event
from handlcp.grasp.model.request import GraspSpec
from handlcp.record import Record

_LOST = "lost"
_UNDONE = {
    "sticks": "slips", "touches": "opens", "within limit": "over limit", "within tension": "over tension",
    "tightens": "slackens", "holds": "yields", "range": "range end",
}  # fmt: skip
_NEAR = 0.01  # of a stage: events of one kind no further apart are told as one
_START = 0.005  # of a stage
_TURNS, _APART = 3, 0.03  # so many changes of one finger, each no further from the last, are "by turns"


@dataclass(frozen=True, slots=True)
class Event(Record):
    """kind : "slips", "sticks", "opens", "touches" (a contact), "over limit", "within limit", "yields", "holds",
    "range end", "range" (a joint), "over tension", "within tension", "slackens", "tightens" (a tendon), "snaps" (the
    object, which comes to rest again elsewhere), "slides" (a contact that has slid as far as it may), "lost". who : the
    finger, the joint,
    the tendon or "the object"; for "lost" the reason. stage : its name. share : of the stage, 0 to 1, at the end of the
    step in which it happens. number : of the stage, from 0. moved [m], turned [rad] : how far the object snaps. pushed
    (6,) : where the object was in balance, but not stable: the motion in which a small push makes it snap; (): no state
    in balance was left.
    """

    kind: str
    who: str
    stage: str
    share: float
    number: int = 0
    moved: float = 0.0
    turned: float = 0.0
    pushed: tuple[float, ...] = ()

    @property
    def sentence(self) -> str:
        """What happens, without the place."""
        if self.kind == _LOST:
            return f"the object is lost: {self.who}"
        return describe_event(self.kind, (self.who,)) + jump(self.moved, self.turned, self.pushed)

    def __str__(self) -> str:
        return f"{self.stage}, {_at(self.share)}: {self.sentence}"


@dataclass(frozen=True, slots=True)
class Summary(Record):
    """Events of one kind at one place. kind : as in `Event`, or with " by turns" after it. stage, number : its name and
    number. share, until : of the stage, of the first event and of the last. who : the fingers or joints, or the object.
    sentence : in words, without the place.
    """

    entries = ("kind", "stage", "number", "share", "until", "who", "sentence", "text")

    kind: str
    stage: str
    number: int
    share: float
    until: float
    who: tuple[str, ...]
    sentence: str

    @property
    def at(self) -> str:
        """Such as "46 %", "46 % to 49 %", "start"."""
        first, last = _at(self.share), _at(self.until)
        return f"{first} to {last}" if self.kind.endswith(BY_TURNS) and first != last else first

    @property
    def where(self) -> str:
        """Such as "load, 46 %"."""
        return f"{self.stage}, {self.at}"

    @property
    def text(self) -> str:
        """What happens, after the place."""
        return f"{self.where}: {self.sentence}"

    def __str__(self) -> str:
        return self.text


def _at(share: float) -> str:
    """Such as "46 %"; "start" and "end" of a stage where a step cannot tell it from these."""
    return "start" if share < _START else "end" if share > 1.0 - 1e-9 else words.format_percent(share)


def summary(events: Iterable[Event], spec: GraspSpec) -> tuple[Summary, ...]:
    """Events in their order, those of one kind at one place as one; "lost" is left out.

    spec : of the grasp, which knows the names of all fingers and joints.
    """
    groups = list[_Group]()
    for new in _by_turns(events):
        for old in reversed(groups):
            if old.takes(new):
                old.who += new.who
                old.until = max(old.until, new.until)
                break
        else:
            groups.append(new)
    mechanism = spec.mechanism
    joints = () if mechanism is None else mechanism.names
    tendons = () if mechanism is None or mechanism.joint_model.cables is None else mechanism.joint_model.cables.names
    order = {name: k for k, name in enumerate((*spec.names, *joints, *tendons))}
    for g in groups:
        g.who.sort(key=lambda name: order.get(name, -1))
    return tuple([
        Summary(g.kind, g.stage, g.number, g.share, g.until, tuple(g.who), g.said(spec))
        for g in groups
    ])  # fmt: skip


@dataclass(slots=True)
class _Group:
    """As `Summary`, while it grows."""

    kind: str
    stage: str
    number: int
    share: float
    until: float
    who: list[str]
    moved: float = 0.0
    turned: float = 0.0
    pushed: tuple[float, ...] = ()

    def said(self, spec: GraspSpec) -> str:
        """In words, without the place."""
        return describe_event(self.kind, self.who, spec) + jump(self.moved, self.turned, self.pushed)

    def takes(self, other: _Group) -> bool:
        """Whether what another finger does is the same, at the same place."""
        since = self.until if self.kind.endswith(BY_TURNS) else self.share
        same = (self.kind, self.number) == (other.kind, other.number) and other.who[0] not in self.who
        return same and other.share - since <= _NEAR


def _by_turns(events: Iterable[Event]) -> Iterator[_Group]:
    """Each event; what one finger does and undoes several times becomes one group, where the first of it is."""
    left = [e for e in events if e.kind != _LOST]
    while left:
        first = left[0]
        family, run = _UNDONE.get(first.kind, first.kind), [first]
        for e in left[1:]:
            if e.who != first.who or _UNDONE.get(e.kind, e.kind) != family:
                continue
            if e.number != first.number or e.share - run[-1].share > _APART:
                break
            run.append(e)
        run = run if len(run) >= _TURNS else [first]
        kind = first.kind if len(run) == 1 else family + BY_TURNS
        moved, turned = sum([e.moved for e in run]), sum([e.turned for e in run])
        until, who = run[-1].share, [first.who]
        yield _Group(kind, first.stage, first.number, first.share, until, who, moved, turned, first.pushed)
        left = [e for e in left if all(e is not other for other in run)]


def jump(moved: float, turned: float, pushed: tuple[float, ...] = ()) -> str:
    """Such as ", by 5.5 mm and 14°", and the small push that makes an object in balance do it; "" for no jump."""
    parts = [words.format_length(moved)] * (moved > 0.0) + [words.format_angle(turned)] * (turned > 1e-4)
    far = f", by {' and '.join(parts)}" if parts else ""
    return f"{far}: it was in balance, which a small push{describe_direction(np.array(pushed))} ends" if pushed else far
