"""What a grasp costs among many: `solve_many` on one core and on all, from a hundred to a hundred thousand."""

from __future__ import annotations

import gc
import os
import time
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
from rich.console import Console

import handlcp as hl
from tests.benchmarks.real_time import Walk
from tests.benchmarks.report import plain_table
from tests.support.grasp import arrays

__all__ = ["measure", "sweep"]

COUNTS = (100, 1_000, 10_000, 100_000)


def sweep(count: int, strength: float, seed: int = 0) -> list[hl.Grasp]:
    """The five-finger hand and its ball under random loads of so many newtons (and newtons times 1.5 cm)."""
    rng, grasp = np.random.default_rng(seed), Walk().grasp(0)
    load = np.array([*arrays(grasp).force, 0, 0, 0])
    pulls = rng.normal(size=(count, 6)) * strength * np.array([1, 1, 1, 0.015, 0.015, 0.015]) / np.sqrt(3)
    return [grasp.replace(wrench=load + pull) for pull in pulls]


def seconds(grasps: list[hl.Grasp], workers: int, rounds: int) -> float:
    """Best time of all of them, without proofs."""
    best = np.inf
    for _ in range(rounds):
        gc.collect()
        start = time.perf_counter()
        hl.solve_many(grasps, workers=workers, proof=False).held.sum()
        best = min(best, time.perf_counter() - start)
    return best


def measure(console: Console, most: int = 100_000) -> dict[str, Any]:
    """Print and return µs a grasp by (count, workers), and the same where a part of the grasps is hard."""
    cores = os.cpu_count() or 1
    easy = sweep(most, 0.3)
    hl.solve_many(easy[:10], workers=1)
    out: dict[str, Any] = {"cores": cores}
    table = plain_table(
        f"solve_many: five fingers, 8 faces, µs a grasp, on 1 and on {cores} cores", "grasps", "held", "1 core",
        f"{cores} cores", "× less", caption="Loads of 0.3 N, which the first stage answers; then of 2 N, many of which "
        "cannot be held, without proofs that nothing holds them: those go to processes.",
    )  # fmt: skip
    cases = [(f"{m:,}", easy[:m], 20 if m < 1_000 else 3) for m in COUNTS if m <= most]
    cases.append(("1,000 hard", sweep(1_000, 2.0), 1))
    for name, grasps, rounds in cases:
        held = hl.solve_many(grasps, proof=False).held.mean()
        us = [1e6 * seconds(grasps, w, rounds) / len(grasps) for w in (1, cores)]
        out[name] = us
        table.add_row(name, f"{100 * held:.0f} %", *(f"{x:.1f}" for x in us), f"{us[0] / us[1]:.2f}")
    one = easy[:300]
    start = time.perf_counter()
    for g in one:
        g.solve()
    out["alone"] = 1e6 * (time.perf_counter() - start) / len(one)
    console.print(table)
    _print_reading(console, easy[: min(most, 10_000)], out)
    console.print(f"One after the other by grasp.solve(): {out['alone']:.1f} µs a grasp")
    return out


def _print_reading(console: Console, grasps: list[hl.Grasp], out: dict[str, Any]) -> None:
    """What a look at the answers costs: µs and bytes a grasp."""
    gc.collect()
    tracemalloc.start()
    solutions = hl.solve_many(grasps, workers=1)
    kept = tracemalloc.get_traced_memory()[0] / len(grasps)
    tracemalloc.stop()
    looks: dict[str, Callable[[], Any]] = {
        "torques, the first of the arrays": lambda: solutions.torques,
        "forces": lambda: solutions.forces,
        "to_dict()": solutions.to_dict,
        "each solution": lambda: [s.torques for s in solutions],
    }
    table = plain_table(f"Answers of {len(grasps):,} grasps, {kept:.0f} bytes each", "looked at in turn", "µs a grasp")
    for name, look in looks.items():
        start = time.perf_counter()
        look()
        out[f"look: {name}"] = us = 1e6 * (time.perf_counter() - start) / len(grasps)
        table.add_row(name, f"{us:.1f}")
    out["bytes"] = kept
    console.print(table)
