"""`Chance`: the chance that a grasp holds, with its interval, and what matters most for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from handlcp import words
from handlcp.check import Array, Bools

# ----------------------------------------------------------------
# What matters most: how the margin of the samples hangs on each value, and what its derivative at the means says.
#
# From the samples, by ranks, so that a sample that is not held counts as lower than all that are:
#
# rank correlation   Spearman's, between value and margin; its sign says which way it helps
# share              Var(E[y | x]) / Var(y), the first-order index of Sobol', y the rank of the margin, x cut into
# pieces of as many samples each, corrected for chance (ε², Kelley 1935)
#
# From the derivative: what one standard deviation changes in the margin, and its square as a share of all squares. That
# is what a linear model says: it knows nothing of what happens far from them, nor of kinks.

_PIECE_COUNT_RANGE = 8, 32  # that the values are cut into, least and most
_SAMPLES_PER_PIECE = 64  # samples of a piece, about


@dataclass(frozen=True, slots=True)
class Influence:
    """How much one value that varies matters; NaN where nothing is known.

    name, unit : of the value. sd : its standard deviation, in its unit. rank : rank correlation with the margin, -1 to
    1. share : of the variance of the margin's rank that it explains alone, 0 to 1. slope : change of the margin with
    one standard deviation, from its derivative at the means; of one solve each, also with by="check". linear : its
    share by these derivatives, 0 to 1.
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
        return f"± {words.format_percent(self.sd) if self.unit == '×' else format_value(self.sd, self.unit)}"


def format_value(x: float, unit: str) -> str:
    """A number with its unit; factors as such."""
    if unit == "m":
        return words.format_length(x)
    return words.format_angle(x) if unit == "rad" else f"× {x:.3g}" if unit == "×" else f"{x:.3g} {unit}".rstrip()


def rank_influences(
    names: list[tuple[str, str, float]], points: Array, margin: Array, slopes: Array
) -> list[Influence]:
    """One for each (name, unit, sd), those that matter most first. points (m, d) of the unit cube; margin (m,), NaN
    where it is not known to hold; slopes (d,).
    """
    y = stats.rankdata(np.where(np.isnan(margin), -np.inf, margin))
    squares, differ = np.nan_to_num(slopes**2), bool(np.ptp(y) > 0.0)
    linear = squares / squares.sum() if squares.sum() > 0.0 else squares
    if not np.isfinite(slopes).any():
        linear = np.full(len(slopes), np.nan)
    found = []
    for who, u, slope, part in zip(names, points.T, slopes, linear, strict=True):
        rank = float(np.corrcoef(stats.rankdata(u), y)[0, 1]) if differ else np.nan
        found.append(Influence(*who, rank, _first_order_index(u, y), float(slope), float(part)))
    return sorted(found, key=lambda f: (-round(f.share, 3) if f.share == f.share else 0.0, -abs(f.rank)))


def _first_order_index(u: Array, y: Array) -> float:
    """Between 0 and 1; NaN where all samples are alike, or too few."""
    m = len(y)
    pieces = int(np.clip(m // _SAMPLES_PER_PIECE, *_PIECE_COUNT_RANGE))
    if np.ptp(y) == 0.0 or m < 2 * pieces:
        return np.nan
    parts = np.array_split(y[np.argsort(u, kind="stable")], pieces)
    total = float(((y - y.mean()) ** 2).sum())
    within = sum([float(((p - p.mean()) ** 2).sum()) for p in parts])
    return float(np.clip(1.0 - within / (m - pieces) / (total / (m - 1)), 0.0, 1.0))


# ----------------------------------------------------------------
# A chance from samples, and the interval that covers the truth with a given confidence.
#
# The samples come in R blocks. Each block is a set of Sobol points, scrambled on its own, so its share of held samples
# is an unbiased estimate, and the R estimates are independent. Their spread gives Student's interval. It is widened by
# ln(2/α)/N: what never happens among N samples may still happen with that chance (the rule of three, for 1 - α). With
# independent samples instead, an interval would be wider, because Sobol points fill the space more evenly.
#
# Source: Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences" (1995); L'Ecuyer et al., "Confidence intervals for
# randomized quasi-Monte Carlo estimators", Winter Simulation Conference (2023).

_SHARE_ROUNDING = 1e-12  # share of samples: rounding
_SUBSET_ALPHA_SHARE = 0.2  # part of α that goes to what was not solved in full


@dataclass(frozen=True, slots=True)
class Chance:
    """A chance that was estimated from samples, with its confidence interval.

    value : the estimated share of samples that surely hold; NaN where all are undecided. Samples that were never solved
        in full count in proportion to those that were.
    low, high : ends of the interval that covers the truth with this confidence.
    undecided : the share of samples of which nobody knows; `low` counts them as not held, `high` as held.
    """

    value: float
    low: float
    high: float
    confidence: float
    undecided: float = 0.0

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        """In percent, with as many digits as the interval is sure of."""
        width = 100 * (self.high - self.low)
        digits = min(max(1 - math.floor(math.log10(width)), 1), 6) if width > 0.0 else 1
        low, high = (format_chance(x, digits) for x in (self.low, self.high))
        value = "undecided" if np.isnan(self.value) else f"{format_chance(self.value, digits)} %"
        if self.undecided and not np.isnan(self.value):
            value = f"at least {value}, undecided {format_chance(self.undecided, digits)} %"
        return f"{value} ({100 * self.confidence:.4g} % interval {low} to {high} %)"


def estimate_chance(
    good: Bools, unresolved: Bools, inconclusive: Bools, fully_solved: tuple[Bools, Bools], size: int, level: float
) -> Chance:
    """The chance of a good sample, from N samples in blocks of `size`, (N,) each.

    good : surely. unresolved : left open, and not solved in full. inconclusive : nothing more will be known of them.
    fully_solved : (solved in full, good among them); they tell how many of the unresolved are good, or inconclusive.
    """
    solved, found, doubtful = (int(some.sum()) for some in (*fully_solved, fully_solved[0] & inconclusive))
    alpha, share, unknown, low, high = 1.0 - level, 0.0, 1.0, 0.0, 0.0
    if unresolved.any():
        inner, alpha = _SUBSET_ALPHA_SHARE * alpha, (1.0 - _SUBSET_ALPHA_SHARE) * alpha
        low = clopper_pearson_interval(found, solved, inner)[0]
        high = clopper_pearson_interval(found + doubtful, solved, inner)[1]
        if solved:
            share, unknown = found / solved, doubtful / solved
    value = float(np.mean(good + share * unresolved))
    undecided = float(np.mean(inconclusive + unknown * unresolved))
    down = student_interval(good + low * unresolved, size, alpha)[0]
    up = student_interval(good + high * unresolved + inconclusive, size, alpha)[1]
    nothing = undecided >= 1.0 - _SHARE_ROUNDING
    return Chance(np.nan if nothing else value, min(down, value), max(up, value), level, undecided)


def student_interval(good: Array, size: int, alpha: float) -> tuple[float, float]:
    """Both ends of the interval, from how good samples (N,) are, 0 to 1, in R ≥ 2 blocks of `size` each."""
    shares = good.reshape(-1, size).mean(axis=1)
    count = len(shares)
    half = float(stats.t.ppf(1.0 - alpha / 2.0, count - 1)) * float(shares.std(ddof=1)) / math.sqrt(count)
    half += math.log(2.0 / alpha) / (count * size)
    mean = float(shares.mean())
    return max(mean - half, 0.0), min(mean + half, 1.0)


def clopper_pearson_interval(found: int, of: int, alpha: float) -> tuple[float, float]:
    """Exact interval of a chance from independent trials (Clopper and Pearson, Biometrika 26, 1934)."""
    low = 0.0 if found == 0 else float(stats.beta.ppf(alpha / 2.0, found, of - found + 1))
    high = 1.0 if found == of else float(stats.beta.ppf(1.0 - alpha / 2.0, found + 1, of - found))
    return low, high


def format_chance(share: float, digits: int) -> str:
    """Without its sign; 0 and 100 are said of nothing else."""
    if share in (0.0, 1.0):
        return f"{100 * share:.0f}"
    text, least = f"{100 * share:.{digits}f}", 0.1**digits
    kept = {0.0: f"{least:.{digits}f}", 100.0: f"{100 - least:.{digits}f}"}
    return kept.get(float(text), text)
