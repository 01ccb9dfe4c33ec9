"""What dry friction at the joints, tendons that go slack, and tendons along routes cost a step of a loading.

`python -m tests.benchmarks.joints_on_path`: each grasp with and without in turns, one process, compiled code warm; a
step may take twice as long. Of hands with routes "without" is the same hand with fixed arms.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import handlcp as hl
from tests.benchmarks.clock import Run, best_times
from tests.support.routed import threes

FRICTION, MOST = 0.02, 2.0  # N·m; times a step without
LOAD = [2.0, 1.0, 0.0, 0.0, 0.02, 0.0]
OBJECTS = {
    "three_finger": hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2),
    "five_finger": hl.Sphere(0.03, (0, 0, 0.09), mass=0.2),
}


def grasps() -> dict[str, tuple[Any, Any]]:
    """A box in three fingers and a ball in five, with and without."""
    found = dict[str, tuple[Any, Any]]()
    for name, obj in OBJECTS.items():

        def made(obj: hl.Object = obj, name: str = name, **hand: Any) -> Any:
            own = hl.example_hand(name, pad_flexibility=1e-4, **hand)
            return own.at(own.close_on(obj)).grasp(obj, friction=0.8, squeeze=0.004, wrench=LOAD)

        found[f"{name}, friction"] = made(joint_stiffness=6.0, joint_friction=FRICTION), made(joint_stiffness=6.0)
        joints, ways = hl.example_hand(name).joint_names, {"flexor": 0.01, "extensor": -0.008}
        arms = {f"{joint} {way}": {joint: arm} for joint in joints for way, arm in ways.items()}
        slack, taut = (made(joint_stiffness=hl.Tendons(arms, 3e4, 1.0, pretension=T)) for T in (0.0, np.inf))
        found[f"{name}, {len(arms)} tendons"] = slack, taut
        found[f"{name}, tendons that stay taut"] = taut, made(joint_stiffness=taut.state.hand.joint_stiffness)
    for tendons, extensors in ((3, False), (6, True)):
        for words, friction in (("", 0.0), (" that rub", 0.1)):
            both = tuple([threes(extensors, 2.0, along, friction) for along in (True, False)])
            found[f"three_finger, {tendons} routes{words}"] = both[0], both[1]
    return found


def follow(grasp: Any) -> Run:
    """One path."""
    return lambda: grasp.follow()


def main() -> int:
    """Print times of a step, and their ratios; 1 where one is too large."""
    worst = 0.0
    for name, both in grasps().items():
        counts = [len(grasp.follow().steps) for grasp in both]
        tasks = {which: (lambda grasp=grasp: follow(grasp)) for which, grasp in zip("ab", both, strict=True)}
        best = best_times(tasks, 5, 1, time.process_time)
        step, without = (1e3 * best[which] / count for which, count in zip("ab", counts, strict=True))
        worst = max(worst, step / without)
        print(f"{name:40s} {step:.2f} ms a step, {step / without:.2f} times that without ({without:.2f} ms)")
    return int(worst > MOST)


if __name__ == "__main__":
    raise SystemExit(main())
