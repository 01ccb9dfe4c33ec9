"""Write the four hands of this folder, byte for byte the same every time: `python urdf/generate.py [folder]`.

Every finger has two joints and links of 50 mm and 40 mm that end in a ball of 8 mm radius about the tip frame. Three
hands stand their fingers on a round palm (two, three and five of them), pointing along +z; positive angles close the
hand. The fourth is a ring of six fingers that lie in the xy plane and point at its centre, with joints about z. World
frame: the palm's.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from math import cos, pi, sin
from pathlib import Path

import numpy as np
from yourdfpy import urdf as u

PROXIMAL, DISTAL = 0.050, 0.040  # link lengths [m]
LINK_RADIUS, TIP_RADIUS = 0.007, 0.008  # [m]
MASS = {"palm": 0.250, "proximal": 0.025, "distal": 0.018, "tip": 0.003}  # [kg]: small geared motors in plastic links
EFFORT = {"proximal": 0.8, "distal": 0.4}  # [N·m]
SPEED = 6.0  # [rad/s]
PALM_RADIUS, PALM_HEIGHT = 0.055, 0.020  # [m]
CIRCLE = 0.045  # where the fingers stand on the palm [m]
RING = 0.120  # where the fingers stand on the ring [m]

GREY = u.Material(name="grey", color=u.Color(rgba=np.array([0.45, 0.47, 0.50, 1.0])))
STEEL = u.Material(name="steel", color=u.Color(rgba=np.array([0.72, 0.74, 0.77, 1.0])))
RUBBER = u.Material(name="rubber", color=u.Color(rgba=np.array([0.15, 0.16, 0.18, 1.0])))

Vector = tuple[float, float, float]


def pose(xyz: Vector = (0.0, 0.0, 0.0), rpy: Vector = (0.0, 0.0, 0.0)) -> np.ndarray:
    """A 4×4 placement; URDF's roll, pitch and yaw about fixed axes."""
    (r, p, y), T = rpy, np.eye(4)
    Rx = np.array([[1, 0, 0], [0, cos(r), -sin(r)], [0, sin(r), cos(r)]])
    Ry = np.array([[cos(p), 0, sin(p)], [0, 1, 0], [-sin(p), 0, cos(p)]])
    Rz = np.array([[cos(y), -sin(y), 0], [sin(y), cos(y), 0], [0, 0, 1]])
    T[:3, :3], T[:3, 3] = Rz @ Ry @ Rx, xyz
    return T


def inertial(mass: float, principal: Vector, at: np.ndarray) -> u.Inertial:
    """A body with principal moments [kg·m²] along the axes of `at`."""
    return u.Inertial(origin=at, mass=mass, inertia=np.diag([float(f"{i:.6g}") for i in principal]))


def cylinder_inertia(mass: float, radius: float, length: float) -> Vector:
    """Principal moments of a solid cylinder about its centre, axis z."""
    across = mass * (3 * radius**2 + length**2) / 12
    return (across, across, mass * radius**2 / 2)


def cylinder(radius: float, length: float) -> u.Geometry:
    """Along z, about its centre."""
    return u.Geometry(cylinder=u.Cylinder(radius=radius, length=length))


def ball(radius: float) -> u.Geometry:
    """About the origin."""
    return u.Geometry(sphere=u.Sphere(radius=radius))


def along(direction: str, distance: float) -> Vector:
    """A point on the finger's own axis."""
    return (distance, 0.0, 0.0) if direction == "x" else (0.0, 0.0, distance)


def link(name: str, kind: str, length: float, direction: str) -> u.Link:
    """A finger link along its x or z axis: a cylinder with a ball at its joint."""
    middle = pose(along(direction, length / 2), (0.0, pi / 2 if direction == "x" else 0.0, 0.0))
    shaft = cylinder(LINK_RADIUS, length)
    return u.Link(
        name=name,
        inertial=inertial(MASS[kind], cylinder_inertia(MASS[kind], LINK_RADIUS, length), middle),
        visuals=[
            u.Visual(name=None, origin=middle, geometry=shaft, material=STEEL),
            u.Visual(name=None, origin=pose(), geometry=ball(LINK_RADIUS * 1.2), material=GREY),
        ],
        collisions=[u.Collision(name=None, origin=middle, geometry=shaft)],
    )


def tip(name: str) -> u.Link:
    """The fingertip: a rubber ball about its frame."""
    moment = 0.4 * MASS["tip"] * TIP_RADIUS**2
    return u.Link(
        name=name,
        inertial=inertial(MASS["tip"], (moment, moment, moment), pose()),
        visuals=[u.Visual(name=None, origin=pose(), geometry=ball(TIP_RADIUS), material=RUBBER)],
        collisions=[u.Collision(name=None, origin=pose(), geometry=ball(TIP_RADIUS))],
    )


def finger(
    name: str, root: np.ndarray, direction: str, axis: Vector, ranges: dict[str, tuple[float, float]]
) -> tuple[list[u.Link], list[u.Joint]]:
    """Links and joints of one finger that stands at `root` on the palm, pointing along root's x or z axis."""

    def revolute(kind: str, parent: str, origin: np.ndarray) -> u.Joint:
        lower, upper = ranges[kind]
        return u.Joint(
            name=f"{name}_{kind}",
            type="revolute",
            parent=parent,
            child=f"{name}_{kind}_link",
            origin=origin,
            axis=np.array(axis),
            limit=u.Limit(effort=EFFORT[kind], velocity=SPEED, lower=lower, upper=upper),
        )

    links = [
        link(f"{name}_proximal_link", "proximal", PROXIMAL, direction),
        link(f"{name}_distal_link", "distal", DISTAL, direction),
        tip(f"{name}_tip"),
    ]
    joints = [
        revolute("proximal", "palm", root),
        revolute("distal", f"{name}_proximal_link", pose(along(direction, PROXIMAL))),
        u.Joint(
            name=f"{name}_tip_mount",
            type="fixed",
            parent=f"{name}_distal_link",
            child=f"{name}_tip",
            origin=pose(along(direction, DISTAL)),
        ),
    ]
    return links, joints


def robot(name: str, palm: u.Link, fingers: Sequence[tuple[list[u.Link], list[u.Joint]]]) -> u.Robot:
    """Palm and fingers."""
    links, joints = [palm], []
    for more_links, more_joints in fingers:
        links += more_links
        joints += more_joints
    return u.Robot(name=name, links=links, joints=joints, materials=[])


def upright(name: str, n: int) -> u.Robot:
    """N fingers around a circle on a round palm, pointing along +z; positive angles turn them inward."""
    below = pose((0.0, 0.0, -PALM_HEIGHT / 2))
    disc = cylinder(PALM_RADIUS, PALM_HEIGHT)
    palm = u.Link(
        name="palm",
        inertial=inertial(MASS["palm"], cylinder_inertia(MASS["palm"], PALM_RADIUS, PALM_HEIGHT), below),
        visuals=[u.Visual(name=None, origin=below, geometry=disc, material=GREY)],
        collisions=[u.Collision(name=None, origin=below, geometry=disc)],
    )
    ranges = {"proximal": (-0.5, 1.6), "distal": (0.0, 1.9)}
    angles = [2 * pi * i / n for i in range(n)]
    return robot(
        name,
        palm,
        [
            finger(
                f"finger_{i + 1}",
                pose((CIRCLE * cos(a), CIRCLE * sin(a), 0.0), (0.0, 0.0, a)),
                "z",
                (0.0, -1.0, 0.0),
                ranges,
            )
            for i, a in enumerate(angles)
        ],
    )


def ring(name: str, n: int) -> u.Robot:
    """N fingers in the xy plane, pointing at the centre; their joints turn about the world's z axis."""
    height = 0.010
    below = pose((0.0, 0.0, -2 * height))
    disc = cylinder(RING, height)
    palm = u.Link(
        name="palm",
        inertial=inertial(0.4, cylinder_inertia(0.4, RING, height), below),
        visuals=[u.Visual(name=None, origin=below, geometry=disc, material=GREY)],
        collisions=[u.Collision(name=None, origin=below, geometry=disc)],
    )
    ranges = {"proximal": (-1.2, 1.2), "distal": (-1.9, 1.9)}
    angles = [2 * pi * i / n for i in range(n)]
    return robot(
        name,
        palm,
        [
            finger(
                f"finger_{i + 1}",
                pose((RING * cos(a), RING * sin(a), 0.0), (0.0, 0.0, a + pi)),
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


def tidy(number: str) -> str:
    """Twelve decimals: the same text from every libm, and no -0.0."""
    return f"{round(float(number), 12) + 0.0:.12g}"


def text(name: str) -> bytes:
    """The URDF of one hand as the bytes of its file: what yourdfpy writes, indented, with tidy numbers."""
    model = u.URDF(robot=HANDS[name](), build_scene_graph=False, load_meshes=False)
    model.validate()
    root = ET.fromstring(model.write_xml_string())
    for element in root.iter():
        for key, value in element.attrib.items():
            if key not in ("name", "type", "link"):
                element.set(key, " ".join(tidy(number) for number in value.split()))
    ET.indent(root, "  ")
    header = b'<?xml version="1.0" encoding="UTF-8"?>\n<!-- Written by urdf/generate.py: change that, not this. -->\n'
    return header + ET.tostring(root) + b"\n"


def main(folder: Path) -> None:
    """Write all of them."""
    for name in HANDS:
        (folder / f"{name}.urdf").write_bytes(text(name))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
