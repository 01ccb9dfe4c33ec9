"""What a worker does of a sweep: some designs of one cell, made, evaluated and told as rows.

A cell is worked on in two steps, and the numbers hang on these alone, not on who does them when:

    its heads       those in its middle, one after the other
    the others      in any order

Each searches for its grasps; the best grasps of the heads are candidates of the others, which "start" from them.
"""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

from handlcp.design.brief import Brief
from handlcp.design.evaluate import evaluate, evaluate_worst
from handlcp.design.evaluation import Evaluation, ObjectCase
from handlcp.design.space import ParameterValue
from handlcp.errors import InputError, UnknownName, translate_arguments
from handlcp.grasp.solution.verdict import HELD
from handlcp.hand.hand import Hand

MOST_HEADS = 8  # where none of so many grasps an object, the others of the cell have no candidate of theirs
DESIGN, ERROR = "design", "error"  # columns beside the parameters and what `Evaluation.to_row` has
FAILURES = Exception, SystemExit  # what a design may raise, which then is its reason

Values = Mapping[str, ParameterValue]
Numbered = tuple[int, Values]  # a design: its number, its parameters
Outcome = Evaluation | str  # of a design, or why there is none
Row = dict[str, Any]

# ----------------------------------------------------------------
# How a hand and its brief are made.


@dataclass(frozen=True, slots=True)
class Maker:
    """make : a function of parameters, by name, to a `Hand`, or a Hand that is varied. brief : a Brief, or a function
    to one. Each function gets those of the parameters that it names, all where it takes any; a Hand gets those that the
    brief's function does not name.
    """

    make: Any
    brief: Any

    def hand(self, values: Values) -> Hand:
        """Raises what `make` raises, and InputError for what is no Hand."""
        if isinstance(self.make, Hand):
            briefly = () if isinstance(self.brief, Brief) else _named(self.brief)
            return self.make.vary({name: value for name, value in values.items() if name not in briefly})
        made = self.make(**_taken(self.make, values))
        if not isinstance(made, Hand):
            raise InputError("make", "a function that gives a Hand", repr(made)[:80])
        return made

    def asked(self, values: Values) -> Brief:
        """Raises what `brief` raises, and InputError for what is no Brief."""
        made = self.brief if isinstance(self.brief, Brief) else self.brief(**_taken(self.brief, values))
        if not isinstance(made, Brief):
            raise InputError("brief", "a Brief, or a function that gives one", repr(made)[:80])
        return made

    def check(self, values: Values) -> None:
        """Raises InputError where a parameter goes nowhere or one is missing; UnknownName for one that the hand or the
        brief of these values does not have. Hands and briefs that take any name are made for that.
        """
        given = {"make": (self.make, Hand), "brief": (self.brief, Brief)}
        taken, free = set[str](), list[str]()
        for argument, (function, kind) in given.items():
            if isinstance(function, Hand):
                free.append(argument)
            elif not isinstance(function, Brief):
                if not callable(function):
                    name = kind.__name__
                    raise InputError(argument, f"a {name}, or a function to one", repr(function)[:80])
                try:
                    own = _taken(function, values)
                    inspect.signature(function).bind(**own)
                except (TypeError, ValueError) as error:
                    raise InputError(argument, f"a function of {', '.join(values)}", str(error)) from None
                taken |= set(own)
                if _takes_any(function):
                    free.append(argument)
        lost = [name for name in values if name not in taken]
        if lost and not isinstance(self.make, Hand):
            raise InputError("space", "parameters that make or brief takes", ", ".join(lost))
        with translate_arguments({"changes": "space"}):
            for argument in free:
                try:
                    self.hand(values) if argument == "make" else self.asked(values)
                except UnknownName:
                    raise
                except FAILURES:
                    continue  # a design's own reason


def _named(function: Callable[..., Any]) -> tuple[str, ...]:
    """The parameters that a function names."""
    kinds = inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY
    return tuple([p.name for p in inspect.signature(function).parameters.values() if p.kind in kinds])


def _takes_any(function: Callable[..., Any]) -> bool:
    """Whether a function takes any name."""
    return any(p.kind is inspect.Parameter.VAR_KEYWORD for p in inspect.signature(function).parameters.values())


def _taken(function: Callable[..., Any], values: Values) -> dict[str, ParameterValue]:
    """Those of the values that a function takes."""
    if _takes_any(function):
        return dict(values)
    names = _named(function)
    return {name: value for name, value in values.items() if name in names}


# ----------------------------------------------------------------
# How it travels: as bytes, in which functions of a script or a notebook go along.


def packed(value: Any) -> bytes:
    """For `unpacked`, in another process, also of functions that it cannot import."""
    from cloudpickle import dumps

    return bytes(dumps(value))


@lru_cache(maxsize=4)
def unpacked(value: bytes) -> Any:
    """Once in a process for all tasks of a sweep or a cell."""
    import pickle

    return pickle.loads(value)


class Task(NamedTuple):
    """maker : a `Maker`, packed. designs : those to do. near : the `Evaluation` that they start from, packed; None:
    they search. head : whether it is one head of a cell.
    """

    maker: bytes
    designs: Sequence[Numbered]
    near: bytes | None
    head: bool


class Done(NamedTuple):
    """rows : of the designs. grasps : of a head, packed; None where it failed. seconds : that it took."""

    rows: list[Row]
    grasps: bytes | None
    seconds: float


# ----------------------------------------------------------------


def work(task: Task) -> Done:
    """In any process. Nothing that a design raises comes out: it is the row's reason."""
    began, maker = time.perf_counter(), unpacked(task.maker)
    near: Evaluation | None = None if task.near is None else unpacked(task.near)
    found = [evaluated(maker, one, near, task.head) for one in task.designs]
    rows = [row_of(one, each) for one, each in zip(task.designs, found, strict=True)]
    kept = packed(bare(found[0])) if task.head and isinstance(found[0], Evaluation) else None
    return Done(rows, kept, time.perf_counter() - began)


class Heads:
    """The first designs of a cell, whose grasps the others start from: of each object that with which a head holds
    most, as the brief asks. More follow the first, one by one, as long as an object has no grasp.
    """

    def __init__(self, cell: Sequence[int]) -> None:
        self.designs, self.begun = list(cell[:MOST_HEADS]), 0
        self.found: dict[int, Evaluation | None] = {}  # of those that are done

    def ready(self) -> list[int]:
        """Those that may begin now, and have not."""
        if self.done or len(self.found) < self.begun:
            return []
        self.begun += 1
        return self.designs[self.begun - 1 : self.begun]

    @property
    def done(self) -> bool:
        """Whether the others may begin."""
        if len(self.found) < max(self.begun, 1):
            return False
        near = self.near
        known = near is not None and all(case.candidate is not None for case in near.cases.values())
        return known or len(self.found) == len(self.designs)

    @property
    def near(self) -> Evaluation | None:
        """What those start from that begin now; None: nothing, they search."""
        best = dict[str, ObjectCase]()
        for found in [self.found[k] for k in self.designs if k in self.found]:
            for name, case in ({} if found is None else found.cases).items():
                was = best.get(name)
                if was is None or _rank(case) > _rank(was):
                    best[name] = case
        return Evaluation(best) if best else None


def _rank(case: ObjectCase) -> tuple[bool, bool, float]:
    """The better of two grasps has the larger."""
    return case.candidate is not None, case.word == HELD, case.factor


def bare(found: Evaluation) -> Evaluation:
    """Its grasps, without what was worked out of them."""
    cases = found.cases.items()
    return Evaluation({
        name: replace(case, candidate=None if case.candidate is None else replace(case.candidate))
        for name, case in cases
    })  # fmt: skip


def evaluated(maker: Maker, design: Numbered, near: Evaluation | None, head: bool) -> Outcome:
    """The evaluation of a design, or why there is none. Heads are compared object by object, so all of theirs are
    followed to the end.
    """
    try:
        return (evaluate if head else evaluate_worst)(maker.hand(design[1]), maker.asked(design[1]), near)
    except FAILURES as error:
        return why_failed(error)


def why_failed(error: BaseException) -> str:
    """The reason of a design's row."""
    return f"{type(error).__name__}: {error}"


def row_of(design: Numbered, found: Outcome) -> Row:
    """Number, parameters, what went wrong and the outcome; None where there is nothing to say."""
    number, values = design
    outcome = {ERROR: found} if isinstance(found, str) else {ERROR: None} | found.to_row()
    return {DESIGN: number, **values} | {key: None if value == "" else value for key, value in outcome.items()}


def in_order(rows: Sequence[Row]) -> list[Row]:
    """By the numbers of the designs."""
    return sorted(rows, key=lambda row: int(row[DESIGN]))
