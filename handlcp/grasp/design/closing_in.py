"""The least value that holds, closed in on from a value that should be near it.

Whether a grasp holds need not be monotone: a stronger grip can push the object away. So the search goes from where it
starts, down while it holds or up while it does not, in steps that double, and then halves what is left. What comes back
holds, and a tolerance less does not. Another window further away may have been missed.
"""

from __future__ import annotations

from collections.abc import Callable

Test = Callable[[float], bool]

_LOOKS = 8  # for a value that is not too much, and between one that is and one that is too little
_NONE = 1e-9  # of the start: less is nothing


def closed_in(
    holds: Test, start: float, most: float, tolerance: float, too_much: Test = lambda x: False, least: float = 0.0
) -> tuple[float | None, float]:
    """(value, fails): the least value that holds and the largest tried below it that does not; twice `least` where even
    that holds; (None, x) where no value was found, x being the last that was not too much.

    start : > 0. least, most : the smallest and the largest that are tried. tolerance : of the value. too_much : whether
    a value fails because it is too large, asked of those that do not hold.
    """
    for _ in range(_LOOKS):
        if holds(start) or not too_much(start):
            break
        start *= 0.5
    low, high = _down(holds, start, least, tolerance) if holds(start) else _up(holds, start, most, tolerance, too_much)
    if high is None or high == least:
        return high, low
    while high - low > max(tolerance * high, _NONE * start):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high, low


def _down(holds: Test, start: float, least: float, step: float) -> tuple[float, float]:
    """A value that does not hold below one that does."""
    low, high = start, start
    while True:
        low, high, step = max(start * (1.0 - step), least), low, 2.0 * step
        if not holds(low):
            return low, high
        if low == least:
            return least, least


def _up(holds: Test, start: float, most: float, step: float, too_much: Test) -> tuple[float, float | None]:
    low = start
    while low < most:
        high, step = min(start * (1.0 + step), most), 2.0 * step
        if holds(high):
            return low, high
        if too_much(high):
            return _between(holds, low, high, too_much)
        low = high
    return low, None


def _between(holds: Test, low: float, high: float, too_much: Test) -> tuple[float, float | None]:
    """Between a value that is too little and one that is too much."""
    for _ in range(_LOOKS):
        middle = 0.5 * (low + high)
        if holds(middle):
            return low, middle
        low, high = (low, middle) if too_much(middle) else (middle, high)
    return low, None
