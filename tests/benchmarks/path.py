"""What a loading costs that is followed: beside a grasp and solve for each stage, and beside MuJoCo on the same grasp.

    python -m tests.benchmarks.path [--rounds 9] [--no-mujoco]

`follow` takes 40 steps a stage, `check` follows and judges, `load_limit` goes on until something gives out. With
motors, joint friction and slack tendons on the way, a step may take twice as long.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import numpy as np

import handlcp as hl
from tests.benchmarks.measure import best_times, options, print_table

__all__ = ["main"]

Make = Callable[[], hl.HandGrasp]
BURST = 20
PULL = (2.0, 1.0, 0.0, 0.0, 0.02, 0.0)
BALL = hl.Sphere(0.035, (0, 0, 0.07), mass=0.3)
BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)


def makes() -> dict[str, Make]:
    """Ways to make a grasp from a posture and an object."""
    five = hl.example_hand("five_finger", joint_stiffness=6.0)
    holding = five.at(five.close_on(BALL))
    three = hl.example_hand("three_finger", joint_stiffness=6.0)
    around = three.at(three.close_on(BOX))
    soft = hl.example_hand("five_finger", joint_stiffness=2.0)
    loose = soft.at(soft.close_on(BALL))
    up = (0, 0, 9.81)
    return {
        "ball, five fingers": lambda: holding.grasp(BALL, gravity=up, squeeze=0.003),
        "cube, three fingers": lambda: around.grasp(BOX, friction=hl.Coulomb(0.8), squeeze=0.003),
        "ball, sliding": lambda: loose.grasp(BALL, gravity=up, squeeze=0.003),
        "ball, soft fingers": lambda: holding.grasp(BALL, hl.SoftFinger(0.6, 0.003), gravity=up, squeeze=0.003),
    }


def timed(run: Callable[[], object]) -> float:
    """Seconds of this process."""
    begun = time.process_time()
    run()
    return time.process_time() - begun


def stages(rounds: int, mujoco: bool) -> dict[str, dict[str, float]]:
    """Print and return what each call takes, as a multiple of one grasp and solve; `follow` for each of its stages."""
    found, rows = {}, []
    for name, make in makes().items():
        grasp = make()
        calls: dict[str, Callable[[], object]] = {
            "follow": grasp.follow,
            "10 steps": lambda grasp=grasp: grasp.follow(steps=10),
            "check": lambda make=make: make().check(),
            "load limit": lambda make=make: make().load_limit(PULL),
            "limit, fixed": lambda make=make: make().load_limit(PULL, geometry="fixed"),
        }
        make().solve()
        for call in calls.values():
            call()
        pairs: dict[str, list[float]] = {call: [] for call in calls}
        ones = []
        for _ in range(rounds):
            ones.append(timed(lambda make=make: [make().solve().held for _ in range(BURST)]) / BURST)
            for call, run in calls.items():
                pairs[call].append(timed(run) / ones[-1])
        ratios = {call: median(p) for call, p in pairs.items()}
        ratios["follow"] /= len(grasp.follow().stages)
        there, here = (grasp.follow(steps=steps).steps.forces_world[-1] for steps in (40, 10))
        off = float(abs(here - there).max() / abs(there).max())
        if mujoco:
            from handlcp.simulator import simulate

            ratios["MuJoCo"] = simulate(make()).seconds / min(ones)
        found[name] = ratios
        cells = [f"{ratios[c]:,.1f}" if c in ratios else "–" for c in [*calls, "MuJoCo"]]
        rows.append((name, f"{1e6 * min(ones):.0f}", *cells, f"{100 * off:.3f} %"))
    headings = (
        "grasp",
        "solve µs",
        "follow, a stage",
        "10 steps",
        "check",
        "load limit",
        "fixed",
        "MuJoCo",
        "10 off by",
    )
    print_table("Multiples of one grasp and solve", headings, rows)
    return found


def steps(rounds: int) -> dict[str, float]:
    """Print and return what a step takes with motors, friction or slack tendons, as a multiple of that without."""
    motor = hl.Motor(0.005, 0.02, holding=3.0, friction=0.05, reduction=100.0, efficiency=0.7)
    joints, ways = hl.example_hand("three_finger").joint_names, {"flexor": 0.01, "extensor": -0.008}
    arms = {f"{joint} {way}": {joint: arm} for joint in joints for way, arm in ways.items()}

    def grasp(**hand: Any) -> hl.HandGrasp:
        own = hl.example_hand("three_finger", pad_flexibility=1e-4, **hand)
        return own.at(own.close_on(BOX)).grasp(BOX, friction=0.8, squeeze=0.004, wrench=PULL)

    plain = grasp(joint_stiffness=6.0)
    slack, taut = (grasp(joint_stiffness=hl.Tendons(arms, 3e4, 1.0, pretension=T)) for T in (0.0, np.inf))
    pairs = {
        "the same: the noise": (grasp(joint_stiffness=6.0), plain),
        "geared motors": (grasp(joint_stiffness=6.0, motors=motor), plain),
        "joint friction": (grasp(joint_stiffness=6.0, joint_friction=0.02), plain),
        "tendons that may go slack, beside taut ones": (slack, taut),
    }
    ratios, rows = {}, []
    for name, pair in pairs.items():
        counts = [len(g.follow().steps) for g in pair]
        tasks = {k: (lambda g=g: g.follow) for k, g in zip("ab", pair, strict=True)}
        best = best_times(tasks, rounds, 1)
        a, b = (1e3 * best[k] / count for k, count in zip("ab", counts, strict=True))
        ratios[name] = a / b
        rows.append((name, f"{a:.3f}", f"{b:.3f}", f"{a / b:.2f}"))
    print_table("A step of a loading, three fingers", ("with", "ms", "without ms", "ratio"), rows)
    return ratios


def main(arguments: Sequence[str] | None = None) -> dict[str, Any]:
    """Measure, print, and return the ratios of both tables."""
    parser = options(__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--no-mujoco", action="store_true")
    asked = parser.parse_args(arguments)
    return {"stages": stages(asked.rounds, not asked.no_mujoco), "steps": steps(asked.rounds)}


if __name__ == "__main__":
    main()
