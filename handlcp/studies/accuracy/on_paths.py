"""`path_cost`: time and error of `follow` and `load_limit` over the number of their steps."""

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
from handlcp.grasp.limits.followed import followed_limit, sliding as sliding_to_limit
from handlcp.grasp.limits.load_limit import is_followed, load_of
from handlcp.grasp.path.follow import follow, sliding
from handlcp.grasp.path.state import Stage
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.record import Record
from handlcp.refinement import ERROR_SAFETY, MIN_STEP_RATIO
from handlcp.studies.accuracy.methods import share
from handlcp.words import TextTable, wrap_text

FOLLOW, LIMIT = "follow", "load_limit"
_HELD = 0.7  # of the load limit: what `follow` is asked for
_FINEST = 4  # times the most steps: what errors are measured against
_ANY = (np.inf, np.inf)
_STEPS = 8  # of a stage, as many as `check` takes
_ORDER = ("squeeze", Stage("weight", weight=1.0), "load")


_Answer = tuple[Array, int, int]  # what was found, in how many steps, and in how many of these something slides


@dataclass(frozen=True, slots=True)
class PathRow(Record):
    """One question with one number of steps. question : "follow", the forces at the end of a held load; or
    "load_limit", the factor. times : as many steps as usual were asked for; steps : that were taken, which events and
    sharp bends make more. seconds : the quickest of several runs. error : relative, against the finest steps.
    estimate : what `accuracy=` takes for it; NaN: none.
    """

    entries = ("question", "times_as_many = times", "steps", "seconds", "error", "estimate")

    question: str
    times: float
    steps: int
    seconds: float
    error: float
    estimate: float


@check_method_calls
@dataclass(frozen=True, eq=False)
class PathCost(Record):
    """What accuracy costs on a path of a grasp; made by `path_cost`.

    rows : every question with every number of steps. load (6,) : the load whose limit was asked for [N, N·m]. factor :
        its load limit, with the finest steps. geometry : "fixed" or "followed".
    """

    entries = ("load_N_Nm (6,)", "factor", "geometry", "rows")

    rows: tuple[PathRow, ...]
    load: Array
    factor: float
    geometry: str

    def of(self, question: str) -> tuple[PathRow, ...]:
        """The rows of one question, the fewest steps first."""
        return tuple([r for r in self.rows if r.question == question])

    @property
    def summary(self) -> str:
        """One sentence about the order of convergence, and how often the estimate is too small."""
        orders = []
        for question in (FOLLOW, LIMIT):
            rows = [r for r in self.of(question) if r.error > 0.0]
            if len({r.steps for r in rows}) > 1:
                slope = np.polyfit(np.log([r.steps for r in rows]), np.log([r.error for r in rows]), 1)[0]
                orders.append(f"{2.0 ** -float(slope):.2g} ({question})")
        known = [r for r in self.rows if np.isfinite(r.estimate)]
        low = sum([r.error > r.estimate for r in known])
        fall = f"twice the steps divide the error by {' and '.join(orders)}; " if orders else ""
        return f"{fall}the estimate is below the true error in {low} of {len(known)} rows"

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
            estimate = share(r.estimate) if np.isfinite(r.estimate) else "–"
            rows.append((r.question, f"× {r.times:g}", f"{r.steps}", took, share(r.error), estimate))
        heads = "question", "asked", "steps", "time\nms", "error", "estimate"
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
    times: Sequence[float] = (0.5, 1, 2, 4, 8, 16),
    repeats: int = 3,
) -> PathCost:
    """Time and error of `load_limit` along a wrench, and of `follow` up to 0.7 of that limit, over the number of steps.

    wrench, geometry, faces : as in `Grasp.load_limit`; in one posture, too, the path is taken in steps here. times :
    as many steps as usual, increasing; errors are against four times the most of them. repeats : of each run; the
    quickest counts. Raises InputError, also for a load that has no limit; Unsupported.
    """
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    many = [check_number("times", x, above=0.0) for x in check_sequence("times", times, "numbers that increase")]
    if len(many) < 2 or many != sorted(set(many)):
        raise InputError("times", "at least two numbers that increase", repr(list(times)))
    check_integer("repeats", repeats, 1, 1000)
    section = as_section(faces, planar=grasp.scene.kind.planar)
    spec, load = load_of(grasp.spec, wrench)
    how = "followed" if is_followed(spec, geometry) else "fixed"
    rests = np.zeros(6) if spec.mechanism is not None else spec.resting_wrench

    def limit(finer: float) -> _Answer:
        found = followed_limit(spec, section, load, _ANY, how, finer)
        return np.array([found.factor]), len(found.path.factors), sliding_to_limit(found)

    best = float(limit(_FINEST * many[-1])[0][0])
    if not 0.0 < best < np.inf:
        raise InputError("wrench", "a load with a limit", f"one that is held {best:g} times")

    def end(finer: float) -> _Answer:
        count = max(int(np.ceil(_STEPS * finer)), 1)
        found = follow(spec, section, rests + _HELD * best * load, _ORDER, how, count, None)
        return np.asarray(found.steps.forces[-1]), len(found.steps.states), sliding(found)

    rows = [*_rows(FOLLOW, end, many, repeats), *_rows(LIMIT, limit, many, repeats)]
    return PathCost(tuple(rows), load, best, how)


def _rows(question: str, ask: Callable[[float], _Answer], many: Sequence[float], repeats: int) -> list[PathRow]:
    """A row for each number of steps; ask : the answer with so many times as many."""
    finest, _, _ = ask(_FINEST * many[-1])
    size, known, found = float(abs(finest).max()), [ask(0.5 * many[0])], list[PathRow]()
    for finer in many:
        took, answer, steps, slid = np.inf, finest, 0, 0
        for _ in range(repeats):
            begun = time.perf_counter()
            answer, steps, slid = ask(finer)
            took = min(took, time.perf_counter() - begun)
        coarser = [a for a, _, few in known if slid >= MIN_STEP_RATIO * few]
        estimate = ERROR_SAFETY * float(abs(answer - coarser[-1]).max()) / size if coarser else np.nan
        found.append(PathRow(question, finer, steps, took, float(abs(answer - finest).max()) / size, estimate))
        known.append((answer, steps, slid))
    return found
