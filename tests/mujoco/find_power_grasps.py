"""Power grasps for the comparison with MuJoCo, found once: `python -m tests.mujoco.find_power_grasps [hand ...]`.

An object is laid against the palm somewhere, slid along the palm's normal until it touches, and the hand closes on it.
What holds its own weight there is kept, two of each hand and object at most, as numbers in `power_grasps.json`.
"""

from __future__ import annotations

import pathlib
import sys
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import trimesh

import handlcp as hl
from handlcp.errors import HandLCPError
from tests.mujoco.case import read_rows, write_rows
from tests.support.hand import link_gap

FILE = pathlib.Path(__file__).with_name("power_grasps.json")
MU, STIFFNESS, TORQUE = 0.8, 5.0, 0.3  # friction, N·m/rad, N·m
EACH, TRIES = 2, 10
FAR = 0.12  # [m] before the palm, where an object begins


class Palm(NamedTuple):
    """A point before the palm (3,), the normal out of it (3,), where fingers point (3,); how far objects are laid aside
    along the fingers and across them [m]; joints that stand elsewhere than at the neutral posture, from and to.
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]
    along: tuple[float, float, float]
    aside: tuple[float, float]
    joints: dict[str, tuple[float, float]]


PALMS = {
    "three_finger": Palm((0, 0, 0), (0, 0, 1), (1, 0, 0), (0.004, 0.004), {}),
    "five_finger": Palm((0, 0, 0), (0, 0, 1), (1, 0, 0), (0.004, 0.004), {}),
    "allegro": Palm((0.01, 0, -0.01), (1, 0, 0), (0, 0, 1), (0.025, 0.02),
                    {"joint_12.0": (1.0, 1.39), "joint_13.0": (0.0, 0.6)}),
    "leap": Palm((-0.02, 0.035, 0.035), (0, 0, 1), (1, 0, 0), (0.025, 0.02),
                 {"th_cmc": (0.6, 1.6), "th_axl": (0.3, 1.6)}),
    "barrett": Palm((0, 0, 0.091), (0, 0, 1), (0, 1, 0), (0.02, 0.02),
                    {"finger_1_prox_joint": (-0.4, -0.2), "finger_2_prox_joint": (0.2, 0.4)}),
    "shadow": Palm((0.33, 0, 0.032), (0, 0, 1), (1, 0, 0), (0.02, 0.015),
                   {"rh_THJ4": (0.7, 1.2), "rh_THJ5": (-0.3, 0.8)}),
    "schunk": Palm((0, 0.025, 0.1), (0, 1, 0), (0, 0, 1), (0.02, 0.015),
                   {"right_hand_Thumb_Opposition": (0.5, 0.98)}),
}  # fmt: skip
SMALL = ("three_finger", "five_finger")


def hull(points):
    """A mesh: the hull of points (m, 3)."""
    return trimesh.Trimesh(vertices=np.array(points), process=True).convex_hull


def cup(size):
    """A cup with twelve sides that is wider above than below."""
    angles = np.arange(12) * np.pi / 6
    rings = ((0.75, -1.2), (1.0, 1.2))
    return hull([(size * r * np.cos(a), size * r * np.sin(a), size * z) for r, z in rings for a in angles])


def stone(size):
    """A stone with 40 corners."""
    random = np.random.default_rng(5)
    points = random.standard_normal((40, 3))
    return hull(size * points / np.linalg.norm(points, axis=1)[:, None] * (1.0, 0.8, 1.2))


def thing(name, hand, at):
    """The object of this name, made for the size of a hand, there."""
    size = 0.03 if hand in SMALL else 0.035
    match name:
        case "box":
            return hl.Box((1.8 * size, 1.6 * size, 3.0 * size), at, mass=0.1)
        case "cylinder":
            return hl.Cylinder(0.9 * size, 3.0 * size, at, mass=0.1)
        case "ball":
            return hl.Sphere(size, at, mass=0.1)
        case "cup":
            return hl.Mesh(cup(size), None, at, 0.1)
        case "stone":
            return hl.Mesh(stone(size), None, at, 0.1)
    raise KeyError(name)


THINGS = ("box", "cylinder", "ball", "cup", "stone")


def a_hand(name):
    """A hand whose torque limits are out of the way."""
    return hl.example_hand(name, joint_stiffness=STIFFNESS, torque_limits=10.0)


def made(row):
    """The grasp of a row of the file."""
    hand = a_hand(row["hand"])
    obj = thing(row["thing"], row["hand"], pin.SE3(np.array(row["rotation"]), np.array(row["position"])))
    state = hand.at(row["q"])
    return state.grasp(obj, hl.Coulomb(row["mu"]), links="all", closing_torque=row["torque"])


def main(names):
    """Find and write them."""
    rows = read_rows(FILE)
    for name in names or list(PALMS):
        rows = {key: row for key, row in rows.items() if row["hand"] != name}
        hand = a_hand(name)
        for k, what in enumerate(THINGS):
            random, count = np.random.default_rng(100 * list(PALMS).index(name) + k), 0
            for _ in range(TRIES):
                row = tried(hand, name, what, random)
                if row is None:
                    continue
                count += 1
                rows[f"{name}, {what} {count}"] = row
                print(name, what, row["contacts"], flush=True)
                if count == EACH:
                    break
        write_rows(FILE, rows)


def tried(hand, name, what, random):
    """One placement at random; a row, where the hand holds the object there."""
    palm, q = PALMS[name], np.clip(hand.neutral, hand.lower, hand.upper)
    for joint, (low, high) in palm.joints.items():
        q[hand.joint_names.index(joint)] = random.uniform(low, high)
    n, along = np.array(palm.normal, dtype=float), np.array(palm.along, dtype=float)
    across = np.cross(n, along)
    at = np.array(palm.point) + palm.aside[0] * random.uniform(-1, 1) * along
    at = at + palm.aside[1] * random.uniform(-1, 1) * across
    axes = np.stack([along, across, n], axis=1) if random.uniform() < 0.4 else np.stack([n, along, across], axis=1)
    turn = random.standard_normal(3)
    R = pin.exp3(turn if what == "stone" else 0.3 * turn[0] * n) @ axes
    low, high = 0.0, FAR
    for _ in range(40):
        middle = 0.5 * (low + high)
        obj = thing(what, name, pin.SE3(R, at + middle * n))
        free = link_gap(hand, q, obj) > 0.0
        low, high = (low, middle) if free else (middle, high)
    place = pin.SE3(np.round(R, 12), np.round(at + high * n, 9))
    try:
        closed = hand.close_on(thing(what, name, place), q, wrap=True)
        row = {"hand": name, "thing": what, "q": np.round(closed, 9).tolist(), "rotation": place.rotation.tolist(),
               "position": place.translation.tolist(), "mu": MU, "torque": TORQUE}  # fmt: skip
        grasp = made(row)
        joints = [site.joint for site in grasp.state.hand.tips.places]
        if len(grasp.names) < 4 or len(set(joints)) < 3 or not grasp.follow(steps=20).reached:
            return None
    except HandLCPError as e:
        print("   ", name, what, type(e).__name__, str(e)[:150], flush=True)
        return None
    return row | {"contacts": len(grasp.names)}


if __name__ == "__main__":
    main(sys.argv[1:])
