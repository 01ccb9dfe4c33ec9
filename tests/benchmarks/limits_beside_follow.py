"""Load limits with the geometry followed beside `follow`: where a load that grows step by step loses the object.

    python -m tests.benchmarks.limits_beside_follow [--directions 20] [--steps 80]

`follow` gets 1.1 times the limit and says at which share it is lost. It knows no torque limits and ends of range as
limits: directions where these bind are left out. It takes steps of the load, and is of first order
where contacts slide; the limit is led by the object's motion, and is of second order. With --steps larger both meet.
"""

from __future__ import annotations

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["HANDLCP_KERNELS"] = "compiled"

import numpy as np

import handlcp as hl
from tests.benchmarks.loading import makes
from tests.benchmarks.report import opened, plain_table

__all__ = ["main"]

MORE = 1.1  # times the limit: the load that is followed
FAR = 0.01  # differences that are listed


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--directions", type=int, default=20)
    parser.add_argument("--steps", type=int, default=80)
    asked = parser.parse_args()
    console = opened(150)
    table = plain_table(
        f"load limits beside follow, {asked.steps} steps", "grasp", "directions", "median difference", "largest",
        "within 1 %", "held at 1.1 ×",
    )  # fmt: skip
    ways = np.random.default_rng(0).normal(size=(asked.directions, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    for name, make in list(makes().items())[:3]:
        grasp, off, held = make(), list[float](), 0
        for way in ways:
            limit = grasp.load_limit(np.append(way, np.zeros(3)))
            if not limit.binds or limit.binds[0].kind in ("torque", "range"):
                continue
            order = ("squeeze", hl.Stage("weight", weight=1.0), hl.Stage("load", load=MORE * limit.load))
            path = grasp.follow(order=order, steps=asked.steps)
            held += path.reached
            if path.lost_at is not None and path.lost_stage == "load":
                off.append(MORE * path.lost_at - 1.0)
                if abs(off[-1]) > FAR:
                    console.print(f"{name}, {np.round(way, 2)}: {limit.why}; follow: {1.0 + off[-1]:.3f} times that")
        sizes = abs(np.array(off))
        table.add_row(
            name, f"{len(off)}", f"{100 * np.median(sizes):.3f} %", f"{100 * sizes.max():.2f} %",
            f"{(sizes <= FAR).sum()}", f"{held}",
        )  # fmt: skip
    console.print(table)


if __name__ == "__main__":
    main()
