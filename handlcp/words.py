"""`TextTable`: numbers, lists and tables for people, with units that fit and two or three digits."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NEGLIGIBLE_LENGTH = 1e-10  # [m] motions below this are rounding
_MAX_NAMES = 4  # names in a list
_TIE_TOLERANCE = 1e-6  # of the largest: what differs by less is a tie
_NEGLIGIBLE_FRICTION = 5e-4  # of the normal force: less is not written


@dataclass(frozen=True, slots=True)
class LengthUnit:
    """A unit of length for a whole column.

    size : of the unit [m].
    """

    name: str
    size: float

    def __call__(self, metres: float) -> str:
        """The number without its unit; a bare 0 for rounding noise."""
        if not np.isfinite(metres):
            return "–"
        if abs(metres) < NEGLIGIBLE_LENGTH:
            return "0"
        value = metres / self.size
        return f"{value:.1f}" if abs(value) >= 100 else f"{value:.2f}" if abs(value) >= 0.095 else f"{value:.3f}"


def choose_length_unit(metres: Iterable[float]) -> LengthUnit:
    """Millimetres, or micrometres when nothing reaches a tenth of a millimetre."""
    largest = max((abs(m) for m in metres if np.isfinite(m)), default=0.0)
    return LengthUnit("µm", 1e-6) if NEGLIGIBLE_LENGTH <= largest < 1e-4 else LengthUnit("mm", 1e-3)


def format_length(metres: float) -> str:
    """A length as text, such as "0.42 mm", "12 µm", "24 m"."""
    if abs(metres) >= 1.0:
        return _format_quantity(metres, " m", 2)
    small = NEGLIGIBLE_LENGTH <= abs(metres) < 1e-4
    return _format_quantity(metres * 1e6, " µm", 2) if small else _format_quantity(metres * 1e3, " mm", 2)


def format_lengths(metres: Iterable[float]) -> list[str]:
    """Lengths of one sentence in one unit, such as ["0.014 mm", "0.17 mm"]."""
    values = list(metres)
    largest = max((abs(m) for m in values if np.isfinite(m)), default=0.0)
    name, size = ("m", 1.0) if largest >= 1.0 else ("µm", 1e-6) if NEGLIGIBLE_LENGTH <= largest < 1e-4 else ("mm", 1e-3)
    return [_format_quantity(m / size if abs(m) >= NEGLIGIBLE_LENGTH else 0.0, f" {name}", 2) for m in values]


def format_force(newtons: float) -> str:
    """A force as text, such as "1.53 N"."""
    return _format_quantity(newtons, " N")


def format_contact_force(normal: float, friction: float) -> str:
    """The force of a contact as text, such as "1.53 + 0.4 N": normal, and along the surface where that counts."""
    if friction <= _NEGLIGIBLE_FRICTION * abs(normal):
        return format_force(normal)
    one, two = format_force(normal), format_force(friction)
    unit = two[two.rindex(" ") :]
    return f"{one.removesuffix(unit)} + {two}" if one.endswith(unit) else f"{one} + {two}"


def format_torque(newton_metres: float) -> str:
    """A torque as text, such as "0.142 N·m", "3.1 mN·m"."""
    small = 0 < abs(newton_metres) < 0.01
    return _format_quantity(newton_metres * 1e3, " mN·m") if small else _format_quantity(newton_metres, " N·m")


def effort_unit(slides: bool) -> str:
    """What a joint pulls with: newton metres, or newtons where it slides."""
    return "N" if slides else "N·m"


def stiffness_unit(slides: bool) -> str:
    """What a joint's spring is given in."""
    return "N/m" if slides else "N·m/rad"


def unit_of_joints(unit: Callable[[bool], str], sliding: Iterable[bool]) -> str:
    """The unit of several joints, by `effort_unit` or `stiffness_unit`: "N·m", "N", or "N·m, N of slides"."""
    both = sorted(set(sliding))
    return unit(both[0]) if len(both) == 1 else f"{unit(False)}, {unit(True)} of slides"


def format_effort(size: float, unit: str) -> str:
    """The effort of a joint as text, in "N·m", or in "N" where it slides."""
    return format_force(size) if unit == "N" else format_torque(size)


def format_efforts(sizes: Iterable[float], unit: str) -> list[str]:
    """Several efforts of one joint as texts; those in "N·m" have one prefix."""
    return [format_force(size) for size in sizes] if unit == "N" else format_torques(sizes)


def format_torques(newton_metres: Iterable[float]) -> list[str]:
    """Torques as texts with one unit, such as ["0.21 N·m", "0.2 N·m"]; a limit that is infinite is "∞"."""
    values = list(newton_metres)
    small = 0 < max((abs(t) for t in values if np.isfinite(t)), default=0.0) < 0.01
    size, unit = (1e-3, " mN·m") if small else (1.0, " N·m")
    return ["∞" if np.isinf(t) else _format_quantity(t / size, unit) for t in values]


def choose_prefix(unit: str, values: Iterable[float]) -> tuple[str, float]:
    """The unit of a column with the prefix that fits, and its size: ("mN", 1e-3) where nothing reaches a tenth of N."""
    largest = max((abs(x) for x in values if np.isfinite(x)), default=0.0)
    if largest >= 1e5:
        return f"k{unit}", 1e3
    if 0.0 < largest < 1e-4:
        return f"µ{unit}", 1e-6
    return (f"m{unit}", 1e-3) if 0.0 < largest < 0.1 else (unit, 1.0)


def format_column(values: Iterable[float]) -> list[str]:
    """Numbers with as many decimals as give the largest of them four digits, three at most; "–" for no number."""
    numbers = list(values)
    largest = max((abs(x) for x in numbers if np.isfinite(x)), default=0.0)
    decimals = 3 if largest < 9.9995 else 2 if largest < 99.995 else 1
    return [f"{round(x, decimals) + 0.0:.{decimals}f}" if np.isfinite(x) else "–" for x in numbers]


def format_duration(seconds: float) -> str:
    """A time as text, such as "0.4 s", "12 s", "3 min" or "2 h"."""
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s" if seconds < 99.5 else f"{seconds:.0f} s"


def format_angle(radians: float) -> str:
    """An angle as text in degrees, such as "0.58°"."""
    return _format_quantity(float(np.degrees(radians)), "°", 2)


def format_percent(share: float) -> str:
    """A share as text in whole percents; one digit more below ten."""
    value = 100 * share
    if not np.isfinite(value):
        return "–"
    return f"{value:.0f} %" if value >= 9.95 or value == 0 else f"{value:.1f} %"


def list_names(names: Sequence[str]) -> str:
    """A list of at most four names, and how many more there are."""
    names = list(names)
    return ", ".join(names[:_MAX_NAMES]) + (f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else "")


def join_names(names: Sequence[str]) -> str:
    """The names as a sentence has them: "a, b and c", or "a, b, c and 2 more"."""
    told, more = (names, 0) if len(names) <= _MAX_NAMES else (names[: _MAX_NAMES - 1], len(names) - _MAX_NAMES + 1)
    if more:
        return f"{', '.join(told)} and {more} more"
    return told[0] if len(told) == 1 else f"{', '.join(told[:-1])} and {told[-1]}"


def group_by_link(names: Sequence[str], links: Mapping[str, str]) -> list[str]:
    """The names, several of one link as one: "3 contacts of palm".

    links : name → its link; names without one stay.
    """
    groups = dict[str, list[str]]()
    for name in names:
        groups.setdefault(links.get(name, name), []).append(name)
    return [many[0] if len(many) == 1 else f"{len(many)} contacts of {link}" for link, many in groups.items()]


def first_largest_index(values: NDArray[np.float64]) -> int:
    """The index of the largest value, the first of those that differ by rounding alone, so that ties are safe."""
    largest = values.max()
    return int((values >= largest - _TIE_TOLERANCE * abs(largest)).argmax())


def number_duplicates(names: Sequence[str]) -> list[str]:
    """The names, a number behind those that came before."""
    return [name if name not in names[:i] else f"{name} ({i + 1})" for i, name in enumerate(names)]


def join_alternatives(parts: Sequence[str]) -> str:
    """Alternatives as a sentence has them, such as "a, b or c"."""
    return " or ".join(part for part in (", ".join(parts[:-1]), parts[-1]) if part)


def _format_quantity(value: float, unit: str, digits: int = 3) -> str:
    """A number with so many significant digits, whole numbers unrounded, and its unit."""
    if not np.isfinite(value):
        return "–"
    if abs(value) < 1e-9:
        return f"0{unit}"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}{unit}" if "e" in text else f"{text}{unit}"


# ----------------------------------------------------------------
# Tables as plain text, and the width that everything printed keeps to.


MAX_TEXT_WIDTH = 80  # columns of what is printed
_COLUMN_GAP, _MIN_FIRST_COLUMN = "  ", 8  # between columns; the narrowest that the first one becomes


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table that prints as plain text within 80 columns; a first column that is too wide goes on in further lines.

    heads : of the columns; a unit stands in a second line.
    rows : as many cells each.
    align : "<" or ">" for each column.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str

    def __str__(self) -> str:
        heads = [head.split("\n") for head in self.heads]
        tall = max(len(head) for head in heads)
        top = [[head[k] if k < len(head) else "" for head in heads] for k in range(tall)]
        widths = [max(len(line[j]) for line in (*top, *self.rows)) for j in range(len(heads))]
        others = sum(widths[1:]) + len(_COLUMN_GAP) * (len(widths) - 1)
        widths[0] = max(min(widths[0], MAX_TEXT_WIDTH - others), _MIN_FIRST_COLUMN)
        lines = [self._format_line(cells, widths) for cells in top]
        for first, *rest in self.rows:
            pieces = textwrap.wrap(first, widths[0], break_on_hyphens=False) or [""]
            lines += [self._format_line([pieces[0], *rest], widths), *pieces[1:]]
        return "\n".join(lines)

    def _format_line(self, cells: Sequence[str], widths: Sequence[int]) -> str:
        placed = [f"{cell:{way}{width}}" for cell, way, width in zip(cells, self.align, widths, strict=True)]
        return _COLUMN_GAP.join(placed).rstrip()


def wrap_text(text: str, indent: str = "", first: str = "") -> str:
    """The text in lines of at most 80 columns; words that are longer are cut.

    first, indent : what the first line begins with, and all others.
    """
    short = textwrap.TextWrapper(MAX_TEXT_WIDTH, initial_indent=first, subsequent_indent=indent, break_on_hyphens=False)
    return "\n".join(short.wrap(text))
