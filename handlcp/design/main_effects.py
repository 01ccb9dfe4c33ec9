"""What an outcome is on average along each parameter, and how much of its variance that explains, from any samples.

    S = Var(E(y | x)) / Var(y)      first-order Sobol index of a parameter x

Samples are sorted into k classes by x, each with as many, or into the values of x where these are few. The share of the
variance between classes is η² = 1 - W / V, with W the sum of squares about the means of the classes and V that about
the mean of all. By chance alone it is (k - 1) / (n - 1); freed of that it is Kelley's

    ε² = 1 - W / (n - k) · (n - 1) / V

(T. L. Kelley, An unbiased correlation ratio measure, PNAS 21, 1935; indices from given data: E. Plischke, E. Borgonovo,
C. L. Smith, European Journal of Operational Research 226, 2013). What y changes within a class by x itself is missed:
of a straight line 1 / k² of the index. Parameters are taken to be independent, as the samples of a sweep are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array

_POWER = 0.4  # k = n^0.4 classes: more of them follow y better, fewer are less noisy


@dataclass(frozen=True, slots=True)
class MainEffect:
    """The main effect of one parameter on an outcome, over k classes of its values.

    places : (k,) of the classes, as unit coordinates.
    means : (k,) of the outcome.
    errors : (k,) standard errors of the means.
    index : first-order Sobol index [-], NaN where nothing varies or samples are few; what is below 0 is chance.
    """

    places: Array
    means: Array
    errors: Array
    index: float


def main_effect(x: Array, y: Array) -> MainEffect:
    """The main effect of a parameter, from n samples.

    x : (n,) unit coordinates of the parameter.
    y : (n,) the outcome, finite.
    """
    n, values = len(x), np.unique(x)
    most = max(2, round(n**_POWER))
    if len(values) <= most:
        number = np.searchsorted(values, x)
    else:
        number = np.empty(n, dtype=int)
        number[np.argsort(x, kind="stable")] = np.arange(n) * most // n
    k = int(number.max(initial=0)) + 1
    count = np.bincount(number, minlength=k)
    means = np.bincount(number, y, k) / count
    squares = np.bincount(number, (y - means[number]) ** 2, k)
    total = float(((y - y.mean()) ** 2).sum()) if n else 0.0
    known = n > k and total > 0.0 and len(values) > 1
    index = 1.0 - float(squares.sum()) / (n - k) * (n - 1) / total if known else np.nan
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = np.sqrt(squares / (count - 1) / count)
    return MainEffect(np.bincount(number, x, k) / count, means, np.nan_to_num(errors, posinf=0.0), index)
