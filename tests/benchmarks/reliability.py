"""What `hl.reliability` costs beside solving grasps that are made already, and whether its interval covers the truth.

    python -m tests.benchmarks.reliability [--samples 10000]
    python -m tests.benchmarks.reliability --truth 1000000 [--seeds 200]

The first prints seconds, placing included, on one core and on two. The second, some minutes long, takes the truth from
so many samples of one grasp that holds about nine times in ten, and counts how many runs of 1,000 samples cover it.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import time
from typing import Any

import numpy as np
from scipy import stats

import handlcp as hl
from tests.benchmarks.report import conditions, opened, plain_table

__all__ = ["main"]

EVERYTHING = {
    "friction": 0.15, "stiffness": 0.1, "pads": 0.1, "mass": 0.2, "squeeze": 0.1, "positions": 0.001, "posture": 0.005
}  # fmt: skip
SPREADS = {"friction and mass": {"friction": 0.15, "mass": 0.2}, "everything": EVERYTHING}


def five_fingers() -> hl.HandGrasp:
    """A ball that a hand holds from above."""
    hand, ball = hl.example_hand("five_finger", joint_stiffness=6.0), hl.Sphere(0.035, (0, 0, 0.07), mass=0.3)
    return hand.at(hand.close_on(ball)).grasp(ball, friction=0.6, squeeze=0.003, gravity=(0, 0, 9.81))


def three_fingers() -> hl.HandGrasp:
    """A cube that is nearly too heavy."""
    hand, cube = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Box(0.05, (0, 0, 0.08), mass=0.3)
    return hand.at(hand.close_on(cube)).grasp(cube, friction=0.65, squeeze=0.005)


CASES = {"five fingers": five_fingers, "three fingers, some fail": three_fingers}


def timed(call: Any) -> tuple[float, float, Any]:
    """Seconds by the wall's clock and by the processor's, and what came."""
    wall, own = time.perf_counter(), time.process_time()
    found = call()
    return time.perf_counter() - wall, time.process_time() - own, found


def speed(console: Any, samples: int) -> None:
    """Seconds of whole runs, and their multiple of the same samples solved by `solve_many`, grasps made before."""
    table = plain_table(
        f"hl.reliability, {samples:,} samples, placing included [s]", "grasp", "varies", "values", "held", "1 core",
        "2 cores", "processor", "bare", "ratio",
        caption="processor: its own seconds on one core. bare: those of solve_many on the same grasps, made before. "
        "ratio: of both.",
    )  # fmt: skip
    for case, make in CASES.items():
        grasp = make()
        for name, spread in SPREADS.items():
            hl.reliability(grasp, spread, 256, workers=1)
            wall, own, found = timed(lambda g=grasp, s=spread: hl.reliability(g, s, samples, workers=1))
            two, _, _ = timed(lambda g=grasp, s=spread: hl.reliability(g, s, samples, workers=2))
            some = [found.sample(k).grasp for k in range(0, found.samples, 10)]
            _, bare, _ = timed(lambda s=some: hl.solve_many(s, workers=1, proof=False).held.sum())
            bare *= found.samples / len(some)
            table.add_row(
                case, name, str(len(found.names)), f"{100 * float(found.chance_held):.1f} %", f"{wall:.2f}",
                f"{two:.2f}", f"{own:.2f}", f"{bare:.2f}", f"{own / bare:.1f}",
            )  # fmt: skip
    console.print(table)


def coverage(console: Any, samples: int, seeds: int, kept: str | None) -> None:
    """How many of so many runs of 1,000 samples cover the truth."""
    grasp, spread = three_fingers(), {"friction": 0.15, "mass": 0.15, "stiffness": 0.1}
    truth = hl.reliability(grasp, spread, samples, seed=1_000_000, decide=5000, workers=1, resume=kept).chance_held
    runs = [hl.reliability(grasp, spread, 1000, seed=s, workers=1).chance_held for s in range(seeds)]
    covers = sum(r.low <= truth.value <= r.high for r in runs)
    width = np.mean([r.high - r.low for r in runs])
    independent = 2 * stats.norm.ppf(0.975) * np.sqrt(truth.value * (1 - truth.value) / 1024)
    console.print(f"truth from {samples:,} samples: {truth}")
    console.print(f"{covers} of {seeds} runs of 1,024 samples cover it, at 95 %")
    console.print(f"mean width {width:.4f}; of independent samples {independent:.4f}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=10_000)
    parser.add_argument("--truth", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--resume", help="A file that keeps the samples of the truth.")
    o, console = parser.parse_args(), opened(120)
    console.print(conditions(), highlight=False)
    if o.truth:
        coverage(console, o.truth, o.seeds, o.resume)
    else:
        speed(console, o.samples)


if __name__ == "__main__":
    main()
