"""What an optimisation found: designs that passed, what was tried, why it ended, and how the objective goes on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from handlcp import words
from handlcp.check import check_integer, check_method_calls
from handlcp.design.evaluation import Evaluation
from handlcp.design.optimise.aims import COLUMN, Aim
from handlcp.design.optimise.slopes import Gradient
from handlcp.design.space import ParameterValue, Space
from handlcp.design.study import Study
from handlcp.design.sweep.work import DESIGN, Maker
from handlcp.errors import InputError
from handlcp.hand.hand import Hand
from handlcp.record import Record
from handlcp.words import TextTable, wrap_text

_TIED = 1e-3  # of the least: loads that hold so little more give out at once
_SHOWN = 10


@dataclass(frozen=True, eq=False)
class Kink(Record):
    """A parameter by which the objective has no sure derivative. says : why, in words. ahead, behind : derivatives by
    the parameter where it is a little larger and a little smaller; NaN beyond an end of its range.
    """

    entries = ("parameter", "says", "ahead", "behind")

    parameter: str
    says: str
    ahead: float
    behind: float


@check_method_calls
@dataclass(frozen=True, eq=False)
class Best(Record):
    """The designs that passed; made by `optimise`. Iterates over their parameters, the best first; prints as a table.

    objectives : as asked. designs : parameters of each, by name. numbers : of each in `study`. why : the optimisation
    ended. dropped : number of a design that was among the best → why it did not pass. slopes : of one objective, at the
    first design: its derivative by each parameter with a range, in the objective's unit by the parameter's. kinks :
    those of them that are none, with the reason. study : everything that was tried, as a `Study`.
    """

    entries = ("objectives", "designs", "numbers", "why", "dropped", "slopes", "kinks")

    objectives: tuple[str, ...]
    designs: tuple[Mapping[str, ParameterValue], ...]
    numbers: tuple[int, ...]
    why: str
    dropped: Mapping[int, str]
    slopes: Mapping[str, float]
    kinks: tuple[Kink, ...]
    study: Study = field(repr=False)
    maker: Maker = field(repr=False)
    evaluations: tuple[Evaluation, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self.designs)

    def __iter__(self) -> Iterator[Mapping[str, ParameterValue]]:
        return iter(self.designs)

    def hand(self, i: int = 0) -> Hand:
        """Of design i, made anew. Raises InputError for no such design."""
        return self.maker.hand(self.designs[self._at(i)])

    def evaluation(self, i: int = 0) -> Evaluation:
        """Of design i, with its grasps. Raises InputError for no such design."""
        return self.evaluations[self._at(i)]

    def _at(self, i: Any) -> int:
        if not self.designs:
            raise InputError("i", "a design that passed", f"{i!r}, and none did: {self.why}")
        return check_integer("i", i, 0, len(self) - 1)

    @property
    def front(self) -> Study:
        """The rows of the designs, as a table."""
        return self.study.some(self.numbers)

    def to_frame(self) -> Any:
        """A pandas table with a row for each design. Raises Unsupported without pandas."""
        return self.front.to_frame()

    def plot(self, path: Any = None, title: str = "") -> Any:
        """The figure of everything that was tried, as `Study.plot` has it, by the first two objectives, or one and the
        torque. Raises InputError; Unsupported without matplotlib.
        """
        by = [*self.objectives, "payload" if self.objectives[0].endswith("torque") else "-torque"][:2]
        return self.study.plot(
            path, title or f"An optimisation: the best {words.list_names(list(self.objectives))}", by
        )

    def __str__(self) -> str:
        few = f"{len(self)} {'design' if len(self) == 1 else 'designs'} of {len(self.study)} that were tried"
        head = f"{few}, for {words.list_names(list(self.objectives))}: {self.why}."
        lost = [f"Design {k} was dropped: {why}." for k, why in self.dropped.items()]
        said = [wrap_text(text) for text in (head, *lost, *[f"{kink.says}." for kink in self.kinks])]
        if not self.designs:
            return "\n".join(said)
        front = self.front
        columns = dict.fromkeys([*[COLUMN[one.removeprefix("-")] for one in self.objectives], "gives_out"])
        shown = [DESIGN, *Space(front.sweep["space"]).free, *columns]
        rows = [tuple([_cell(front.columns[name][k]) for name in shown]) for k in range(min(len(front), _SHOWN))]
        heads = tuple([name.replace("_", "\n") if name in columns else name.replace(".", ".\n", 1) for name in shown])
        table = TextTable(heads, tuple(rows), "<" + ">" * (len(shown) - 2) + "<")
        more = f"\n… {len(front) - _SHOWN} more" if len(front) > _SHOWN else ""
        return "\n".join(said) + f"\n\n{table}{more}"

    def __repr__(self) -> str:
        return f"Best({len(self)} of {len(self.study)} designs)"


def _cell(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else "" if value is None else str(value)


def slopes_of(
    space: Space, values: Mapping[str, ParameterValue], aim: Aim, terms: Mapping[str, float], g: Gradient
) -> tuple[dict[str, float], tuple[Kink, ...]]:  # fmt: skip
    """Derivatives of an objective by parameters, and where there are none. terms : near the least, key → value; g :
    their derivatives by the cube's coordinates.
    """
    if not terms:
        return {}, ()
    order = sorted(terms, key=lambda key: terms[key])
    least, tied = order[0], [key for key in order[1:] if terms[key] <= terms[order[0]] * (1.0 + _TIED)]
    slopes, kinks = dict[str, float](), list[Kink]()
    for name, one in g.slopes.get(least, {}).items():
        entry = space.ranges[name]
        step = 1.0 / (float(values[name]) * _log(entry) if entry.log else entry.high - entry.low)
        ahead, behind = (side * step for side in one.sides)
        slopes[name] = one.rate * step
        says = ""
        if tied:
            says = f"{aim.name} by {name}: {words.list_names([least, *tied])} give out at once, and the least counts"
        elif not one.sure:
            says = f"{aim.name} by {name} has no sure derivative: two steps differ by {one.apart:.1e} of it"
        if says:
            kinks.append(Kink(name, says, ahead, behind))
    return slopes, tuple(kinks)


def _log(entry: Any) -> float:
    from math import log

    return log(entry.high / entry.low)
