"""Numbers and lists for people: the unit that fits, three digits, no noise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

__all__ = ["NO_LENGTH", "LengthUnit", "angle", "force", "length", "length_unit", "listed", "percent", "torque"]

NO_LENGTH = 1e-10  # [m] motions below this are rounding
_MOST = 4  # names in a list


class LengthUnit:
    """Millimetres or micrometres, chosen for a whole column."""

    def __init__(self, name: str, size: float) -> None:
        self.name, self.size = name, size

    def __call__(self, metres: float) -> str:
        """The number alone; "–" for none, a bare 0 for rounding noise."""
        if not np.isfinite(metres):
            return "–"
        if abs(metres) < NO_LENGTH:
            return "0"
        value = metres / self.size
        return f"{value:.1f}" if abs(value) >= 100 else f"{value:.2f}" if abs(value) >= 0.095 else f"{value:.3f}"


def length_unit(metres: Iterable[float]) -> LengthUnit:
    """Millimetres, or micrometres when nothing reaches a tenth of a millimetre."""
    largest = max((abs(m) for m in metres if np.isfinite(m)), default=0.0)
    return LengthUnit("µm", 1e-6) if NO_LENGTH <= largest < 1e-4 else LengthUnit("mm", 1e-3)


def length(metres: float) -> str:
    """Such as "0.42 mm", "12 µm"."""
    if not np.isfinite(metres):
        return "–"
    return f"{_digits(metres * 1e6, 2)} µm" if NO_LENGTH <= abs(metres) < 1e-4 else f"{_digits(metres * 1e3, 2)} mm"


def force(newtons: float) -> str:
    """Such as "1.53 N"."""
    return f"{_digits(newtons)} N" if np.isfinite(newtons) else "–"


def torque(newton_metres: float) -> str:
    """Such as "0.142 N·m", "3.1 mN·m"."""
    if not np.isfinite(newton_metres):
        return "–"
    small = abs(newton_metres) < 0.01
    return f"{_digits(newton_metres * 1e3)} mN·m" if small and newton_metres else f"{_digits(newton_metres)} N·m"


def angle(radians: float) -> str:
    """Degrees."""
    return f"{_digits(float(np.degrees(radians)), 2)}°" if np.isfinite(radians) else "–"


def percent(share: float) -> str:
    """Whole percents; one digit more below ten."""
    if not np.isfinite(share):
        return "–"
    value = 100 * share
    return f"{value:.0f} %" if value >= 9.95 or value == 0 else f"{value:.1f} %"


def listed(names: Sequence[str]) -> str:
    """At most four names, and how many more there are."""
    names = list(names)
    return ", ".join(names[:_MOST]) + (f" and {len(names) - _MOST} more" if len(names) > _MOST else "")


def _digits(value: float, digits: int = 3) -> str:
    """Significant digits, but no rounding of whole numbers."""
    if abs(value) < 1e-9:
        return "0"
    return f"{value:.0f}" if abs(value) >= 10**digits else f"{value:.{digits}g}"
