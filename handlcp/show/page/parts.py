"""The solids of a page, each with what moves it: a joint of the hand, the object, or nothing."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.grasp import Grasp
from handlcp.hand import HandState
from handlcp.hand.robot.urdf import captured_stderr, resolve_meshes
from handlcp.show.page.simplify import simplified
from handlcp.show.picture import shapes
from handlcp.show.picture.bodies import HAND, Body, environment_bodies, object_body, stub_bodies

__all__ = ["FIXED", "Part", "Solids", "solids_of"]

FIXED = -1
MOST = 60_000  # triangles of a hand; more are simplified
_LEAST = 200  # of one link
_STILL = pin.SE3.Identity()


@dataclass(frozen=True, slots=True)
class Part:
    """triangles (m, 3, 3) [m] in axes of their own. at : these in axes of what moves it. layer : "hand", "object",
    "environment". joint : number of the joint that moves it; FIXED: none.
    """

    triangles: Array
    colour: tuple[float, float, float]
    layer: str
    joint: int = FIXED
    at: Any = _STILL


@dataclass(frozen=True, slots=True)
class Solids:
    """parts : all of them. glass : the object as a body in world axes, or None. notes : what a reader should know of
    how they are drawn.
    """

    parts: tuple[Part, ...]
    glass: Body | None
    notes: tuple[str, ...]


def solids_of(grasp: Grasp, obj: Any, around: Grasp) -> Solids:
    """Hand, object and environment. obj : what to draw as the object where the grasp does not know it. around : the
    grasp whose environment is drawn.
    """
    state, notes = getattr(grasp, "state", None), list[str]()
    if state is None:
        hand = [Part(b.triangles, b.colour, "hand") for b in stub_bodies(grasp)]
        notes.append("The grasp has no hand: rods stand for its fingers.")
    else:
        hand, told = _hand(state)
        notes += told
    glass = object_body(grasp, obj)
    around_it = [Part(b.triangles, b.colour, "environment") for b in environment_bodies(around)]
    solid = []
    if glass is not None:
        few = simplified(glass.triangles, MOST)
        solid = [Part(few, glass.colour, "object")]
        if len(few) < len(glass.triangles):
            notes.append(f"The object is drawn with {len(few)} of its {len(glass.triangles)} triangles.")
        if glass.label != "object":
            notes.append("The object is not known: the hull of the contacts stands for it.")
    return Solids((*hand, *around_it, *solid), glass, tuple(notes))


def _hand(state: HandState) -> tuple[list[Part], list[str]]:
    """All links with their visual geometry, else their collision geometry, else rods between the joints."""
    for kind, other in ((pin.GeometryType.VISUAL, "collision"), (pin.GeometryType.COLLISION, "visual")):
        if found := list(_links(state, kind, other)):
            notes = ["The hand has no visual geometry: its collision geometry is drawn."] if other == "visual" else []
            few = _fewer(found)
            before, after = (sum(len(p.triangles) for p in parts) for parts in (found, few))
            if after < before:
                notes.append(f"The hand is drawn with {after} of its {before} triangles.")
            return few, notes
    return list(_rods(state)), ["The hand has no geometry that can be read: rods join its joints and fingertips."]


def _links(state: HandState, kind: Any, other: str) -> Iterator[Part]:
    """Parts from the hand's URDF, in axes of their joints; none where it has no such geometry, or no meshes."""
    root, folders = state.hand.urdf_tree
    if root is None:
        return
    drawn = copy.deepcopy(root)
    for link in drawn.findall("link"):
        for element in link.findall(other):
            link.remove(element)  # its meshes may be missing
    try:
        resolve_meshes(drawn, folders)
        with captured_stderr():
            geometry = pin.buildGeomFromUrdfString(state.hand.model, ET.tostring(drawn, encoding="unicode"), kind)
    except (HandLCPError, ValueError, RuntimeError):
        return
    for item in geometry.geometryObjects:
        triangles = shapes.of_coal(item.geometry)
        if triangles is not None and len(triangles):
            yield Part(triangles, _tint(item), "hand", int(item.parentJoint), item.placement.copy())


def _tint(item: Any) -> tuple[float, float, float]:
    """The URDF's colour, lightened so that arrows stand out."""
    c = np.array(item.meshColor).ravel()[:3] if item.overrideMaterial else np.array(HAND)
    r, g, b = (0.42 + 0.55 * c).tolist()
    return (r, g, b)


def _fewer(parts: list[Part]) -> list[Part]:
    """With at most so many triangles in all, each link's share as it was; equal shapes count once."""
    size = {p.triangles.tobytes(): len(p.triangles) for p in parts}
    share = MOST / max(sum(size.values()), 1)
    if share >= 1.0:
        return parts
    return [
        Part(simplified(p.triangles, max(_LEAST, int(share * len(p.triangles)))), p.colour, p.layer, p.joint, p.at)
        for p in parts
    ]


def _rods(state: HandState) -> Iterator[Part]:
    """From each joint to the next, and to the fingertips."""
    hand = state.hand
    model = hand.model
    data = model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    ends = [(model.parents[i], np.array(data.oMi[i].translation)) for i in range(1, model.njoints)]
    tips = zip(hand.tips.frames, state.tip_positions, strict=True)
    ends += [(model.frames[f].parentJoint, p) for f, p in tips]
    points = np.array([p for _, p in ends] + [data.oMi[j].translation for j, _ in ends])
    size = float(np.ptp(points, axis=0).max()) or 1.0
    for joint, end in ends:
        tip = data.oMi[joint].actInv(end)
        if np.linalg.norm(tip) > 1e-6 * size:
            yield Part(shapes.capsule(np.zeros(3), tip, 0.03 * size), HAND, "hand", int(joint))
