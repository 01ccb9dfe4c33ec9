"""The designs that an optimisation has tried: evaluated in any process, each beside the grasps of one that lies near.

Grasps are searched for by every design. Of each later design the grasps of the nearest design whose own search found
them, object by object, and which makes the same choices, are candidates, too: it "starts" from these. Designs that are
tried at once do not start from each other. So the rows hang on what is asked for alone, not on who does it when, and
a design's grasps can be made again from its row.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.design.evaluation import NOT_FOUND, Evaluation, ObjectCase
from handlcp.design.optimise.slopes import Gradient
from handlcp.design.space import ParameterValue, Space
from handlcp.design.sweep.cells import alike
from handlcp.design.sweep.journal import Journal
from handlcp.design.sweep.work import (
    DESIGN,
    ERROR,
    Maker,
    Numbered,
    Row,
    Values,
    bare,
    evaluated,
    packed,
    row_of,
    unpacked,
)
from handlcp.grasp.batch.solve_many import ExecutorJobs

NEAR = "near"  # column: the designs from whose grasps a design started, one for each object; "" for a search
_NONE = "-"
_HEADS = 3  # designs of the same choices that search for their grasps, where nothing comes before them
SLOPES = "slopes"  # key in a journal: samples for derivatives
Starts = dict[str, int]  # object → number of the design that it starts from
MOVED = 1e-3  # of the cube's side: designs that are nearer to each other than this have the same grasps


class Spent(Exception):
    """The budget, or the time, is spent. The argument says which."""


class Trials:
    """What has been tried so far. rows : of designs, by number. points : where these are in the cube."""

    def __init__(
        self, maker: Maker, space: Space, budget: int, seconds: float, renewed: Callable[[], Executor],
        journal: Journal | None, say: Callable[[int], None],
    ) -> None:  # fmt: skip
        self.maker, self.space, self.budget, self.seconds = maker, space, budget, seconds
        self.rows, self.points = list[Row](), list[Array]()
        self.used = 0
        self.gradients = dict[int, tuple[dict[str, float], Gradient]]()  # by design: terms near the least, derivatives
        self._packed, self._renewed, self._journal, self._say = packed(maker), renewed, journal, say
        self._there = dict[int, list[Row]]()
        for row in journal.rows if journal else ():
            if DESIGN in row:
                self._there.setdefault(int(row[DESIGN]), []).append(row)
        self._slopes = {row[SLOPES]: row for row in journal.rows if SLOPES in row} if journal else {}
        self._grasps, self._known = dict[int, bytes](), dict[tuple[Any, ...], int]()
        self._began = time.monotonic()

    # ---------------------------------------------------------------- What may still be spent.

    def spend(self, wanted: int, last: bool = False) -> int:
        """How many more evaluations of so many may be made. last : whatever the time. Raises Spent for none."""
        if not last and time.monotonic() - self._began > self.seconds:
            raise Spent(f"{self.seconds:g} s are over")
        left = self.budget - self.used
        if left <= 0:
            raise Spent(f"{self.budget} evaluations are spent")
        return min(wanted, left)

    def used_up(self, count: int) -> None:
        """So many were made."""
        self.used += count
        self._say(count)

    # ---------------------------------------------------------------- Designs.

    def tried(self, cube: Array, starts: Starts | None = None, last: bool = False) -> list[int]:
        """Numbers of the designs at points (n, d) of the cube, of which those that are new are evaluated. starts : what
        all of them start from, {} for a search; None: each from what is near. last : as in `spend`.

        Raises Spent once no more may be evaluated; what was is kept.
        """
        own = None if starts is None else tuple(starts.items())
        keys = [(*self.space.point(u).values(), own) for u in cube]
        new = dict[tuple[Any, ...], Array]()
        for key, u in zip(keys, cube, strict=True):
            if key not in self._known:
                new.setdefault(key, u)
        for wave in self._waves(list(new.items())) if starts is None else [list(new.items())]:
            if wave:
                self._wave(wave, starts, last)
        return [self._known[key] for key in keys]

    def _waves(self, new: list[tuple[Any, Array]]) -> list[list[tuple[Any, Array]]]:
        """Those that nothing comes before search for their grasps; then the others."""
        first, others = list[tuple[Any, Array]](), list[tuple[Any, Array]]()
        kinds = {self._kind(v) for v in self.points}
        for key, u in new:
            mine = self._kind(u)
            heads = sum(self._kind(v) == mine for _, v in first)
            (first if mine not in kinds and heads < _HEADS else others).append((key, u))
        return [first, others]

    def _wave(self, wave: list[tuple[Any, Array]], given: Starts | None, last: bool) -> None:
        """Evaluate all of these, as far as the budget goes."""
        may, before = self.spend(len(wave), last), len(self.rows)
        designs = [(before + k, self.space.point(u)) for k, (_, u) in enumerate(wave[:may])]
        starts = [self.starts(u) if given is None else given for _, u in wave[:may]]
        found = dict[int, Row]()
        try:
            self._settle(designs, starts, found)
        finally:  # stopped on the way, those are kept before which none is missing
            for (number, _), (key, u) in zip(designs, wave, strict=False):
                if number not in found:
                    break
                self.rows.append(found[number])
                self.points.append(u)
                self._known[key] = number
        if may < len(wave):
            self.spend(1)

    def _settle(self, designs: Sequence[Numbered], starts: Sequence[Starts], found: dict[int, Row]) -> None:
        """Put rows by number, of the journal or made."""
        known = {k: self._known_row(k, values) for k, values in designs}
        found.update({k: row for k, row in known.items() if row is not None})
        self.used_up(len(found))
        jobs = [(one, start) for one, start in zip(designs, starts, strict=True) if one[0] not in found]
        nears = {tuple(start.items()): self.near(start) for _, start in jobs}
        tasks = [(self._packed, one, nears[tuple(start.items())]) for one, start in jobs]
        for k, (row, grasps) in self.sent(design_work, tasks):
            (number, _), start = jobs[k]
            found[number] = row | {NEAR: " ".join(str(start.get(name, _NONE)) for name in names_of(row) if start)}
            if grasps is not None:
                self._grasps[number] = grasps
            if self._journal is not None:
                self._journal.append([found[number]])
            self.used_up(1)

    def _known_row(self, number: int, values: Values) -> Row | None:
        """Of a run before."""
        rows = [row for row in self._there.get(number, ()) if all(row.get(n) == v for n, v in values.items())]
        return rows[-1] if rows else None

    @property
    def beyond(self) -> list[Row]:
        """Rows of a run before with a larger budget, by number."""
        return [self._there[k][-1] for k in sorted(self._there) if k >= len(self.rows)]

    def sent(self, work: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
        """What comes back of each task, by its place, as it comes."""
        with ExecutorJobs[int](self._renewed()) as jobs:
            for k, task in enumerate(tasks):
                jobs.send(k, _called, (work, task))
                yield from jobs.finished_results(wait=False)  # in this process all are done at once
            while len(jobs):
                yield from jobs.finished_results(wait=True)

    # ---------------------------------------------------------------- What a design starts from.

    def starts(self, u: Array) -> Starts:
        """From which design the grasp of each object is brought along: the nearest of the same kind that searched."""
        found, mine = dict[str, tuple[float, int]](), self._kind(u)
        for k, (row, v) in enumerate(zip(self.rows, self.points, strict=True)):
            if self._kind(v) != mine:
                continue
            away = float(np.sum((u - v) ** 2))
            for name in searched(row):
                far, was = found.get(name, (np.inf, k))
                same = abs(away - far) <= MOVED**2
                if self._factor(k, name) > self._factor(was, name) if same else away < far:
                    found[name] = away, k
        return {name: k for name, (_, k) in found.items()}

    def _factor(self, number: int, name: str) -> float:
        value = self.rows[number].get(f"objects.{name}.factor")
        return np.inf if value is None else float(value)

    def near(self, starts: Mapping[str, int]) -> bytes | None:
        """The evaluation with these grasps, packed; made again where it is not there. None: nothing to start from."""
        missing = [k for k in dict.fromkeys(starts.values()) if k not in self._grasps]
        tasks = [(self._packed, (k, self.values(k)), None) for k in missing]
        for at, (_, grasps) in self.sent(design_work, tasks):
            if grasps is not None:
                self._grasps[missing[at]] = grasps
        cases = dict[str, ObjectCase]()
        for name, k in starts.items():
            there: Evaluation | None = unpacked(self._grasps[k]) if k in self._grasps else None
            if there is not None and there.cases[name].candidate is not None:
                cases[name] = there.cases[name]
        return packed(Evaluation(cases)) if cases else None

    def started(self, number: int) -> Starts:
        """What a design started from, as its row says."""
        row = self.rows[number]
        said = str(row.get(NEAR) or "").split()
        return {n: int(k) for n, k in zip(names_of(row), said, strict=False) if k != _NONE}

    def values(self, number: int) -> dict[str, ParameterValue]:
        """The parameters of a design."""
        return {name: self.rows[number][name] for name in self.space.names}

    def _kind(self, u: Array) -> tuple[float, ...]:
        """The choices that make another kind of hand."""
        same = alike(self.space)
        return tuple([self.space.point(u)[n] for n, a in zip(self.space.free, same, strict=True) if not a])  # type: ignore[misc]

    # ---------------------------------------------------------------- Derivatives, kept like rows.

    def kept(self, key: str, count: int, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """What `make` gives, plain data that take so many evaluations, from the journal where it is there. Raises
        Spent where these, and one more, may not be made.
        """
        if self.spend(count + 1) <= count:
            raise Spent(f"{self.budget} evaluations are spent")
        found = self._slopes.get(key)
        if found is None:
            found = {SLOPES: key} | make()
            if self._journal is not None:
                self._journal.append([found])
        self.used_up(count)
        return found


def _called(cargo: tuple[Callable[..., Any], tuple[Any, ...]]) -> Any:
    work, task = cargo
    return work(*task)


def names_of(row: Mapping[str, Any]) -> list[str]:
    """The objects of a row."""
    return [key.removeprefix("objects.").removesuffix(".continued") for key in row if key.endswith(".continued")]


def searched(row: Mapping[str, Any]) -> list[str]:
    """The objects of which a design has a grasp that it searched for."""
    return [
        name for name in names_of(row)
        if row[f"objects.{name}.continued"] is False and row[f"objects.{name}.word"] != NOT_FOUND
    ]  # fmt: skip


def design_work(maker: bytes, design: Numbered, near: bytes | None) -> tuple[Row, bytes | None]:
    """In any process: the row of a design, and its grasps, packed, where it searched for any."""
    found = evaluated(unpacked(maker), design, None if near is None else unpacked(near), head=near is None)
    row = row_of(design, found)
    wanted = row[ERROR] is None and bool(searched(row))
    return row, packed(bare(found)) if wanted and isinstance(found, Evaluation) else None


@contextmanager
def ended() -> Iterator[list[str]]:
    """Around an optimisation: why it was ended before it was done, in words; [] where it was not."""
    why = list[str]()
    try:
        yield why
    except Spent as spent:
        why.append(str(spent))
    except KeyboardInterrupt:
        why.append("it was interrupted")
