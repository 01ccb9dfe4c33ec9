"""What each question about a load costs, as multiples of one `solve` of README's cube, in one run.

    python -m tests.benchmarks.questions [--directions 100] [--rounds 3]

A check of the cube that is held; load limits along directions all around; a payload; envelopes, followed and in one
posture; a power grasp of thirty contacts beside a pinch; load limits in two threads of one process beside one. Seconds
of the processor, but for the threads. The column "at most" is what the engine of paths is to reach.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from statistics import median
from typing import Any

import numpy as np

import handlcp as hl
from tests.benchmarks.measure import best_times, options, print_table
from tests.limits.pinches import bare_pinch
from tests.support.power import STRONG, power_grasp

__all__ = ["main"]

MOST = {
    "check, held": 60.0, "load_limit, median": 160.0, "load_limit, worst": 800.0, "payload of six": 1200.0,
    "envelope, followed": 60_000.0, "envelope, one posture": 12_000.0,
}  # fmt: skip
CONTACTS, ALL_AROUND = 30, 362
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)


def make_cube() -> Callable[[], hl.HandGrasp]:
    """README's cube, a new grasp in every call: none keeps what another one was asked."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    state = hand.at(hand.close_on(CUBE))
    return lambda: state.grasp(CUBE, friction=0.8, squeeze=0.005)


def timed(run: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Seconds of one call."""
    begun = clock()
    run()
    return clock() - begun


def directions(count: int) -> np.ndarray:
    """(count, 6) forces of 1 N, spread evenly: a Fibonacci spiral."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    around = np.sqrt(1.0 - z**2)
    return np.column_stack([around * np.cos(turn), around * np.sin(turn), z, np.zeros((count, 3))])


def limits_of(make: Callable[[], hl.Grasp], ways: np.ndarray) -> list[float]:
    """Seconds of each load limit."""
    return [timed(lambda way=way: make().load_limit(way).factor) for way in ways]


class _Times(dict[str, float]):
    """Seconds by name; what comes is printed at once, since all of it takes minutes."""

    def __ior__(self, more: Any) -> Any:
        for name, seconds in more.items():
            print(f"{name}: {1e3 * seconds:,.3f} ms", flush=True)
        return super().__ior__(more)


def questions(count: int, rounds: int) -> dict[str, float]:
    """Print and return what each question costs, as multiples of a solve."""
    make, ways = make_cube(), directions(count)
    assert make().solve().held
    assert make().check().ok
    make().load_limit(ways[0])

    def task(ask: Callable[[hl.HandGrasp], object]) -> Callable[[], Callable[[], object]]:
        def ready() -> Callable[[], object]:
            grasp = make()
            return lambda: ask(grasp)

        return ready

    times = _Times()
    times |= best_times({"solve": task(lambda grasp: grasp.solve())}, 10, 10)
    times |= best_times({"check, held": task(lambda grasp: grasp.check().word)}, 3 * rounds, 3)
    limits = np.min([limits_of(make, ways) for _ in range(rounds)], axis=0)
    times |= {"load_limit, median": median(limits), "load_limit, worst": float(max(limits))}
    times |= best_times({"payload of six": task(lambda grasp: grasp.payload().mass)}, rounds, 1)
    for name, geometry in (("envelope, followed", "followed"), ("envelope, one posture", "fixed")):
        ask = task(lambda grasp, how=geometry: hl.envelope(grasp, ALL_AROUND, geometry=how).factors)
        times |= best_times({name: ask}, 1, 1)
    ratios = {name: seconds / times["solve"] for name, seconds in times.items()}
    rows = [
        (name, f"{1e3 * seconds:,.3f}", f"{ratios[name]:,.0f}", f"{MOST[name]:,.0f}" if name in MOST else "–")
        for name, seconds in times.items()
    ]
    print_table("README's cube", ("", "ms", "× solve", "at most"), rows)
    return ratios


def contacts(rounds: int) -> dict[str, float]:
    """Print and return what thirty contacts cost as multiples of two, question by question."""
    drawn = power_grasp(CONTACTS, 0, STRONG, loaded=False)
    many, two = drawn.dense(), bare_pinch(0.6)
    load = np.array((0, 0, -1.0, 0, 0, 0))
    asks = {
        "follow": lambda grasp: grasp.follow(load).held,
        "check": lambda grasp: grasp.replace(wrench=load).check().word,
        "load_limit": lambda grasp: grasp.load_limit(load).factor,
    }
    ratios, rows = {}, []
    for name, ask in asks.items():
        tasks = {k: lambda g=g, ask=ask: lambda: ask(g.replace()) for k, g in {"many": many, "two": two}.items()}
        best = best_times(tasks, rounds + 1, 1)
        ratios[name] = best["many"] / best["two"]
        rows.append((name, f"{1e3 * best['two']:.3f}", f"{1e3 * best['many']:.3f}", f"{ratios[name]:.1f}", "5"))
    print_table("A power grasp of 30 contacts beside a pinch", ("", "pinch ms", "power ms", "ratio", "at most"), rows)
    return ratios


def threads(count: int) -> float:
    """Print and return how much sooner two threads are through with load limits than one, by the clock."""
    make, ways = make_cube(), directions(count)
    halves = ways[::2], ways[1::2]

    def both() -> None:
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda half: limits_of(make, half), halves))

    alone = timed(lambda: [limits_of(make, half) for half in halves], time.perf_counter)
    beside = timed(both, time.perf_counter)
    rows = [(f"{count} load limits", f"{alone:.2f}", f"{beside:.2f}", f"{alone / beside:.2f}", "1.8")]
    print_table("Threads of one process", ("", "one s", "two s", "ratio", "at least"), rows)
    return alone / beside


def main(arguments: Sequence[str] | None = None) -> dict[str, dict[str, float]]:
    """Measure, print, and return the ratios of each table."""
    parser = options(__doc__)
    parser.add_argument("--directions", type=int, default=100, help="of load limits")
    parser.add_argument("--rounds", type=int, default=3, help="of which the best counts")
    asked = parser.parse_args(arguments)
    return {
        "questions": questions(asked.directions, asked.rounds), "contacts": contacts(asked.rounds),
        "threads": {"two beside one": threads(asked.directions)},
    }  # fmt: skip


if __name__ == "__main__":
    main()
