"""Fingertips: which links may be one, where a link ends, and the frames that are chosen."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, read_only
from handlcp.errors import HandLCPError, InputError, UnknownName
from handlcp.hand.robot.link_surface import surface_points
from handlcp.hand.robot.linkages import linkage_bars
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description
from handlcp.hand.robot.source.part import Part

# ----------------------------------------------------------------
# Where a link ends: the middle of the round end that its geometry has farthest from its joint.
#
# The link points from the joint's axis to the middle of its geometry. The end is the last fifth of its length from
# there. The point lies in the middle of the end's width, and below the outermost surface by half of the end's
# thickness, as the centre of a ball that would just fill a round end.

_END = 0.2  # of the link's length
_DIGITS = 4  # a tenth of a millimetre


def far_end(parts: Sequence[Part], origin: Array, axis: Array) -> Array | None:
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
    end = points[along > (1.0 - _END) * along.max()]
    side = np.cross(way, axis if abs(way @ axis) < 0.9 else np.eye(3)[int(abs(way).argmin())])
    side = side / np.linalg.norm(side)
    sides = np.stack([side, np.cross(way, side)])
    spread = end @ sides.T
    middle, half = 0.5 * (spread.min(axis=0) + spread.max(axis=0)), 0.5 * np.ptp(spread, axis=0)
    depth = min(float(half.min()), 0.5 * float(np.ptp(along)))
    point = middle @ sides + way * (origin @ way + float(along.max()) - depth)
    return read_only(np.round(point, _DIGITS) + 0.0)


# ----------------------------------------------------------------
# What looks like a fingertip: at the end of each chain of joints, a frame called one, or the link's far end.

_FEWEST, _MOST = 2, 5  # fingers of a hand whose fingertips may be taken without being named


@dataclass(frozen=True, slots=True)
class Candidate:
    """One fingertip that could be meant. name : as `fingertips` takes it. link : that carries it. point : (3,) on the
    link, in its frame [m]; None: the origin of the frame. reason : why it could be one. sure : whether nothing else of
    its finger could be.
    """

    name: str
    link: str
    point: Array | None
    reason: str
    sure: bool
    called_tip: bool = False

    def __str__(self) -> str:
        return f"{self.name}: {self.reason}"


def candidates(description: Description) -> tuple[Candidate, ...]:
    """One or more for each chain of movable joints that ends, in Pinocchio's order of joints. Bars of linkages that end
    at another link are none.
    """
    model = description.model
    inner = {int(model.parents[j]) for j in range(1, model.njoints)}
    ends = [j for j in range(1, model.njoints) if j not in inner and model.joints[j].nv]
    called, bars = _called_tip(model), linkage_bars(description)
    out: list[Candidate] = []
    for joint in sorted({*ends, *(model.frames[i].parentJoint for i in called)}):
        names = [model.frames[i].name for i in called if model.frames[i].parentJoint == joint]
        if names:
            out += [Candidate(name, name, None, _said(name), True, True) for name in names]
        elif joint not in bars:
            out += _of_end(description, joint)
    return tuple(out)


# What may follow "tip" in the name of one: a word for what it is, a side, or a number.
_AFTER_TIP = re.compile(r"[_\-. ]*(link|frame|site|body|pad|left|right|\d+|(?<=[_\-. ])[lr])$", re.IGNORECASE)


def _is_called_tip(name: str) -> bool:
    """Whether a name says that it is a fingertip's: "index_tip", "thumb_tip_link", "finger_tip_1"."""
    while (shorter := _AFTER_TIP.sub("", name)) != name:
        name = shorter
    return name.lower().endswith("tip")


def _said(name: str) -> str:
    return 'its name ends in "tip"' if name.lower().endswith("tip") else "its name says that it is a fingertip"


def obvious(found: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The fingertips that need no naming: those whose names say so; else all, if they are two to five and sure."""
    if called := [c for c in found if c.called_tip]:
        return tuple(called)
    return tuple(found) if _FEWEST <= len(found) <= _MOST and all(c.sure for c in found) else ()


def _called_tip(model: Any) -> list[int]:
    """Leaf frames that a joint moves, and whose names say that they are fingertips."""
    parents = {frame.parentFrame for frame in model.frames}
    frames = [(i, f) for i, f in enumerate(model.frames) if i not in parents and _is_called_tip(f.name)]
    return [i for i, f in frames if any(model.joints[j].nv for j in model.supports[f.parentJoint] if j)]


def _of_end(description: Description, joint: int) -> list[Candidate]:
    """Candidates on what the last joint of a chain moves: a marker fixed to it, else the far end of its geometry."""
    model, name = description.model, description.model.names[joint]
    links = [(i, f) for i, f in enumerate(model.frames) if f.parentJoint == joint and f.type == pin.FrameType.BODY]
    shaped = {kind: set(description.has(kind)) for kind in (COLLISION, VISUAL)}
    seen = shaped[COLLISION] | shaped[VISUAL]
    fixed_on = {int(model.frames[f.parentFrame].parentFrame) for _, f in links}
    markers = [f for i, f in links[1:] if f.name not in seen and i not in fixed_on]
    if markers:
        reason = f"a frame without geometry, fixed to what the last joint {name} moves"
        return [Candidate(f.name, f.name, None, reason, len(markers) == 1) for f in markers]
    for kind in (COLLISION, VISUAL):
        there = [f for _, f in links if f.name in shaped[kind]]
        if there and (made := _far_end(description, joint, there[-1], kind, len(there) == 1)):
            return [made]
    return [
        Candidate(f.name, f.name, None, f"the last link, moved by {name}; it has no geometry", False) for _, f in links
    ]


def _far_end(description: Description, joint: int, frame: Any, kind: str, alone: bool) -> Candidate | None:
    """The far end of a link's geometry; without a point where its meshes cannot be read."""
    model = description.model
    last = f"the last link, moved by {model.names[joint]}"
    try:
        parts = description.parts(kind, {frame.name})
    except HandLCPError:
        return Candidate(frame.name, frame.name, None, f"{last}; its meshes cannot be read", False)
    origin = frame.placement.inverse().translation.copy()
    axis = frame.placement.rotation.T @ _axis(model.joints[joint])
    point = far_end(parts, origin, axis)
    if point is None:
        return None
    x, y, z = (f"{1e3 * v:.1f}" for v in point)
    how = f"{last}; the point ({x}, {y}, {z}) mm is at the far end of its {kind} geometry"
    return Candidate(frame.name, frame.name, point, how, alone or kind == COLLISION)


def _axis(joint: Any) -> Array:
    """(3,) direction of a joint's axis, in its frame."""
    subspace = np.asarray(joint.createData().S if hasattr(joint.createData(), "S") else np.zeros((6, 1))).reshape(6, -1)
    way = subspace[3:, 0] if subspace[3:, 0].any() else subspace[:3, 0]
    return np.asarray(way, dtype=float)


# ----------------------------------------------------------------
# The fingertips as frames of Pinocchio's model; a point on a link becomes a frame of its own.

_FORMS = 'names of links or frames, such as ["thumb_tip", ("index_3", (0, 0, 0.03))] or {"thumb": "thumb_tip"}'
_FARTHEST = 1.0  # [m] a point from its link's frame


@dataclass(frozen=True, slots=True)
class TipPlace:
    """link : number of the frame that was named. joint : of the joint that carries it. placement : of the tip in that
    joint's frame.
    """

    link: int
    joint: int
    placement: Any


class TipFrames:
    """The fingertips in Pinocchio's model.

    names, frames : n names and frame numbers. places : where they are on their links.
    support : (n, 1, joints), 1 where a joint moves a tip. every : 0 to n-1.
    """

    __slots__ = ("every", "frames", "names", "places", "support")

    def __init__(
        self, names: tuple[str, ...], frames: tuple[int, ...], places: tuple[TipPlace, ...], support: Array
    ) -> None:
        self.names, self.frames, self.places, self.support = names, frames, places, read_only(support)
        self.every = tuple(range(len(names)))


def find_tips(model: Any, description: Description, fingertips: Any) -> TipFrames:
    """The fingertips that are named; None: those that are obvious.

    model : a copy of the description's, to which points on links are added as frames. Raises UnknownName (before
    Pinocchio sees the name, which may crash on an unknown one), InputError.
    """
    named = _obvious(description) if fingertips is None else _named(fingertips)
    known = [f.name for f in model.frames if f.name != "universe"]
    if unknown := [str(link) for _, link, _ in named if not isinstance(link, str) or link not in known]:
        raise UnknownName("fingertips", "a frame", unknown, known)
    names = tuple(name for name, _, _ in named)
    if len(set(names)) != len(names) or not names:
        raise InputError("fingertips", "different frame names, at least one", repr(list(names)))
    last = {frame.name: i for i, frame in enumerate(model.frames)}  # the link, where a joint has the same name
    places, frames = list[TipPlace](), list[int]()
    support = np.zeros((len(names), 1, model.nv))
    for (name, link, point), row in zip(named, support, strict=True):
        frame = model.frames[last[link]]
        _check_moved(model, frame, row)
        if point is None and name == link:
            at, number = frame.placement, last[link]
        else:
            at = frame.placement * pin.SE3(np.eye(3), np.zeros(3) if point is None else np.array(point))
            number = _added(model, name, frame, last[link], at, name in known and name != link)
        frames.append(number)
        places.append(TipPlace(last[link], int(frame.parentJoint), pin.SE3(at)))
    return TipFrames(names, tuple(frames), tuple(places), support)


def _obvious(description: Description) -> list[tuple[str, str, Array | None]]:
    found = candidates(description)
    if taken := obvious(found):
        return [(c.name, c.link, c.point) for c in taken]
    if not found:
        every = [f.name for f in description.model.frames if f.name != "universe"]
        raise UnknownName("fingertips", "names of fingertips (nothing looks like one)", [], every)
    proposed = "; ".join(str(c) for c in found)
    expected = f"the names of the fingertips, which are not obvious ({proposed}): some"
    raise UnknownName("fingertips", expected, [], [c.name for c in found])


def _named(given: Any) -> list[tuple[Any, Any, Array | None]]:
    """(name, link, point) of each from what users pass. Raises InputError."""
    pairs: Iterable[tuple[Any, Any]]
    if isinstance(given, Mapping):
        pairs = given.items()
    elif isinstance(given, str) or not isinstance(given, Sequence):
        raise InputError("fingertips", _FORMS, repr(given)[:80])
    else:
        pairs = [(one[0] if isinstance(one, tuple) and one else one, one) for one in given]
    return [_one(name, value) for name, value in pairs]


def _one(name: Any, value: Any) -> tuple[Any, Any, Array | None]:
    if not isinstance(value, (tuple, list)):
        return name, value, None
    if len(value) != 2 or not isinstance(value[0], str):
        raise InputError(
            f"fingertips[{name!r}]", 'a link, or a link and a point on it, ("link", (x, y, z))', repr(value)[:80]
        )
    point = array(f"fingertips[{name!r}]", value[1], (3,), what="the point on the link [m], in the link's frame,")
    if abs(point).max() > _FARTHEST:
        expected = "a point on the link in metres (millimetres? divide by 1000)"
        raise InputError(f"fingertips[{name!r}]", expected, f"{point.tolist()}")
    return name, value[0], point


def _check_moved(model: Any, frame: Any, row: Array) -> None:
    """Mark the joints that move a frame. Raises InputError for none."""
    for joint in model.supports[frame.parentJoint]:
        if joint and model.joints[joint].nv:
            row[0, model.joints[joint].idx_v] = 1.0
    if not row.any():
        came = f"{frame.name!r}, which is fixed to the base"
        expected = "frames that a joint moves (what stands still, such as a palm, touches as environment= of the grasp)"
        raise InputError("fingertips", expected, came)


def _added(model: Any, name: Any, frame: Any, number: int, place: Any, taken: bool) -> int:
    """The number of a new frame on a link. Raises InputError for a name that is none, or another frame's."""
    if not isinstance(name, str) or not name or taken:
        came = f"{name!r}, which is another frame" if taken else repr(name)
        raise InputError("fingertips", "a name of its own for a point on a link", came)
    return int(model.addFrame(pin.Frame(name, frame.parentJoint, number, place, pin.FrameType.OP_FRAME)))
