"""Whether the hand's links keep out of the object and out of each other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import URDFError
from handlcp.geometry.distance import bounding_balls, bounding_box
from handlcp.geometry.link_penetration import point_distances
from handlcp.geometry.object import Object
from handlcp.grasp.model.contact import cross_rows
from handlcp.robot.hand_model import HandModel
from handlcp.robot.link_surface import LinkSurface

# ----------------------------------------------------------------
# A posture of the hand and a placement of the object, together: what a search for grasps varies.

_SPARE = 0.03  # of a joint's range, kept free at both ends so that the fingers can still be squeezed
_THICK = (3e-3, 12e-3)  # [m] half of a fingertip's thickness, at least and at most


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """q (nv,) [rad, m] of the hand. rotation (3, 3), position (3,) [m]: of the object's frame, world axes."""

    q: Array
    rotation: Array
    position: Array

    def moved(self, joints: Array, twist: Array) -> Place:
        """After small motions of the joints (nv,), and of the object about its own frame's origin (6,)."""
        turn = np.asarray(pin.exp3(np.asarray(twist[3:])))
        return Place(self.q + joints, turn @ self.rotation, self.position + twist[:3])

    def of(self, obj: Object) -> Object:
        """The object at this placement."""
        return obj.moved_to(pin.SE3(self.rotation, self.position))


def free_ranges(hand: HandModel) -> tuple[Array, Array]:
    """(nv,) lower and upper ends of what a search uses of the joint ranges; a joint without limits turns by ±π."""
    lower = np.where(np.isfinite(hand.lower), hand.lower, -np.pi)
    upper = np.where(np.isfinite(hand.upper), hand.upper, np.pi)
    spare = _SPARE * (upper - lower)
    return lower + spare, upper - spare


def size_of_object(obj: Object) -> float:
    """Half of the object's mean width [m]."""
    low, high = bounding_box(obj.geometry)
    return float(np.mean(high - low)) / 2


def end_of(hand: HandModel, tip: int) -> tuple[Array, float]:
    """The middle of a fingertip in its frame (3,) [m], and how far its surface is from there [m], roughly.

    A ball's centre. Of another shape a point near its far end, seen from the last joint of the finger: that of its
    surface which is furthest along the finger, drawn in by half of the shape's thickness.
    """
    shapes = hand.tip_shapes(tip)
    if len(shapes) == 1 and shapes[0].radius is not None:
        return shapes[0].translation, shapes[0].radius
    points = np.concatenate([_corners(s.geometry) @ s.rotation.T + s.translation for s in shapes])
    joint = hand.kinematics.model.frames[hand.tips.frames[tip]].placement.inverse().translation  # in the tip's frame
    along = points.mean(axis=0) - joint
    along /= max(float(np.linalg.norm(along)), 1e-12)
    thick = float(np.clip(np.sqrt(np.linalg.eigvalsh(np.cov(points.T))[0]), *_THICK))
    far = float((points @ along).max())
    centre = points[points @ along > far - 2 * thick].mean(axis=0)
    return centre + along * (far - thick - float(centre @ along)), thick


def _corners(shape: Any) -> Array:
    """(m, 3) corners of a convex shape, or of a box around it."""
    if hasattr(shape, "points"):
        return np.array(shape.points(), dtype=float)
    low, high = bounding_box(shape)
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


# ----------------------------------------------------------------

_POINTS = 150  # of a link, at most, that are looked at
_DEPTH, _MOST = 1e-4, 3e-3  # [m] how deep a link may be in the object, and at most one that carries a fingertip
_BESIDE = 2e-4  # [m] how much less deep a link is pushed that is too deep


class Links:
    """The links of a hand, as points for the object and as coal's shapes for each other.

    A link may be in another where it is so in the neutral posture, or where both are within two joints of each other.
    """

    def __init__(self, hand: HandModel, tips: tuple[int, ...]) -> None:
        self._hand = hand
        try:
            self._links = hand.link_surfaces
        except URDFError:
            self._links = ()  # nothing is known of them
        self._frames = [link.frame for link in self._links]
        model = hand.kinematics.model
        carried = {model.frames[hand.tips.frames[i]].parentJoint: i for i in tips}
        nets = [link.net for link in self._links]
        steps = [max(1, -(-len(points) // _POINTS)) for points, _ in nets]
        points = [points[::step] for (points, _), step in zip(nets, steps, strict=True)]
        self._points = np.concatenate([*points, np.zeros((0, 3))])
        self._of = np.repeat(np.arange(len(points)), [len(p) for p in points])
        self._starts = np.cumsum([0, *map(len, points)])[:-1]
        allowed = [_allowed(hand, link, carried.get(link.joint)) for link in self._links]
        slack = [r[::step] - a for (_, r), step, a in zip(nets, steps, allowed, strict=True)]
        self._slack = np.concatenate([*slack, np.zeros(0)])
        self._moved_by = np.zeros((len(self._links), model.nv))
        for row, link in zip(self._moved_by, self._links, strict=True):
            for joint in model.supports[link.joint]:
                if joint and model.joints[joint].nv:
                    row[model.joints[joint].idx_v] = 1.0
        balls = [_ball(link) for link in self._links]
        self._middles = np.array([middle for middle, _ in balls]).reshape(-1, 3)
        self._sizes = np.array([size for _, size in balls])
        self._parts = [bounding_balls(link.parts) for link in self._links]
        every = [(i, j) for i, j in combinations(range(len(self._links)), 2) if self._apart(model, i, j)]
        at = hand.kinematics.frames_at(hand.neutral, self._frames)[0]
        self._pairs = np.array([pair for pair in every if not self._meet(at, *pair)], dtype=int).reshape(-1, 2)

    @property
    def middles(self) -> tuple[list[int], Array]:
        """Frames of the links, and the middle of each in its frame (m, 3) [m]."""
        return self._frames, np.array(
            [self._points[self._of == k].mean(axis=0) for k in range(len(self._links))]
        ).reshape(-1, 3)

    def pushes(self, home: Object, place: Place) -> tuple[Array, Array, Array, Array]:
        """Of the links inside the object: gap (m,) of each link's deepest point [m], below 0; that point (m, 3); the
        normal (m, 3) from it into the object; and n · J (m, nv) of the point. World axes.
        """
        none = np.zeros((0, 3))
        if not self._links:
            return np.zeros(0), none, none, np.zeros((0, self._hand.nv))
        beyond, local, columns = self._beyond(home, place)
        deep = np.flatnonzero(np.minimum.reduceat(beyond, self._starts) < 0.0)
        ends = np.append(self._starts, len(beyond))
        worst = np.array([ends[i] + int(np.argmin(beyond[ends[i] : ends[i + 1]])) for i in deep], dtype=int)
        known = [home.closest(local[k]) for k in worst]
        out = np.array([[0.0, 0.0, 0.0] if one is None else one[2] for one in known]).reshape(-1, 3)
        points, normals = local[worst] @ place.rotation.T + place.position, -out @ place.rotation.T
        levers = (normals @ columns[:3] + cross_rows(points, normals) @ columns[3:]) * self._moved_by[deep]
        coupling = self._hand.kinematics.coupling
        return beyond[worst] - _BESIDE, points, normals, levers if coupling is None else levers @ coupling

    def _beyond(self, home: Object, place: Place) -> tuple[Array, Array, Array]:
        """How far each point is beyond what is allowed [m], the points in the object's frame, and the joints' columns
        (6, joints) of the world's origin.
        """
        at, columns = self._hand.kinematics.frames_at(place.q, self._frames)
        R, o = place.rotation, place.position
        turns, shifts = R.T @ at[:, :3, :3], (at[:, :3, 3] - o) @ R
        local = np.einsum("kxy,ky->kx", turns[self._of], self._points) + shifts[self._of]
        return point_distances(local, home, self._slack) - self._slack, local, columns

    def out_of_each_other(self, q: Array) -> bool:
        """Whether no two links of different fingers, and no finger and the palm, meet."""
        at, _ = self._hand.kinematics.frames_at(q, self._frames)
        middles = np.einsum("kxy,ky->kx", at[:, :3, :3], self._middles) + at[:, :3, 3]
        one, two = self._pairs.T
        apart = middles[one] - middles[two]
        near = (apart * apart).sum(axis=1) <= (self._sizes[one] + self._sizes[two]) ** 2
        return not any(self._meet(at, i, j) for i, j in self._pairs[near].tolist())

    def _apart(self, model: Any, i: int, j: int) -> bool:
        """Whether more than two joints lie between two links."""
        one, two = (set(model.supports[self._links[k].joint]) for k in (i, j))
        return len(one ^ two) > 2

    def _meet(self, at: Array, i: int, j: int) -> bool:
        (x, r), (y, s) = self._parts[i], self._parts[j]
        x, y = x @ at[i, :3, :3].T + at[i, :3, 3], y @ at[j, :3, :3].T + at[j, :3, 3]
        near = ((x[:, None] - y) ** 2).sum(axis=2) <= (r[:, None] + s) ** 2
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        for m, n in np.argwhere(near).tolist():
            (a, R, p), (b, Q, o) = self._links[i].parts[m], self._links[j].parts[n]
            first = coal.Transform3s(at[i, :3, :3] @ R, at[i, :3, :3] @ p + at[i, :3, 3])
            second = coal.Transform3s(at[j, :3, :3] @ Q, at[j, :3, :3] @ o + at[j, :3, 3])
            if coal.collide(a, first, b, second, request, result):
                return True
        return False


def _ball(link: LinkSurface) -> tuple[Array, float]:
    """Middle (3,) in the link's frame, and radius, of a ball that holds it [m]."""
    points, radii = link.net
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return middle, float((np.linalg.norm(points - middle, axis=1) + radii).max()) + _DEPTH


def _allowed(hand: HandModel, link: LinkSurface, tip: int | None) -> float:
    """How deep a link may be in the object [m]: where a ball stands for the fingertip that it carries, by as much as it
    reaches out of that ball, away from the finger.
    """
    shapes = () if tip is None else hand.tip_shapes(tip)
    if tip is None or len(shapes) != 1 or shapes[0].radius is None:
        return _DEPTH
    model, (points, radii) = hand.kinematics.model, link.net
    at, to = model.frames[link.frame].placement, model.frames[hand.tips.frames[tip]].placement
    centre = at.actInv(to).act(np.array(shapes[0].translation))
    away = centre - at.inverse().translation  # from the finger's last joint
    arms = points - centre
    out = np.linalg.norm(arms, axis=1) + radii - shapes[0].radius
    return float(np.clip(out[arms @ away > 0.0].max(initial=0.0), _DEPTH, _MOST))
