"""What varies in a grasp: from the mapping that users pass to one `Dimension` for each independent number.

| parameter | a number is | a distribution is of | varies |
| --- | --- | --- | --- |
| friction | a share of the coefficient | the coefficient | all fingers' contacts together |
| stiffness | a share | a factor on the joints' stiffness | all joints together |
| pads | a share | a factor on the flexibility of the pads | all pads together |
| mass | a share of the mass | the mass [kg] | |
| load | a share | a factor on the load besides the weight | |
| squeeze | a share | a factor on squeeze, grip and preload | all fingers together |
| positions | [m] | displacements of a contact on the object's surface | each finger's contact, along both tangents |
| posture | [rad, m] | how far a joint stands from where it is said to be | each joint |

Each is a class in `grasp/derivatives/parameter`. A mapping by name in place of the number or distribution varies each
of its own: contacts for friction, fingers for positions, joints for stiffness and posture, fingertips for pads.

Numbers of a hand vary, too, by their names for `Hand.vary`: a share of the number, or a distribution of it [SI].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from handlcp.check import Array, check_number
from handlcp.errors import InputError, UnknownName, translate_arguments
from handlcp.grasp.derivatives.parameter import Parameter, parameters
from handlcp.grasp.grasp import Grasp
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.vary.vary import ARGUMENT_NUMBERS, hand_number, hand_numbers, number_unit

# ----------------------------------------------------------------
# How one number of a grasp varies: a distribution, from what users pass.
#
# A number is a standard deviation. As a share it belongs to a quantity that cannot be negative, and the distribution is
# lognormal with the nominal value as its mean; as a length or an angle it is normal about zero.

MAX_CUT_CHANCE = 1e-6  # chance of impossible values that is cut off; a distribution with more of them is refused
HAND_NUMBER = "number"  # what the parameter of a number of the hand is called
_PLACE_PARAMETERS = "positions", "posture"
# Times the distance from the mean to the least possible value: no standard deviation may be larger
MAX_RELATIVE_SPREAD = 100.0
_QUANTILE_GRID = (np.arange(16) + 0.5) / 16  # quantiles that tell two distributions apart


@dataclass(frozen=True, slots=True)
class NumberDistribution:
    """The distribution of one number that varies.

    quantile : from shares (m,) to the values (m,) below which these shares of all values lie.
    mean, sd : mean and standard deviation.
    chance_below : the chance of values below the least possible one, which are cut off.
    """

    quantile: Callable[[Array], Array]
    mean: float
    sd: float
    chance_below: float = 0.0

    def values_at(self, u: Array) -> Array:
        """Values (m,) at points u (m,) of [0, 1)."""
        inside = self.chance_below + (1.0 - self.chance_below) * np.clip(u, 2.0**-33, 1.0 - 2.0**-33)
        return np.asarray(self.quantile(inside), dtype=float)

    @property
    def fingerprint(self) -> list[float]:
        """Numbers that differ where distributions differ."""
        return [float(x) for x in self.values_at(_QUANTILE_GRID)]


def read_distribution(argument: str, value: Any, mean: float | None, least: float) -> NumberDistribution:
    """The law of a number, or of a frozen distribution of scipy.stats.

    mean : nominal value, of which a number is a share; None: a number is the standard deviation itself, about 0.
    least : the least possible value. Raises InputError.
    """
    found = getattr(value, "ppf", None) or getattr(value, "icdf", None)
    if callable(value) or isinstance(value, str):  # scipy.stats.norm itself, not yet with its numbers
        expected = "a standard deviation, or a frozen distribution such as scipy.stats.norm(0.5, 0.05)"
        raise InputError(argument, expected, repr(value)[:80])
    if found is not None and hasattr(value, "cdf"):
        return _read_frozen(argument, value, found, least)
    spread = check_number(argument, value, above=0.0)
    if mean is None:
        frozen = stats.norm(0.0, spread)
        return NumberDistribution(frozen.ppf, 0.0, spread)
    if mean <= 0.0:
        raise InputError(argument, "a distribution: a share of zero is zero", value)
    _check_width(argument, mean, mean * spread, least)
    width = math.sqrt(math.log1p(spread * spread))
    lognormal = stats.lognorm(width, scale=mean * math.exp(-0.5 * width * width))
    return NumberDistribution(lognormal.ppf, mean, mean * spread)


def _read_frozen(argument: str, frozen: Any, quantile: Callable[[Array], Array], least: float) -> NumberDistribution:
    """The law of a frozen distribution; what of it is impossible is cut off where it is next to nothing."""
    values = np.asarray(quantile(_QUANTILE_GRID), dtype=float)
    sd = frozen.std() if hasattr(frozen, "std") else frozen.standard_deviation()
    if values.shape != _QUANTILE_GRID.shape or not np.isfinite(values).all() or not np.isfinite(sd):
        raise InputError(argument, "one distribution of finite numbers with a standard deviation", repr(frozen)[:80])
    below = 0.0
    if least > -np.inf:
        below = float(frozen.cdf(least)) if float(quantile(np.array([2.0**-33]))[0]) < least else 0.0
        if below > MAX_CUT_CHANCE:
            expected = f"values of at least {least:g}; scipy.stats.lognorm and truncnorm have no others"
            raise InputError(argument, expected, f"values below it with a chance of {below:.2g}")
    _check_width(argument, float(frozen.mean()), float(sd), least)
    return NumberDistribution(quantile, float(frozen.mean()), float(sd), below)


def _check_width(argument: str, mean: float, sd: float, least: float) -> None:
    """Raises InputError where a hundredth of sd to either side of the mean, as a derivative takes it, is impossible."""
    if sd > (widest := MAX_RELATIVE_SPREAD * (mean - least)):
        most = f"{widest:g}, {MAX_RELATIVE_SPREAD:g} times the mean's distance from the least possible value"
        raise InputError(argument, f"a standard deviation of at most {most}", f"one of {sd:g}")


# ----------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Dimension:
    """One number of a grasp that varies.

    name : for tables. parameter : what `reliability` calls it.
    index : which contact, joint or tip, and for positions which tangent; () for all together.
    distribution : of its values.
    unit : of its values.
    """

    name: str
    parameter: str
    index: tuple[int, ...]
    distribution: NumberDistribution
    unit: str


def read_spread(grasp: Grasp, spread: Any) -> tuple[Dimension, ...]:
    """The dimensions of a spread, checked against its grasp. Raises InputError, UnknownName."""
    if not isinstance(spread, Mapping):
        expected = "a mapping of what varies, such as {'friction': 0.1}"
        raise InputError("spread", expected, repr(spread)[:80])
    known, numbers = varying_parameters(), hand_numbers(grasp.state.hand) if isinstance(grasp, HandGrasp) else {}
    own = [key for key in spread if key in numbers or (numbers and key in ARGUMENT_NUMBERS)]
    if unknown := [str(key) for key in spread if key not in known and key not in own]:
        raise UnknownName("spread", "a parameter, or a number of the hand,", unknown, (*known, *numbers))
    if own and (beside := [key for key in _PLACE_PARAMETERS if key in spread]):
        raise InputError("spread", f"no {beside[0]} beside numbers of the hand, which move the contacts", own[0])
    if not spread:
        raise InputError("spread", "at least one parameter that varies", "none")
    found = [
        Dimension(e.name, key, e.at, read_distribution(e.argument, e.given, e.mean, e.least), e.unit)
        for key, p in known.items()
        if key in spread
        for e in p.entries(grasp.spec, f"spread[{key!r}]", spread[key])
    ]
    for name in own:
        assert isinstance(grasp, HandGrasp)
        with translate_arguments({"changes": "spread"}):
            mean = hand_number(grasp.state.hand, name)
        law = read_distribution(f"spread[{name!r}]", spread[name], mean, 0.0)
        found.append(Dimension(name, HAND_NUMBER, (), law, number_unit(name)))
    return tuple(found)


def varying_parameters() -> dict[str, Parameter]:
    """The parameters that can vary, by what they are called here."""
    return {p.spread: p for p in parameters() if p.spread}
