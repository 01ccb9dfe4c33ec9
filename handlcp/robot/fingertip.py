"""`TipGeometry`: which links may be fingertips, where a link ends, and the frames and shapes that are chosen."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array, check_array, check_keys, check_number, read_only
from handlcp.errors import HandLCPError, InputError, UnknownName, URDFError
from handlcp.robot.description import COLLISION, VISUAL, RobotDescription
from handlcp.robot.link_shape import LinkShape
from handlcp.robot.link_surface import convex_hull, surface_points
from handlcp.robot.linkage import find_linkage_bars

# ----------------------------------------------------------------
# Where a link ends: the middle of the round end that its geometry has farthest from its joint.
#
# The link points from the joint's axis to the middle of its geometry. The end is the last fifth of its length from
# there. The point lies in the middle of the end's width, and below the outermost surface by half of the end's
# thickness, as the centre of a ball that would just fill a round end.

_END_SHARE = 0.2  # of the link's length
_POINT_DIGITS = 4  # a tenth of a millimetre


def find_far_end(parts: Sequence[LinkShape], origin: Array, axis: Array) -> Array | None:
    """(3,) point in the link's frame [m]; None without geometry.

    origin (3,), axis (3,) : a point and the direction of the joint's axis, link's frame.
    """
    points = surface_points([(p.shape, p.rotation, p.position) for p in parts])
    if points is None:
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    toward = 0.5 * (low + high) - origin
    across = toward - axis * (axis @ toward)
    size = float(np.linalg.norm(high - low))
    way = across if np.linalg.norm(across) > 0.1 * size else toward  # a joint that turns the link about its length
    if np.linalg.norm(way) < 0.05 * size:
        return None
    way = way / np.linalg.norm(way)
    along = (points - origin) @ way
    end = points[along > (1.0 - _END_SHARE) * along.max()]
    side = np.cross(way, axis if abs(way @ axis) < 0.9 else np.eye(3)[int(abs(way).argmin())])
    side = side / np.linalg.norm(side)
    sides = np.stack([side, np.cross(way, side)])
    spread = end @ sides.T
    middle, half = 0.5 * (spread.min(axis=0) + spread.max(axis=0)), 0.5 * np.ptp(spread, axis=0)
    depth = min(float(half.min()), 0.5 * float(np.ptp(along)))
    point = middle @ sides + way * (origin @ way + float(along.max()) - depth)
    return read_only(np.round(point, _POINT_DIGITS) + 0.0)


# ----------------------------------------------------------------
# What looks like a fingertip: at the end of each chain of joints, a frame called one, or the link's far end.

_MIN_FINGERS, _MAX_FINGERS = 2, 5  # fingers of a hand whose fingertips may be taken without being named


@dataclass(frozen=True, slots=True)
class FingertipCandidate:
    """One fingertip that could be meant. name : as `fingertips` takes it. link : that carries it. point : (3,) on the
    link, in its frame [m]; None: the origin of the frame. reason : why it could be one. is_sure : whether nothing else
    of its finger could be.
    """

    name: str
    link: str
    point: Array | None
    reason: str
    is_sure: bool
    is_named_tip: bool = False

    def __str__(self) -> str:
        return f"{self.name}: {self.reason}"


def find_tip_candidates(description: RobotDescription) -> tuple[FingertipCandidate, ...]:
    """One or more for each chain of movable joints that ends, in Pinocchio's order of joints. Bars of linkages that end
    at another link are none.
    """
    model = description.model
    inner = {int(model.parents[j]) for j in range(1, model.njoints)}
    ends = [j for j in range(1, model.njoints) if j not in inner and model.joints[j].nv]
    parents = {frame.parentFrame for frame in model.frames}
    leaves = [f for i, f in enumerate(model.frames) if i not in parents and _is_tip_name(f.name)]
    called = [f for f in leaves if any(model.joints[j].nv for j in model.supports[f.parentJoint] if j)]
    bars, out = find_linkage_bars(description), list[FingertipCandidate]()
    for joint in sorted({*ends, *(f.parentJoint for f in called)}):
        names = [f.name for f in called if f.parentJoint == joint]
        for name in names:
            own = 'its name ends in "tip"' if name.lower().endswith("tip") else "its name says that it is a fingertip"
            out.append(FingertipCandidate(name, name, None, own, True, True))
        if not names and joint not in bars:
            out += _end_candidates(description, joint)
    return tuple(out)


# What may follow "tip" in the name of one: a word for what it is, a side, or a number.
_TIP_SUFFIX = re.compile(r"[_\-. ]*(link|frame|site|body|pad|left|right|\d+|(?<=[_\-. ])[lr])$", re.IGNORECASE)


def _is_tip_name(name: str) -> bool:
    """Whether a name says that it is a fingertip's: "index_tip", "thumb_tip_link", "finger_tip_1"."""
    while (shorter := _TIP_SUFFIX.sub("", name)) != name:
        name = shorter
    return name.lower().endswith("tip")


def choose_obvious_tips(found: Sequence[FingertipCandidate]) -> tuple[FingertipCandidate, ...]:
    """The fingertips that need no naming: those whose names say so; else all, if they are two to five and sure."""
    if called := [c for c in found if c.is_named_tip]:
        return tuple(called)
    return tuple(found) if _MIN_FINGERS <= len(found) <= _MAX_FINGERS and all(c.is_sure for c in found) else ()


def _end_candidates(description: RobotDescription, joint: int) -> list[FingertipCandidate]:
    """Candidates on what the last joint of a chain moves: a marker fixed to it, else the far end of its geometry."""
    model, name = description.model, description.model.names[joint]
    links = [(i, f) for i, f in enumerate(model.frames) if f.parentJoint == joint and f.type == pin.FrameType.BODY]
    shaped = {kind: set(description.links_with(kind)) for kind in (COLLISION, VISUAL)}
    seen = shaped[COLLISION] | shaped[VISUAL]
    fixed_on = {int(model.frames[f.parentFrame].parentFrame) for _, f in links}
    markers = [f for i, f in links[1:] if f.name not in seen and i not in fixed_on]
    if markers:
        reason = f"a frame without geometry, fixed to what the last joint {name} moves"
        return [FingertipCandidate(f.name, f.name, None, reason, len(markers) == 1) for f in markers]
    last, moves = f"the last link, moved by {name}", model.joints[joint].createData()
    for kind in (COLLISION, VISUAL):
        there = [f for _, f in links if f.name in shaped[kind]]
        if not there:
            continue
        frame = there[-1]
        try:
            parts = description.load_shapes(kind, {frame.name})
        except HandLCPError:
            return [FingertipCandidate(frame.name, frame.name, None, f"{last}; its meshes cannot be read", False)]
        twist = np.array(getattr(moves, "S", np.zeros((6, 1))), dtype=float).reshape(6, -1)[:, 0]  # joint's frame
        axis = frame.placement.rotation.T @ (twist[3:] if twist[3:].any() else twist[:3])
        point = find_far_end(parts, frame.placement.inverse().translation.copy(), axis)
        if point is not None:
            x, y, z = (f"{1e3 * v:.1f}" for v in point)
            how = f"{last}; the point ({x}, {y}, {z}) mm is at the far end of its {kind} geometry"
            sure = kind == COLLISION or len(there) == 1
            return [FingertipCandidate(frame.name, frame.name, point, how, sure)]
    return [FingertipCandidate(f.name, f.name, None, f"{last}; it has no geometry", False) for _, f in links]


# ----------------------------------------------------------------
# The fingertips as frames of Pinocchio's model; a point on a link becomes a frame of its own.

_FINGERTIPS_EXPECTED = (
    'names of links or frames, such as ["thumb_tip", ("index_3", (0, 0, 0.03))] or {"thumb": "thumb_tip"}'
)
_MAX_POINT_DISTANCE = 1.0  # [m] a point from its link's frame


@dataclass(frozen=True, slots=True)
class TipPlacement:
    """Where a fingertip sits on the robot. link : number of the frame that was named. joint : of the joint that carries
    it. placement : of the tip in that joint's frame.
    """

    link: int
    joint: int
    placement: Any


class TipFrames:
    """The fingertips in Pinocchio's model.

    names, frames : n names and frame numbers. places : where they are on their links.
    support : (n, 1, joints), 1 where a joint moves a tip. numbers : 0 to n-1.
    """

    __slots__ = ("frames", "names", "numbers", "places", "support")

    def __init__(
        self, names: tuple[str, ...], frames: tuple[int, ...], places: tuple[TipPlacement, ...], support: Array
    ) -> None:
        self.names, self.frames, self.places, self.support = names, frames, places, read_only(support)
        self.numbers = tuple(range(len(names)))


def find_tips(model: Any, description: RobotDescription, fingertips: Any) -> TipFrames:
    """The fingertips that are named; None: those that are obvious.

    model : a copy of the description's, to which points on links are added as frames. Raises UnknownName (before
    Pinocchio sees the name, which may crash on an unknown one), InputError.
    """
    named = _find_obvious_tips(description) if fingertips is None else _read_named_tips(fingertips)
    known = [f.name for f in model.frames if f.name != "universe"]
    if unknown := [str(link) for _, link, _ in named if not isinstance(link, str) or link not in known]:
        raise UnknownName("fingertips", "a frame", unknown, known)
    names = tuple(name for name, _, _ in named)
    if len(set(names)) != len(names) or not names:
        raise InputError("fingertips", "different frame names, at least one", repr(list(names)))
    last = {frame.name: i for i, frame in enumerate(model.frames)}  # the link, where a joint has the same name
    places, frames = list[TipPlacement](), list[int]()
    support = np.zeros((len(names), 1, model.nv))
    for (name, link, point), row in zip(named, support, strict=True):
        frame, number = model.frames[last[link]], last[link]
        carrier = int(frame.parentJoint)
        for joint in model.supports[carrier]:
            if joint and model.joints[joint].nv:
                row[0, model.joints[joint].idx_v] = 1.0
        if not row.any():
            still = "what stands still, such as a palm, touches as environment= of the grasp"
            came = f"{frame.name!r}, which is fixed to the base"
            raise InputError("fingertips", f"frames that a joint moves ({still})", came)
        at = frame.placement
        if point is not None or name != link:  # a frame of its own
            if not isinstance(name, str) or not name or (name in known and name != link):
                came = f"{name!r}, which is another frame" if isinstance(name, str) and name else repr(name)
                raise InputError("fingertips", "a name of its own for a point on a link", came)
            at = frame.placement * pin.SE3(np.eye(3), np.zeros(3) if point is None else np.array(point))
            number = int(model.addFrame(pin.Frame(name, carrier, number, at, pin.FrameType.OP_FRAME)))
        frames.append(number)
        places.append(TipPlacement(last[link], carrier, pin.SE3(at)))
    return TipFrames(names, tuple(frames), tuple(places), support)


def _find_obvious_tips(description: RobotDescription) -> list[tuple[str, str, Array | None]]:
    found = find_tip_candidates(description)
    if taken := choose_obvious_tips(found):
        return [(c.name, c.link, c.point) for c in taken]
    if not found:
        every = [f.name for f in description.model.frames if f.name != "universe"]
        raise UnknownName("fingertips", "names of fingertips (nothing looks like one)", [], every)
    proposed = "; ".join(str(c) for c in found)
    expected = f"the names of the fingertips, which are not obvious ({proposed}): some"
    raise UnknownName("fingertips", expected, [], [c.name for c in found])


def _read_named_tips(given: Any) -> list[tuple[Any, Any, Array | None]]:
    """(name, link, point) of each from what users pass. Raises InputError."""
    pairs: Iterable[tuple[Any, Any]]
    if isinstance(given, Mapping):
        pairs = given.items()
    elif isinstance(given, str) or not isinstance(given, Sequence):
        raise InputError("fingertips", _FINGERTIPS_EXPECTED, repr(given)[:80])
    else:
        pairs = [(one[0] if isinstance(one, tuple) and one else one, one) for one in given]
    found = list[tuple[Any, Any, Array | None]]()
    for name, value in pairs:
        if not isinstance(value, (tuple, list)):
            found.append((name, value, None))
            continue
        argument = f"fingertips[{name!r}]"
        if len(value) != 2 or not isinstance(value[0], str):
            raise InputError(argument, 'a link, or a link and a point on it, ("link", (x, y, z))', repr(value)[:80])
        point = check_array(argument, value[1], (3,), what="the point on the link [m], in the link's frame,")
        if abs(point).max() > _MAX_POINT_DISTANCE:
            expected = "a point on the link in metres (millimetres? divide by 1000)"
            raise InputError(argument, expected, f"{point.tolist()}")
        found.append((name, value[0], point))
    return found


# ----------------------------------------------------------------
# The geometry of fingertips: a sphere at the tip frame, or the geometry of its link.

_MAX_TIP_RADIUS = 0.5  # [m] no fingertip is larger

_CONVEX_SHAPES = (coal.Sphere, coal.Box, coal.Cylinder, coal.Capsule, coal.Ellipsoid, coal.ConvexBase)


class SweptBall(NamedTuple):
    """A ball of this radius [m] about centre + s spans[0] + t spans[1], -1 ≤ s, t ≤ 1, in tip axes [m]. centre (3,).
    spans (2, 3) : half the edges, across each other; zero for a line's second and both of a ball's.
    """

    centre: Array
    spans: Array
    radius: float


@dataclass(frozen=True, slots=True)
class TipShape:
    """One convex shape of a fingertip: coal's geometry and its placement in the tip frame.

    radius : [m] of a sphere, None for other shapes. is_central : whether it is a sphere about the origin of the tip
    frame. name : for messages. face : the ball, line or face of it, in the tip frame, that alone is where it touches;
    None: not known, or a sphere's. corner (3,) : of the object, in the axes of its shape, which stands on the face;
    None: what is nearest touches.
    """

    geometry: Any
    rotation: Array
    translation: Array
    radius: float | None
    is_central: bool = False
    name: str = "a fingertip"
    face: SweptBall | None = None
    corner: Array | None = None

    @property
    def middle(self) -> Array:
        """(3,) where it touches, or near there, in the tip frame."""
        face = None if self.corner is not None else self.swept_ball
        return self.translation if face is None else face.centre

    @property
    def swept_ball(self) -> SweptBall | None:
        """The swept ball that it is, where it touches; None: another shape."""
        if self.radius is not None:
            return SweptBall(self.translation, np.zeros((2, 3)), self.radius)
        return self.face


class TipGeometry:
    """The shapes of the fingertips: spheres of given radii, else the robot's own geometry, read when asked for."""

    __slots__ = ("_found", "_round", "_tips", "description")

    def __init__(self, description: RobotDescription, tips: TipFrames, radii: Mapping[str, float]) -> None:
        self.description, self._tips = description, tips
        self._found = {i: make_sphere_tip(radii[name]) for i, name in enumerate(tips.names) if name in radii}
        self._round = frozenset(self._found)

    def shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The shapes of the tip numbered `tip`. Raises URDFError when there are none."""
        if tip not in self._found:
            self._found[tip] = self._load_shapes(tip)
        return self._found[tip]

    def kind(self, tip: int) -> str:
        """What makes a tip: "radius", "collision" or "visual" geometry, "" for nothing."""
        return "radius" if tip in self._round else self._links(tip)[0]

    def _links(self, tip: int) -> tuple[str, set[str]]:
        """Which kind of geometry is the tip's, and of which links: its own, or all that move as one with it."""
        model, frame = self.description.model, self._tips.places[tip]
        links = [(i, f) for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY]
        for kind in (COLLISION, VISUAL):
            there = self.description.links_with(kind)
            shaped = [(i, f) for i, f in links if f.name in there]
            own = {f.name for i, f in shaped if frame.link in (i, f.parentFrame)}  # the link's frame, or its joint's
            if found := own or {f.name for _, f in shaped if f.parentJoint == frame.joint}:
                return kind, found
        return "", set()

    def _load_shapes(self, tip: int) -> tuple[TipShape, ...]:
        name, place = self._tips.names[tip], self._tips.places[tip].placement
        kind, links = self._links(tip)
        if not kind:
            raise URDFError("tip_radius", f"a radius for {name!r}, whose link has no geometry", "None")
        frames = self.description.model.frames
        parts = self.description.load_shapes(kind, links)
        return tuple(make_convex_shape(name, p.shape, place.actInv(frames[p.frame].placement), p) for p in parts)

    def covered_links(self, tip: int) -> set[str]:
        """The links whose collision geometry is the tip's."""
        kind, links = self._links(tip)
        return links if kind == COLLISION and tip not in self._round else set()

    @classmethod
    def from_shapes(
        cls, description: RobotDescription, tips: TipFrames, shapes: Sequence[tuple[TipShape, ...]]
    ) -> TipGeometry:
        """Of tips whose shapes are known, one tuple for each."""
        made = cls(description, tips, {})
        made._found = dict(enumerate(shapes))
        return made


def make_sphere_tip(radius: float) -> tuple[TipShape, ...]:
    """A sphere about the origin of the tip frame."""
    return (TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(np.zeros(3)), radius, True),)


def read_tip_radii(value: Any, tips: Sequence[str]) -> dict[str, float]:
    """Radii by tip name [m] from None (no radii), a number (all tips) or a mapping. Raises InputError, UnknownName."""
    if value is None:
        return {}
    if isinstance(value, Mapping):
        given = check_keys("tip_radius", value, tips, "a fingertip")
        return {tip: _read_radius(f"tip_radius[{tip!r}]", r) for tip, r in given.items()}
    return dict.fromkeys(tips, _read_radius("tip_radius", value))


def _read_radius(argument: str, value: Any) -> float:
    radius = check_number(argument, value, above=0.0)
    if radius > _MAX_TIP_RADIUS:
        expected = f"a radius in metres (if millimetres are meant, {radius / 1e3:g})"
        raise InputError(argument, expected, f"{radius:g}, a fingertip {2 * radius:g} m wide")
    return radius


def make_convex_shape(name: str, geometry: Any, link: Any, part: LinkShape) -> TipShape:
    """A part of a link as that of a tip; link : where the link's frame is in the tip's. A mesh becomes its hull."""
    if isinstance(geometry, coal.BVHModelBase):
        if (made := convex_hull(np.array(geometry.vertices(), dtype=float))) is None:
            raise URDFError("source", f"a mesh for {name!r} that encloses a volume", "one that is flat")
        geometry = made
    elif not isinstance(geometry, _CONVEX_SHAPES):
        expected = f"a radius for {name!r}, whose geometry is no convex shape"
        raise URDFError("tip_radius", expected, type(geometry).__name__)
    placement = link * pin.SE3(part.rotation, part.position)
    radius = float(geometry.radius) if isinstance(geometry, coal.Sphere) else None
    rotation, translation = read_only(placement.rotation.copy()), read_only(placement.translation.copy())
    central = radius is not None and not translation.any()
    return TipShape(geometry, rotation, translation, radius, central, name)
