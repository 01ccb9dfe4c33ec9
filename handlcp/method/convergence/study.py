"""Runs of one problem: natural units against others, greedy against uniform sampling, seed beside seed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.errors import InputError
from handlcp.grasp import Grasp, Pyramid
from handlcp.lcp import LCP, solve_lcp
from handlcp.lcp.compiler.when import at_once
from handlcp.method.convergence.runs import Run, Sampling, follow, watch
from handlcp.method.nsngrk import RES, SEEDS, STEPS, UnitsOf
from handlcp.record import Record, columns_of, data_frame
from handlcp.words import distinct

_KINDS: tuple[tuple[UnitsOf, Sampling], ...] = (
    ("natural", "greedy"),
    ("natural", "uniform"),
    ("equilibrated", "greedy"),
    ("given", "greedy"),
)


@dataclass(frozen=True, slots=True)
class Convergence(Record):
    """NSNGRK's runs on one problem, none of them ended by Newton's method; `select` finds those of a kind.

    names : (p,) of the recorded values: fingers, or "z[0]", "z[1]", … quantity : "normal force [N]", or "z".
    answer : (p,) the certified values.
    stop : the stop rule on ‖Φ‖ that runs in given units are judged by, the paper's 1e-5.
    """

    names: tuple[str, ...]
    quantity: str
    answer: Array
    stop: float
    runs: tuple[Run, ...]

    def select(self, units: UnitsOf = "natural", sampling: Sampling = "greedy") -> tuple[Run, ...]:
        """The runs of one kind, seed by seed. Raises InputError for a kind that was not run."""
        found = tuple(r for r in self.runs if (r.units, r.sampling) == (units, sampling))
        if not found:
            kinds = " or ".join(sorted({f"{r.units}, {r.sampling}" for r in self.runs}))
            raise InputError("units, sampling", kinds, f"{units}, {sampling}")
        return found

    def rate(self, units: UnitsOf = "natural", sampling: Sampling = "greedy") -> float:
        """Median measured rate: the decrease of ln ‖Φ‖ per step."""
        return float(np.median([r.rate for r in self.select(units, sampling)]))

    def bound(self, units: UnitsOf = "natural", sampling: Sampling = "greedy") -> float:
        """Median of the rates that conditioning guarantees, per step; see `rates`."""
        return float(np.median([r.bound for r in self.select(units, sampling)]))

    @property
    def gain(self) -> float:
        """How many uniform steps a greedy one is worth, in natural units."""
        return self.rate() / self.rate(sampling="uniform")

    @property
    def disputed(self) -> int:
        """Index of the value that seeds disagree on most at the stop rule in given units, among those not almost zero.

        The first of those that differ by less than a thousandth, such as fingers that mirror each other.
        """
        values = np.array([r.stopped for r in self.select("given")])
        size = abs(self.answer)
        share = np.ptp(values, axis=0) / np.where(size > 0.01 * size.max(), size, np.inf)
        return int(np.argmax(share >= 0.999 * share.max()))

    def spread(self, units: UnitsOf) -> float:
        """How far seeds disagree on it, as a share of the answer: at the stop rule in given units, else at the end."""
        i = self.disputed
        values = [r.stopped[i] if units == "given" else r.values[-1, i] for r in self.select(units)]
        return float(np.ptp(values) / abs(self.answer[i]))

    def to_frame(self) -> Any:
        """A pandas table with a row for each look at each run: "units", "sampling", "seed", "step", and the recorded
        values by their names. Raises Unsupported without pandas.
        """
        looks = [r for r in self.runs for _ in r.looks]
        values = zip(distinct(self.names), np.concatenate([r.values for r in self.runs]).T, strict=True)
        steps = {"step": np.concatenate([r.looks for r in self.runs])} | dict(values)
        return data_frame(columns_of(looks, "units", "sampling", "seed") | steps)

    def error(self, run: Run) -> Array:
        """(m,) worst error at each of the run's looks, as a share of the largest value."""
        return np.asarray(abs(run.values - self.answer).max(1) / abs(self.answer).max())


@at_once()
def convergence(
    problem: Grasp | LCP,
    faces: int | Pyramid = 8,
    *,
    seeds: Iterable[int] = SEEDS,
    tol: float = 1e-9,
    max_iterations: int = 200_000,
    stop: float = RES,
) -> Convergence:
    """Run NSNGRK on a grasp, or on any LCP, in several units, with both samplings and with each of `seeds`.

    faces : of the friction pyramids, for a grasp. tol : of every run, ‖Φ‖₂ in its own units. max_iterations : of runs
        in natural units; the others, which mostly make no progress, get the paper's 20 000 at most.
    stop : a rule ‖Φ‖₂ ≤ stop, such as the paper's; what it does to runs in given units is recorded.

    Raises InputError for a problem that is neither, for no seeds and for settings that are not as described;
    NoSolutionFound when there is no certified answer to compare with.
    """
    if not isinstance(problem, (Grasp, LCP)):
        raise InputError("problem", "a Grasp, or an LCP", type(problem).__name__)
    lcp = problem.problem(faces) if isinstance(problem, Grasp) else problem
    if not isinstance(lcp, LCP):
        raise InputError("faces", "an integer ≥ 3, or a Pyramid: the cone makes no plain LCP", repr(faces))
    try:
        chosen = [integer("seeds", seed, 0) for seed in seeds]
    except TypeError:
        raise InputError("seeds", "integers ≥ 0", repr(seeds)) from None
    if not chosen:
        raise InputError("seeds", "at least one", "none")
    limit, most = number("tol", tol, above=0.0), integer("max_iterations", max_iterations, 1)
    rule = number("stop", stop, above=0.0)
    quantity, names, read = watch(problem, lcp)
    answer = read(solve_lcp(lcp).z / lcp.scaled.units.z)
    if not answer.any():
        raise InputError("problem", "one whose answer isn't zero, where every run starts", "one whose answer is zero")
    runs = tuple(
        follow(lcp, read, units, sampling, seed, limit, most if units == "natural" else min(most, STEPS), rule)
        for units, sampling in _KINDS
        for seed in chosen
    )
    return Convergence(names, quantity, answer, rule, runs)
