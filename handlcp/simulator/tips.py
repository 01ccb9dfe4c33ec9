"""What touches the object: fingertips, or the places on links that touch, each on a pad of its own.

A pad is a body on up to three sprung slides, along the axes in which it gives way. Its flexibility is a matrix in the
axes of the tip frame; its eigenvectors are the slides, and a direction in which it is rigid has none. It carries the
shapes of its fingertip. A shape that touches at a ball, a line or a face of its own alone (`Swept`) is written as
that: a sphere, a capsule, a thin box below the face. Where a corner of the object stands on a face it is the corner,
a small ball at the object's body, that touches.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import coal
import numpy as np

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.hand.objects.detect import nearest
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture
from handlcp.hand.robot.tip_geometry import TipShape
from handlcp.hand.sites.patch import patch
from handlcp.simulator.settings import SimulatorSettings, add, add_shape, axes_along, placed

_MASS, _INERTIA = 1e-4, 1e-8  # [kg, kg·m²] of a pad's body, without weight
_NONE = 1e-12  # of the largest flexibility: less is rounding, and rigid
_THIN = 5e-4  # [m] of the box below a face
CORNER = 1e-4  # [m] radius of the balls that are corners of the object
_NEAR = 1e-3  # [m] a shape of a fingertip that is farther from the object does not touch it


def pad_of(name: str) -> str:
    """The name of the body of a fingertip's pad."""
    return f"{name} pad"


def add_tip(
    root: ET.Element, body: ET.Element, hand: HandModel, tip: int, obj: Object, settings: SimulatorSettings
) -> tuple[str, ...]:
    """The fingertip numbered `tip` below the body of its link: the names of its shapes."""
    name, at = hand.fingertips[tip], hand.tips.places[tip].placement
    below = add(body, "body", name=pad_of(name), gravcomp=1.0, **placed(at.rotation, at.translation))
    pad = hand.pads.blocks[tip]
    if hand.tips.places[tip].joint or not pad.any():
        add_pad(below, pad_of(name), pad, settings)
    else:
        add_pad(below, pad_of(name), pad, settings, weighty(pad, settings))
    names = list[str]()
    for k, shape in enumerate(hand.tip_shapes(tip)):
        names.append(f"{name} ({k + 1})" if k else name)
        faced = shape.radius is None and shape.face is not None and (obj.known is not None or shape.corner is not None)
        add_shape(below, name=names[-1], **(_face_words(shape) if faced else _whole(root, names[-1], shape)))
    return tuple(names)


def add_corner(body: ET.Element, posture: Posture, tip: int, obj: Object) -> str | None:
    """At the object's body, the corner that stands on the fingertip numbered `tip`: its name. None: it has none."""
    (shape, *_), name = posture.hand.tip_shapes(tip), f"{posture.hand.fingertips[tip]} corner"
    if shape.corner is None:
        return None
    normal = nearest((shape,), posture.tip_positions[tip], posture.tip_rotations[tip], obj).normal
    centre = obj.placement.actInv(obj.frame[0] @ shape.corner + obj.frame[1] + CORNER * normal)
    add_shape(body, name=name, type="sphere", size=[CORNER], pos=centre)
    return name


def add_pad(body: ET.Element, name: str, flexibility: Array, settings: SimulatorSettings, mass: float = _MASS) -> None:
    """Slides of a body, with springs that make a flexibility (3, 3) [m/N] in its axes. mass : [kg] of the body, without
    weight.
    """
    values, vectors = np.linalg.eigh(flexibility)
    if not (abs(flexibility - flexibility[0, 0] * np.eye(3)) > _NONE * abs(flexibility).max()).any():
        vectors = np.eye(3)
    soft = np.flatnonzero(values > _NONE * abs(values).max())
    for count, i in enumerate(soft, 1):
        k = 1 / values[i]
        add(body, "joint", name=f"{name} {count}", type="slide", axis=vectors[:, i], stiffness=k, **settings.damped(k))
    add(body, "inertial", pos=np.zeros(3), mass=mass, diaginertia=np.full(3, _INERTIA))


def weighty(flexibility: Array, settings: SimulatorSettings) -> float:
    """[kg] of a pad on slides that no joint moves. MuJoCo makes contacts as stiff as bodies are heavy, and there it
    does not count the armature of slides (`body_invweight0`).
    """
    return settings.damped(1.0 / float(abs(flexibility).max()))["armature"]


# ----------------------------------------------------------------
# Shapes.


def _whole(root: ET.Element, name: str, shape: TipShape) -> dict[str, Any]:
    return placed(shape.rotation, shape.translation) | shape_words(root, name, shape.geometry)


def _face_words(shape: TipShape) -> dict[str, Any]:
    """Attributes of a geom that is the face of a shape."""
    face = shape.face
    assert face is not None  # the caller saw to it
    half = np.linalg.norm(face.spans, axis=1)
    lines = np.flatnonzero(half > 0.0)
    if not len(lines):
        return {"type": "sphere", "pos": face.centre, "size": [face.radius]}
    x = face.spans[lines[0]] / half[lines[0]]
    if len(lines) == 1:
        words = placed(axes_along(x), face.centre)
        return words | {"type": "capsule", "size": [face.radius, half[lines[0]]]}
    y = face.spans[1] / half[1]
    normal = np.cross(x, y)
    inward = normal * np.copysign(1.0, normal @ (shape.translation - face.centre))
    thick = 0.5 * _THIN + face.radius
    centre = face.centre + (thick - face.radius) * inward
    return placed(np.stack([x, y, normal], axis=1), centre) | {"type": "box", "size": [half[0], half[1], thick]}


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
            add(
                add(root, "asset") if assets is None else assets,
                "mesh",
                name=name,
                vertex=np.array(geometry.points(), dtype=float),
            )
            return {"type": "mesh", "mesh": name}
    raise Unsupported(f"the shape {type(geometry).__name__} of {name!r} cannot be written")


def round_shape(geometry: Any) -> bool:
    """Whether the shape touches any convex shape in one point."""
    return isinstance(geometry, coal.Sphere | coal.Ellipsoid)


def check_points(posture: Posture, tip: int, obj: Object) -> None:
    """Whether a fingertip touches the object in one point, where the hand is. Raises Unsupported."""
    if round_shape(obj.geometry) or posture.hand.links_of_sites is not None:
        return
    p, R = posture.tip_positions[tip], posture.tip_rotations[tip]
    for shape in posture.hand.tip_shapes(tip):
        if round_shape(shape.geometry) or nearest((shape,), p, R, obj).gap > _NEAR:
            continue
        if len(patch(shape, p, R, obj)) > 1:
            name = posture.hand.fingertips[tip]
            raise Unsupported(
                f"fingertip {name!r} and the object touch along a line or on a patch: give it a tip_radius, or pass "
                'links="all", where each of its corners is a contact'
            )
