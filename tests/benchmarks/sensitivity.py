"""What the derivatives of an answer cost beside its solve, in one run: processor time, the best of several rounds."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rich.console import Console

from tests.benchmarks.real_time import Walk
from tests.benchmarks.report import plain_table

__all__ = ["measure"]

PARAMETERS = ("wrench", "squeeze", "stiffness", "pads", "friction", "positions")
READ = ("forces", "torques", "slip", "gap", "object_displacement", "friction_margin")


def measure(console: Console, rounds: int = 10) -> dict[str, float]:
    """Print and return the microseconds of a solve, of a solve whose arrays are read, and of derivatives of the forces
    by six parameters, of a ball in five fingers, of which some slide.
    """
    walk = Walk(3.0)  # run with HANDLCP_KERNELS=compiled: interpreted kernels would be measured otherwise
    grasps = [g for g in map(walk.grasp, range(64)) if g.solve(throw=False).held]
    solutions = [g.solve() for g in grasps]

    def solve(k: int) -> Any:
        return grasps[k].solve()

    def read(k: int) -> Any:
        s = grasps[k].solve()
        return [getattr(s, name) for name in READ]

    def derive(k: int) -> Any:
        found = solutions[k].sensitivity()
        return [found.of("forces", name) for name in PARAMETERS]

    tasks: dict[str, Callable[[int], Any]] = {
        "a solve": solve, "a solve, its arrays read": read, "forces by six parameters": derive,
    }  # fmt: skip
    best = dict.fromkeys(tasks, float("inf"))
    for _ in range(rounds):
        for name, task in tasks.items():
            begun = time.process_time()
            for k in range(len(grasps)):
                task(k)
            best[name] = min(best[name], (time.process_time() - begun) / len(grasps) * 1e6)
    table = plain_table("derivatives beside a solve", "", "µs", "beside a solve, read")
    for name, value in best.items():
        table.add_row(name, f"{value:.0f}", f"{value / best['a solve, its arrays read']:.2f}")
    console.print(table)
    return best


if __name__ == "__main__":
    measure(Console())
