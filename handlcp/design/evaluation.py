"""How well a hand does what a brief asks: plain numbers, for each object and in all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.design.require import read, unmet
from handlcp.errors import RequirementNotMet
from handlcp.grasp.solution.verdict import HELD
from handlcp.hand.find.candidate import Candidate
from handlcp.keywords import helped, helped_methods
from handlcp.record import Record
from handlcp.text_table import TextTable, wrapped

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
        return shown(factor, more)

    @property
    def mass(self) -> str:
        """The payload as it is printed."""
        return f"{shown(self.payload, self.at_least)} kg"


@helped_methods
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
        return self._most("force")

    @property
    def torque(self) -> float:
        """The largest torque of a joint [N·m, N]."""
        return self._most("torque")

    @property
    def torque_used(self) -> float:
        """The largest share of a torque limit [-]."""
        return self._most("torque_used")

    @property
    def motion(self) -> float:
        """The farthest that an object moves under its weight [m]."""
        return self._most("motion")

    @helped("texts")
    def require(self, *texts: str) -> Self:
        """This evaluation, where every object is held as the brief asks, and requirements are met such as
        "payload>=1.5" [kg] or "torque_used<=0.8": payload, factor, force, torque, torque_used or motion beside a limit,
        in the units above; >=, <=, > or <. The worst object counts.

        Raises RequirementNotMet, which says by how much, and what gives out; InputError for other texts.
        """
        __tracebackhide__ = True  # of pytest, which shows the test that asks, and what is not met
        if sentences := unmet([read(text) for text in texts], self.cases):
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
    def _in_all(self) -> str:
        word = "every object is held" if self.holds else f"not every object is held: {self.worst_object} is the worst"
        return f"{word}. First gives out: {self.gives_out or 'nothing up to that'}"

    @property
    def _without_mass(self) -> str:
        """Which objects have no mass, and what the verdict is about, in words; "" where all have one."""
        found = {name: case.candidate for name, case in self.cases.items() if case.candidate is not None}
        names = [name for name, one in found.items() if one.grasp.target is not None and not one.grasp.target.mass]
        if not names:
            return ""
        loads = any(len(self.cases[name].factors) > 1 for name in names)
        says = "payload and loads" if loads else "payload only"
        return f"no mass was given of {words.all_of(names)}: the verdict is about {says}. "

    def _most(self, name: str) -> float:
        known = [value for case in self.cases.values() if not np.isnan(value := getattr(case, name))]
        return max(known, default=np.nan)

    def __str__(self) -> str:
        head = wrapped(f"{self._without_mass}{self._in_all}.")
        rows = [
            (
                name,
                case.word,
                case.times(),
                shown(case.payload, case.at_least),
                _of(case.force),
                _percent(case.torque_used),
                _of(1e3 * case.motion),
            )
            for name, case in self.cases.items()
        ]
        heads = "object", "verdict", "times\nits loads", "payload\nkg", "force\nN", "torque\nused", "moves\nmm"
        return f"{head}\n\n{TextTable(heads, tuple(rows), '<<>>>>>')}"

    def __repr__(self) -> str:
        said = words.listed([f"{name}: {case.word}" for name, case in self.cases.items()])
        return f"Evaluation(payload={self.payload:.6g}, {said})"


def shown(value: float, more: bool) -> str:
    """A mass or factor that is held, as it is printed.

    more : whether it may be more, since nothing gave out.
    """
    return "any" if value == np.inf else f"{'≥ ' if more else ''}{value:.3g}"


def _of(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.3g}"


def _percent(value: float) -> str:
    return "" if np.isnan(value) else f"{100 * value:.0f} %"
