"""`path_cost`: time and error of `follow` and `load_limit` over the accuracy that is asked of their steps."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, check_call, check_integer, check_method_calls, check_number, check_sequence
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.limits.followed import Before, anything_else
from handlcp.grasp.limits.load_limit import load_of
from handlcp.grasp.path.follow import follow, is_followed
from handlcp.grasp.path.state import Stage
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.record import Record
from handlcp.studies.accuracy.methods import share
from handlcp.words import TextTable, wrap_text

FOLLOW, LIMIT = "follow", "load_limit"
_HELD = 0.95  # of the load limit: what `follow` is asked for
_FINEST = 0.1  # times the finest accuracy: that of the answer which errors are measured against
_STEPS = 1  # of a stage, at least
_ORDER = ("squeeze", Stage("weight", weight=1.0), "load")


_Answer = tuple[Array, int, float]  # what was found, in how many steps, and its estimated error


@dataclass(frozen=True, slots=True)
class PathRow(Record):
    """One question with one accuracy. question : "follow", the forces at the end of a held load; or "load_limit", the
    factor. accuracy : asked of each step. steps : that were taken. seconds : the quickest of several runs. error :
    relative, against a finer accuracy. estimate : the largest error of a step, as the path estimates it.
    """

    entries = ("question", "accuracy", "steps", "seconds", "error", "estimate")

    question: str
    accuracy: float
    steps: int
    seconds: float
    error: float
    estimate: float


@check_method_calls
@dataclass(frozen=True, eq=False)
class PathCost(Record):
    """What accuracy costs on a path of a grasp; made by `path_cost`.

    rows : every question with every accuracy. load (6,) : the load whose limit was asked for [N, N·m]. factor : its
        load limit, with the finest accuracy. geometry : "fixed" or "followed".
    """

    entries = ("load_N_Nm (6,)", "factor", "geometry", "rows")

    rows: tuple[PathRow, ...]
    load: Array
    factor: float
    geometry: str

    def of(self, question: str) -> tuple[PathRow, ...]:
        """The rows of one question, the coarsest accuracy first."""
        return tuple([r for r in self.rows if r.question == question])

    @property
    def summary(self) -> str:
        """One sentence about how the error falls with the accuracy, and how often it is larger than that."""
        orders = []
        for question in (FOLLOW, LIMIT):
            rows = [r for r in self.of(question) if r.error > 0.0]
            if len({r.steps for r in rows}) > 1:
                slope = np.polyfit(np.log([r.accuracy for r in rows]), np.log([r.error for r in rows]), 1)[0]
                orders.append(f"{10.0 ** float(slope):.2g} ({question})")
        low = sum([r.error > r.accuracy for r in self.rows])
        fall = f"a tenth of the accuracy asked divides the error by {' and '.join(orders)}; " if orders else ""
        return f"{fall}the error is larger than the accuracy asked in {low} of {len(self.rows)} rows"

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """Draw error against time for each question, its estimate dashed.

        A matplotlib figure, or the file that it was written to. Raises InputError for an unknown format; Unsupported
        without matplotlib.
        """
        from handlcp.viz import draw_or_save, draw_path_cost  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_path_cost, self, title)

    def __str__(self) -> str:
        """A table and the summary."""
        rows = []
        for r in self.rows:
            took = f"{1e3 * r.seconds:.0f}" if r.seconds >= 0.1 else f"{1e3 * r.seconds:.3g}"
            rows.append((r.question, f"{r.accuracy:g}", f"{r.steps}", took, share(r.error), share(r.estimate)))
        heads = "question", "accuracy", "steps", "time\nms", "error", "estimate"
        table = TextTable(heads, tuple(rows), "<>>>>>")
        said = f"{self.summary[0].upper()}{self.summary[1:]}."
        return f"{table}\n\n{wrap_text(said, '')}"


@check_call()
@compile_now()
def path_cost(
    grasp: Grasp,
    wrench: Any = None,
    *,
    geometry: str | None = None,
    faces: int | str | Pyramid = "cone",
    accuracies: Sequence[float] = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5),
    repeats: int = 3,
) -> PathCost:
    """Time and error of `load_limit` along a wrench, and of `follow` up to 0.95 of that limit, over their accuracy.

    wrench, geometry, faces : as in `Grasp.load_limit`; in one posture, too, the path is taken in steps here.
    accuracies : asked of each step, from coarse to fine; errors are against a tenth of the last. repeats : of each run;
    the quickest counts. Raises InputError, also for a load that has no limit; Unsupported.
    """
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    expected = "at least two numbers that decrease"
    many = [check_number("accuracies", x, above=0.0) for x in check_sequence("accuracies", accuracies, expected)]
    if len(many) < 2 or many != sorted(set(many), reverse=True):
        raise InputError("accuracies", expected, repr(list(accuracies)))
    check_integer("repeats", repeats, 1, 1000)
    section = as_section(faces, planar=grasp.scene.kind.planar)
    spec, load = load_of(grasp.spec, wrench)
    how = "followed" if is_followed(spec, geometry) else "fixed"
    rests = np.zeros(6) if spec.mechanism is not None else spec.resting_wrench

    def limit(accuracy: float) -> _Answer:
        found = Before(spec, section, anything_else(spec), how, accuracy).limit(load)
        return np.array([found.factor]), len(found.path.factors), found.accuracy

    best = float(limit(_FINEST * many[-1])[0][0])
    if not 0.0 < best < np.inf:
        raise InputError("wrench", "a load with a limit", f"one that is held {best:g} times")

    def end(accuracy: float) -> _Answer:
        found = follow(spec, section, rests + _HELD * best * load, _ORDER, how, _STEPS, None, accuracy)
        return np.asarray(found.steps.forces[-1]), len(found.steps.states), found.accuracy

    rows = [*_rows(FOLLOW, end, many, repeats), *_rows(LIMIT, limit, many, repeats)]
    return PathCost(tuple(rows), load, best, how)


def _rows(question: str, ask: Callable[[float], _Answer], many: Sequence[float], repeats: int) -> list[PathRow]:
    """A row for each accuracy; ask : the answer with one."""
    finest, _, _ = ask(_FINEST * many[-1])
    size, found = float(abs(finest).max()), list[PathRow]()
    for accuracy in many:
        took, answer, steps, estimate = np.inf, finest, 0, 0.0
        for _ in range(repeats):
            begun = time.perf_counter()
            answer, steps, estimate = ask(accuracy)
            took = min(took, time.perf_counter() - begun)
        found.append(PathRow(question, accuracy, steps, took, float(abs(answer - finest).max()) / size, estimate))
    return found
