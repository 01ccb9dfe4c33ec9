"""Batches on one core: what a grasp costs beside a bare pivoting kernel, and what grasps that don't hold add.

    python -m tests.benchmarks.batches FOLDER [--families ring sphere] [--fingers 3 5] [--count 60] [--proofs 10]

FOLDER holds the peers' scenes (`tests.benchmarks.corpus`). Everything is on one thread, best of some rounds in turns,
and timed by the processor's clock, so that a busy machine counts for little. Needs `pip install '.[bench]'`.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from quantecon.optimize import lcp_lemke

import handlcp as hl
from tests.benchmarks.clock import Task, best_times
from tests.benchmarks.corpus import PeersFolder, as_case, family_options
from tests.benchmarks.report import conditions, opened, plain_table

__all__ = ["main"]

FACES = 8
ALIKE = 256  # copies of a scene that make a batch
LIMITS = {"solve_many / QuantEcon": 1.5, "half don't hold, proof=False": 5.0, "half don't hold": 50.0}


def beside_lemke(folder: PeersFolder, scene: Any, rounds: int) -> tuple[float, float] | None:
    """(µs a grasp in a batch of this scene, µs of the bare kernel on its standard form); None unless both solve it."""
    problem = folder.problems.mixed(scene, FACES)
    standard = folder.problems.standard(problem)
    if standard is None:
        return None
    M, q = np.ascontiguousarray(standard.M), standard.q
    forces, twist = problem.to_si(standard.X @ lcp_lemke(M, q, max_iter=10000).z + standard.x0)
    make = as_case(scene, FACES).grasp
    solution = make().solve(FACES, throw=False)
    both = solution.held and folder.residual_of(scene, solution, FACES) <= folder.problems.TOL
    if not both or not folder.residual(scene, forces, twist, FACES) <= folder.problems.TOL:
        return None
    tasks: dict[str, Task] = {
        "many": lambda: batch([make() for _ in range(ALIKE)]),
        "Lemke": lambda: lambda: [lcp_lemke(M, q, max_iter=10000) for _ in range(ALIKE)],
    }
    best = best_times(tasks, rounds, burst=1, clock=time.process_time)
    return 1e6 * best["many"] / ALIKE, 1e6 * best["Lemke"] / ALIKE


def batch(grasps: list[hl.Grasp], proof: bool = True) -> Callable[[], Any]:
    """The call that is timed: solved, and the forces read."""
    return lambda: hl.solve_many(grasps, FACES, workers=1, proof=proof).forces


def halves(scenes: list[Any], count: int, proofs: int, rounds: int) -> dict[str, float]:
    """Times a grasp of batches half of which doesn't hold, as multiples of one that holds throughout."""
    makes = [as_case(s, FACES).grasp for s in scenes]
    held = hl.solve_many([make() for make in makes], FACES, workers=1, proof=False).held
    good, bad = ([m for m, h in zip(makes, held, strict=True) if h is wanted] for wanted in (np.True_, np.False_))
    if not good or not bad:
        return {}

    def some(of: list[Callable[[], hl.Grasp]], n: int) -> list[hl.Grasp]:
        return [of[k % len(of)]() for k in range(n)]

    best = best_times({
        "all": lambda: batch(some(good, count)),
        "half don't hold, proof=False": lambda: batch(some(good, count // 2) + some(bad, count // 2), proof=False),
    }, rounds, burst=1, clock=time.process_time)  # fmt: skip
    each = best["all"] / count
    few = min(proofs, len(bad))
    proven = best_times({"half": lambda: batch(some(good, few) + some(bad, few))}, 1, burst=1, clock=time.process_time)[
        "half"
    ]
    return {
        "half don't hold, proof=False": best["half don't hold, proof=False"] / count / each,
        "half don't hold": proven / (2 * few) / each,
    }


def main() -> None:
    """Measure, print, write."""
    parser = family_options(__doc__)
    parser.add_argument("--proofs", type=int, default=10, help="grasps that don't hold of a batch with proofs at most")
    o = parser.parse_args()
    console, folder = opened(120), PeersFolder(o.folder)
    console.print(conditions(), highlight=False)
    table = plain_table(
        f"solve_many on one core, {FACES} faces: medians over scenes", "family", "scenes", "µs a grasp", "QuantEcon µs",
        *LIMITS, caption="Batches half of which doesn't hold: multiples of the time of one that holds throughout.",
    )  # fmt: skip
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as directory:
        for family in o.families:
            for fingers in o.fingers:
                scenes = folder.family(Path(directory), family, fingers, o.count)
                pairs = np.array([p for s in scenes if (p := beside_lemke(folder, s, o.rounds)) is not None])
                ours, theirs = np.median(pairs, axis=0)
                ratios = {"solve_many / QuantEcon": ours / theirs, **halves(scenes, 2 * o.count, o.proofs, o.rounds)}
                found[f"{family}, {fingers} fingers"] = {"us": [ours, theirs], **ratios}
                cells = [f"{ratios[name]:.2f}" if name in ratios else "–" for name in LIMITS]
                table.add_row(f"{family}, {fingers}", str(len(pairs)), f"{ours:.1f}", f"{theirs:.1f}", *cells)
    middle = {n: float(np.median([f[n] for f in found.values() if n in f] or [np.nan])) for n in LIMITS}
    table.add_row("median", "", "", "", *(f"{middle[name]:.2f}" for name in LIMITS))
    table.add_row("at most", "", "", "", *(f"{limit:g}" for limit in LIMITS.values()))
    console.print(table)
    if o.json:
        o.json.write_text(json.dumps({"conditions": conditions(), "families": found, "medians": middle}, indent=1))


if __name__ == "__main__":
    main()
