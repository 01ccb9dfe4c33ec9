"""Other lengths, axes and places in the <robot> of a hand, which is changed in place."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand.robot.source.description import COLLISION, VISUAL
from handlcp.hand.robot.source.part import numbers_of, origin_of
from handlcp.hand.robot.urdf import link_of
from handlcp.hand.vary.stretch import Stretch


def put_joint(root: ET.Element, name: str, position: Array) -> None:
    """A joint stands elsewhere, (3,) [m] in its parent's frame."""
    _place(_joint(root, name), position)


def turn_joint(root: ET.Element, name: str, axis: Array) -> None:
    """A joint turns about, or slides along, another axis (3,), a unit vector in its own frame."""
    joint = _joint(root, name)
    element = joint.find("axis")
    (ET.SubElement(joint, "axis") if element is None else element).set("xyz", _text(axis))


def stretch_links(root: ET.Element, model: Any, stretches: Mapping[int, Stretch]) -> list[str]:
    """Links of other lengths, by the number of the joint that moves them; model : Pinocchio's of this robot.

    Returns the names of links with meshes that keep their shape, as none of their axes runs along the length.
    """
    own, kept = dict[str, Stretch](), list[str]()
    for frame in model.frames:
        stretch = stretches.get(int(frame.parentJoint))
        local = None if stretch is None else stretch.in_link(frame.placement)
        if frame.type == pin.FrameType.BODY and local is not None:
            own[frame.name] = local
    for link in root.findall("link"):
        if (local := own.get(link.get("name", ""))) is None:
            continue
        for element in link:
            if element.tag == "inertial":
                _place(element, local.point(origin_of(element)[1]))
            elif element.tag in (COLLISION, VISUAL) and not _stretch_shape(element, local):
                kept.append(link.get("name", ""))
    for joint in root.findall("joint"):
        if (local := own.get(link_of(joint, "parent"))) is not None:
            _place(joint, local.point(origin_of(joint)[1]))
    return list(dict.fromkeys(kept))


def _stretch_shape(element: ET.Element, stretch: Stretch) -> bool:
    """One <collision> or <visual>; False for a mesh that keeps its shape."""
    R, p = origin_of(element)
    for shape in element.iterfind("geometry/cylinder"):
        length = float(shape.get("length", 0.0))
        p, sizes = stretch.solid(R[:, [2]], p, np.array([length]))
        shape.set("length", _text(sizes))
        _place(element, p)
        return True
    for shape in element.iterfind("geometry/box"):
        p, sizes = stretch.solid(R, p, numbers_of(shape.get("size", "0 0 0")))
        shape.set("size", _text(sizes))
        _place(element, p)
        return True
    for shape in element.iterfind("geometry/mesh"):
        made = stretch.mesh(R, p, numbers_of(shape.get("scale", "1 1 1")))
        if made is not None:
            shape.set("scale", _text(made[1]))
            _place(element, made[0])
        return made is not None
    _place(element, stretch.point(p))
    return True


def _joint(root: ET.Element, name: str) -> ET.Element:
    return next(joint for joint in root.findall("joint") if joint.get("name") == name)


def _place(element: ET.Element, position: Array) -> None:
    origin = element.find("origin")
    (ET.SubElement(element, "origin") if origin is None else origin).set("xyz", _text(position))


def _text(values: Array) -> str:
    """So that the same numbers come back."""
    return " ".join([repr(v) for v in values.tolist()])
