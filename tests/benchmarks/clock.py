"""Best times of several ways to do a thing, in turns, so that a busy moment meets all of them alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from typing import Any

__all__ = ["Task", "best_times"]

Run = Callable[[], Any]
Task = Callable[[], Run]  # makes one call ready, untimed; a call may leave things cached, so each gets its own


def best_times(tasks: dict[str, Task], rounds: int, burst: int = 3) -> dict[str, float]:
    """Best time of each [s] over `rounds` turns of `burst` calls. The collector is off meanwhile."""
    best = dict.fromkeys(tasks, float("inf"))
    clock = time.perf_counter
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
