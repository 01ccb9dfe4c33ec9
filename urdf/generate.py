"""Write the four hands of this folder, byte for byte the same every time: `python urdf/generate.py [folder]`.

Every finger has two joints and links of 50 mm and 40 mm that end in a ball of 8 mm radius about the tip frame. Three
hands stand their fingers on a round palm (two, three and five of them), pointing along +z; positive angles close the
hand. The fourth is a ring of six fingers that lie in the xy plane and point at its centre, with joints about z. World
frame: the palm's.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.design.urdf_parts import (
    Vector,
    axis_point,
    format_urdf,
    make_link,
    make_palm,
    make_pose,
    make_revolute_joint,
    make_robot,
    make_tip,
    make_tip_mount,
)

PROXIMAL, DISTAL = 0.050, 0.040  # link lengths [m]
LINK_RADIUS, TIP_RADIUS = 0.007, 0.008  # [m]
MASS = {"palm": 0.250, "proximal": 0.025, "distal": 0.018, "tip": 0.003}  # [kg]: small geared motors in plastic links
EFFORT = {"proximal": 0.8, "distal": 0.4}  # [N·m]
SPEED = 6.0  # [rad/s]
PALM_RADIUS, PALM_HEIGHT = 0.055, 0.020  # [m]
CIRCLE = 0.045  # where the fingers stand on the palm [m]
RING = 0.120  # where the fingers stand on the ring [m]


def finger(
    name: str, root: np.ndarray, direction: str, axis: Vector, ranges: dict[str, tuple[float, float]]
) -> tuple[list[Any], list[Any]]:
    """Links and joints of one finger that stands at `root` on the palm, pointing along root's x or z axis."""

    def joint(kind: str, parent: str, origin: np.ndarray) -> Any:
        return make_revolute_joint(f"{name}_{kind}", parent, origin, axis, EFFORT[kind], SPEED, ranges[kind])

    links = [
        make_link(f"{name}_proximal_link", MASS["proximal"], LINK_RADIUS, PROXIMAL, direction),
        make_link(f"{name}_distal_link", MASS["distal"], LINK_RADIUS, DISTAL, direction),
        make_tip(f"{name}_tip", MASS["tip"], TIP_RADIUS),
    ]
    joints = [
        joint("proximal", "palm", root),
        joint("distal", f"{name}_proximal_link", make_pose(axis_point(direction, PROXIMAL))),
        make_tip_mount(name, f"{name}_distal_link", make_pose(axis_point(direction, DISTAL))),
    ]
    return links, joints


def upright(name: str, n: int) -> Any:
    """N fingers around a circle on a round palm, pointing along +z; positive angles turn them inward."""
    ranges = {"proximal": (-0.5, 1.6), "distal": (0.0, 1.9)}
    angles = [2 * pi * i / n for i in range(n)]
    return make_robot(
        name,
        make_palm(MASS["palm"], PALM_RADIUS, PALM_HEIGHT, PALM_HEIGHT / 2),
        [
            finger(
                f"finger_{i + 1}",
                make_pose((CIRCLE * cos(a), CIRCLE * sin(a), 0.0), (0.0, 0.0, a)),
                "z",
                (0.0, -1.0, 0.0),
                ranges,
            )
            for i, a in enumerate(angles)
        ],
    )


def ring(name: str, n: int) -> Any:
    """N fingers in the xy plane, pointing at the centre; their joints turn about the world's z axis."""
    height = 0.010
    ranges = {"proximal": (-1.2, 1.2), "distal": (-1.9, 1.9)}
    angles = [2 * pi * i / n for i in range(n)]
    return make_robot(
        name,
        make_palm(0.4, RING, height, 2 * height),
        [
            finger(
                f"finger_{i + 1}",
                make_pose((RING * cos(a), RING * sin(a), 0.0), (0.0, 0.0, a + pi)),
                "x",
                (0.0, 0.0, 1.0),
                ranges,
            )
            for i, a in enumerate(angles)
        ],
    )


HANDS = {
    "two_finger": lambda: upright("two_finger", 2),
    "three_finger": lambda: upright("three_finger", 3),
    "five_finger": lambda: upright("five_finger", 5),
    "planar_ring": lambda: ring("planar_ring", 6),
}


def text(name: str) -> bytes:
    """The URDF of one hand as the bytes of its file."""
    return format_urdf(HANDS[name](), "Written by urdf/generate.py: change that, not this.")


def main(folder: Path) -> None:
    """Write all of them."""
    for name in HANDS:
        (folder / f"{name}.urdf").write_bytes(text(name))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
