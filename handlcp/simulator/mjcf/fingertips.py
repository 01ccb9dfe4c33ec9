"""Fingertips: one shape each, on a pad of up to three sprung slides along the axes in which the pad gives way.

A pad's flexibility is a matrix in the axes of the tip frame; its eigenvectors are the slides, and a direction in which
it is rigid has none.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.tip_geometry import TipShape
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.mjcf.words import add, placed

_MASS, _INERTIA = 1e-4, 1e-8  # [kg, kg·m²] of a pad's body, without weight
_NONE = 1e-12  # of the largest flexibility of a pad: a direction with less is rigid


def add_tip(
    root: ET.Element, body: ET.Element, hand: HandModel, tip: int, settings: SimulatorSettings
) -> tuple[str, TipShape]:
    """The fingertip numbered `tip` below the body of its link: the name of its shape, and the shape.

    Raises Unsupported for a fingertip of several shapes.
    """
    name, frame = hand.fingertips[tip], hand.kinematics.model.frames[hand.tips.frames[tip]]
    shapes = hand.tip_shapes(tip)
    if len(shapes) != 1:
        raise Unsupported(f"fingertip {name!r} has {len(shapes)} shapes: give it one, such as a tip_radius")
    at = frame.placement
    below = add(body, "body", name=f"{name} pad", gravcomp=1.0, **placed(at.rotation, at.translation))
    add_pad(below, f"{name} pad", hand.pads.blocks[tip], settings)
    shape = shapes[0]
    words = shape_words(root, name, shape.geometry)
    add(
        below,
        "geom",
        name=name,
        contype="0",
        conaffinity="0",
        mass=0.0,
        **placed(shape.rotation, shape.translation),
        **words,
    )
    return name, shape


def add_pad(body: ET.Element, name: str, flexibility: Array, settings: SimulatorSettings, mass: float = _MASS) -> None:
    """Slides of a body, with springs that make a flexibility (3, 3) [m/N] in its axes. mass : [kg] of the body, without
    weight.
    """
    values, vectors = np.linalg.eigh(flexibility)
    if not (abs(flexibility - flexibility[0, 0] * np.eye(3)) > _NONE * abs(flexibility).max()).any():
        vectors = np.eye(3)
    soft = np.flatnonzero(values > _NONE * abs(values).max())
    for count, i in enumerate(soft, 1):
        add(
            body,
            "joint",
            name=f"{name} {count}",
            type="slide",
            axis=vectors[:, i],
            stiffness=1 / values[i],
            **settings.damped(1 / values[i]),
        )
    add(body, "inertial", pos=np.zeros(3), mass=mass, diaginertia=np.full(3, _INERTIA))


def shape_words(root: ET.Element, name: str, geometry: Any) -> dict[str, Any]:
    """Attributes of a geom with coal's shape; a hull becomes a mesh in the assets. Raises Unsupported."""
    match geometry:
        case coal.Sphere():
            return {"type": "sphere", "size": [geometry.radius]}
        case coal.Box():
            return {"type": "box", "size": np.array(geometry.halfSide)}
        case coal.Capsule():
            return {"type": "capsule", "size": [geometry.radius, geometry.halfLength]}
        case coal.Cylinder():
            return {"type": "cylinder", "size": [geometry.radius, geometry.halfLength]}
        case coal.Ellipsoid():
            return {"type": "ellipsoid", "size": np.array(geometry.radii)}
        case coal.ConvexBase():
            assets = root.find("asset")
            add(add(root, "asset") if assets is None else assets, "mesh", name=name, vertex=convex_points(geometry))
            return {"type": "mesh", "mesh": name}
    raise Unsupported(f"the shape {type(geometry).__name__} of {name!r} cannot be written")


def convex_points(geometry: Any) -> Array:
    """(m, 3) corners of a convex hull [m]."""
    return np.array(geometry.points(), dtype=float).reshape(-1, 3)


def round_shape(geometry: Any) -> bool:
    """Whether the shape touches any convex shape in one point."""
    return isinstance(geometry, coal.Sphere | coal.Ellipsoid)
