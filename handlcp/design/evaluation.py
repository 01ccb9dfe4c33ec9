"""`Evaluation`: how well a hand does what a brief asks: plain numbers, for each object and in all."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np

from handlcp import words
from handlcp.check import check_call, check_method_calls, check_number
from handlcp.errors import InputError, RequirementNotMet, UnknownName
from handlcp.grasp.solution.verdict import HELD
from handlcp.hand.find.candidate import Candidate
from handlcp.record import Record
from handlcp.words import TextTable, wrap_text

NOT_FOUND = "NOT FOUND"  # beside the words of a verdict


@dataclass(frozen=True, eq=False)
class ObjectCase(Record):
    """How well a hand holds one object of a brief.

    word : the worst of `verdicts`, or "NOT FOUND" where no grasp was.
    verdicts : "HELD", "OVER LIMIT", "NOT HELD" or "UNDECIDED" for the weight and each load, with the safety that was
        asked for.
    factors : how many times the weight in the worst orientation, and each load, is held; infinite for what nothing
        ends. A load that holds more than the safety, and than what gives out first, is not followed on: its factor is
        that up to which it was.
    factor : the smallest of the factors.
    payload : [kg] held in every orientation, 0 without a grasp.
    gives_out : what gives out there, in words, or why no grasp was found; "" where nothing gives out up to `payload`
        and `factor`, which are then at least what they say: `at_least`.
    kind : of the grasp, "pinch" or "power".
    continued : whether it is the grasp of another design, brought along.
    force : the largest normal force at a contact while the hand closes and the loads come [N].
    torque : the largest of a joint at the end of that [N·m, N].
    torque_used : the largest share of a torque limit at the end of that [-].
    motion : how far the object moves under its weight [m].
    candidate : the grasp; None without one.
    masses : [kg] held in each orientation, or at least.
    """

    entries = (
        "word",
        "verdicts",
        "factors",
        "payload_kg",
        "factor",
        "gives_out",
        "at_least",
        "kind",
        "continued",
        "force_N",
        "torque_Nm",
        "torque_used",
        "motion_m",
    )

    word: str
    verdicts: Mapping[str, str]
    factors: Mapping[str, float]
    payload: float
    gives_out: str
    kind: str = ""
    continued: bool = False
    force: float = np.nan
    torque: float = np.nan
    torque_used: float = np.nan
    motion: float = np.nan
    candidate: Candidate | None = field(default=None, repr=False)
    masses: tuple[float, ...] = field(default=(), repr=False)

    @property
    def factor(self) -> float:
        """The smallest of the factors."""
        return min(self.factors.values())

    @property
    def at_least(self) -> bool:
        """Whether payload and factor may be more."""
        return not self.gives_out

    def times(self, load: str = "") -> str:
        """The factor of a load, or the smallest, as it is printed: "≥ 1.5" where it may be more."""
        factor, first = self.factors.get(load, self.factor), min(self.factors, key=lambda name: self.factors[name])
        more = self.at_least or (load not in ("", first) and self.verdicts[load] == HELD)
        return format_held(factor, more)

    @property
    def mass(self) -> str:
        """The payload as it is printed."""
        return f"{format_held(self.payload, self.at_least)} kg"


@check_method_calls
@dataclass(frozen=True, eq=False)
class Evaluation(Record):
    """How well a hand does what a brief asks; made by `evaluate`. `to_dict` and `to_row` are plain numbers and words.

    cases : object → what is so of it. Numbers in all are those of the worst object: the least payload [kg] and factor,
    the largest force [N], torque [N·m], share of a torque limit and motion [m]; a number that is not known of some
    object, since no grasp of it was found, is that of the others, NaN where there are none.
    """

    entries = (
        "holds",
        "payload_kg",
        "factor",
        "gives_out",
        "worst_object",
        "force_N",
        "torque_Nm",
        "torque_used",
        "motion_m",
        "objects = cases",
    )

    cases: Mapping[str, ObjectCase]

    @property
    def holds(self) -> bool:
        """Whether every object is held under its weight and every load."""
        return all(case.word == HELD for case in self.cases.values())

    @property
    def verdicts(self) -> dict[str, dict[str, str]]:
        """The word of each object under each load: object → load → word."""
        return {name: dict(case.verdicts) for name, case in self.cases.items()}

    @property
    def worst_object(self) -> str:
        """The one with the smallest factor, of those that are not held where there are any; of several the first of
        which it is known what gives out.
        """
        cases = self.cases
        return min(cases, key=lambda name: (cases[name].word == HELD, cases[name].factor, cases[name].at_least))

    @property
    def payload(self) -> float:
        """[kg] of the object of which the least mass is held."""
        return min(case.payload for case in self.cases.values())

    @property
    def factor(self) -> float:
        """How many times all weights and loads are held."""
        return min(case.factor for case in self.cases.values())

    @property
    def gives_out(self) -> str:
        """What gives out first, in words."""
        return self.cases[self.worst_object].gives_out

    @property
    def force(self) -> float:
        """The largest normal force at a contact [N]."""
        return self._largest("force")

    @property
    def torque(self) -> float:
        """The largest torque of a joint [N·m, N]."""
        return self._largest("torque")

    @property
    def torque_used(self) -> float:
        """The largest share of a torque limit [-]."""
        return self._largest("torque_used")

    @property
    def motion(self) -> float:
        """The farthest that an object moves under its weight [m]."""
        return self._largest("motion")

    @check_call("texts")
    def require(self, *texts: str) -> Self:
        """This evaluation, where every object is held as the brief asks, and requirements are met such as
        "payload>=1.5" [kg] or "torque_used<=0.8": payload, factor, force, torque, torque_used or motion beside a limit,
        in the units above; >=, <=, > or <. The worst object counts.

        Raises RequirementNotMet, which says by how much, and what gives out; InputError for other texts.
        """
        __tracebackhide__ = True  # of pytest, which shows the test that asks, and what is not met
        if sentences := list_unmet([parse_requirement(text) for text in texts], self.cases):
            raise RequirementNotMet(sentences)
        return self

    def to_row(self) -> dict[str, Any]:
        """`to_dict` without dictionaries in it, for a row of a table: keys within keys are joined by dots. A payload or
        factor that nothing ends is infinite.
        """
        known = {"payload_kg": self.payload, "factor": self.factor}
        for name, case in self.cases.items():
            own = {"payload_kg": case.payload, "factor": case.factor}
            own |= {f"factors.{load}": factor for load, factor in case.factors.items()}
            known |= {f"objects.{name}.{key}": value for key, value in own.items()}
        return super().to_row() | {key: value for key, value in known.items() if value == np.inf}

    @property
    def _summary(self) -> str:
        word = "every object is held" if self.holds else f"not every object is held: {self.worst_object} is the worst"
        return f"{word}. First gives out: {self.gives_out or 'nothing up to that'}"

    @property
    def _mass_note(self) -> str:
        """Which objects have no mass, and what the verdict is about, in words; "" where all have one."""
        found = {name: case.candidate for name, case in self.cases.items() if case.candidate is not None}
        names = [name for name, one in found.items() if one.grasp.target is not None and not one.grasp.target.mass]
        if not names:
            return ""
        loads = any(len(self.cases[name].factors) > 1 for name in names)
        says = "payload and loads" if loads else "payload only"
        return f"no mass was given of {words.join_names(names)}: the verdict is about {says}. "

    def _largest(self, name: str) -> float:
        known = [value for case in self.cases.values() if not np.isnan(value := getattr(case, name))]
        return max(known, default=np.nan)

    def __str__(self) -> str:
        head = wrap_text(f"{self._mass_note}{self._summary}.")
        rows = [
            (
                name,
                case.word,
                case.times(),
                format_held(case.payload, case.at_least),
                _format_number(case.force),
                _format_share(case.torque_used),
                _format_number(1e3 * case.motion),
            )
            for name, case in self.cases.items()
        ]
        heads = "object", "verdict", "times\nits loads", "payload\nkg", "force\nN", "torque\nused", "moves\nmm"
        return f"{head}\n\n{TextTable(heads, tuple(rows), '<<>>>>>')}"

    def __repr__(self) -> str:
        said = words.list_names([f"{name}: {case.word}" for name, case in self.cases.items()])
        return f"Evaluation(payload={self.payload:.6g}, {said})"


def format_held(value: float, more: bool) -> str:
    """A mass or factor that is held, as it is printed.

    more : whether it may be more, since nothing gave out.
    """
    return "any" if value == np.inf else f"{'≥ ' if more else ''}{value:.3g}"


def _format_number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.3g}"


def _format_share(value: float) -> str:
    return "" if np.isnan(value) else f"{100 * value:.0f} %"


# ----------------------------------------------------------------
# Requirements such as "payload>=1.5" of an evaluation, and what is said where one is not met.


REQUIREMENT_UNITS = {"payload": "kg", "factor": "", "force": "N", "torque": "N·m", "torque_used": "", "motion": "m"}
_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
}
_REQUIREMENT_PATTERN = re.compile(r"\s*(\w+)\s*(>=|<=|>|<)\s*([^=<>\s]\S*)\s*")


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
        return " ".join([self.name, self.comparison, _format_with_unit(self.limit, REQUIREMENT_UNITS[self.name])])

    def is_met(self, value: float) -> bool:
        """Whether this number meets the requirement; NaN meets nothing."""
        return _COMPARISONS[self.comparison](value, self.limit)

    def find_shortfall(self, cases: Mapping[str, Any]) -> tuple[str, str] | None:
        """Why it is not met, and by which object: the worst counts, and each has to have a grasp. None: it is met."""
        values = {name: getattr(case, self.name) for name, case in cases.items()}
        if without := [name for name, value in values.items() if np.isnan(value)]:
            return f"{self} is not met: {without[0]} is not held at all", without[0]
        least = self.comparison.startswith(">")
        worst = (min if least else max)(values, key=lambda name: values[name])
        if self.is_met(values[worst]):
            return None
        here, apart = (
            _format_with_unit(v, REQUIREMENT_UNITS[self.name]) for v in (values[worst], abs(values[worst] - self.limit))
        )
        return f"{self} is not met: {here} with {worst}, {apart} too {'little' if least else 'much'}", worst


def list_unmet(requirements: Iterable[Requirement], cases: Mapping[str, Any]) -> list[str]:
    """A sentence for each object that is not held as its brief asks, and for each requirement that objects do not meet;
    and what gives out with each of these objects.
    """
    lost = {name: case for name, case in cases.items() if case.word != HELD}
    found = [why for one in requirements if (why := one.find_shortfall(cases)) is not None]
    first = dict.fromkeys(name for _, name in found if name not in lost)
    return [
        *[f"{name} is {case.word}: {case.gives_out}" for name, case in lost.items()],
        *[why for why, _ in found],
        *[f"With {name} first gives out: {cases[name].gives_out}" for name in first],
    ]


def parse_requirement(text: Any) -> Requirement:
    """Read a requirement such as "payload>=1.5" from its text.

    Raises InputError for text of another form, UnknownName for what is no number of an evaluation.
    """
    found = _REQUIREMENT_PATTERN.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        expected = f'a number of {", ".join(REQUIREMENT_UNITS)} beside a limit, such as "payload>=1.5"; >=, <=, > or <'
        raise InputError("requirement", expected, repr(text)[:80])
    name, comparison, limit = found.groups()
    if name not in REQUIREMENT_UNITS:
        raise UnknownName("requirement", "a number", [name], REQUIREMENT_UNITS)
    try:
        return Requirement(name, comparison, check_number("requirement", float(limit)))
    except ValueError:
        raise InputError("requirement", f"a finite number after {comparison}", repr(text)[:80]) from None


def _format_with_unit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip()
