"""Load limits over squeeze, friction and direction, on boxes: where they jump.

A jump is a step between neighbours that is larger than `LEAST` of the factor and than `TIMES` the typical step of its
scan. Between such neighbours the scan is repeated ten times finer: a limit that only rises steeply has no jump there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from tests.paths.corpus import Case, cases
from tests.paths.recipes import HandRecipe
from tests.paths.same import factor_of

LEAST, TIMES, FINER = 0.05, 3.0, 10
Ask = Callable[[float], float]


class Jump(NamedTuple):
    """at, until : the neighbours, as shares or angles. low, high : factors there."""

    at: float
    until: float
    low: float
    high: float


def cases_with_boxes(count: int, seed: int = 0) -> Iterator[Case]:
    """Cases with hands that hold boxes."""
    every = (case for case in cases(400 * count, seed) if isinstance(case.recipe, HandRecipe))
    yield from islice((case for case in every if case.recipe.thing.kind == "box"), count)


def _turned(way: np.ndarray, angle: float) -> np.ndarray:
    """A force turned about an axis across it."""
    axis = np.cross(way[:3], np.eye(3)[int(abs(way[:3]).argmin())])
    return np.append(pin.exp3(angle * axis / np.linalg.norm(axis)) @ way[:3], way[3:])


def scans_of(case: Case, points: int) -> dict[str, tuple[np.ndarray, Ask]]:
    """Of a case along its first direction: what is varied, its values, and the limit there."""
    way = case.directions[0]
    return {
        "squeeze": (np.linspace(0.7, 1.4, points), lambda s: factor_of(case.changed(case.recipe.squeezed(s)), way)),
        "friction": (np.linspace(0.7, 1.4, points), lambda s: factor_of(case.changed(case.recipe.rubbed(s)), way)),
        "direction": (np.linspace(0.0, 2 * np.pi, points), lambda a: factor_of(case, _turned(way, a))),
    }


def _steps(values: np.ndarray) -> np.ndarray:
    """Steps between neighbours, relative to the larger one; between infinite ones 0, to an infinite one 1."""
    a, b = values[:-1], values[1:]
    with np.errstate(invalid="ignore"):
        off = abs(b - a) / np.maximum(np.maximum(abs(a), abs(b)), 1e-300)
    return np.where(a == b, 0.0, np.where(np.isfinite(a) & np.isfinite(b), off, 1.0))


def jumps(at: np.ndarray, ask: Ask, finer: int = FINER) -> tuple[np.ndarray, list[Jump]]:
    """The factors of a scan, and its jumps, each between neighbours `finer` times closer. finer 1: as they are."""
    values = np.array([ask(x) for x in at])
    return values, list(_jumps(at, values, ask, finer))


def _jumps(at: np.ndarray, values: np.ndarray, ask: Ask, finer: int) -> Iterator[Jump]:
    steps = _steps(values)
    least = max(LEAST, TIMES * float(np.median(steps)))
    for k in np.flatnonzero(steps > least):
        between, found = at[k : k + 2], values[k : k + 2]
        if finer > 1:
            between = np.linspace(at[k], at[k + 1], finer + 1)
            found = np.array([values[k], *[ask(x) for x in between[1:-1]], values[k + 1]])
        inner = _steps(found)
        j = int(inner.argmax())
        if inner[j] > min(least, 0.5 * steps[k]):
            yield Jump(float(between[j]), float(between[j + 1]), float(found[j]), float(found[j + 1]))


def measure(boxes: int, points: int, seed: int = 0) -> int:
    """Print every jump; their number."""
    total: dict[str, Any] = {}
    for case in cases_with_boxes(boxes, seed):
        for what, (at, ask) in scans_of(case, points).items():
            _, found = jumps(at, ask)
            total[what] = total.get(what, 0) + len(found)
            for j in found:
                where = f"({case.seed}, {case.number}) {case.name}: {what} {j.at:.4f} to {j.until:.4f}"
                print(f"{where}: {j.low:.5g} to {j.high:.5g}", flush=True)
    print(f"jumps on {boxes} boxes: {total}")
    return sum(total.values())
