"""What dry friction at the joints costs a step of a loading: `python -m tests.benchmarks.joint_friction`.

Each grasp with and without it in turns, one process, compiled code warm; a step may take twice as long.
"""

from __future__ import annotations

import time
from typing import Any

import handlcp as hl
from tests.benchmarks.clock import Run, best_times

FRICTION, MOST = 0.02, 2.0  # N·m; times a step without


def grasps() -> dict[str, Any]:
    """A box in three fingers and a ball in five, each with and without friction."""
    objects = {
        "three_finger": hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2),
        "five_finger": hl.Sphere(0.03, (0, 0, 0.09), mass=0.2),
    }
    found = dict[str, Any]()
    for name, obj in objects.items():
        for friction in (0.0, FRICTION):
            hand = hl.example_hand(name, joint_stiffness=6.0, pad_flexibility=1e-4, joint_friction=friction)
            grasp = hand.at(hand.close_on(obj)).grasp(obj, friction=0.8, squeeze=0.004)
            found[f"{name}, {friction:g} N·m"] = grasp
    return found


def follow(grasp: Any) -> Run:
    """One path."""
    return lambda: grasp.follow()


def main() -> int:
    """Print times of a step, and their ratios; 1 where one is too large."""
    every = grasps()
    counts = {name: len(grasp.follow().steps) for name, grasp in every.items()}
    tasks = {name: (lambda grasp=grasp: follow(grasp)) for name, grasp in every.items()}
    best = best_times(tasks, 5, 1, time.process_time)
    steps = {name: 1e3 * best[name] / counts[name] for name in every}
    names, worst = list(steps), 0.0
    for without, rubbing in zip(names[::2], names[1::2], strict=True):
        ratio = steps[rubbing] / steps[without]
        worst = max(worst, ratio)
        print(f"{rubbing}: {steps[rubbing]:.2f} ms a step, {ratio:.2f} times that without ({steps[without]:.2f} ms)")
    return int(worst > MOST)


if __name__ == "__main__":
    raise SystemExit(main())
