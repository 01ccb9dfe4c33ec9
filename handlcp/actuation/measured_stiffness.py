"""`MeasuredStiffness`: a spring from readings, with its stiffness, spread and rest, and whether they lie on a line.

    τ = τ₀ + K θ + f s,    s = ±1 on the way up and down,    θ₀ = -τ₀ / K

Boards and sheets set the angle, which is exact beside what a scale reads: scatter and friction belong to τ, and the
line is that of τ over θ. A line of θ over τ would call springs stiffer the more the loads scatter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from handlcp import words
from handlcp.check import Array, check_array, check_call
from handlcp.errors import InputError
from handlcp.record import Record

_MIN_READINGS = 3  # points: two have no scatter
_BEND_SIGNIFICANCE = 0.01  # of readings on a line to look bent
_MIN_STIFFNESS_RATIO = 1.2  # stiffest by softest part: a spring that changes by less is used as one number
_EQUAL_READING_TOLERANCE = 1e-12  # of the largest: readings that differ by less are the same


@dataclass(frozen=True)
class MeasuredStiffness(Record):
    """A spring from readings, by `stiffness_from`. Units as of the readings: rad and N·m of a joint, m and N of a pad.

    stiffness : K [N·m/rad or N/m], for `joint_stiffness` of a hand. flexibility : 1 / K [rad/(N·m) or m/N], for
    `pad_flexibility`. spread : how far K may be off, as a share of it, from scatter and from friction; `reliability`
    takes it as "stiffness" or "pads". friction : f, half of how far loads on the way up are above those on the way down
    [N·m or N], 0 where they are not; None where readings go one way. rest : angle or displacement without load [rad or
    m]. rest_error : its standard error. points : how many readings. range (2,) : of the softest and the stiffest part,
    where the readings show that they lie on no line; else None.
    """

    entries = ("stiffness", "flexibility", "spread", "friction", "rest", "rest_error", "points", "range")

    stiffness: float
    spread: float
    friction: float | None
    rest: float
    rest_error: float
    points: int
    range: tuple[float, float] | None

    @property
    def flexibility(self) -> float:
        """The inverse of the measured stiffness, in the inverse of its unit."""
        return 1.0 / self.stiffness

    def __str__(self) -> str:
        said = [
            f"stiffness {self.stiffness:.4g} ± {words.format_percent(self.spread)} (N·m/rad; of a pad N/m)",
            f"flexibility {self.flexibility:.4g} (rad/(N·m); of a pad m/N)",
            f"unloaded at {self.rest:.3g} ± {self.rest_error:.1g} (rad; of a pad m)",
        ]
        if self.friction is not None:
            said.append(f"friction {self.friction:.2g}, counted in the spread (N·m; of a pad N)")
        if self.range is None:
            return "\n".join((*said, f"{self.points} readings, which agree with a line"))
        low, high = self.range
        bent = f"{self.points} readings, on no line: stiffness goes from {low:.3g} to {high:.3g};"
        return "\n".join((*said, bent, "measure about the load that the hand will have"))


@check_call()
def stiffness_from(angle: Any, torque: Any) -> MeasuredStiffness:
    """The stiffness of a spring from readings: of a joint, or of a pad in the same way.

    angle : (m,) what was set [rad]; of a pad the displacement [m]. m ≥ 3, in the order in which they were taken.
    torque : (m,) the load that was read at each [N·m]; of a pad the force [N]. It turns the joint to larger angles
    where positive.

    The straight line of least squares through the torques over the angles, with an intercept: the angle may be counted
    from anywhere. Readings that go up and down make two parallel lines, 2 f apart, and the spring is midway. spread² is
    the sum of three squares: of the standard error; of f over what the spring's torque changes by in all; and of half
    the difference between the slopes of both ways, as far as that is more than scatter. An F-test at 1 % tells whether
    a curve (up to the third degree) fits better; that is said, and changes no other number.
    Raises InputError for fewer than 3 readings, different lengths, readings or loads that are all the same, and a
    stiffness that is not positive. Source: Draper & Smith, Applied Regression Analysis (1998), sections 1, 12 and 14.
    """
    angles, loads = (check_array(name, x, (-1,)) for name, x in (("angle", angle), ("torque", torque)))
    if len(angles) != len(loads):
        raise InputError("torque", f"a load for each of {len(angles)} readings", f"{len(loads)} of them")
    for name, x in (("angle", angles), ("torque", loads)):
        if len(x) < _MIN_READINGS:
            raise InputError(name, f"at least {_MIN_READINGS} readings", f"{len(x)}")
        if np.ptp(x) <= _EQUAL_READING_TOLERANCE * abs(x).max():
            raise InputError(name, "readings that differ", f"{len(x)} times {x[0]:g}")
    middle, size = angles.mean(), float(np.ptp(angles))
    x, way = (angles - middle) / size, _loading_directions(angles)
    line = _fit_columns(loads, x**0, x)
    both = None if way is None else _fit_columns(loads, x**0, x, way)
    fit = both or line
    assert fit is not None  # readings differ, and are three at least
    at_middle, rise = fit.values[:2].tolist()  # rise : K times the range of the angle
    if not rise > 0.0:
        expected = "loads that turn or press further the larger they are; -torque where signs are opposite"
        raise InputError("torque", expected, f"a stiffness of {rise / size:.3g}")
    parts = [np.sqrt(fit.covariance[1, 1])]
    if both is not None and way is not None:
        parts.append(both.values[2])
        if (slopes := _fit_columns(loads, x**0, x, way, way * x)) is not None:
            parts.append(np.sqrt(max(0.0, slopes.values[3] ** 2 - slopes.covariance[3, 3])))  # less its average scatter
    slant = np.array([-1.0, at_middle / rise]) / rise  # d(rest) / d(at_middle, rise), in ranges of the angle
    error = size * float(np.sqrt(slant @ fit.covariance[:2, :2] @ slant))
    spread = float(np.linalg.norm(parts)) / rise
    friction = None if both is None else max(0.0, float(both.values[2]))
    way = None if both is None else way
    rest, bent = float(middle - size * at_middle / rise), _find_bend(loads, x, way, fit, size)
    return MeasuredStiffness(rise / size, spread, friction, rest, error, len(angles), bent)


def _loading_directions(angles: Array) -> Array | None:
    """(m,) +1 of readings that were come to upwards, -1 downwards; None where fewer than two are of either kind. The
    first one, and one at the angle of that before it, belong to the way on from there.
    """
    moves = np.diff(angles)
    moves[abs(moves) <= _EQUAL_READING_TOLERANCE * abs(angles).max()] = 0.0
    way = np.sign(np.append(moves[0], moves))
    for k in reversed(range(len(way) - 1)):
        way[k] = way[k] or way[k + 1]
    for k in range(1, len(way)):
        way[k] = way[k] or way[k - 1]
    return way if min((way > 0.0).sum(), (way < 0.0).sum()) >= 2 else None


class _LeastSquaresFit(NamedTuple):
    """Values (p,) fitted by least squares, their covariance (p, p), what is left of squares, degrees of freedom."""

    values: Array
    covariance: Array
    residual_squares: float
    degrees_of_freedom: int


def _fit_columns(loads: Array, *columns: Array) -> _LeastSquaresFit | None:
    """Loads (m,) as a sum of columns (m,); None where readings cannot tell these apart, or leave no scatter."""
    A, free = np.column_stack(columns), len(loads) - len(columns)
    values, _, rank, _ = np.linalg.lstsq(A, loads)
    if free < 1 or rank < len(columns):
        return None
    left = float(np.sum((loads - A @ values) ** 2))
    return _LeastSquaresFit(np.asarray(values), np.asarray(left / free * np.linalg.inv(A.T @ A)), left, free)


def _find_bend(
    loads: Array, x: Array, way: Array | None, line: _LeastSquaresFit, size: float
) -> tuple[float, float] | None:
    """Least and largest stiffness of the curve that fits better than the line; None where the line does as well."""
    degree = min(3, len(np.unique(x)) - 1, line.degrees_of_freedom)
    powers = [x**k for k in range(2, degree + 1)]
    curve = _fit_columns(loads, x**0, x, *([] if way is None else [way]), *powers)
    if not powers or curve is None:
        return None
    straight, curved, free = line.residual_squares, curve.residual_squares, curve.degrees_of_freedom
    better = np.inf if curved == 0.0 else (straight - curved) / curved * free / len(powers)
    if straight == 0.0 or stats.f.sf(better, len(powers), free) > _BEND_SIGNIFICANCE:
        return None
    bends = np.append(curve.values[1:2], curve.values[len(curve.values) - len(powers) :])
    slopes = np.polynomial.Polynomial(np.append(0.0, bends)).deriv()(np.linspace(x.min(), x.max(), 101)) / size
    softest, stiffest = max(0.0, float(slopes.min())), float(slopes.max())
    return (softest, stiffest) if stiffest > _MIN_STIFFNESS_RATIO * softest else None
