"""The solids of a picture: the hand, the object, the environment, rods for unknown fingers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.geometry.mesh import ClosedSurface
from handlcp.grasp import Grasp
from handlcp.hand import HandGrasp, HandState
from handlcp.robot.description import COLLISION, VISUAL
from handlcp.robot.hand_model import HandPosture
from handlcp.show.picture.shapes import box, capsule, hull, of_coal, placed

Colour = tuple[float, float, float]  # red, green, blue from 0 to 1

HAND, OBJECT, ENVIRONMENT = (0.62, 0.65, 0.69), (0.90, 0.70, 0.30), (0.80, 0.78, 0.74)


@dataclass(frozen=True, slots=True)
class Body:
    """A solid of a picture, as triangles of one colour.

    triangles (m, 3, 3) : corners [m], world axes.
    label : for the legend. link : the name of a hand's link, "" for others.
    marked : whether it is marked, as a link inside the object is.
    """

    triangles: Array
    colour: Colour
    label: str = ""
    link: str = ""
    marked: bool = False


def object_body(grasp: Grasp, obj: Any = None) -> Body | None:
    """The object; the hull of the contacts where the object is not known; None where they span no volume."""
    obj = getattr(grasp, "target", None) if obj is None else obj
    if obj is not None:
        known = obj.triangles if obj.triangles is not None else of_coal(obj.geometry)
        if known is not None:
            return Body(placed(known, obj.placement), OBJECT, "object")
    around = hull(grasp.scene.positions, 0.3 * grasp.scene.units.length)
    return None if around is None else Body(around, OBJECT, "hull of the contacts")


def stub_bodies(grasp: Grasp) -> list[Body]:
    """For a grasp without a hand: a short rod behind each contact of a finger, ending at the contact."""
    size = grasp.scene.units.length
    r = 0.08 * size
    fingers = grasp.scene.n - grasp.scene.environment
    pairs = zip(grasp.scene.positions[:fingers], grasp.scene.frames[:fingers, :, 2], strict=True)
    return [Body(capsule(p - n * 0.75 * size, p - n * r, r), HAND) for p, n in pairs]


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
        slab = box([*(high - low), thick]) + np.array([*(low + high) / 2, -thick / 2])
        out.append(Body(slab @ R.T + p, ENVIRONMENT))
        left = [i for i, there in zip(left, same.tolist(), strict=True) if not there]
    return out


# ----------------------------------------------------------------
# The hand in its posture: each link with its visual geometry, else its collision geometry, else as a stick figure;
# and the fingertip shapes that find contacts, where they are not what is drawn.

_ROD = 0.03  # radius of a stick, in sizes of the stick figure
_APART = 0.03  # of the grasp's size: a contact farther than this from what is drawn of the hand needs its fingertip


def hand_bodies(state: HandState) -> list[Body]:
    """The hand's links as solids; `Body.link` names them.

    Each has its visual geometry, else its collision geometry, else rods from joint to joint.
    """
    found = list[Body]()
    for kind in (VISUAL, COLLISION):
        found += _links(state, kind, {b.link for b in found})
    return [*found, *_sticks(state, {b.link for b in found})]


def tip_shapes(grasp: Grasp, bodies: Sequence[Body]) -> list[Array]:
    """Triangles (m, 3, 3) of the convex shapes of each fingertip whose contact is not on what is drawn of the hand; of
    a contact on a link, the link's.

    So it is where a `tip_radius` or the collision geometry differs from the visual geometry. Contacts that were given
    and lie on neither show nothing.
    """
    if not isinstance(grasp, HandGrasp):
        return []
    state, links = grasp.state, grasp.spec.links
    out, seen = list[Array](), set[str]()
    drawn = np.concatenate([b.triangles for b in bodies])
    near = _APART * grasp.scene.units.length
    for p, tip in zip(grasp.scene.positions, grasp.mechanism.tips, strict=False):
        off = _distance(p, drawn)
        if off <= near or (link := links.get(state.hand.fingertips[tip])) in seen:
            continue
        if link is not None:
            whole = [
                b.triangles for b in _links(state, COLLISION, state.hand.description.readable_links(COLLISION) - {link})
            ]
            if whole and min(_distance(p, tri) for tri in whole) < 0.5 * off:
                out += whole
                seen.add(link)
                continue
        try:
            known = state.hand.tip_shapes(tip)
        except HandLCPError:
            continue
        R, t = state.tip_rotations[tip], state.tip_positions[tip]
        own = [(of_coal(s.geometry), s) for s in known]
        here = [(tri @ s.rotation.T + s.translation) @ R.T + t for tri, s in own if tri is not None]
        if here and min(_distance(p, tri) for tri in here) < 0.5 * off:
            out += here
    return out


def _distance(point: Array, triangles: Array) -> float:
    """To the nearest of triangles (m, 3, 3) [m], without those that are farther than another one surely is."""
    middle = triangles.mean(axis=1)
    away = np.linalg.norm(middle - point, axis=1)
    reach = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    return abs(float(ClosedSurface(triangles[away - reach <= away.min()]).closest(point[None])[0][0]))


def _links(state: HandPosture, kind: str, known: set[str]) -> Iterator[Body]:
    """Bodies of the links of a file that are not known yet and have geometry of this kind whose meshes are found."""
    described, kinematics = state.hand.description, state.hand.kinematics
    try:
        parts = () if described.root is None else described.load_shapes(kind, described.readable_links(kind) - known)
    except HandLCPError:
        return
    placements, _ = kinematics.frames_at(state.q, [part.frame for part in parts])
    for part, at in zip(parts, placements, strict=True):
        if (triangles := of_coal(part.shape)) is not None:
            local = triangles @ part.rotation.T + part.position
            link = kinematics.model.frames[part.frame].name
            yield Body(local @ at[:3, :3].T + at[:3, 3], _tint(part.colour), link=link)


def _tint(colour: Array | None) -> Colour:
    """The file's colour, lightened so that arrows stand out."""
    r, g, b = (0.42 + 0.55 * np.array(HAND if colour is None else colour)).tolist()
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
            yield Body(capsule(a, b, _ROD * size), HAND, link=names[0] if names else "")
