"""What motors behind gears cost a grasp of five fingers: one solve and its table of torques, a verdict, and a loading
that is followed.

`python -m tests.benchmarks.geared`: with and without motors in turns, one process, compiled code warm, a new load in
every call. A solve may take half as long again. Every second line compares two hands that are the same, which says what
of a ratio is noise.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import handlcp as hl
from tests.benchmarks.clock import Run, Task, best_times

MOST = 1.5  # times a solve without
GEARED = hl.Motor(0.005, 0.02, holding=3.0, friction=0.05, reduction=100.0, efficiency=0.7, thermal_time=20.0)
CALLS: dict[str, Callable[[Any], Any]] = {
    "solve": lambda grasp: grasp.solve(),
    "its table": lambda grasp: str(grasp.solve().torque_check),
    "check": lambda grasp: str(grasp.check()),
    "follow": lambda grasp: grasp.follow(),
}


def grasp_of(**hand: Any) -> hl.HandGrasp:
    """A ball in five fingers."""
    ball = hl.Sphere(0.03, (0, 0, 0.09), mass=0.2)
    made = hl.example_hand("five_finger", joint_stiffness=6.0, pad_flexibility=1e-4, **hand)
    return made.at(made.close_on(ball)).grasp(ball, friction=0.8, squeeze=0.004)


def task(grasp: hl.HandGrasp, call: Callable[[Any], Any]) -> Task:
    """A call of the grasp under another load every time, so that no answer is known; the same loads for all."""
    pulls, numbers = (
        np.random.default_rng(0).uniform(-0.5, 0.5, (64, 6)) * [1, 1, 1, 0.02, 0.02, 0.02],
        itertools.count(),
    )

    def ready() -> Run:
        loaded = grasp.replace(load=pulls[next(numbers) % len(pulls)])
        return lambda: call(loaded)

    return ready


def main() -> int:
    """Print times and ratios; 1 where a solve takes too long."""
    plain, ratio = grasp_of(), dict[str, float]()
    for name, call in CALLS.items():
        rounds, burst = (3, 3) if name in ("check", "follow") else (12, 20)
        for what, other in (("geared", grasp_of(motors=GEARED)), ("the same", grasp_of())):
            tasks = {"with": task(other, call), "without": task(plain, call)}
            best = best_times(tasks, rounds, burst, time.process_time)
            ratio[f"{name}, {what}"] = best["with"] / best["without"]
            print(f"{name:11s}{what:10s}{1e3 * best['with']:9.3f} ms, {best['with'] / best['without']:.2f} times "
                  f"{1e3 * best['without']:.3f} ms")  # fmt: skip
    return int(ratio["solve, geared"] > MOST)


if __name__ == "__main__":
    raise SystemExit(main())
