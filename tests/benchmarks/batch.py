"""What many grasps cost: `solve_many` beside one solve each, load limits in many directions, memory of a stream.

    python -m tests.benchmarks.batch [--grasps 10000] [--updates 1000000]

A ball in the five-finger hand under random loads: 0.3 N, which every grasp holds, and 2 N, under which many do not.
`--updates` of a stream say by how many bytes the process grows with each.
"""

from __future__ import annotations

import gc
import os
import resource
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import handlcp as hl
from tests.benchmarks.measure import best_times, options, print_table

__all__ = ["main"]

FACES = 8
WEIGHT = np.array([0, 0, -0.2 * 9.81, 0, 0, 0])
ARM = np.array([1, 1, 1, 0.015, 0.015, 0.015])
POSTURES = 64


def held() -> tuple[hl.HandGrasp, np.ndarray]:
    """The grasp, and its posture."""
    hand = hl.example_hand("five_finger", joint_stiffness=5.0)
    ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
    q = hand.close_on(ball, squeeze=3e-3)
    seen = hand.at(q).grasp(ball, hl.Coulomb(0.6))
    made = hand.at(q).grasp(seen.contacts, wrench=WEIGHT, offset=seen.offset, reference=seen.reference)
    return made, q


def loaded(grasp: hl.HandGrasp, count: int, strength: float) -> list[hl.HandGrasp]:
    """The grasp under random loads of so many newtons, and newtons times 1.5 cm."""
    pulls = np.random.default_rng(0).normal(size=(count, 6)) * strength * ARM / np.sqrt(3)
    return [grasp.replace(wrench=WEIGHT + pull) for pull in pulls]


def many(grasp: hl.HandGrasp, count: int, rounds: int) -> dict[str, float]:
    """Print and return times a grasp, as multiples of one after the other by `grasp.solve`."""
    easy, hard, cores = loaded(grasp, count, 0.3), loaded(grasp, min(count, 1000), 2.0), os.cpu_count() or 1

    def batch(grasps: list[hl.HandGrasp], workers: int, proof: bool = False) -> Callable[[], Callable[[], Any]]:
        return lambda: lambda: hl.solve_many(grasps, FACES, workers=workers, proof=proof).held.sum()

    few = easy[: min(count, 300)]
    cases: dict[str, tuple[list[hl.HandGrasp], Callable[[], Callable[[], Any]]]] = {
        "one after the other": (few, lambda: lambda: [g.replace().solve(FACES).held for g in few]),
        "all hold, one core": (easy, batch(easy, 1)),
        f"all hold, {cores} cores": (easy, batch(easy, cores)),
        "many don't hold, one core": (hard, batch(hard, 1)),
        "a few of these, with proofs": (hard[:40], batch(hard[:40], 1, True)),
    }
    hl.solve_many(easy[:10], FACES)
    tasks = {name: task for name, (_, task) in cases.items()}
    best = best_times(tasks, rounds, 1, time.perf_counter)
    each = {name: best[name] / len(grasps) for name, (grasps, _) in cases.items()}
    one = each["one after the other"]
    ratios = {name: seconds / one for name, seconds in each.items()}
    rows = []
    for name, (grasps, _) in cases.items():
        share = float(np.mean(hl.solve_many(grasps, FACES, proof=False).held))
        cells = f"{len(grasps):,}", f"{100 * share:.0f} %", f"{1e6 * each[name]:.1f}", f"{ratios[name]:.2f}"
        rows.append((name, *cells))
    print_table("solve_many, five fingers", ("", "grasps", "held", "µs a grasp", "× one by one"), rows)
    return ratios


def directions(grasp: hl.HandGrasp, count: int, rounds: int) -> dict[str, float]:
    """Print and return what a direction of an envelope costs, as a multiple of a load limit of its own."""
    pull, ratios, rows = (0.3, 0.2, -1.0, 0, 0, 0), {}, []
    for faces in (FACES, "cone"):
        tasks = {
            "one limit": lambda faces=faces: lambda: grasp.load_limit(pull, geometry="fixed", faces=faces),
            "envelope": lambda faces=faces: lambda: hl.envelope(grasp, count, faces=faces, adaptive=0).factors,
        }
        for task in tasks.values():
            task()()
        best = best_times(tasks, rounds, 1)
        size = len(hl.envelope(grasp, count, faces=faces, adaptive=0).factors)
        ratios[str(faces)] = best["envelope"] / size / best["one limit"]
        cells = f"{1e3 * best['one limit']:.2f}", str(size), f"{1e3 * best['envelope'] / size:.3f}"
        rows.append((str(faces), *cells, f"{ratios[str(faces)]:.2f}"))
    print_table("Load limits", ("faces", "one ms", "directions", "ms each", "ratio"), rows)
    return ratios


def growth(grasp: hl.HandGrasp, q: np.ndarray, updates: int) -> float:
    """Print and return the bytes by which the process grows with each update of a stream, after a tenth of them."""
    turns = np.linspace(0, 2 * np.pi, POSTURES, endpoint=False)
    stream = hl.GraspStream(grasp)

    def run(times: int) -> int:
        for k in range(times):
            turn = turns[k % POSTURES]
            stream.update(q + 5e-3 * np.sin(turn), wrench=WEIGHT + 0.2 * np.cos(turn) * ARM).torques  # noqa: B018
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)

    before = run(updates // 10)
    each = (run(updates) - before) / updates
    print_table("Memory of a stream", ("updates", "bytes each"), [(f"{updates:,}", f"{each:.3f}")])
    return each


def main(arguments: Sequence[str] | None = None) -> dict[str, Any]:
    """Measure, print, and return the ratios."""
    parser = options(__doc__)
    parser.add_argument("--grasps", type=int, default=10_000)
    parser.add_argument("--directions", type=int, default=1000)
    parser.add_argument("--updates", type=int, default=1_000_000, help="of the stream, for its memory")
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args(arguments)
    grasp, q = held()
    return {
        "many": many(grasp, asked.grasps, asked.rounds),
        "directions": directions(grasp, asked.directions, asked.rounds),
        "growth": growth(grasp, q, asked.updates),
    }


if __name__ == "__main__":
    main()
