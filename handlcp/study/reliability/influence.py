"""What matters most: how the margin of the samples hangs on each value, and what its derivative at the means says.

From the samples, by ranks, so that a sample that is not held counts as lower than all that are:

    rank correlation   Spearman's, between value and margin; its sign says which way it helps
    share              Var(E[y | x]) / Var(y), the first-order index of Sobol', y the rank of the margin, x cut into
                       pieces of as many samples each, corrected for chance (ε², Kelley 1935)

From the derivative: what one standard deviation changes in the margin, and its square as a share of all squares. That
is what a linear model says: it knows nothing of what happens far from them, nor of kinks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from handlcp import words
from handlcp.check import Array

_PIECES = 8, 32  # that the values are cut into, least and most
_EACH = 64  # samples of a piece, about


@dataclass(frozen=True, slots=True)
class Influence:
    """How much one value that varies matters; NaN where nothing is known.

    name, unit : of the value. sd : its standard deviation, in its unit. rank : rank correlation with the margin, -1 to
    1. share : of the variance of the margin's rank that it explains alone, 0 to 1. slope : change of the margin with
    one standard deviation, from its derivative at the means. linear : its share by these derivatives, 0 to 1.
    """

    name: str
    unit: str
    sd: float
    rank: float
    share: float
    slope: float
    linear: float

    @property
    def said(self) -> str:
        """The standard deviation with its unit, such as "± 10 %", "± 1 mm", "± 0.57°"."""
        return f"± {words.percent(self.sd) if self.unit == '×' else value_with(self.sd, self.unit)}"


def value_with(x: float, unit: str) -> str:
    """A number with its unit; factors as such."""
    if unit == "m":
        return words.length(x)
    return words.angle(x) if unit == "rad" else f"× {x:.3g}" if unit == "×" else f"{x:.3g} {unit}".rstrip()


def influences(names: list[tuple[str, str, float]], points: Array, margin: Array, slopes: Array) -> list[Influence]:
    """One for each (name, unit, sd), those that matter most first. points (m, d) of the unit cube; margin (m,), NaN
    where nothing holds; slopes (d,).
    """
    y = stats.rankdata(np.where(np.isnan(margin), -np.inf, margin))
    squares = np.nan_to_num(slopes**2)
    known = np.isfinite(slopes).any()
    linear = squares / squares.sum() if squares.sum() > 0.0 else squares
    found = [
        Influence(*who, _correlation(u, y), _first_order(u, y), float(slope), float(part) if known else np.nan)
        for who, u, slope, part in zip(names, points.T, slopes, linear, strict=True)
    ]
    return sorted(found, key=lambda f: (-round(f.share, 3) if f.share == f.share else 0.0, -abs(f.rank)))


def _correlation(u: Array, y: Array) -> float:
    x = stats.rankdata(u)
    if np.ptp(y) == 0.0:
        return np.nan
    return float(np.corrcoef(x, y)[0, 1])


def _first_order(u: Array, y: Array) -> float:
    """Between 0 and 1; NaN where all samples are alike, or too few."""
    m = len(y)
    pieces = int(np.clip(m // _EACH, *_PIECES))
    if np.ptp(y) == 0.0 or m < 2 * pieces:
        return np.nan
    parts = np.array_split(y[np.argsort(u, kind="stable")], pieces)
    total = float(((y - y.mean()) ** 2).sum())
    within = sum([float(((p - p.mean()) ** 2).sum()) for p in parts])
    return float(np.clip(1.0 - within / (m - pieces) / (total / (m - 1)), 0.0, 1.0))
