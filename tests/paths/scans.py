"""Load limits over squeeze, friction, stiffness and direction: where they jump, and whether something happens there.

A jump is a step between neighbours that is larger than `LEAST` of the factor and than `TIMES` the typical step of its
scan, and that stays while the neighbours are brought together: a limit that only rises steeply has no jump. A jump has
a name where mechanics has one: the path with the lower limit has no rest beyond it ("lost"), or the two paths end by
different things, such as a joint at its torque limit that the other one only comes near. A limit that was not found,
or that a criterion ends on both sides of the jump, hangs on something else.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

import handlcp as hl
from tests.paths.corpus import Case, grasp_of, held
from tests.paths.time_limit import TookTooLong, at_most
from tests.paths.words import limit_of

LEAST, TIMES = 0.05, 3.0
NOTHING = 0.1  # of the median factor of a scan: below it a step counts against this
SAME = 1e-6  # of two loads on one path
HALVINGS = 12  # of the interval between neighbours
SCANS = ("squeeze", "friction", "stiffness", "direction")
SHARES = (0.7, 1.4)  # of squeeze, friction and stiffness


@dataclass(frozen=True)
class Limit:
    """A point of a scan. found : its load limit; None: it is refused."""

    found: hl.LoadLimit | None

    @property
    def factor(self) -> float:
        """NaN where it is refused."""
        return np.nan if self.found is None else float(self.found.factor)

    @property
    def ends(self) -> set[tuple[str, str]]:
        """What gives out, with whom that befalls; without what is no matter of mechanics."""
        binds = () if self.found is None else self.found.binds
        return {(bind.kind, bind.who) for bind in binds if bind.kind != "undecided"}

    @property
    def is_lost(self) -> bool:
        """Whether the path has no rest beyond."""
        lost = None if self.found is None else self.found.lost
        return lost is not None and lost <= self.factor * (1.0 + SAME)

    @property
    def events(self) -> set[tuple[str, str]]:
        """What happens on the way, with whom, each once."""
        events = () if self.found is None else self.found.events
        return {(event.kind, event.who) for event in events if event.factor <= self.factor}


Ask = Callable[[float], Limit]


@dataclass(frozen=True)
class Jump:
    """at, until : the neighbours, as shares or angles. low, high : limits there."""

    at: float
    until: float
    low: Limit
    high: Limit

    @property
    def name(self) -> str:
        """What ends the path with the lower limit; "": nothing that mechanics has a name for."""
        lower, upper = sorted((self.low, self.high), key=lambda limit: np.nan_to_num(limit.factor, nan=-1.0))
        if not lower.ends or (lower.ends == upper.ends and not lower.is_lost):
            return ""
        return ("lost, " if lower.is_lost else "") + _listed(lower.ends)

    def __str__(self) -> str:
        size = f"{self.at:.5f} to {self.until:.5f}: {self.low.factor:.5g} to {self.high.factor:.5g}"
        only = _listed(self.low.events ^ self.high.events) or "nothing"
        return f"{size}: {self.name or 'WITHOUT A NAME'}; on one side alone: {only}"


def _listed(events: Iterable[tuple[str, str]]) -> str:
    return ", ".join(sorted(f"{who} {kind}" for kind, who in events))


def ask_limit(case: Case, way: np.ndarray) -> Limit:
    """The limit of a case along a load."""
    try:
        return Limit(limit_of(case, way))
    except hl.HandLCPError:
        return Limit(None)


def turned(way: np.ndarray, angle: float) -> np.ndarray:
    """A force turned about an axis across it."""
    axis = np.cross(way[:3], np.eye(3)[int(abs(way[:3]).argmin())])
    return np.append(pin.exp3(angle * axis / np.linalg.norm(axis)) @ way[:3], way[3:])


def scan_of(case: Case, what: str, points: int) -> tuple[np.ndarray, Ask]:
    """Values of what is varied, and the limit at one of them along the case's first direction."""
    way, recipe = case.directions[0], case.recipe
    if what == "direction":
        return np.linspace(0.0, 2 * np.pi, points), lambda angle: ask_limit(case, turned(way, angle))
    change = {"squeeze": recipe.squeezed, "friction": recipe.rubbed, "stiffness": recipe.stiffer}[what]
    return np.linspace(*SHARES, points), lambda share: ask_limit(case.changed(change(share)), way)


def steps_of(values: np.ndarray, floor: float) -> np.ndarray:
    """Steps between neighbours, relative to the larger one, or to a factor that is next to nothing in this scan;
    between infinite ones 0, to an infinite one 1.
    """
    a, b = values[:-1], values[1:]
    with np.errstate(invalid="ignore"):
        off = abs(b - a) / np.maximum(np.maximum(abs(a), abs(b)), max(floor, 1e-300))
    return np.where(a == b, 0.0, np.where(np.isfinite(a) & np.isfinite(b), off, 1.0))


def find_jumps(at: np.ndarray, ask: Ask) -> Iterator[Jump]:
    """The jumps of a scan, each between neighbours that were halved `HALVINGS` times."""
    limits = [ask(x) for x in at]
    values = np.array([limit.factor for limit in limits])
    floor = NOTHING * float(np.median(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0
    steps = steps_of(values, floor)
    least = max(LEAST, TIMES * float(np.median(steps)))
    for k in np.flatnonzero(steps > least):
        jump = Jump(float(at[k]), float(at[k + 1]), limits[k], limits[k + 1])
        for _ in range(HALVINGS):
            middle = 0.5 * (jump.at + jump.until)
            between = ask(middle)
            left, right = steps_of(np.array([jump.low.factor, between.factor, jump.high.factor]), floor)
            if max(left, right) <= least:
                break  # each half is small: the limit is steep
            if left >= right:
                jump = Jump(jump.at, middle, jump.low, between)
            else:
                jump = Jump(middle, jump.until, between, jump.high)
        else:
            yield jump


def measure(count: int, points: int, seconds: float, ask: str, seed: int = 0, start: int = 0) -> int:
    """Print every jump of so many grasps of `corpus.grasp_of`; the number of those without a name. seconds : longest
    for one scan, per point.
    """
    total: Counter[str] = Counter()
    for index in range(start, start + count):
        case = grasp_of(seed, index)
        if case.source != "case_of" and not held(case):
            total["not held"] += 1
            continue
        for what in ask.split(","):
            total[f"scans of {what}"] += 1
            for line, kind in _told(case, what, points, seconds):
                total[f"{what}: {kind}"] += 1
                print(f"{case.rebuilt} {case.name}: {line}", flush=True)
    print(dict(total))
    return sum(number for what, number in total.items() if what.endswith("without a name"))


def _told(case: Case, what: str, points: int, seconds: float) -> list[tuple[str, str]]:
    """(line to print, what it is) of each jump of one scan, or that its time was over."""
    found: list[Any] = []
    try:
        with at_most(points * seconds):
            for jump in find_jumps(*scan_of(case, what, points)):
                kind = "jumps with a name" if jump.name else "jumps without a name"
                found.append((f"{what} {jump}", kind))
    except TookTooLong as why:
        found.append((f"{what}: {why}", "stopped"))
    return found
