"""80 loads that grow on 20 grasps of six hands, three of them commercial: gentle and firm, along axes and at random.

A grasp is HELD without load. Grasps of the shipped hands are those of `cases`; those of commercial hands are kept in
`grasps.json`, see `find_grasps`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

import handlcp as hl
from tests.mujoco import find_grasps
from tests.mujoco.case import closing, read_rows
from tests.mujoco.cases import CAN, UP, three, two

LEVER = 0.02  # [m] a random load has this much torque for each newton


@dataclass(frozen=True)
class LimitCase:
    """make : the grasp. wrench (6,) : the load that grows. short : whether the default suite runs it in MuJoCo."""

    hand: str
    name: str
    load: str
    make: Callable[[], Any]
    wrench: tuple[float, ...]
    short: bool = False

    @property
    def title(self):
        """Its name in the stored table."""
        return f"{self.hand}, {self.name}, {self.load}"


def ball():
    """Three fingers around a ball of 50 g."""
    return three(hl.Sphere(0.03, [0, 0, 0.08], mass=0.05), hand=FREE)


FREE = {"torque_limits": 10.0}
SOFT = hl.SoftFinger(0.8, 0.008)


def in_two(obj, offset):
    """Two soft fingers that hang and pinch an object."""
    return two(obj, offset, SOFT, hand=FREE)


def in_five(obj, depth):
    """Five fingers that hang around an object, closed so far."""
    hand = hl.example_hand("five_finger", joint_stiffness=6.0, **FREE)
    return closing(hand.at(hand.close_on(obj)).grasp(obj, hl.Coulomb(0.6), gravity=UP), depth)


def found(hand, thing, squeeze=1.0):
    """A grasp of `grasps.json`, squeezed so many times as much."""
    row = read_rows(find_grasps.FILE)[f"{hand} {thing}"]
    obj = find_grasps.OBJECTS[thing](pin.SE3(np.array(row["rotation"]), np.array(row["position"])))
    state = find_grasps.hand(hand).at(row["q"])
    return state.grasp(obj, hl.Coulomb(find_grasps.MU), joint_offset=squeeze * np.array(row["offset"]))


GRASPS: dict[tuple[str, str], tuple[Callable[[], Any], tuple[str, str]]] = {
    ("two_finger", "box"): (lambda: in_two(hl.Box(0.05, [0, 0, 0.085], mass=0.05), 0.05), ("-z", "+x")),
    ("two_finger", "ball, gentle"): (
        lambda: in_two(hl.Sphere(0.025, [0, 0, 0.085], mass=0.03), 0.02), ("+z", "-y")),
    ("two_finger", "cylinder"): (
        lambda: in_two(hl.Cylinder(0.025, 0.06, [0, 0, 0.085], mass=0.05), 0.03), ("-z", "+y")),
    ("three_finger", "cube, gentle"): (lambda: three(hand=FREE), ("+y", "-z")),
    ("three_finger", "cube, firm"): (lambda: three(offset=0.05, hand=FREE), ("-y", "+x")),
    ("three_finger", "ball"): (ball, ("-z", "+y")),
    ("three_finger", "cylinder, stiff"): (lambda: three(CAN, K=20.0, hand=FREE), ("+z", "+y")),
    ("five_finger", "ball, gentle"): (lambda: in_five(hl.Sphere(0.035, [0, 0, 0.073], mass=0.3), 0.0015), ("+x", "-z")),
    ("five_finger", "ball, firm"): (lambda: in_five(hl.Sphere(0.035, [0, 0, 0.07], mass=0.3), 0.003), ("+z", "-y")),
    ("five_finger", "cylinder"): (
        lambda: in_five(hl.Cylinder(0.03, 0.06, [0, 0, 0.07], mass=0.1), 0.003), ("-x", "-z")),
    ("five_finger", "ellipsoid"): (
        lambda: in_five(hl.Ellipsoid([0.03, 0.035, 0.04], [0, 0, 0.072], 0.1), 0.003), ("+y", "-z")),
    ("allegro", "ball"): (lambda: found("allegro", "ball"), ("+x", "-z")),
    ("allegro", "box"): (lambda: found("allegro", "box"), ("+y", "-x")),
    ("allegro", "cylinder, firm"): (lambda: found("allegro", "cylinder", 2.0), ("+z", "-y")),
    ("barrett", "ball, firm"): (lambda: found("barrett", "ball", 2.0), ("+x", "-y")),
    ("barrett", "box"): (lambda: found("barrett", "box"), ("-z", "+y")),
    ("barrett", "cylinder"): (lambda: found("barrett", "cylinder"), ("+z", "-x")),
    ("schunk", "ball"): (lambda: found("schunk", "ball"), ("-z", "+y")),
    ("schunk", "box, firm"): (lambda: found("schunk", "box", 1.5), ("+x", "-y")),
    ("schunk", "cylinder"): (lambda: found("schunk", "cylinder"), ("+z", "-x")),
}  # fmt: skip
SHORT = {"two_finger, ball, gentle, +z", "three_finger, ball, -z", "allegro, ball, random force"}


def _loads(ways, seed):
    """Two along axes, a random force, and a random force with a torque; each of 1 N."""
    loads = {}
    for way in ways:
        force = np.zeros(6)
        force["xyz".index(way[1])] = 1.0 if way[0] == "+" else -1.0
        loads[way] = force
    random = np.random.default_rng(seed)
    for name, lever in (("random force", 0.0), ("random wrench", LEVER)):
        force, torque = (v / np.linalg.norm(v) for v in random.standard_normal((2, 3)))
        loads[name] = np.concatenate([force, lever * torque])
    return {name: tuple((np.round(load, 4) + 0.0).tolist()) for name, load in loads.items()}


CASES = tuple(
    LimitCase(hand, name, load, make, wrench, f"{hand}, {name}, {load}" in SHORT)
    for seed, ((hand, name), (make, ways)) in enumerate(GRASPS.items())
    for load, wrench in _loads(ways, seed).items()
)
