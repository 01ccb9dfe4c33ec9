"""The least number with which something holds, closed in on from both sides.

Whether a grasp holds need not be monotone in a number: a stronger grip can push the object away, more friction can let
an equilibrium vanish. So the search goes from where it starts, down while it holds or up while it does not, in steps
that double, and then halves what is left. What comes back holds, and a tolerance less does not; both were asked.
Another window farther away may have been stepped over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Test = Callable[[float], bool]

_LOOKS = 8  # for a value that is not too much, and between one that is and one that is too little
_NONE = 1e-9  # of the start: less is nothing


@dataclass(frozen=True, slots=True)
class Least:
    """value : the least that holds; None: none was found. fails : the largest tried below it that does not, None where
    the floor itself holds; where no value was found, the last that was not too much. tried : of (x, whether it holds).
    """

    value: float | None
    fails: float | None
    tried: tuple[tuple[float, bool], ...]


class _Search:
    """Asks, and remembers what it has asked. too_much : whether a value fails because it is too large."""

    def __init__(self, holds: Test, too_much: Test, tolerance: float) -> None:
        self.holds, self.too_much, self.tolerance = holds, too_much, tolerance
        self.tried: list[tuple[float, bool]] = []

    def __call__(self, x: float) -> bool:
        self.tried.append((x, bool(self.holds(x))))
        return self.tried[-1][1]

    def found(self, value: float | None, fails: float | None) -> Least:
        return Least(value, fails, tuple(self.tried))

    def down(self, start: float, floor: float, step: float) -> tuple[float | None, float]:
        """(a value that does not hold, one above it that does); (None, floor) where the floor holds."""
        high = start
        while high > floor:
            low, step = max(start - step, floor), 2.0 * step
            if not self(low):
                return low, high
            high = low
        return None, floor

    def up(self, start: float, most: float, step: float) -> tuple[float | None, float | None]:
        """(a value that does not hold, one above it that does); None: nothing up to `most` does."""
        low = start
        while low < most:
            high, step = min(start + step, most), 2.0 * step
            if self(high):
                return low, high
            if self.too_much(high):
                return self._window(low, high)
            low = high
        return low, None

    def _window(self, low: float, high: float) -> tuple[float, float | None]:
        """Between a value that is too little and one that is too much."""
        for _ in range(_LOOKS):
            middle = 0.5 * (low + high)
            if self(middle):
                return low, middle
            low, high = (low, middle) if self.too_much(middle) else (middle, high)
        return low, None

    def halved(self, low: float, high: float, nothing: float = 0.0) -> tuple[float, float]:
        """The same as close as the tolerance, or to neighbouring floats."""
        while high - low > max(self.tolerance * high, nothing):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            low, high = (low, middle) if self(middle) else (middle, high)
        return low, high


def least(
    holds: Test, start: float, most: float, tolerance: float, *, step: float | None = None, floor: float = 0.0,
    too_much: Test = lambda x: False, sure: Test | None = None,
) -> Least:  # fmt: skip
    """The least value that holds, to a relative tolerance: value - fails ≤ tolerance · value, or one rounding step.

    start : where the search begins, near the answer if that is known. floor, most : the least and the largest tried.
    step : of the first step; None: the tolerance times the start. too_much : asked of values that do not hold.
    sure : asked once more where the answer hangs on a "no" of `holds`, such as a slower test; where it says yes, the
    search goes on down with it.
    """
    search = _Search(holds, too_much, tolerance)
    first = tolerance * start if step is None else step
    for _ in range(_LOOKS):
        if search(start) or not too_much(start):
            break
        start *= 0.5
    low, high = search.down(start, floor, first) if search.tried[-1][1] else search.up(start, most, first)
    if low is not None and high is not None:
        low, high = search.halved(low, high, _NONE * start)
    if sure is not None and low is not None:
        search.holds = sure
        if search(low):
            low, high = search.down(low, floor, tolerance * low)
            if low is not None:
                low, high = search.halved(low, high)
    return search.found(floor, None) if low is None else search.found(high, low)
