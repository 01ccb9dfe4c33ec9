"""Times of several ways to do a thing, in turns, so that a busy moment meets all of them alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from statistics import median
from typing import Any

__all__ = ["Task", "best_times", "median_times"]

Run = Callable[[], Any]
Task = Callable[[], Run]  # makes one call ready, untimed; a call may leave things cached, so each gets its own


def best_times(
    tasks: dict[str, Task], rounds: int, burst: int = 3, clock: Callable[[], float] = time.perf_counter
) -> dict[str, float]:
    """Best time of each [s] over `rounds` turns of `burst` calls. The collector is off meanwhile.

    clock : `time.process_time` counts what this process alone computes, on a machine that others use.
    """
    best = dict.fromkeys(tasks, float("inf"))
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            for name, task in tasks.items():
                for run in [task() for _ in range(burst)]:
                    start = clock()
                    run()
                    took = clock() - start
                    best[name] = min(best[name], took)
    finally:
        gc.enable()
    return best


def median_times(runs: dict[str, Run], rounds: int, burst: int = 10, warm: int = 20) -> dict[str, float]:
    """Median time of each call [µs] over `rounds` calls, in turns of `burst`. The collector is off meanwhile."""
    times: dict[str, list[float]] = {name: [] for name in runs}
    clock = time.perf_counter
    for run in runs.values():
        for _ in range(warm):
            run()
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds // burst):
            for name, run in runs.items():
                for _ in range(burst):
                    start = clock()
                    run()
                    times[name].append(clock() - start)
    finally:
        gc.enable()
    return {name: 1e6 * median(seconds) for name, seconds in times.items()}
