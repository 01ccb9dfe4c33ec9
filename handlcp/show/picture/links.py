"""The hand in its posture: each link with its visual geometry, else its collision geometry, else as a stick figure; and
the fingertip shapes that find contacts, where they are not what is drawn.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.grasp import Grasp
from handlcp.hand import HandGrasp, HandState
from handlcp.hand.objects.shapes import closest_of
from handlcp.hand.robot.urdf import captured_stderr, resolve_meshes
from handlcp.show.picture import shapes
from handlcp.show.picture.bodies import HAND, Body, Colour

_ROD = 0.03  # radius of a stick, in sizes of the stick figure
_APART = 0.03  # of the grasp's size: a contact farther than this from what is drawn of the hand needs its fingertip


def hand_bodies(state: HandState) -> list[Body]:
    """All links: visual geometry, else collision geometry, else rods from joint to joint; `Body.link` names them."""
    found = list[Body]()
    for kind, tag in ((pin.GeometryType.VISUAL, "visual"), (pin.GeometryType.COLLISION, "collision")):
        found += _links(state, kind, tag, {b.link for b in found})
    return [*found, *_sticks(state, {b.link for b in found})]


def tip_shapes(grasp: Grasp, bodies: Sequence[Body]) -> list[Array]:
    """Triangles (m, 3, 3) of the convex shapes of each fingertip whose contact is not on what is drawn of the hand.

    So it is where a `tip_radius` or the collision geometry differs from the visual geometry. Contacts that were given
    and lie on neither show nothing.
    """
    if not isinstance(grasp, HandGrasp):
        return []
    state, out = grasp.state, list[Array]()
    drawn = np.concatenate([b.triangles for b in bodies])
    near = _APART * grasp.scene.units.length
    for p, tip in zip(grasp.scene.positions, grasp.mechanism.tips, strict=False):
        off = _distance(p, drawn)
        if off <= near:
            continue
        try:
            known = state.hand.tip_shapes(tip)
        except HandLCPError:
            continue
        R, t = state.tip_rotations[tip], state.tip_positions[tip]
        placed = [(shapes.of_coal(s.geometry), s) for s in known]
        here = [(tri @ s.rotation.T + s.translation) @ R.T + t for tri, s in placed if tri is not None]
        if here and min(_distance(p, tri) for tri in here) < 0.5 * off:
            out += here
    return out


def _distance(point: Array, triangles: Array) -> float:
    """To the nearest of triangles (m, 3, 3) [m], without those that are farther than another one surely is."""
    middle = triangles.mean(axis=1)
    away = np.linalg.norm(middle - point, axis=1)
    reach = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    return abs(closest_of(point, triangles[away - reach <= away.min()])[0])


def _links(state: HandState, kind: Any, tag: str, known: set[str]) -> Iterator[Body]:
    """Bodies of the links that are not known yet and have geometry of this kind whose meshes are found."""
    root, folders = state.hand.urdf_tree
    if root is None:
        return
    drawn = copy.deepcopy(root)
    for link in drawn.findall("link"):
        wanted = link.get("name") not in known and _readable(link, tag, folders)
        for element in [e for e in link if e.tag in ("visual", "collision")]:
            if not (wanted and element.tag == tag):
                link.remove(element)
    model, q = state.hand.model, state.hand.kinematics.configuration(state.q)
    try:
        with captured_stderr():
            geometry = pin.buildGeomFromUrdfString(model, ET.tostring(drawn, encoding="unicode"), kind)
    except (ValueError, RuntimeError):
        return
    placements = pin.GeometryData(geometry)
    pin.updateGeometryPlacements(model, model.createData(), geometry, placements, q)
    for item, placement in zip(geometry.geometryObjects, placements.oMg, strict=True):
        if (triangles := shapes.of_coal(item.geometry)) is not None:
            link = model.frames[item.parentFrame].name
            yield Body(shapes.placed(triangles, placement), _tint(item), link=link)


def _readable(link: ET.Element, tag: str, folders: Sequence[Path]) -> bool:
    """Whether the meshes of a link are found; their addresses become full paths."""
    try:
        for element in link.findall(tag):
            resolve_meshes(element, folders)
    except HandLCPError:
        return False
    return True


def _tint(item: Any) -> Colour:
    """The URDF's colour, lightened so that arrows stand out."""
    c = np.array(item.meshColor).ravel()[:3] if item.overrideMaterial else np.array(HAND)
    r, g, b = (0.42 + 0.55 * c).tolist()
    return (r, g, b)


def _sticks(state: HandState, known: set[str]) -> Iterator[Body]:
    """Rods from each joint to the next ones and to the fingertips, for links without a body; `known` have one."""
    hand = state.hand
    model = hand.model
    data = model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    at = [np.array(m.translation) for m in data.oMi]
    solid = {f.parentJoint for f in model.frames if f.name in known}
    ends = [(model.parents[i], at[model.parents[i]], at[i]) for i in range(1, model.njoints)]
    tips = zip(hand.tips.frames, state.tip_positions, strict=True)
    ends += [(model.frames[f].parentJoint, at[model.frames[f].parentJoint], p) for f, p in tips]
    size = float(np.ptp(np.array([p for _, *pair in ends for p in pair]), axis=0).max()) or 1.0
    for joint, a, b in ends:
        if joint not in solid and np.linalg.norm(b - a) > 1e-6 * size:
            names = [f.name for f in model.frames if f.parentJoint == joint and f.type == pin.FrameType.BODY]
            yield Body(shapes.capsule(a, b, _ROD * size), HAND, link=names[0] if names else "")
