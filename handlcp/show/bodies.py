"""What there is to draw: the hand's links in their posture, the object, and stubs for fingers nobody described."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.grasp import Grasp
from handlcp.show import shapes

if TYPE_CHECKING:
    from handlcp.hand import HandState

__all__ = ["Body", "environment_bodies", "hand_bodies", "object_body", "stub_bodies"]

GREY = (0.62, 0.65, 0.69)
ENVIRONMENT = (0.80, 0.78, 0.74)


@dataclass(frozen=True, slots=True)
class Body:
    """triangles (m, 3, 3) [m], world axes; colour (r, g, b); outward: all wind outwards; label: for the legend."""

    triangles: Array
    colour: tuple[float, float, float]
    outward: bool = True
    label: str = ""


def hand_bodies(state: HandState) -> list[Body]:
    """Every link as its URDF draws it (else as it collides); rods between the joints when there is no geometry."""
    return _links(state) or _rods(state)


def object_body(grasp: Grasp, obj: Any = None) -> Body | None:
    """The object; without a description the hull of the contacts; None where they span nothing."""
    obj = getattr(grasp, "target", None) if obj is None else obj
    if obj is not None:
        known = (obj.triangles, False) if obj.triangles is not None else shapes.of_coal(obj.geometry)
        if known is not None:
            return Body(shapes.placed(known[0], obj.placement), (0.90, 0.70, 0.30), known[1], "object")
    size = grasp.scene.units.length
    t = shapes.hull(grasp.scene.positions, 0.3 * size)
    return None if t is None else Body(t, (0.90, 0.70, 0.30), True, "hull of the contacts")


def stub_bodies(grasp: Grasp) -> list[Body]:
    """A short rod behind each contact of a grasp without a hand, ending at the contact."""
    size = grasp.scene.units.length
    r = 0.08 * size
    fingers = grasp.scene.n - grasp.scene.environment
    pairs = zip(grasp.scene.positions[:fingers], grasp.scene.frames[:fingers, :, 2], strict=True)
    return [Body(shapes.capsule(p - n * 0.75 * size, p - n * r, r), GREY) for p, n in pairs]


def environment_bodies(grasp: Grasp) -> list[Body]:
    """A slab under the environment's contacts that lie in one plane, half a grasp's size wider than they are."""
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
    import pinocchio as pin

    from handlcp.hand.urdf import captured_stderr, resolve_meshes

    hand = state.hand
    root, folders = hand.urdf_tree
    if root is None:
        return []
    for kind in (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION):
        drawn = copy.deepcopy(root)
        other = "collision" if kind == pin.GeometryType.VISUAL else "visual"
        for link in drawn.findall("link"):
            for element in link.findall(other):
                link.remove(element)
        model = hand.model
        try:
            resolve_meshes(drawn, folders)
            with captured_stderr():
                geometry = pin.buildGeomFromUrdfString(model, ET.tostring(drawn, encoding="unicode"), kind)
        except (HandLCPError, ValueError, RuntimeError):
            continue
        if not len(geometry.geometryObjects):
            continue
        data, geometry_data = model.createData(), pin.GeometryData(geometry)
        q = hand.kinematics.configuration(state.q)
        pin.updateGeometryPlacements(model, data, geometry, geometry_data, q)
        found = []
        for item, placement in zip(geometry.geometryObjects, geometry_data.oMg, strict=True):
            if (known := shapes.of_coal(item.geometry)) is not None:
                found.append(Body(shapes.placed(known[0], placement), _tint(item), known[1]))
        if found:
            return found
    return []


def _tint(item: Any) -> tuple[float, float, float]:
    """The URDF's colour, lightened so that arrows stand out."""
    c = np.array(item.meshColor).ravel()[:3] if item.overrideMaterial else np.array(GREY)
    r, g, b = (0.42 + 0.55 * c).tolist()
    return (r, g, b)


def _rods(state: HandState) -> list[Body]:
    """From each joint to the next, and to the fingertips."""
    import pinocchio as pin

    hand = state.hand
    model = hand.model
    data = model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    at = [np.array(m.translation) for m in data.oMi]
    ends = [(at[model.parents[i]], at[i]) for i in range(1, model.njoints)]
    ends += [(at[model.frames[f].parentJoint], p) for f, p in zip(hand.tips.frames, state.tip_positions, strict=True)]
    size = float(np.ptp(np.array([p for pair in ends for p in pair]), axis=0).max()) or 1.0
    return [Body(shapes.capsule(a, b, 0.03 * size), GREY) for a, b in ends if np.linalg.norm(b - a) > 1e-6 * size]
