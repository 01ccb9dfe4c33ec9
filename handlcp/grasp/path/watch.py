"""What is watched while a grasp is loaded: states of contacts and tendons, limits of torques and tensions, ends of
joint ranges, and how far contacts have slid.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, NumbersByName
from handlcp.grasp.failure.failure_mode import StateLimits, is_exceeded, limit_shares, state_limits
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.geometry import Geometry
from handlcp.grasp.path.state import OPEN, SLIDES, STICKS, Failure, State
from handlcp.grasp.path.step import Stepper

# ----------------------------------------------------------------
# Where inside a step a contact changes its state: one root finder on margins.

_CLOSE = 1e-3  # of a step: a change this close is where it is looked for
_TRIES = 8


def margins(stepper: Stepper, state: State) -> Array:
    """(n, 2) of each contact: how far it is from sliding and from opening, in newtons; below 0, what it has slid and
    opened in the step, as the force that would take it back.
    """
    k = stepper.stiffness
    read, limits = state.read, stepper.friction
    forces, slid = read.forces, state.slid
    lever = stepper.lever
    tangential = np.sqrt((forces[:, 0] ** 2 + forces[:, 1] ** 2) + (read.torsion * lever) ** 2)
    normal, gap = forces[:, 2], np.maximum(read.motion[:, 2], 0.0)
    slip = np.sqrt(slid[:, 0] ** 2 + slid[:, 1] ** 2 + (slid[:, 2] * stepper.length) ** 2)
    slides = np.array([kind == SLIDES for kind in state.kinds])
    opened = np.array([kind == OPEN for kind in state.kinds])
    friction = np.where(slides, -k * slip, np.maximum(limits * normal - tangential, 0.0))
    return np.column_stack([np.where(opened, np.inf, friction), np.where(opened, -k * gap, normal)])


def first_change(
    stepper: Stepper, state: State, found: State, at: Callable[[float], State | Failure]
) -> tuple[float, State]:
    """The part of a step up to just behind the first change of a contact that held, and the state there; 1 and the
    step's end where none changes. at : the state at a part of the step.
    """
    if state.kinds == found.kinds:
        return 1.0, found
    low, high = _Side(0.0, margins(stepper, state)), _Side(1.0, margins(stepper, found))
    for _ in range(_TRIES):
        changed = (low.margins > 0.0) & (high.margins < 0.0) & np.isfinite(low.margins)
        if not changed.any() or high.part - low.part < _CLOSE:
            break
        part = _crossing(low, high, changed) + 0.2 * _CLOSE
        if high.part - part < _CLOSE:
            break
        middle = at(part)
        if isinstance(middle, Failure):
            break
        m = margins(stepper, middle)
        if ((low.margins > 0.0) & (m < 0.0) & np.isfinite(low.margins)).any():
            high, found = high.moved(part, m), middle
        else:
            low = low.moved(part, m)
    return high.part, found


class _Side(NamedTuple):
    """Of the first change: a part of the step, margins there, and how fast they fall on this side of it, once two
    parts on this side are known.
    """

    part: float
    margins: Array
    falls: Array | None = None

    def moved(self, part: float, values: Array) -> _Side:
        """To margins at another part."""
        with np.errstate(invalid="ignore"):
            return _Side(part, values, (self.margins - values) / (part - self.part))


def _crossing(low: _Side, high: _Side, changed: Bools) -> float:
    """The part at which the first of these margins is zero, if each side goes on as it did; on a chord where neither
    side is known. Margins have a kink there: forces fall, then slips or gaps grow.
    """
    a, b, wide = low.margins[changed], high.margins[changed], high.part - low.part
    least = high.part
    for side, own in ((low, a), (high, b)):
        if side.falls is not None:
            falls = side.falls[changed]
            there = side.part + own / np.where(falls > 0.0, falls, np.inf)
            least = min(least, float(np.where(falls > 0.0, there, low.part + 0.5 * wide).min()))
    if low.falls is None and high.falls is None:
        least = low.part + wide * float((a / (a - b)).min())
    return max(least, low.part)


# ----------------------------------------------------------------
# How far contacts slide.

MAX_SLIP = 1e-3  # [m] by which a contact may slide, unless something else is said
_TIED = 1e-3  # of how far it may: contacts that are this near to it have slid as far together


def read_max_slip(value: Any, names: tuple[str, ...]) -> Array:
    """(n,) how far each contact may slide [m], from a number, inf, or numbers by contact. Raises InputError,
    UnknownName.
    """
    return NumbersByName("contact", above=0.0, finite=False, rest=MAX_SLIP).read("max_slip", value, names)


def slip_lengths(state: State) -> Array:
    """(n,) how far contacts that press slid in the step to this state [m]."""
    slides = np.array([kind == SLIDES for kind in state.kinds])
    return np.where(slides, np.hypot(state.slid[:, 0], state.slid[:, 1]), 0.0)


def is_at_max_slip(slipped: Array, max_slip: Array) -> Bools:
    """(n,) which contacts have slid as far as they may, or nearly so, where the first has."""
    return np.asarray(slipped >= (1.0 - _TIED) * max_slip)


# ----------------------------------------------------------------

_NEAR = 1e-6  # of the contacts' distances from their centre: fingertips no farther than this touch already
_BEGINS = ("over limit", "over tension", "slackens", "yields", "range end")
_ENDS = ("within limit", "within tension", "tightens", "holds", "range")


@dataclass(frozen=True, slots=True)
class Watch:
    """limits : of torques and ranges. near : gaps up to this are none [m]. max_slip (n,) : how far each contact may
    slide [m].
    """

    limits: StateLimits
    near: float
    max_slip: Array

    def events(self, a: State, b: State, stage: str, number: int, share: float) -> list[Event]:
        """What happens from one state to the next."""
        return [Event(kind, who, stage, share, number) for kind, who in self._between(a, b)]

    def _between(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """(kind, who)."""
        if a.kinds != b.kinds:
            yield from self._contacts(a, b)
        yield from self._joints(a, b)

    def _contacts(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """What contacts do."""
        gaps = a.read.motion[:, 2] if len(a.start) else a.loads.base[:, 2]
        for name, before, now, gap in zip(self.limits.names, a.kinds, b.kinds, gaps.tolist(), strict=True):
            if before == now:
                continue
            if now == OPEN:
                yield "opens", name
            elif before == OPEN and gap > self.near:
                yield "touches", name
            if now == SLIDES or (now == STICKS and before == SLIDES):
                yield "slips" if now == SLIDES else "sticks", name

    def _joints(self, a: State, b: State) -> Iterator[tuple[str, str]]:
        """What joints and tendons do."""
        joints, tendons = self.limits.joints, self.limits.tendons
        if not joints:
            return
        marks, parts = [], [len(joints), len(joints) + len(tendons)]
        for s in (a, b):
            torque, tension, outside = np.split(is_exceeded(limit_shares(self.limits, s.efforts, s.where.q)), parts)
            marks.append((torque, tension, s.pull.slack, s.yielded != 0.0, outside))
        names = joints, tendons, tendons, joints, joints
        for ends, begins, of, before, now in zip(_ENDS, _BEGINS, names, *marks, strict=True):
            for j in np.flatnonzero(before != now).tolist():
                yield (begins if now[j] else ends), of[j]


def watch_of(spec: GraspSpec, geometry: Geometry, max_slip: Array) -> Watch:
    """All contacts and joints of a grasp. max_slip (n,) : as in `Watch`."""
    near = _NEAR * float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
    return Watch(
        state_limits(spec, ranges=geometry.follows), near, max_slip
    )  # elsewhere joints are measured from the posture
