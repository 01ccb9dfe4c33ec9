"""The fingertips as frames of Pinocchio's model; a point on a link becomes a frame of its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.hand.robot.fingertips.candidates import candidates, obvious
from handlcp.hand.robot.source.description import Description

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
