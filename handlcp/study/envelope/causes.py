"""What gives out first in each direction, in words and as shares of all directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.cause.judge import Cause
from handlcp.grasp.cause.wording import said
from handlcp.grasp.model.spec import GraspSpec

# ----------------------------------------------------------------
# What passive compliance gives away: the limits of loading beside those of friction and torques alone.


@dataclass(frozen=True, slots=True)
class Compliance:
    """Factors as shares of the bound, over the directions in which both are finite, and the bound positive.

    median, least : shares; NaN where there is no such direction. number : of the direction with the least share.
    """

    median: float
    least: float
    number: int

    @classmethod
    def of(cls, factors: Array, bound: Array, shares: Array) -> Self:
        """Shares (m,) : what part of all directions each stands for."""
        known = np.flatnonzero(np.isfinite(bound) & (bound > 0.0) & np.isfinite(factors))
        if not len(known):
            return cls(np.nan, np.nan, 0)
        kept = factors[known] / bound[known]
        order = np.argsort(kept, kind="stable")
        below = np.cumsum(shares[known][order])
        middle = kept[order][np.searchsorted(below, 0.5 * below[-1])]
        return cls(float(middle), float(kept[order[0]]), int(known[order[0]]))


# ----------------------------------------------------------------

Binds = tuple[Cause, ...]


@dataclass(frozen=True, slots=True)
class Sector:
    """Directions in which the same gives out first.

    binds : as in `Envelope.binds`; () where nothing gives out. says : in words. share : of all directions.
    least, median : of the factors there, by solid angle; infinite where nothing gives out, NaN where undecided.
    """

    binds: Binds
    says: str
    share: float
    least: float
    median: float


def causes_of(
    binds: Sequence[Binds], factors: Array, shares: Array, spec: GraspSpec
) -> tuple[tuple[Sector, ...], Ints]:
    """The causes, the most frequent first; and (m,) the number of each direction's cause. shares (m,) : what part of
    all directions each stands for. spec : of the grasp.
    """
    keys = [frozenset(some) for some in binds]
    first = dict[frozenset[Cause], int]()
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
        found.append(Sector(some, said(some, spec), float(part[k]), float(factors[here].min()), middle))
    return tuple(found), rank[own]


def _median(values: Array, shares: Array) -> float:
    """With these weights."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(shares[order])
    return float(values[order][np.searchsorted(below, 0.5 * below[-1])])
