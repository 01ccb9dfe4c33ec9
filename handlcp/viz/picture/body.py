"""`Body`: triangles of the shapes that hands and objects are made of; every array is (m, 3, 3), corners in metres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import scipy

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.geometry.mesh import ClosedSurface
from handlcp.grasp import Grasp
from handlcp.grasp.model.contact import contact_frame
from handlcp.hand import HandGrasp, HandState
from handlcp.robot.description import COLLISION, VISUAL
from handlcp.robot.hand_model import HandPosture
from handlcp.robot.link_surface import mesh_triangles

_MIN_COARSENED_TRIANGLES = 4000  # triangles: a surface of fewer is not made coarser
ROUND_FACETS = 96  # facets around a round shape
_CUBE_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))  # of a cube with edges of one
# Corners of each side in their order, seen from outside
_CUBE_SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def box_triangles(size: Any) -> Array:
    """A box about the origin with edges `size` (3,)."""
    triangles = _CUBE_SIDES[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return np.asarray((_CUBE_CORNERS * np.asarray(size, dtype=float))[triangles])


def revolve_profile(profile: Any, around: int = ROUND_FACETS) -> Array:
    """The surface that a profile sweeps about z. profile : points (radius, z) from the lower pole to the upper."""
    r, z = np.asarray(profile, dtype=float).T[..., None]
    a = 2 * np.pi * np.arange(around + 1) / around
    points = np.stack(np.broadcast_arrays(r * np.cos(a), r * np.sin(a), z), axis=-1)
    q00, q01, q10, q11 = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    both = np.concatenate([np.stack([q00, q01, q11], axis=2), np.stack([q00, q11, q10], axis=2)])
    t = both.reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
    return np.asarray(t[area > 1e-12 * max(float(area.max()), 1e-300)])


def ellipsoid_triangles(radii: Any) -> Array:
    """An ellipsoid about the origin. radii : semi-axes (3,), or one radius."""
    a = np.linspace(-np.pi / 2, np.pi / 2, 25)
    ball = revolve_profile(np.stack([np.cos(a), np.sin(a)], axis=1))
    return np.asarray(ball * (np.ones(3) * np.asarray(radii, dtype=float)))


def cylinder_triangles(radius: float, length: float) -> Array:
    """A cylinder along z about the origin."""
    h = length / 2
    return revolve_profile([(0, -h), (radius, -h), (radius, h), (0, h)])


def capsule_triangles(start: Any, end: Any, radius: float) -> Array:
    """A rod with round ends between two points."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(b - a))
    t = np.linspace(0, np.pi / 2, 6)
    low = [(radius * np.sin(x), -radius * np.cos(x)) for x in t]
    up = [(radius * np.cos(x), length + radius * np.sin(x)) for x in t]
    shape = revolve_profile([*low, *up], 20)
    axis = (b - a) / length if length > 0 else np.array([0.0, 0.0, 1.0])
    return np.asarray(shape @ contact_frame(axis).T + a)


def thick_hull(points: Array, thickness: float) -> Array | None:
    """The convex hull of points (n, 3), given a thickness where they lie in a plane; None where they span nothing."""
    p = np.asarray(points, dtype=float)
    centred = p - p.mean(0)
    _, s, axes = np.linalg.svd(centred)
    if len(p) < 3 or s[1] < 1e-6 * max(s[0], 1e-300):
        return None
    if len(s) < 3 or s[2] < 1e-3 * s[0]:
        p = np.concatenate([p + axes[2] * thickness / 2, p - axes[2] * thickness / 2])
    if (t := convex_hull(p)) is None:
        return None
    outward = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    flip = (outward * (t.mean(1) - p.mean(0))).sum(1) < 0
    t[flip] = t[flip][:, ::-1]
    return t


def convex_hull(points: Array) -> Array | None:
    """The convex hull of points (n, 3), its triangles turned either way; None where they span no volume."""
    try:
        return np.asarray(points[scipy.spatial.ConvexHull(points).simplices])
    except scipy.spatial.QhullError:
        return None


def coal_triangles(geometry: Any) -> Array | None:
    """Triangles of a coal geometry; None for one that has no picture."""
    g = geometry
    if isinstance(g, coal.Sphere):
        return ellipsoid_triangles(g.radius)
    if isinstance(g, coal.Ellipsoid):
        return ellipsoid_triangles(np.array(g.radii).ravel())
    if isinstance(g, coal.Box):
        return box_triangles(2 * np.array(g.halfSide).ravel())
    if isinstance(g, coal.Cylinder):
        return cylinder_triangles(g.radius, 2 * g.halfLength)
    if isinstance(g, coal.Capsule):
        return capsule_triangles((0, 0, -g.halfLength), (0, 0, g.halfLength), g.radius)
    if isinstance(g, coal.Cone):
        return revolve_profile([(0, -g.halfLength), (g.radius, -g.halfLength), (0, g.halfLength)])
    if isinstance(g, coal.BVHModelBase):
        triangles = mesh_triangles(g)
        return triangles if len(triangles) else None
    return thick_hull(np.array(g.points()), 0.0) if isinstance(g, coal.ConvexBase) else None


def coarsen_triangles(triangles: Array, cell: float) -> Array:
    """(k, 3, 3) about the same surface, of many triangles (m, 3, 3): corners on a grid, what falls together once."""
    if len(triangles) < _MIN_COARSENED_TRIANGLES:
        return triangles
    corners = np.round(triangles / cell).astype(np.int64)
    a, b, c = corners.transpose(1, 0, 2)
    kept = corners[(a != b).any(1) & (b != c).any(1) & (c != a).any(1)]
    return np.asarray(np.unique(kept.reshape(-1, 9), axis=0).reshape(-1, 3, 3) * cell)


def place_triangles(triangles: Array, placement: Any) -> Array:
    """Triangles moved by `placement`, a pin.SE3."""
    return np.asarray(triangles @ np.asarray(placement.rotation).T + np.asarray(placement.translation))


# ----------------------------------------------------------------
# The solids of a picture: the hand, the object, the environment, rods for unknown fingers.


Colour = tuple[float, float, float]  # red, green, blue from 0 to 1

HAND_COLOUR, OBJECT_COLOUR, ENVIRONMENT_COLOUR = (0.62, 0.65, 0.69), (0.90, 0.70, 0.30), (0.80, 0.78, 0.74)


@dataclass(frozen=True, slots=True)
class Body:
    """A solid of a picture, as triangles of one colour.

    triangles (m, 3, 3) : corners [m], world axes.
    label : for the legend. link : the name of a hand's link, "" for others.
    is_marked : whether it is marked, as a link inside the object is.
    """

    triangles: Array
    colour: Colour
    label: str = ""
    link: str = ""
    is_marked: bool = False


def object_body(grasp: Grasp, obj: Any = None) -> Body | None:
    """The object; the hull of the contacts where the object is not known; None where they span no volume."""
    obj = getattr(grasp, "target", None) if obj is None else obj
    if obj is not None:
        known = obj.triangles if obj.triangles is not None else coal_triangles(obj.geometry)
        if known is not None:
            return Body(place_triangles(known, obj.placement), OBJECT_COLOUR, "object")
    around = thick_hull(grasp.scene.positions, 0.3 * grasp.scene.units.length_unit)
    return None if around is None else Body(around, OBJECT_COLOUR, "hull of the contacts")


def stub_bodies(grasp: Grasp) -> list[Body]:
    """For a grasp without a hand: a short rod behind each contact of a finger, ending at the contact."""
    size = grasp.scene.units.length_unit
    r = 0.08 * size
    fingers = grasp.scene.n - grasp.scene.environment
    pairs = zip(grasp.scene.positions[:fingers], grasp.scene.frames[:fingers, :, 2], strict=True)
    return [Body(capsule_triangles(p - n * 0.75 * size, p - n * r, r), HAND_COLOUR) for p, n in pairs]


def environment_bodies(grasp: Grasp) -> list[Body]:
    """A slab under each set of environment contacts in one plane, wider by half a grasp's size on every side."""
    scene, out = grasp.scene, []
    size, left = scene.units.length_unit, list(range(scene.n - scene.environment, scene.n))
    thick = 0.1 * size
    while left:
        R, p = scene.frames[left[0]], scene.positions[left[0]]
        local = (scene.positions[left] - p) @ R
        same = (abs(local[:, 2]) < 1e-2 * size) & (scene.frames[left][:, :, 2] @ R[:, 2] > 1 - 1e-6)
        low, high = local[same, :2].min(axis=0) - 0.5 * size, local[same, :2].max(axis=0) + 0.5 * size
        slab = box_triangles([*(high - low), thick]) + np.array([*(low + high) / 2, -thick / 2])
        out.append(Body(slab @ R.T + p, ENVIRONMENT_COLOUR))
        left = [i for i, there in zip(left, same.tolist(), strict=True) if not there]
    return out


# ----------------------------------------------------------------
# The hand in its posture: each link with its visual geometry, else its collision geometry, else as a stick figure;
# and the fingertip shapes that find contacts, where they are not what is drawn.

_ROD_RADIUS = 0.03  # radius of a stick, in sizes of the stick figure
# Of the grasp's size: a contact farther than this from what is drawn of the hand needs its fingertip
_MAX_TIP_DISTANCE = 0.03


def hand_bodies(state: HandState) -> list[Body]:
    """The hand's links as solids; `Body.link` names them.

    Each has its visual geometry, else its collision geometry, else rods from joint to joint.
    """
    found = list(_link_bodies(state, VISUAL, set()))
    found += _link_bodies(state, COLLISION, {b.link for b in found})
    return [*found, *_stick_bodies(state, {b.link for b in found})]


def undrawn_tip_shapes(grasp: Grasp, bodies: Sequence[Body]) -> list[Array]:
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
    near = _MAX_TIP_DISTANCE * grasp.scene.units.length_unit
    for p, tip in zip(grasp.scene.positions, grasp.mechanism.tips, strict=False):
        off = _distance_to_triangles(p, drawn)
        if off <= near or (link := links.get(state.hand.fingertips[tip])) in seen:
            continue
        if link is not None:
            others = state.hand.description.readable_links(COLLISION) - {link}
            whole = [b.triangles for b in _link_bodies(state, COLLISION, others)]
            if whole and min(_distance_to_triangles(p, tri) for tri in whole) < 0.5 * off:
                out += whole
                seen.add(link)
                continue
        try:
            known = state.hand.tip_shapes(tip)
        except HandLCPError:
            continue
        R, t = state.tip_rotations[tip], state.tip_positions[tip]
        own = [(coal_triangles(s.geometry), s) for s in known]
        here = [(tri @ s.rotation.T + s.translation) @ R.T + t for tri, s in own if tri is not None]
        if here and min(_distance_to_triangles(p, tri) for tri in here) < 0.5 * off:
            out += here
    return out


def _distance_to_triangles(point: Array, triangles: Array) -> float:
    """To the nearest of triangles (m, 3, 3) [m], without those that are farther than another one surely is."""
    middle = triangles.mean(axis=1)
    away = np.linalg.norm(middle - point, axis=1)
    reach = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    return abs(float(ClosedSurface(triangles[away - reach <= away.min()]).closest(point[None])[0][0]))


def _link_bodies(state: HandPosture, kind: str, known: set[str]) -> Iterator[Body]:
    """Bodies of the links of a file that are not known yet and have geometry of this kind whose meshes are found."""
    described, kinematics = state.hand.description, state.hand.kinematics
    try:
        parts = () if described.root is None else described.load_shapes(kind, described.readable_links(kind) - known)
    except HandLCPError:
        return
    placements, _ = kinematics.frames_at(state.q, [part.frame for part in parts])
    for part, at in zip(parts, placements, strict=True):
        if (triangles := coal_triangles(part.shape)) is not None:
            local = triangles @ part.rotation.T + part.position
            link = kinematics.model.frames[part.frame].name
            # The file's colour, lightened so that arrows stand out
            r, g, b = (0.42 + 0.55 * np.array(HAND_COLOUR if part.colour is None else part.colour)).tolist()
            yield Body(local @ at[:3, :3].T + at[:3, 3], (r, g, b), link=link)


def _stick_bodies(state: HandState, known: set[str]) -> Iterator[Body]:
    """Rods from each joint to the next ones and to the fingertips, for links without a body; `known` have one."""
    hand, model = state.hand, state.hand.model
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
            yield Body(capsule_triangles(a, b, _ROD_RADIUS * size), HAND_COLOUR, link=names[0] if names else "")
