"""A chance from samples, and the interval that covers the truth with a given confidence.

The samples come in R blocks. Each block is a set of Sobol points, scrambled on its own, so its share of held samples is
an unbiased estimate, and the R estimates are independent. Their spread gives Student's interval. It is widened by
ln(2/α)/N: what never happens among N samples may still happen with that chance (the rule of three, for 1 - α). With
independent samples instead, an interval would be wider, because Sobol points fill the space more evenly.

Source: Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences" (1995); L'Ecuyer et al., "Confidence intervals for
randomized quasi-Monte Carlo estimators", Winter Simulation Conference (2023).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from handlcp.check import Array, Bools, Ints

_OF_SUBSET = 0.2  # part of α that goes to what was not solved in full


@dataclass(frozen=True, slots=True)
class Chance:
    """value : the estimate. low, high : ends of the interval that covers the truth with this confidence."""

    value: float
    low: float
    high: float
    confidence: float

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        """In percent, with as many digits as the interval is sure of."""
        width = 100 * (self.high - self.low)
        digits = min(max(1 - math.floor(math.log10(width)), 1), 6) if width > 0.0 else 1
        value, low, high = (percent(x, digits) for x in (self.value, self.low, self.high))
        return f"{value} % ({100 * self.confidence:.4g} % interval {low} to {high} %)"


def chance_of(good: Bools, left: Bools, open_: Bools, again: tuple[Bools, Bools], size: int, level: float) -> Chance:
    """The chance of a good sample, from N samples in blocks of `size`, (N,) each.

    good : surely. left : nobody looked any further. open_ : neither good nor bad after a full look.
    again : (looked at in full, good among them); they tell how many of those left are good.
    """
    looked, found = int(again[0].sum()), int(again[1].sum())
    alpha, share, low, high = 1.0 - level, 0.0, 0.0, 1.0
    if left.any():
        inner, alpha = _OF_SUBSET * alpha, (1.0 - _OF_SUBSET) * alpha
        share = found / looked if looked else 0.0
        low, high = clopper_pearson(found, looked, inner)
    else:
        low = high = 0.0
    value = float(np.mean(good + share * left))
    down = student(_by_block(good + low * left, size), size, alpha)[0]
    up = student(_by_block(good + high * left + open_, size), size, alpha)[1]
    return Chance(value, min(down, value), max(up, value), level)


def student(shares: Array, size: int, alpha: float) -> tuple[float, float]:
    """Both ends of the interval, from the shares (R,) of good samples of R ≥ 2 blocks of `size` samples each."""
    count = len(shares)
    half = float(stats.t.ppf(1.0 - alpha / 2.0, count - 1)) * float(shares.std(ddof=1)) / math.sqrt(count)
    half += math.log(2.0 / alpha) / (count * size)
    mean = float(shares.mean())
    return max(mean - half, 0.0), min(mean + half, 1.0)


def clopper_pearson(found: int, of: int, alpha: float) -> tuple[float, float]:
    """Exact interval of a chance from independent trials (Clopper and Pearson, Biometrika 26, 1934)."""
    low = 0.0 if found == 0 else float(stats.beta.ppf(alpha / 2.0, found, of - found + 1))
    high = 1.0 if found == of else float(stats.beta.ppf(1.0 - alpha / 2.0, found + 1, of - found))
    return low, high


def _by_block(values: Array | Ints, size: int) -> Array:
    return np.asarray(np.asarray(values, dtype=float).reshape(-1, size).mean(axis=1))


def percent(share: float, digits: int) -> str:
    """Without its sign; 0 and 100 are said of nothing else."""
    if share in (0.0, 1.0):
        return f"{100 * share:.0f}"
    text = f"{100 * share:.{digits}f}"
    least = 0.1**digits
    return (
        f"{least:.{digits}f}" if float(text) == 0.0 else f"{100 - least:.{digits}f}" if float(text) == 100.0 else text
    )
