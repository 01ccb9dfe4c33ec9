"""Requirements such as "payload>=1.5" of an evaluation, and what is said where one is not met."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import number
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.solution.verdict import HELD

UNITS = {"payload": "kg", "factor": "", "force": "N", "torque": "N·m", "torque_used": "", "motion": "m"}
_COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
}
_WRITTEN = re.compile(r"\s*(\w+)\s*(>=|<=|>|<)\s*([^=<>\s]\S*)\s*")


class Requirement(NamedTuple):
    """A number of an evaluation and the limit that it must keep.

    name : of the number, such as "payload".
    comparison : ">=", "<=", ">" or "<".
    limit : in the unit of that number.
    """

    name: str
    comparison: str
    limit: float

    def __str__(self) -> str:
        return " ".join([self.name, self.comparison, _with_unit(self.limit, UNITS[self.name])])

    def met(self, value: float) -> bool:
        """Whether this number meets the requirement; NaN meets nothing."""
        return _COMPARED[self.comparison](value, self.limit)

    def against(self, cases: Mapping[str, Any]) -> tuple[str, str] | None:
        """Why it is not met, and by which object: the worst counts, and each has to have a grasp. None: it is met."""
        values = {name: getattr(case, self.name) for name, case in cases.items()}
        if without := [name for name, value in values.items() if np.isnan(value)]:
            return f"{self} is not met: {without[0]} is not held at all", without[0]
        least = self.comparison.startswith(">")
        worst = (min if least else max)(values, key=lambda name: values[name])
        if self.met(values[worst]):
            return None
        here, apart = (_with_unit(v, UNITS[self.name]) for v in (values[worst], abs(values[worst] - self.limit)))
        return f"{self} is not met: {here} with {worst}, {apart} too {'little' if least else 'much'}", worst


def unmet(requirements: Iterable[Requirement], cases: Mapping[str, Any]) -> list[str]:
    """A sentence for each object that is not held as its brief asks, and for each requirement that objects do not meet;
    and what gives out with each of these objects.
    """
    lost = {name: case for name, case in cases.items() if case.word != HELD}
    found = [why for one in requirements if (why := one.against(cases)) is not None]
    first = dict.fromkeys(name for _, name in found if name not in lost)
    return [
        *[f"{name} is {case.word}: {case.gives_out}" for name, case in lost.items()],
        *[why for why, _ in found],
        *[f"With {name} first gives out: {cases[name].gives_out}" for name in first],
    ]


def read(text: Any) -> Requirement:
    """Read a requirement such as "payload>=1.5" from its text.

    Raises InputError for text of another form, UnknownName for what is no number of an evaluation.
    """
    found = _WRITTEN.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        expected = f'a number of {", ".join(UNITS)} beside a limit, such as "payload>=1.5"; >=, <=, > or <'
        raise InputError("requirement", expected, repr(text)[:80])
    name, comparison, limit = found.groups()
    if name not in UNITS:
        raise UnknownName("requirement", "a number", [name], UNITS)
    try:
        return Requirement(name, comparison, number("requirement", float(limit)))
    except ValueError:
        raise InputError("requirement", f"a finite number after {comparison}", repr(text)[:80]) from None


def _with_unit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip()
