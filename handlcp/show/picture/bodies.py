"""The solids of a picture: the hand's links in their posture, the object, the environment, rods for unknown fingers."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.grasp import Grasp
from handlcp.hand import HandState
from handlcp.hand.robot.urdf import captured_stderr, resolve_meshes
from handlcp.show.picture import shapes

__all__ = ["Body", "environment_bodies", "hand_bodies", "object_body", "stub_bodies"]

Colour = tuple[float, float, float]  # red, green, blue from 0 to 1

HAND, OBJECT, ENVIRONMENT = (0.62, 0.65, 0.69), (0.90, 0.70, 0.30), (0.80, 0.78, 0.74)


@dataclass(frozen=True, slots=True)
class Body:
    """triangles (m, 3, 3) [m], world axes. label : for the legend."""

    triangles: Array
    colour: Colour
    label: str = ""


def hand_bodies(state: HandState) -> list[Body]:
    """All links with their visual geometry, else their collision geometry, else rods between the joints."""
    return _links(state) or _rods(state)


def object_body(grasp: Grasp, obj: Any = None) -> Body | None:
    """The object; the hull of the contacts where the object is not known; None where they span no volume."""
    obj = getattr(grasp, "target", None) if obj is None else obj
    if obj is not None:
        known = obj.triangles if obj.triangles is not None else shapes.of_coal(obj.geometry)
        if known is not None:
            return Body(shapes.placed(known, obj.placement), OBJECT, "object")
    hull = shapes.hull(grasp.scene.positions, 0.3 * grasp.scene.units.length)
    return None if hull is None else Body(hull, OBJECT, "hull of the contacts")


def stub_bodies(grasp: Grasp) -> list[Body]:
    """For a grasp without a hand: a short rod behind each contact of a finger, ending at the contact."""
    size = grasp.scene.units.length
    r = 0.08 * size
    fingers = grasp.scene.n - grasp.scene.environment
    pairs = zip(grasp.scene.positions[:fingers], grasp.scene.frames[:fingers, :, 2], strict=True)
    return [Body(shapes.capsule(p - n * 0.75 * size, p - n * r, r), HAND) for p, n in pairs]


def environment_bodies(grasp: Grasp) -> list[Body]:
    """A slab under each set of environment contacts in one plane, wider by half a grasp's size on every side."""
    scene, out = grasp.scene, []
    size, left = scene.units.length, list(range(scene.n - scene.environment, scene.n))
    thick = 0.1 * size
    while left:
        R, p = scene.frames[left[0]], scene.positions[left[0]]
        local = (scene.positions[left] - p) @ R
        same = (abs(local[:, 2]) < 1e-2 * size) & (scene.frames[left][:, :, 2] @ R[:, 2] > 1 - 1e-6)
        low, high = local[same, :2].min(axis=0) - 0.5 * size, local[same, :2].max(axis=0) + 0.5 * size
        slab = shapes.box([*(high - low), thick]) + np.array([*(low + high) / 2, -thick / 2])
        out.append(Body(slab @ R.T + p, ENVIRONMENT))
        left = [i for i, there in zip(left, same.tolist(), strict=True) if not there]
    return out


def _links(state: HandState) -> list[Body]:
    """Bodies from the hand's URDF; none where it has no geometry, or its meshes cannot be read."""
    root, folders = state.hand.urdf_tree
    if root is None:
        return []
    model, q = state.hand.model, state.hand.kinematics.configuration(state.q)
    for kind, other in ((pin.GeometryType.VISUAL, "collision"), (pin.GeometryType.COLLISION, "visual")):
        drawn = copy.deepcopy(root)
        for link in drawn.findall("link"):
            for element in link.findall(other):
                link.remove(element)  # its meshes may be missing
        try:
            resolve_meshes(drawn, folders)
            with captured_stderr():
                geometry = pin.buildGeomFromUrdfString(model, ET.tostring(drawn, encoding="unicode"), kind)
        except (HandLCPError, ValueError, RuntimeError):
            continue
        placements = pin.GeometryData(geometry)
        pin.updateGeometryPlacements(model, model.createData(), geometry, placements, q)
        found = []
        for item, placement in zip(geometry.geometryObjects, placements.oMg, strict=True):
            if (triangles := shapes.of_coal(item.geometry)) is not None:
                found.append(Body(shapes.placed(triangles, placement), _tint(item)))
        if found:
            return found
    return []


def _tint(item: Any) -> Colour:
    """The URDF's colour, lightened so that arrows stand out."""
    c = np.array(item.meshColor).ravel()[:3] if item.overrideMaterial else np.array(HAND)
    r, g, b = (0.42 + 0.55 * c).tolist()
    return (r, g, b)


def _rods(state: HandState) -> list[Body]:
    """From each joint to the next, and to the fingertips."""
    hand = state.hand
    model = hand.model
    data = model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    at = [np.array(m.translation) for m in data.oMi]
    ends = [(at[model.parents[i]], at[i]) for i in range(1, model.njoints)]
    ends += [(at[model.frames[f].parentJoint], p) for f, p in zip(hand.tips.frames, state.tip_positions, strict=True)]
    size = float(np.ptp(np.array([p for pair in ends for p in pair]), axis=0).max()) or 1.0
    return [Body(shapes.capsule(a, b, 0.03 * size), HAND) for a, b in ends if np.linalg.norm(b - a) > 1e-6 * size]
