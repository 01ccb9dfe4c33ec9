"""What loading in steps costs: beside one grasp and solve for each stage, and beside MuJoCo on the same grasp.

    python -m tests.benchmarks.loading [--rounds 15] [--no-mujoco]

`follow` takes 40 steps a stage, squeeze and load. Times by the processor's clock, in bursts of equal length and in
turns, so that a busy machine meets all alike; the ratio is the median over the turns. Two stages each. Steps are of
second order: ten a stage are worth a column of their own, with what their forces are off.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from statistics import median

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["HANDLCP_KERNELS"] = "compiled"

import time

import handlcp as hl
from tests.benchmarks.report import conditions, opened, plain_table

__all__ = ["main"]

Make = Callable[[], hl.HandGrasp]
MOST = 20.0  # times one grasp and solve, for each stage
BURST = 50


def makes() -> dict[str, Make]:
    """Ways to make a grasp from a posture and an object."""
    five = hl.example_hand("five_finger", joint_stiffness=6.0)
    ball = hl.Sphere(0.035, (0, 0, 0.07), mass=0.3)
    holding = five.at(five.close_on(ball))
    three = hl.example_hand("three_finger", joint_stiffness=6.0)
    box = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    around = three.at(three.close_on(box))
    soft = hl.example_hand("five_finger", joint_stiffness=2.0)
    loose = soft.at(soft.close_on(ball))
    up = (0, 0, 9.81)
    return {
        "ball, five fingers": lambda: holding.grasp(ball, gravity=up, squeeze=0.003),
        "cube, three fingers": lambda: around.grasp(box, friction=hl.Coulomb(0.8), squeeze=0.003),
        "ball, sliding": lambda: loose.grasp(ball, gravity=up, squeeze=0.003),
        "ball, soft fingers": lambda: holding.grasp(ball, hl.SoftFinger(0.6, 0.003), gravity=up, squeeze=0.003),
    }


def timed(run: Callable[[], object]) -> float:
    """Seconds of this process."""
    begun = time.process_time()
    run()
    return time.process_time() - begun


def ratio(make: Make, rounds: int) -> tuple[float, float, float]:
    """Milliseconds of `follow`, microseconds of one grasp and solve, and their ratio for each stage."""
    grasp = make()
    for _ in range(3):
        grasp.follow()
        make().solve("cone")
    stages, pairs = len(grasp.follow().stages), []
    for _ in range(rounds):
        one = timed(lambda: [make().solve("cone").held for _ in range(BURST)]) / BURST
        pairs.append((timed(grasp.follow), one))
    return (
        1e3 * min(f for f, _ in pairs), 1e6 * min(one for _, one in pairs),
        median(f / one / stages for f, one in pairs),
    )  # fmt: skip


def few(grasp: hl.HandGrasp, rounds: int) -> tuple[float, float]:
    """Milliseconds of `follow` with ten steps a stage, and by how much its forces differ, as a share of the largest."""
    there, here = (grasp.follow(steps=steps).steps.forces_world[-1] for steps in (40, 10))
    took = min(timed(lambda: grasp.follow(steps=10)) for _ in range(rounds))
    return 1e3 * took, float(abs(here - there).max() / abs(there).max())


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--no-mujoco", action="store_true")
    asked = parser.parse_args()
    console = opened(150)
    console.print(conditions(), highlight=False)
    table = plain_table(
        "loading in steps", "grasp", "follow ms", "grasp and solve µs", f"× a stage (≤ {MOST:g})", "10 steps ms",
        "off by", "MuJoCo s", "MuJoCo / follow", "/ 10 steps",
    )  # fmt: skip
    for name, make in makes().items():
        follow, one, times = ratio(make, asked.rounds)
        coarse, off = few(make(), asked.rounds)
        simulated = "–", "–", "–"
        if not asked.no_mujoco:
            from handlcp.simulator import simulate

            took = simulate(make()).seconds
            simulated = f"{took:.2f}", f"{1e3 * took / follow:.0f}", f"{1e3 * took / coarse:.0f}"
        table.add_row(
            name, f"{follow:.1f}", f"{one:.0f}", f"{times:.1f}", f"{coarse:.1f}", f"{100 * off:.3f} %", *simulated
        )
    console.print(table)


if __name__ == "__main__":
    main()
