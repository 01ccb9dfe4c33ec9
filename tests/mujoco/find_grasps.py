"""Grasps of commercial hands for the load limits, found once: `python -m tests.mujoco.find_grasps` writes them anew.

They are kept as numbers, so that what MuJoCo said of them stays comparable while the search for grasps changes.
"""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np

import handlcp as hl
from tests.mujoco.case import write_rows

FILE = pathlib.Path(__file__).with_name("grasps.json")
HANDS: dict[str, dict[str, Any]] = {
    "allegro": {}, "barrett": {"tip_radius": 0.008}, "schunk": {"tip_radius": 0.008},
}  # fmt: skip
OBJECTS = {
    "ball": lambda at=None: hl.Sphere(0.03, at, mass=0.1), "box": lambda at=None: hl.Box((0.04, 0.05, 0.08), at, 0.1),
    "cylinder": lambda at=None: hl.Cylinder(0.025, 0.1, at, mass=0.1),
}  # fmt: skip
MU = 0.7


def hand(name):
    """A commercial hand whose torque limits are out of the way."""
    return hl.example_hand(name, joint_stiffness=5.0, torque_limits=10.0, **HANDS[name])


def main():
    """Find and write them."""
    rows = {}
    for name in HANDS:
        for thing, make in OBJECTS.items():
            found = hl.find_grasp(hand(name), make(), friction=MU, throw=False)
            if not found:
                print(name, thing, "none")
                continue
            grasp = found[0].grasp
            at = grasp.target.placement
            rows[f"{name} {thing}"] = {
                "q": np.round(grasp.state.q, 9).tolist(), "offset": np.round(grasp.joint_offset, 6).tolist(),
                "rotation": np.round(at.rotation, 12).tolist(), "position": np.round(at.translation, 9).tolist(),
            }  # fmt: skip
            print(name, thing, found[0].verdict.word, found[0].margin, flush=True)
    write_rows(FILE, rows)


if __name__ == "__main__":
    main()
