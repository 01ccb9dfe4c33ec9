"""What load limits in one posture cost: one beside a held solve, and many directions at once.

    python -m tests.benchmarks.limits [--directions 1000] [--round 100] [--rounds 5]

Five fingers: a ring and a sphere of bare contacts with coupled springs, and a ball in the five-finger example hand. On
one core, the processor's clock beside the wall's, the best of some turns. Compiled code is warm.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["HANDLCP_KERNELS"] = "compiled"

import numpy as np

import handlcp as hl
from tests.benchmarks.report import conditions, opened, plain_table
from tests.support.limits import limits_of_grasp

__all__ = ["main"]

Make = Callable[[], hl.Grasp]
FACES = 8
MOST_ONE, MOST_MANY, MOST_ROUND = 5.0, 0.3, 10.0  # times a solve, s for 1,000 directions, ms a direction on the cone
ARM = 0.05


def placed(points: np.ndarray, seed: int) -> hl.Grasp:
    """Five fingers with coupled springs that press inward at points (5, 3) of a unit ball."""
    rng = np.random.default_rng(seed)
    contacts = [hl.Contact(ARM * p, -p / np.linalg.norm(p), hl.Coulomb(0.6)) for p in points]
    A = rng.normal(size=(15, 15))
    return hl.Grasp(contacts, flexibility=2e-5 * A @ A.T + 2e-4 * np.eye(15), preload=3e-3)


def makes() -> dict[str, Make]:
    """Ways to make a grasp of five fingers."""
    angles = 2 * np.pi * np.arange(5) / 5
    ring = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    height = np.array([1.0, -0.3, -0.3, -0.3, 0.4])
    sphere = ring * np.sqrt(1.0 - height**2)[:, None] + height[:, None] * [0.0, 0.0, 1.0]
    five = hl.example_hand("five_finger", joint_stiffness=6.0)
    ball = hl.Sphere(0.035, (0, 0, 0.07), mass=0.3)
    holding = five.at(five.close_on(ball))
    return {
        "ring": lambda: placed(ring, 0),
        "sphere": lambda: placed(sphere, 1),
        "hand": lambda: holding.grasp(ball, gravity=(0, 0, 9.81), squeeze=0.003),
    }


def best(run: Callable[[], object], rounds: int) -> tuple[float, float]:
    """Least seconds of this process, and of the wall."""
    took = []
    for _ in range(rounds):
        cpu, wall = time.process_time(), time.perf_counter()
        run()
        took.append((time.process_time() - cpu, time.perf_counter() - wall))
    return min(t[0] for t in took), min(t[1] for t in took)


def directions(count: int) -> np.ndarray:
    """(count, 6) forces evenly over the sphere (Fibonacci), without moments."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), z, 0 * z, 0 * z, 0 * z], axis=1)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--directions", type=int, default=1000)
    parser.add_argument("--round", type=int, default=100, help="directions on the cone")
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    console = opened(150)
    table = plain_table(
        f"load limits in one posture, {FACES} faces and the cone; processor (wall)", "grasp", f"solve({FACES}) [ms]",
        "one limit [ms]", "times a solve", f"{asked.directions} directions [s]", "one on the cone [ms]",
        f"{asked.round} on the cone, each [ms]",
    )  # fmt: skip
    one_way, many, round_ = np.array([0.3, 0.2, -1.0, 0, 0, 0]), directions(asked.directions), directions(asked.round)
    for name, make in makes().items():
        grasp = make()
        for faces in (FACES, "cone"):
            grasp.solve(faces)
            grasp.load_limit(one_way, geometry="fixed", faces=faces)
            limits_of_grasp(grasp, many[:3], faces)
        solve = best(lambda m=make: [m().solve(FACES) for _ in range(20)], asked.rounds)
        one = best(
            lambda m=make: [m().load_limit(one_way, geometry="fixed", faces=FACES) for _ in range(20)], asked.rounds
        )
        made = best(lambda m=make: [m() for _ in range(20)], asked.rounds)
        solve, one = (tuple((t - of) / 20 for t, of in zip(x, made, strict=True)) for x in (solve, one))
        all_ = best(lambda g=grasp: limits_of_grasp(g, many, FACES), min(asked.rounds, 3))
        cone = best(lambda g=grasp: g.load_limit(one_way, geometry="fixed"), asked.rounds)
        cones = best(lambda g=grasp: limits_of_grasp(g, round_), 1)
        table.add_row(
            name, both(solve, 1e3), both(one, 1e3), f"{one[0] / solve[0]:.1f}", both(all_, 1.0), both(cone, 1e3),
            both(cones, 1e3 / asked.round),
        )  # fmt: skip
    console.print(table)
    console.print(f"asked: {MOST_ONE} times a solve; {MOST_MANY} s; {MOST_ROUND} ms a direction on the cone")
    console.print(conditions())


def both(seconds: tuple[float, ...], unit: float) -> str:
    """Such as "1.2 (1.3)"."""
    return f"{unit * seconds[0]:.3g} ({unit * seconds[1]:.3g})"


if __name__ == "__main__":
    main()
