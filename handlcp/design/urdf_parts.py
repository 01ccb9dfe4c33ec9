"""`make_link` and its like: links, fingertips, palms and joints of hands as yourdfpy's objects, and their text.

A finger link lies along its z or x axis, from its joint on. yourdfpy takes long to import: this file is imported by
functions, when they need it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from math import cos, pi, sin
from typing import Any

import numpy as np
from yourdfpy import urdf as u

from handlcp.check import Array

GREY = u.Material(name="grey", color=u.Color(rgba=np.array([0.45, 0.47, 0.50, 1.0])))
STEEL = u.Material(name="steel", color=u.Color(rgba=np.array([0.72, 0.74, 0.77, 1.0])))
RUBBER = u.Material(name="rubber", color=u.Color(rgba=np.array([0.15, 0.16, 0.18, 1.0])))

Vector = tuple[float, float, float]

# ---------------------------------------------------------------- Placements, masses, shapes.


def make_pose(xyz: Vector = (0.0, 0.0, 0.0), rpy: Vector = (0.0, 0.0, 0.0)) -> Array:
    """A 4×4 placement; URDF's roll, pitch and yaw about fixed axes."""
    (r, p, y), T = rpy, np.eye(4)
    Rx = np.array([[1, 0, 0], [0, cos(r), -sin(r)], [0, sin(r), cos(r)]])
    Ry = np.array([[cos(p), 0, sin(p)], [0, 1, 0], [-sin(p), 0, cos(p)]])
    Rz = np.array([[cos(y), -sin(y), 0], [sin(y), cos(y), 0], [0, 0, 1]])
    T[:3, :3], T[:3, 3] = Rz @ Ry @ Rx, xyz
    return T


def axis_point(direction: str, distance: float) -> Vector:
    """A point on the finger's own axis, "x" or "z"."""
    return (distance, 0.0, 0.0) if direction == "x" else (0.0, 0.0, distance)


def make_inertial(mass: float, principal: Vector, at: Array) -> Any:
    """A body with principal moments [kg·m²] along the axes of `at`."""
    return u.Inertial(origin=at, mass=mass, inertia=np.diag([float(f"{i:.6g}") for i in principal]))


def cylinder_inertia(mass: float, radius: float, length: float) -> Vector:
    """Principal moments of a solid cylinder about its centre, axis z."""
    across = mass * (3 * radius**2 + length**2) / 12
    return (across, across, mass * radius**2 / 2)


def make_cylinder(radius: float, length: float) -> Any:
    """A cylinder along z, about its centre; radius and length [m]."""
    return u.Geometry(cylinder=u.Cylinder(radius=radius, length=length))


def make_ball(radius: float) -> Any:
    """A ball about the origin; radius [m]."""
    return u.Geometry(sphere=u.Sphere(radius=radius))


def _make_collision(at: Array, shape: Any) -> Any:
    return u.Collision(name=None, origin=at, geometry=shape)


def _make_visual(at: Array, shape: Any, material: Any) -> Any:
    return u.Visual(name=None, origin=at, geometry=shape, material=material)


# ---------------------------------------------------------------- Links.


def make_palm(mass: float, radius: float, height: float, middle: float) -> Any:
    """A palm is a disc across z, its middle so far below the origin; mass [kg], lengths [m]."""
    at, disc = make_pose((0.0, 0.0, -middle)), make_cylinder(radius, height)
    moments = make_inertial(mass, cylinder_inertia(mass, radius, height), at)
    return u.Link(
        name="palm", inertial=moments, visuals=[_make_visual(at, disc, GREY)], collisions=[_make_collision(at, disc)]
    )


def make_link(name: str, mass: float, radius: float, length: float, direction: str, rounded: bool = False) -> Any:
    """A finger link is a cylinder from its joint on, with a ball at the joint.

    mass : [kg]. radius, length : [m].
    direction : axis of the finger, "x" or "z".
    rounded : whether the ball touches, too; else it is only drawn. The next part of the finger brings the ball at the
        other end of such a capsule, a shape that URDFs do not have.
    """
    middle = make_pose(axis_point(direction, length / 2), (0.0, pi / 2 if direction == "x" else 0.0, 0.0))
    shaft = make_cylinder(radius, length)
    knuckle = [_make_collision(make_pose(), make_ball(radius))] if rounded else []
    return u.Link(
        name=name,
        inertial=make_inertial(mass, cylinder_inertia(mass, radius, length), middle),
        visuals=[_make_visual(middle, shaft, STEEL), _make_visual(make_pose(), make_ball(radius * 1.2), GREY)],
        collisions=[_make_collision(middle, shaft), *knuckle],
    )


def make_tip(name: str, mass: float, radius: float) -> Any:
    """A fingertip is a rubber ball about its frame; mass [kg], radius [m]."""
    moment = 0.4 * mass * radius**2
    return u.Link(
        name=name,
        inertial=make_inertial(mass, (moment, moment, moment), make_pose()),
        visuals=[_make_visual(make_pose(), make_ball(radius), RUBBER)],
        collisions=[_make_collision(make_pose(), make_ball(radius))],
    )


# ---------------------------------------------------------------- Joints, and the robot.


def make_revolute_joint(
    name: str,
    parent: str,
    origin: Array,
    axis: Vector,
    effort: float,
    speed: float,
    ends: tuple[float, float],
    follows: tuple[str, float] | None = None,
) -> Any:
    """A revolute joint that carries the link of its own name.

    parent : name of the link that it is on.
    origin : (4, 4) placement in the parent's frame. axis : (3,) in its own frame.
    effort : [N·m]. speed : [rad/s]. ends : of its range [rad].
    follows : another joint, and how far this one turns for each radian of that; None: it is free.
    """
    mimic = None if follows is None else u.Mimic(joint=follows[0], multiplier=follows[1])
    limit = u.Limit(effort=effort, velocity=speed, lower=ends[0], upper=ends[1])
    return u.Joint(
        name=name,
        type="revolute",
        parent=parent,
        child=f"{name}_link",
        origin=origin,
        axis=np.array(axis),
        limit=limit,
        mimic=mimic,
    )


def make_tip_mount(finger: str, parent: str, origin: Array) -> Any:
    """What fixes the fingertip of a finger to its last link."""
    return u.Joint(name=f"{finger}_tip_mount", type="fixed", parent=parent, child=f"{finger}_tip", origin=origin)


def make_robot(name: str, base: Any, fingers: Sequence[tuple[list[Any], list[Any]]]) -> Any:
    """A palm and its fingers, links and joints of each."""
    links, joints = [base], []
    for more_links, more_joints in fingers:
        links += more_links
        joints += more_joints
    return u.Robot(name=name, links=links, joints=joints, materials=[])


# ---------------------------------------------------------------- Text.


def format_urdf(made: Any, written_by: str) -> bytes:
    """The URDF of a robot as the bytes of its file: what yourdfpy writes, indented, with tidy numbers.

    written_by : a line for people, at its head.
    """
    model = u.URDF(robot=made, build_scene_graph=False, load_meshes=False)
    model.validate()
    root = ET.fromstring(model.write_xml_string())
    for element, joint in zip(root.findall("joint"), made.joints, strict=True):
        if joint.mimic is not None:  # which yourdfpy 0.0.60 reads and does not write
            ET.SubElement(element, "mimic", joint=joint.mimic.joint, multiplier=str(joint.mimic.multiplier))
    for element in root.iter():
        for key, value in element.attrib.items():
            if key not in ("name", "type", "link", "joint"):
                element.set(key, " ".join(_round_number(number) for number in value.split()))
    ET.indent(root, "  ")
    header = f'<?xml version="1.0" encoding="UTF-8"?>\n<!-- {written_by} -->\n'.encode()
    return header + ET.tostring(root) + b"\n"


def _round_number(number: str) -> str:
    """The number rounded to twelve decimals, so that every libm gives the same text, without -0.0."""
    return f"{round(float(number), 12) + 0.0:.12g}"
