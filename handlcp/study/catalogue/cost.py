"""What each effect costs on the reference scene: unknowns, and the time of making and solving the grasp.

    ratio = T(with the effect) / T(without it),    T of state.grasp(ball, …).solve(): contacts found, posed, certified

The two are timed in turns, and the best of many times counts. Friction and the flexibility of the fingers are part of
the reference scene, and little is left of it without them. Their ratio is 1/(1 - share), with the share of the time
that `explain(measure=True)` measures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from handlcp.errors import NoSolutionFound
from handlcp.grasp.analysis.compare_without import best_times
from handlcp.grasp.analysis.explanation import Description
from handlcp.lcp.compiler.when import at_once
from handlcp.study.catalogue.effects import entries
from handlcp.study.catalogue.reference import Trial, trials

Clock = Callable[[dict[int, Callable[[], bool]]], dict[int, float]]


@dataclass(frozen=True, slots=True)
class Cost:
    """unknowns : how many more the scene has (< 0: fewer). ratio : of the times; None: every scene has the effect."""

    unknowns: int
    ratio: float | None

    @property
    def more(self) -> str:
        """Unknowns, as they are printed."""
        return f"{self.unknowns:+d}" if self.unknowns else "0"

    def __str__(self) -> str:
        return "–" if self.ratio is None else f"× {self.ratio:.1f}"


def costs(clock: Clock = best_times) -> dict[str, Cost]:
    """The cost of every effect by title, in some seconds. clock : measures runs [s]. Raises NoSolutionFound."""
    return {entry.title: cost(entry, clock) for entry in entries()}


@at_once()
def cost(entry: Description, clock: Clock = best_times) -> Cost:
    """The cost of one effect."""
    on, off = trials(entry)
    grasp = on.grasp(on.state(), on.ball())
    if on == off:
        lines = grasp.explain(on.faces, measure=True).effects
        line = next(x for x in lines if x.on and x.title == entry.title)
        return Cost(line.cost, None if line.share is None else 1.0 / (1.0 - line.share))
    less = off.grasp(off.state(), off.ball()).explain(off.faces)
    times = clock({0: _run(off), 1: _run(on)})
    return Cost(grasp.explain(on.faces).unknowns - less.unknowns, times[1] / times[0])


def _run(trial: Trial) -> Callable[[], bool]:
    """The work that is timed. It is done once here, to compile it and to show that the grasp holds."""
    state, ball = trial.state(), trial.ball()

    def run() -> bool:
        return trial.grasp(state, ball).solve(trial.faces, throw=False).held

    solution = trial.grasp(state, ball).solve(trial.faces, throw=False)
    if not solution.held:
        raise NoSolutionFound(solution.diagnosis, None, solution)
    return run
