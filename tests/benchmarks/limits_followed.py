"""What a load limit costs with the geometry followed: milliseconds, steps and looks a direction, beside one solve.

    python -m tests.benchmarks.limits_followed [--directions 40]

Directions of force all around, the same for every grasp. Squeeze and weight are followed once for all of them, and
stand in a column of their own. Times by the processor's clock.
"""

from __future__ import annotations

import argparse
import os
from statistics import median

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["HANDLCP_KERNELS"] = "compiled"

import time

import numpy as np

from tests.benchmarks.loading import makes
from tests.benchmarks.report import conditions, opened, plain_table
from tests.support.many_limits import Counted

__all__ = ["main"]

MOST = 20.0  # milliseconds a direction


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--directions", type=int, default=40)
    asked = parser.parse_args()
    console = opened(150)
    console.print(conditions(), highlight=False)
    table = plain_table(
        "load limits, geometry followed", "grasp", f"ms a direction (≤ {MOST:g})", "worst", "steps", "looks",
        "squeeze and weight ms", "solve µs", "× a solve",
    )  # fmt: skip
    ways = np.random.default_rng(0).normal(size=(asked.directions, 3))
    loads = np.column_stack([ways / np.linalg.norm(ways, axis=1)[:, None], np.zeros_like(ways)])
    for name, make in makes().items():
        grasp, took, steps, looks = make(), list[float](), list[int](), list[int]()
        Counted(grasp).limit(loads[0])
        begun = time.process_time()
        counted = Counted(grasp)
        squeeze = time.process_time() - begun
        for load in loads:
            begun = time.process_time()
            counted.limit(load)
            took.append(time.process_time() - begun)
            steps.append(counted.steps)
            looks.append(counted.iterates)
        begun = time.process_time()
        for _ in range(50):
            make().solve("cone")
        solve = (time.process_time() - begun) / 50
        ms = 1e3 * median(took)
        table.add_row(
            name, f"{ms:.1f}", f"{1e3 * max(took):.1f}", f"{median(steps):.0f}", f"{median(looks):.0f}",
            f"{1e3 * squeeze:.1f}", f"{1e6 * solve:.0f}", f"{ms * 1e-3 / solve:.0f}",
        )  # fmt: skip
    console.print(table)


if __name__ == "__main__":
    main()
