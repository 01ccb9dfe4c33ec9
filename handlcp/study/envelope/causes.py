"""What gives out first in each direction, in words and as shares of all directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp import words
from handlcp.check import Array, Ints
from handlcp.grasp.limits.result import EQUILIBRIUM, MOTION, OPENS, RANGE, SLIPS, TORQUE, Bind

__all__ = ["NOTHING", "UNDECIDED", "Cause", "causes_of", "said"]

NOTHING = "nothing gives out"
UNDECIDED = "undecided"  # kind of what binds where no limit was found, although there must be one
_ONE = {
    SLIPS: "{} slips through", OPENS: "{} lets go", TORQUE: "{} at its torque limit", RANGE: "{} at its range’s end",
    EQUILIBRIUM: "balance is lost", MOTION: "the object moves too far", UNDECIDED: "undecided",
}  # fmt: skip
_SEVERAL = _ONE | {
    SLIPS: "{} slip through", OPENS: "{} let go", TORQUE: "{} at their torque limits",
    RANGE: "{} at their ranges’ ends",
}  # fmt: skip

Binds = tuple[Bind, ...]


@dataclass(frozen=True, slots=True)
class Cause:
    """What gives out first, in some of the directions.

    binds : as in `Envelope.binds`; () where nothing gives out. says : in words. share : of all directions.
    least, median : of the factors there, by solid angle; infinite where nothing gives out, NaN where undecided.
    """

    binds: Binds
    says: str
    share: float
    least: float
    median: float


def causes_of(
    binds: Sequence[Binds], factors: Array, shares: Array, contacts: Sequence[str]
) -> tuple[tuple[Cause, ...], Ints]:
    """The causes, the most frequent first; and (m,) the number of each direction's cause. shares (m,) : what part of
    all directions each stands for. contacts : their names.
    """
    keys = [frozenset(some) for some in binds]
    first = dict[frozenset[Bind], int]()
    for k, key in enumerate(keys):
        first.setdefault(key, k)
    number = {key: k for k, key in enumerate(first)}
    own = np.array([number[key] for key in keys], dtype=np.int64)
    part = np.bincount(own, shares, len(first))
    order = np.argsort(-part, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    found = []
    for k in order.tolist():
        here = own == k
        some = binds[int(np.flatnonzero(here)[0])]
        middle = _median(factors[here], shares[here])
        found.append(Cause(some, said(some, contacts), float(part[k]), float(factors[here].min()), middle))
    return tuple(found), rank[own]


def said(binds: Binds, contacts: Sequence[str]) -> str:
    """Such as "all contacts slip through", "finger 1, finger 2 slip through", "finger_1_distal at its torque limit"."""
    if not binds:
        return NOTHING
    kinds = dict.fromkeys(b.kind for b in binds)
    return "; ".join(_of_a_kind(kind, [b.who for b in binds if b.kind == kind], contacts) for kind in kinds)


def _of_a_kind(kind: str, who: list[str], contacts: Sequence[str]) -> str:
    every = len(who) > 2 and sorted(who) == sorted(contacts)
    return (_ONE if len(who) == 1 else _SEVERAL)[kind].format("all contacts" if every else words.listed(who))


def _median(values: Array, shares: Array) -> float:
    """With these weights."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(shares[order])
    return float(values[order][np.searchsorted(below, 0.5 * below[-1])])
