"""What many contacts cost: power grasps of 5 to 60 contacts of a hand with 16 joints, beside those of five fingers.

    python -m tests.benchmarks.whole_hand                      times, and what becomes of 200 random grasps
    python -m tests.benchmarks.whole_hand --times --rounds 20
    python -m tests.benchmarks.whole_hand --statuses --count 100
    python -m tests.benchmarks.whole_hand --paths

Times are the best of some rounds, in turns, and ratios are of medians over the grasps.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
from rich.console import Console

import handlcp as hl
from tests.benchmarks.clock import best_times
from tests.benchmarks.report import conditions, opened, plain_table
from tests.support.power import STRONG, WEAK, PowerGrasp, power_grasp

COUNTS = (5, 10, 20, 40, 60)
FOLLOWED = (5, 20, 60)

Make = Callable[[PowerGrasp], hl.Grasp]
WAYS: dict[str, Make] = {"dense E": PowerGrasp.dense, "factored E": PowerGrasp.factored}


def times(console: Console, rounds: int, count: int) -> None:
    """Time of a held solve, by contacts, beside five."""
    rows: dict[tuple[str, int], list[float]] = {}
    for n in COUNTS:
        held = [
            g
            for k in range(20 * count)
            if (g := power_grasp(n, k, STRONG, loaded=False)).dense().solve(throw=False).held
        ]
        for g in held[:count]:
            tasks = {way: _solving(make, g) for way, make in WAYS.items()}
            for way, seconds in best_times(tasks, rounds).items():
                rows.setdefault((way, n), []).append(seconds)
    table = plain_table(
        "A held grasp, friction 0.6", "contacts", *[w for way in WAYS for w in (f"{way} [µs]", "ratio")]
    )
    for n in COUNTS:
        cells = []
        for way in WAYS:
            now, five = median(rows[way, n]), median(rows[way, COUNTS[0]])
            cells += [f"{1e6 * now:.0f}", f"{now / five:.1f}"]
        table.add_row(str(n), *cells)
    console.print(table)


def _solving(make: Make, g: PowerGrasp) -> Callable[[], Callable[[], Any]]:
    def task() -> Callable[[], Any]:
        grasp = make(g)
        return lambda: grasp.solve(throw=False).forces

    return task


def paths(console: Console) -> None:
    """Time of a loading that is followed, by contacts, beside five."""
    table, five = plain_table("A loading that is followed, friction 0.6", "contacts", "time [ms]", "ratio"), 0.0
    for n in FOLLOWED:
        best = []
        for seed in range(3):
            grasp = power_grasp(n, seed, STRONG, loaded=False).factored()
            best.append(best_times({"": lambda grasp=grasp: grasp.follow}, 2, 1)[""])  # type: ignore[misc]
        now = median(best)
        five = five or now
        table.add_row(str(n), f"{1e3 * now:.0f}", f"{now / five:.1f}")
    console.print(table)


def statuses(console: Console, count: int) -> None:
    """What becomes of random grasps of 10 to 60 contacts, half of them with weak friction."""
    rng = np.random.default_rng(0)
    found: dict[float, Counter[str]] = {WEAK: Counter(), STRONG: Counter()}
    for k in range(count):
        mu = (WEAK, STRONG)[k % 2]
        g = power_grasp(int(rng.integers(10, 61)), 1000 + k, mu)
        s = g.factored().solve(throw=False)
        found[mu][s.status.name] += 1
        if s.status.name == "UNDECIDED":
            console.print(f"  UNDECIDED: power_grasp({len(g.contacts)}, {1000 + k}, {mu})")
    names = sorted({name for c in found.values() for name in c})
    table = plain_table(f"{count} random power grasps of 10 to 60 contacts", "friction", *names)
    for mu, c in found.items():
        table.add_row(f"{mu:g}", *[str(c[name]) for name in names])
    console.print(table)
    share = sum(c["UNDECIDED"] for c in found.values()) / count
    console.print(f"UNDECIDED: {share:.1%}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", action="store_true", help="only the times")
    parser.add_argument("--paths", action="store_true", help="only loadings that are followed")
    parser.add_argument("--statuses", action="store_true", help="only what becomes of random grasps")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--grasps", type=int, default=5, help="timed grasps of each number of contacts")
    parser.add_argument("--count", type=int, default=200, help="random grasps")
    o = parser.parse_args()
    console = opened(120)
    console.print(conditions(), highlight=False)
    every = not (o.times or o.paths or o.statuses)
    if o.times or every:
        times(console, o.rounds, o.grasps)
    if o.paths or every:
        paths(console)
    if o.statuses or every:
        statuses(console, o.count)


if __name__ == "__main__":
    main()
