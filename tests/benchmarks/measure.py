"""Clocks and tables of the benchmarks: several ways to do a thing in turns, so that a busy moment meets all of them."""

from __future__ import annotations

import argparse
import gc
import os
import platform
import subprocess
import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

import handlcp as hl

__all__ = ["best_times", "median_times", "options", "print_ratios", "print_table"]

Run = Callable[[], Any]
Task = Callable[[], Run]  # makes one call ready, untimed: a call may leave things cached, so each gets its own


def best_times(
    tasks: dict[str, Task], rounds: int, burst: int = 3, clock: Callable[[], float] = time.process_time
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
                    best[name] = min(best[name], clock() - start)
    finally:
        gc.enable()
    return best


def median_times(runs: dict[str, Run], rounds: int, burst: int = 10, warm: int = 20) -> dict[str, float]:
    """Median time of each call [s] over `rounds` calls, in turns of `burst`. The collector is off meanwhile."""
    times: dict[str, list[float]] = {name: [] for name in runs}
    clock = time.perf_counter
    for run in runs.values():
        for _ in range(warm):
            run()
    gc.collect()
    gc.disable()
    try:
        for _ in range(max(1, rounds // burst)):
            for name, run in runs.items():
                for _ in range(burst):
                    start = clock()
                    run()
                    times[name].append(clock() - start)
    finally:
        gc.enable()
    return {name: median(seconds) for name, seconds in times.items()}


def options(words: str | None) -> argparse.ArgumentParser:
    """A parser of the command line, with the docstring of the script as its help."""
    return argparse.ArgumentParser(description=words, formatter_class=argparse.RawDescriptionHelpFormatter)


def print_table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table, the first column to the left and numbers to the right, and below it what it holds for."""
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if k else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    console = Console()
    console = console if console.is_terminal else Console(width=130)
    console.print(table)
    console.print(_conditions(), highlight=False)


def print_ratios(title: str, times: dict[str, float], unit: str | None = None) -> dict[str, float]:
    """Print times, each beside its multiple of the one called `unit` (the first), and return the multiples."""
    one = times[unit or next(iter(times))]
    ratios = {name: seconds / one for name, seconds in times.items()}
    rows = [(name, f"{1e6 * seconds:,.1f}", f"{ratios[name]:.2f}") for name, seconds in times.items()]
    print_table(title, ("", "µs", f"× {unit or 'the first'}"), rows)
    return ratios


def _conditions() -> str:
    """What the numbers hold for."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    where = f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"
    return f"handlcp {hl.__version__} {commit.stdout.strip()}, Python {platform.python_version()}, {where}"
