"""NSNGRK against the paper's algorithm as printed: time to a residual of 1e-8 on Examples 3 and 5 with 16 faces.

    python -m tests.benchmarks.as_printed [seconds]

One process, one thread, everything compiled and warm. All work on natural units: as given, in metres and newtons, none
of the Kaczmarz methods gets there at all (`examples/paper/convergence.py`). `AsPrinted` takes forward differences in
each step and ends with nothing else; a run is stopped after `seconds` (60), and then only a lower bound of the ratio is
printed, with the time that the rate at its end would still ask for. Methods take turns, seed by seed, so that a busy
moment meets all of them; medians over seeds, and of the fast methods over many calls, too.
"""

from __future__ import annotations

import gc
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from rich.console import Console

import handlcp as hl
from handlcp.lcp import proposals
from handlcp.study.accuracy import AsPrinted
from handlcp.study.paper import example
from tests.benchmarks.report import plain_table
from tests.support.scripts import script

TOL, FACES, SEEDS = 1e-8, 16, range(5)
SAMPLE, CALLS = 2000, 201  # steps that tell what one costs; calls of what takes less than a millisecond


@dataclass(frozen=True)
class Result:
    """Seconds, steps, ‖Φ‖ reached and force error, a share of the largest force.

    more : seconds that a run which was stopped would still take, by the rate at its end; 0: it got there.
    """

    seconds: float
    steps: int
    residual: float
    error: float
    more: float = 0.0


def phi(problem: Any, z: np.ndarray) -> float:
    """‖Φ‖₂ at z."""
    w = problem.M @ z + problem.q
    return float(np.linalg.norm(np.where(problem.free, w, np.hypot(z, w) - z - w)))


def clock(call: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Median seconds of a call, of this thread alone, the collector off; and what it returned."""
    times, out = [], None
    gc.collect()
    gc.disable()
    for _ in range(repeats):
        start = time.thread_time()
        out = call()
        times.append(time.thread_time() - start)
    gc.enable()
    return float(np.median(times)), out


def kaczmarz_alone(make: Callable[..., Any], grasp: hl.Grasp, seed: int, budget: float) -> Result:
    """Steps until ‖Φ‖ ≤ TOL or the budget is spent."""
    problem, answer = grasp.problem(FACES), grasp.solve(FACES).forces
    scaled = problem.scaled
    make(max_iterations=SAMPLE).propose(scaled)
    step = clock(lambda: make(max_iterations=SAMPLE, tol=1e-30).propose(scaled), 5)[0] / SAMPLE
    most = max(int(budget / step), 1)
    seconds, p = clock(lambda: make(tol=TOL, max_iterations=most, seed=seed).propose(scaled), 1)
    norm, more = phi(scaled, p.z), 0.0
    if norm > TOL:
        history = make(tol=TOL, max_iterations=most, seed=seed, stride=max(1, most // 400)).propose(scaled).history
        rate = script("paper/convergence").measured_rate(history)
        more = seconds / p.iterations * float(np.log(norm / TOL)) / rate if rate > 0 else np.inf
    return Result(seconds, p.iterations, norm, off(problem.candidate(p.z).forces, answer), more)


def polished(grasp: hl.Grasp, seed: int, budget: float) -> Result:
    """NSNGRK() with its exact ending on the same complementarity problem."""
    problem, answer = grasp.problem(FACES), grasp.solve(FACES).forces
    solver = hl.NSNGRK(tol=TOL, seed=seed)
    solver.propose(problem.scaled)
    seconds, p = clock(lambda: solver.propose(problem.scaled), CALLS)
    return Result(seconds, p.iterations, phi(problem.scaled, p.z), off(problem.candidate(p.z).forces, answer))


def default(grasp: hl.Grasp, seed: int, budget: float) -> Result:
    """What `grasp.solve` runs: the same method on friction as a set."""
    problem, answer = grasp.problem(FACES), grasp.solve(FACES).forces
    contact, chain = problem.contact, hl.Auto(seed=seed)
    next(proposals(contact, chain))
    seconds, (_, p) = clock(lambda: next(proposals(contact, chain)), CALLS)
    return Result(
        seconds, p.iterations, phi(problem.scaled, problem.lift(p.z)), off(contact.candidate(p.z).forces, answer)
    )


def off(forces: np.ndarray, answer: np.ndarray) -> float:
    """Worst force error, a share of the largest force."""
    return float(abs(forces - answer).max() / abs(answer).max())


METHODS: dict[str, Callable[[hl.Grasp, int, float], Result]] = {
    "as printed": partial(kaczmarz_alone, AsPrinted),
    "analytic subgradients, O(n) a step": partial(kaczmarz_alone, partial(hl.NSNGRK, polish=False)),
    "NSNGRK()": polished,
    "NSNGRK on friction as a set (default)": default,
}


def middle(runs: list[Result]) -> Result:
    """Median time and steps, worst of everything else."""
    return Result(
        float(np.median([r.seconds for r in runs])),
        int(np.median([r.steps for r in runs])),
        max(r.residual for r in runs),
        max(r.error for r in runs),
        max(r.more for r in runs),
    )


def main(console: Console, budget: float = 60.0) -> dict[int, dict[str, Result]]:
    """Print one table an example."""
    found: dict[int, dict[str, Result]] = {}
    for number in (3, 5):
        grasp = example(number).grasp
        runs = [{name: run(grasp, seed, budget) for name, run in METHODS.items()} for seed in SEEDS]
        found[number] = {name: middle([r[name] for r in runs]) for name in METHODS}
        n = grasp.problem(FACES).n
        table = plain_table(
            f"Example {number}, {FACES} faces, {n} unknowns, to {TOL:g} in natural units; {len(SEEDS)} seeds",
            "method", "ms", "× less time", "steps", "worst ‖Φ‖", "worst force error",
        )  # fmt: skip
        first = found[number]["as printed"]
        for name, r in found[number].items():
            least = "≥ " if first.more and r is not first else ""
            table.add_row(name, f"{1e3 * r.seconds:,.3f}", f"{least}{first.seconds / r.seconds:,.0f}", f"{r.steps:,}",
                          f"{r.residual:.0e}", f"{r.error:.0e}")  # fmt: skip
        console.print(table)
        for name, r in found[number].items():
            if r.more:
                console.print(f"{name}: not there; by the rate at its end it would take {r.more:.3g} s more")
    return found


if __name__ == "__main__":
    main(Console(width=110), float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
