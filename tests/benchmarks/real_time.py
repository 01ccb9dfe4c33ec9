"""What following a grasp costs: posture → torques, update by update, beside bare Pinocchio; does memory grow?"""

from __future__ import annotations

import gc
import itertools
import resource
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from rich.console import Console

import handlcp as hl
from tests.benchmarks.clock import median_times
from tests.benchmarks.report import plain_table
from tests.support.grasp import arrays

__all__ = ["Walk", "growth", "measure"]

POSTURES = 64


class Walk:
    """A ball in the five-finger hand, whose posture and load wander: `POSTURES` of each, over and over.

    strength : of the load. 1: all fingers stick; 3: one in six contacts slides, and states change on the way; from 4 on
    part of the way cannot be held.
    """

    def __init__(self, strength: float = 1.0) -> None:
        self.hand = hl.example_hand("five_finger", joint_stiffness=5.0)
        ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
        q = self.hand.close_on(ball, squeeze=3e-3)
        seen = self.hand.at(q).grasp(ball, hl.Coulomb(0.6))
        self.contacts, self.offset, self.reference = seen.contacts, seen.offset, seen.reference
        rng, load = np.random.default_rng(0), np.array([*arrays(seen).force, 0, 0, 0])
        turns = np.linspace(0, 2 * np.pi, POSTURES, endpoint=False)[:, None]
        way = rng.normal(size=(2, 10)) * 5e-3
        pull = rng.normal(size=(2, 6)) * np.array([0.3, 0.3, 0.3, 5e-3, 5e-3, 5e-3]) * strength
        self.q = q + np.sin(turns) * way[0] + np.cos(turns) * way[1]
        self.load = load + np.sin(turns) * pull[0] + np.cos(turns) * pull[1]

    def grasp(self, k: int) -> hl.HandGrasp:
        """The grasp of step k, made anew."""
        more: dict[str, Any] = {"offset": self.offset, "reference": self.reference}
        return self.hand.at(self.q[k]).grasp(self.contacts, wrench=self.load[k], **more)

    def bare(self) -> Callable[[int], Any]:
        """Forward kinematics, joint Jacobians and the frame Jacobians of the fingertips."""
        model = self.hand.model
        data, tips = model.createData(), [model.getFrameId(name) for name in self.hand.fingertips]

        def run(k: int) -> None:
            q = self.q[k]
            pin.framesForwardKinematics(model, data, q)
            pin.computeJointJacobians(model, data, q)
            for tip in tips:
                pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)

        return run


def measure(console: Console, faces: Any = 8) -> dict[str, float]:
    """Print and return medians [µs] of one step, in turns."""
    walk, hard = Walk(), Walk(3.0)
    stream, loads = hl.GraspStream(walk.grasp(0), faces), hl.GraspStream(walk.grasp(0), faces)
    sliding = hl.GraspStream(hard.grasp(0), faces)
    last = [walk.grasp(0).solve(faces)]

    def warm(k: int) -> Any:
        last[0] = walk.grasp(k).solve(faces, start=last[0])
        return last[0].torques

    tasks: dict[str, Callable[[int], Any]] = {
        "bare Pinocchio: FK, joint Jacobians, 5 frame Jacobians": walk.bare(),
        "stream, posture and load → torques": lambda k: stream.update(walk.q[k], wrench=walk.load[k]).torques,
        "the same where fingers slide": lambda k: sliding.update(hard.q[k], wrench=hard.load[k]).torques,
        "stream, load alone → torques": lambda k: loads.update(wrench=walk.load[k]).torques,
        "hand.at(q).grasp(contacts).solve(start=last)": warm,
        "hand.at(q).grasp(contacts).solve()": lambda k: walk.grasp(k).solve(faces).torques,
    }
    step = itertools.count()
    times = median_times({name: lambda run=run: run(next(step) % POSTURES) for name, run in tasks.items()}, 2000)
    bare = next(iter(times.values()))
    table = plain_table(f"Following a grasp: five fingers, {faces} faces, medians of 2000", "one step", "µs", "× bare")
    for name, us in times.items():
        table.add_row(name, f"{us:.1f}", f"{us / bare:.1f}")
    console.print(table)
    return times


def growth(console: Console, updates: int = 1_000_000) -> float:
    """Print and return bytes by which the process grows per update, after a tenth of them."""
    walk = Walk()
    stream = hl.GraspStream(walk.grasp(0))

    def run(times: int) -> int:
        for k in range(times):
            stream.update(walk.q[k % POSTURES], wrench=walk.load[k % POSTURES]).torques  # noqa: B018
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)

    before = run(updates // 10)
    after = run(updates)
    each = (after - before) / updates
    console.print(f"Memory after {updates:,} more updates: {after - before:,} bytes more, {each:.3f} an update")
    return each
