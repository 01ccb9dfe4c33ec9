"""Springs that were measured: stiffness, spread and rest from readings, and whether they lie on a line.

    θ = θ₀ + c τ,    K = 1 / c

Loads come from weights or a scale, which are exact beside what is read off a ruler: the scatter belongs to θ, and the
line is that of θ over τ. A line of τ over θ would call springs softer the more the readings scatter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from scipy import stats

from handlcp import words
from handlcp.check import Array, array
from handlcp.errors import InputError
from handlcp.record import Record

_LEAST = 3  # points: two have no scatter
_CHANCE = 0.01  # of readings on a line to look bent
_BENT = 1.2  # stiffest by softest part: a spring that changes by less is used as one number
_CONSTANT = 1e-12  # of the largest: readings that differ by less are the same


@dataclass(frozen=True)
class MeasuredStiffness(Record):
    """A spring from readings, by `stiffness_from`. Units as of the readings: rad and N·m of a joint, m and N of a pad.

    stiffness : K [N·m/rad or N/m], for `joint_stiffness` of a hand. flexibility : 1 / K [rad/(N·m) or m/N], for
    `pad_flexibility`. spread : standard error of K as a share of it, which is also that of 1 / K; `reliability` takes
    it as "stiffness" or "pads". rest : angle or displacement without load [rad or m]. rest_error : its standard error.
    points : how many readings. range (2,) : of the softest and the stiffest part, where the readings show that they
    lie on no line; else None.
    """

    entries = ("stiffness", "flexibility", "spread", "rest", "rest_error", "points", "range")

    stiffness: float
    spread: float
    rest: float
    rest_error: float
    points: int
    range: tuple[float, float] | None

    @property
    def flexibility(self) -> float:
        """1 / stiffness."""
        return 1.0 / self.stiffness

    def __str__(self) -> str:
        said = [
            f"stiffness {self.stiffness:.4g} ± {words.percent(self.spread)} (N·m/rad; of a pad N/m)",
            f"flexibility {self.flexibility:.4g} (rad/(N·m); of a pad m/N)",
            f"unloaded at {self.rest:.3g} ± {self.rest_error:.1g} (rad; of a pad m)",
        ]
        if self.range is None:
            return "\n".join((*said, f"{self.points} readings, which agree with a line"))
        low, high = self.range
        bent = f"{self.points} readings, on no line: stiffness goes from {low:.3g} to {high:.3g};"
        return "\n".join((*said, bent, "measure about the load that the hand will have"))


def stiffness_from(angle: Any, torque: Any) -> MeasuredStiffness:
    """The stiffness of a spring from readings: of a joint, or of a pad in the same way.

    angle : (m,) what was read [rad]; of a pad the displacement [m]. m ≥ 3, in any order.
    torque : (m,) the load at each [N·m]; of a pad the force [N]. It turns the joint to larger angles where positive.

    The straight line of least squares through the angles over the torques, with an intercept: the angle may be counted
    from anywhere. An F-test at 1 % tells whether a curve (up to the third degree) fits better; that is said, and
    changes no other number.
    Raises InputError for fewer than 3 readings, different lengths, readings or loads that are all the same, and a
    stiffness that is not positive. Source: Draper & Smith, Applied Regression Analysis (1998), sections 1 and 12.
    """
    read, load = (array(name, x, (-1,)) for name, x in (("angle", angle), ("torque", torque)))
    if len(read) != len(load):
        raise InputError("torque", f"a load for each of {len(read)} readings", f"{len(load)} of them")
    for name, x in (("angle", read), ("torque", load)):
        if len(x) < _LEAST:
            raise InputError(name, f"at least {_LEAST} readings", f"{len(x)}")
        if np.ptp(x) <= _CONSTANT * abs(x).max():
            raise InputError(name, "readings that differ", f"{len(x)} times {x[0]:g}")
    line = stats.linregress(load, read)
    if not line.slope > 0.0:
        expected = "loads that turn or press further the larger they are; -torque where signs are opposite"
        raise InputError("torque", expected, f"a flexibility of {line.slope:.3g}")
    rest, error = float(line.intercept), float(line.intercept_stderr)
    spread = float(line.stderr / line.slope)
    return MeasuredStiffness(1.0 / float(line.slope), spread, rest, error, len(read), _bent(load, read))


def _bent(load: Array, read: Array) -> tuple[float, float] | None:
    """Least and largest stiffness of the curve that fits better than the line; None where the line does as well."""
    degree = min(3, len(np.unique(load)) - 1, len(load) - 2)
    if degree < 2:
        return None
    line, curve = (Polynomial.fit(load, read, d) for d in (1, degree))
    left, right = (float(np.sum((read - fit(load)) ** 2)) for fit in (line, curve))
    free = len(load) - degree - 1
    better = np.inf if right == 0.0 else (left - right) / right * free / (degree - 1)
    if left == 0.0 or stats.f.sf(better, degree - 1, free) > _CHANCE:
        return None
    slopes = curve.deriv()(np.linspace(load.min(), load.max(), 101))
    softest = 1.0 / float(slopes.max())
    stiffest = 1.0 / float(slopes.min()) if slopes.min() > 0.0 else np.inf
    return (softest, stiffest) if stiffest > _BENT * softest else None
