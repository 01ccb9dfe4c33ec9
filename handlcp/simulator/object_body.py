"""`add_object`: what touches the object: fingertips, or the places on links that touch, each on a pad of its own.

A pad is a body on up to three sprung slides, along the axes in which it gives way. Its flexibility is a matrix in the
axes of the tip frame; its eigenvectors are the slides, and a direction in which it is rigid has none. It carries the
shapes of its fingertip. A shape that touches at a ball, a line or a face of its own alone (`SweptBall`) is written as
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
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.geometry.contact_patch import find_contact_patch
from handlcp.geometry.object import Object
from handlcp.grasp.model.request import GraspSpec
from handlcp.robot.fingertip import TipShape
from handlcp.robot.hand_model import HandModel, HandPosture
from handlcp.simulator.settings import SimulatorSettings, add_element, add_shape, axes_along, placement_attributes

_PAD_MASS, _PAD_INERTIA = 1e-4, 1e-8  # [kg, kg·m²] of a pad's body, without weight
_FLEXIBILITY_ROUNDING = 1e-12  # of the largest flexibility: less is rounding, and rigid
_FACE_THICKNESS = 5e-4  # [m] of the box below a face
CORNER_BALL_RADIUS = 1e-4  # [m] radius of the balls that are corners of the object
_MAX_TIP_GAP = 1e-3  # [m] a shape of a fingertip that is farther from the object does not touch it


def pad_name(name: str) -> str:
    """The name of the body of a fingertip's pad."""
    return f"{name} pad"


def add_tip(
    root: ET.Element, body: ET.Element, hand: HandModel, tip: int, obj: Object, settings: SimulatorSettings
) -> tuple[str, ...]:
    """The fingertip numbered `tip` below the body of its link: the names of its shapes."""
    name, at, pad = hand.fingertips[tip], hand.tips.places[tip].placement, hand.pads.blocks[tip]
    where = placement_attributes(at.rotation, at.translation)
    below = add_element(body, "body", name=pad_name(name), gravcomp=1.0, **where)
    moved = hand.tips.places[tip].joint or not pad.any()
    add_pad(below, pad_name(name), pad, settings, _PAD_MASS if moved else free_pad_mass(pad, settings))
    names = list[str]()
    for k, shape in enumerate(hand.tip_shapes(tip)):
        names.append(f"{name} ({k + 1})" if k else name)
        faced = shape.radius is None and shape.face is not None and (obj.known is not None or shape.corner is not None)
        whole = placement_attributes(shape.rotation, shape.translation)
        words = _face_attributes(shape) if faced else whole | geometry_attributes(root, names[-1], shape.geometry)
        add_shape(below, name=names[-1], **words)
    return tuple(names)


def add_corner(body: ET.Element, posture: HandPosture, tip: int, obj: Object) -> str | None:
    """At the object's body, the corner that stands on the fingertip numbered `tip`: its name. None: it has none."""
    (shape, *_), name = posture.hand.tip_shapes(tip), f"{posture.hand.fingertips[tip]} corner"
    if shape.corner is None:
        return None
    normal = nearest_proximity((shape,), posture.tip_positions[tip], posture.tip_rotations[tip], obj).normal
    centre = obj.placement.actInv(obj.frame[0] @ shape.corner + obj.frame[1] + CORNER_BALL_RADIUS * normal)
    add_shape(body, name=name, type="sphere", size=[CORNER_BALL_RADIUS], pos=centre)
    return name


def add_pad(
    body: ET.Element, name: str, flexibility: Array, settings: SimulatorSettings, mass: float = _PAD_MASS
) -> None:
    """Slides of a body, with springs that make a flexibility (3, 3) [m/N] in its axes. mass : [kg] of the body, without
    weight.
    """
    values, vectors = np.linalg.eigh(flexibility)
    if not (abs(flexibility - flexibility[0, 0] * np.eye(3)) > _FLEXIBILITY_ROUNDING * abs(flexibility).max()).any():
        vectors = np.eye(3)
    soft = np.flatnonzero(values > _FLEXIBILITY_ROUNDING * abs(values).max())
    for count, i in enumerate(soft, 1):
        k = 1 / values[i]
        slide = {"axis": vectors[:, i], "stiffness": k} | settings.critical_damping(k)
        add_element(body, "joint", name=f"{name} {count}", type="slide", **slide)
    add_element(body, "inertial", pos=np.zeros(3), mass=mass, diaginertia=np.full(3, _PAD_INERTIA))


def free_pad_mass(flexibility: Array, settings: SimulatorSettings) -> float:
    """[kg] of a pad on slides that no joint moves. MuJoCo makes contacts as stiff as bodies are heavy, and there it
    does not count the armature of slides (`body_invweight0`).
    """
    return settings.critical_damping(1.0 / float(abs(flexibility).max()))["armature"]


# ----------------------------------------------------------------
# Shapes.


def _face_attributes(shape: TipShape) -> dict[str, Any]:
    """Attributes of a geom that is the face of a shape."""
    face = shape.face
    assert face is not None  # the caller saw to it
    half = np.linalg.norm(face.spans, axis=1)
    lines = np.flatnonzero(half > 0.0)
    if not len(lines):
        return {"type": "sphere", "pos": face.centre, "size": [face.radius]}
    x = face.spans[lines[0]] / half[lines[0]]
    if len(lines) == 1:
        words = placement_attributes(axes_along(x), face.centre)
        return words | {"type": "capsule", "size": [face.radius, half[lines[0]]]}
    y = face.spans[1] / half[1]
    normal = np.cross(x, y)
    inward = normal * np.copysign(1.0, normal @ (shape.translation - face.centre))
    thick = 0.5 * _FACE_THICKNESS + face.radius
    centre = face.centre + (thick - face.radius) * inward
    where = placement_attributes(np.stack([x, y, normal], axis=1), centre)
    return where | {"type": "box", "size": [half[0], half[1], thick]}


def geometry_attributes(root: ET.Element, name: str, geometry: Any) -> dict[str, Any]:
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
            assets = add_element(root, "asset") if assets is None else assets
            add_element(assets, "mesh", name=name, vertex=np.array(geometry.points(), dtype=float))
            return {"type": "mesh", "mesh": name}
    raise Unsupported(f"the shape {type(geometry).__name__} of {name!r} cannot be written")


def is_round_shape(geometry: Any) -> bool:
    """Whether the shape touches any convex shape in one point."""
    return isinstance(geometry, coal.Sphere | coal.Ellipsoid)


def check_point_contact(posture: HandPosture, tip: int, obj: Object) -> None:
    """Whether a fingertip touches the object in one point, where the hand is. Raises Unsupported."""
    if is_round_shape(obj.geometry) or posture.hand.links_of_sites is not None:
        return
    p, R = posture.tip_positions[tip], posture.tip_rotations[tip]
    for shape in posture.hand.tip_shapes(tip):
        if is_round_shape(shape.geometry) or nearest_proximity((shape,), p, R, obj).gap > _MAX_TIP_GAP:
            continue
        if len(find_contact_patch(shape, p, R, obj)) > 1:
            name = posture.hand.fingertips[tip]
            what = f"fingertip {name!r} and the object touch along a line or on a patch"
            raise Unsupported(
                f'{what}: give it a tip_radius, or pass links="all", where each of its corners is a contact'
            )


# ----------------------------------------------------------------
# The object as a free body that moves quasi-statically; and what it touches besides the hand.


OBJECT_NAME = "object"  # its body, and its shape
LOADED_POINT_NAME = "loaded point"  # body at the point that the load refers to, fixed to the object
_MIN_BODY_MASS = 1e-9  # [kg] of a body without mass, which MuJoCo does not have
_MIN_BODY_LENGTH = 1e-3  # [m]


def add_object(
    root: ET.Element, world: ET.Element, obj: Object, spec: GraspSpec, settings: SimulatorSettings
) -> ET.Element:
    """The object's body. In a planar scene it moves in the plane alone.

    It has the mass of the settings, and its own weight: MuJoCo's gravity compensation makes up for the difference.
    """
    at, moving = obj.placement, settings.object_mass
    where = placement_attributes(at.rotation, at.translation)
    body = add_element(world, "body", name=OBJECT_NAME, gravcomp=1.0 - obj.mass / moving, **where)
    spread = max(float(np.linalg.norm(spec.positions - spec.reference, axis=1).max()), _MIN_BODY_LENGTH)
    inertia = 0.4 * spread**2  # of a ball, for each kilogram
    _add_object_joints(body, at, spec, settings.object_damping, inertia * settings.object_damping)
    centre = at.actInv(np.array(obj.center_of_mass))
    add_element(body, "inertial", pos=centre, mass=moving, diaginertia=np.full(3, moving * inertia))
    add_shape(body, name=OBJECT_NAME, **geometry_attributes(root, OBJECT_NAME, obj.geometry))
    loaded = add_element(body, "body", name=LOADED_POINT_NAME, pos=at.actInv(np.array(spec.reference)), gravcomp=1.0)
    least = np.full(3, _MIN_BODY_MASS * inertia)
    add_element(loaded, "inertial", pos=np.zeros(3), mass=_MIN_BODY_MASS, diaginertia=least)
    return body


def _add_object_joints(body: ET.Element, at: Any, spec: GraspSpec, damping: float, turning: float) -> None:
    """Slides and a turn, all at the point that the motion refers to: a free joint that is damped. In a planar scene two
    slides in the plane and a turn about its normal. Body axes.
    """
    centre = at.actInv(np.array(spec.reference))
    normal = np.array([0.0, 0.0, 1.0]) if spec.plane is None else at.rotation.T @ spec.plane
    x, y, _ = axes_along(normal).T
    slides = {"x": x, "y": y} | ({"z": normal} if spec.plane is None else {})
    for name, axis in slides.items():
        add_element(body, "joint", name=f"{OBJECT_NAME} {name}", type="slide", axis=axis, pos=centre, damping=damping)
    kind: dict[str, Any] = {"type": "ball"} if spec.plane is None else {"type": "hinge", "axis": normal}
    add_element(body, "joint", name=f"{OBJECT_NAME} turn", pos=centre, damping=turning, **kind)


# ----------------------------------------------------------------
# What the object touches besides the hand, as planes.
#
# A contact of the environment is a point of a table or a wall that gives way by itself. On a body with corners or
# rims each such point becomes a small ball at the object, on slides of its own where the support gives way. A ball or
# an ellipsoid rolls: it touches a plane, or where that gives way a block on slides.

_BLOCK_HALF_SIZE = 0.5  # [m] half the size of a block that gives way, far larger than what it carries
_MIN_STANDING_POINTS = 3  # points of a cylinder that stands on its rim; one that lies on its side has fewer


def add_supports(
    world: ET.Element, body: ET.Element, spec: GraspSpec, obj: Object, settings: SimulatorSettings
) -> tuple[tuple[str, str], ...]:
    """Planes in the world and feet at the object's body: the names of the two shapes that touch at each contact, that
    of the ground, which has the name of the contact, and that of the object. Raises Unsupported for supports that share
    their flexibility, and for a cylinder that lies on something flexible.
    """
    k, found = spec.of_hand, list[tuple[str, str]]()
    E = spec.flexibility[3 * k :, 3 * k :]
    cylinder = isinstance(obj.geometry, coal.Cylinder)
    rolls = is_round_shape(obj.geometry) or (cylinder and spec.n - k < _MIN_STANDING_POINTS)
    for i in range(spec.n - k):
        block = E[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
        shared = E[3 * i : 3 * i + 3].copy()
        shared[:, 3 * i : 3 * i + 3] = 0.0
        if shared.any():
            raise Unsupported("contacts of the environment that move under each other's forces cannot be written")
        name, R, point, gap = spec.names[k + i], spec.frames[k + i], spec.positions[k + i], float(spec.offset[k + i, 2])
        surface = placement_attributes(R, point - gap * R[:, 2])
        if rolls and block.any():
            if cylinder:
                lying = "a cylinder that lies on a support that gives way"
                raise Unsupported(f"{lying} cannot be written: its points of contact roll")
            below = add_element(world, "body", name=name, gravcomp=1.0, **surface)
            add_pad(below, name, block, settings, free_pad_mass(block, settings))
            half = np.full(3, _BLOCK_HALF_SIZE)
            add_shape(below, name=name, type="box", pos=(0, 0, -_BLOCK_HALF_SIZE), size=half)
        else:
            add_shape(world, name=name, type="plane", size=(_BLOCK_HALF_SIZE, _BLOCK_HALF_SIZE, 0.01), **surface)
        foot = OBJECT_NAME
        if not rolls:  # a ball whose lowest point is the contact, on slides in the contact's axes
            foot, centre = f"{name} foot", obj.placement.actInv(point + CORNER_BALL_RADIUS * R[:, 2])
            where = placement_attributes(obj.placement.rotation.T @ R, centre)
            ball = add_element(body, "body", name=foot, gravcomp=1.0, **where)
            add_pad(ball, foot, block, settings)
            add_shape(ball, name=foot, type="sphere", size=[CORNER_BALL_RADIUS])
        found.append((name, foot))
    return tuple(found)
