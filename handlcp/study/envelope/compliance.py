"""What passive compliance gives away: the limits of loading beside those of friction and torques alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from handlcp.check import Array


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
