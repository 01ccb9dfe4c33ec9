"""Bodies of a page: parts, their meshes, simplified where they are heavy."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, Ints
from handlcp.hand import HandState
from handlcp.show.picture.bodies import Body, Colour, environment_bodies
from handlcp.show.picture.content import Content
from handlcp.show.style import INK, RED, rgb

# ----------------------------------------------------------------
# Fewer triangles: corners that share a small cell become one.

_FINEST, _COARSEST = 400, 16  # cells along the longest edge
_SAFE = 0.97


def simplified(triangles: Array, most: int) -> Array:
    """At most so many triangles of (m, 3, 3), if cells of 1/16 of their extent are coarse enough; all where they are
    few.
    """
    cells, found = _FINEST, triangles
    while len(found) > most and cells >= _COARSEST:
        found = _clustered(triangles, cells)
        cells = min(cells - 1, int(_SAFE * cells * np.sqrt(most / max(len(found), 1))))
    return found


def _clustered(triangles: Array, cells: int) -> Array:
    """Each corner moved to the mean of those in its cell; triangles without an area left out."""
    points = triangles.reshape(-1, 3)
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max()) or 1.0
    places = np.floor((points - low) * (cells / size)).astype(np.int64)
    wide = cells + 1
    keys = (places[:, 0] * wide + places[:, 1]) * wide + places[:, 2]
    _, cell, count = np.unique(keys, return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(cell, points[:, k]) for k in range(3)], axis=1) / count[:, None]
    corners = cell.reshape(-1, 3)
    a, b, c = corners.T
    whole = corners[(a != b) & (b != c) & (c != a)]
    i, j, k = np.sort(whole, axis=1).T
    _, first = np.unique((i * len(mean) + j) * len(mean) + k, return_index=True)
    return np.asarray(mean[whole[np.sort(first)]])


# ----------------------------------------------------------------
# The solids of a page, each with what moves it: a joint of the hand, the object, or nothing.

FIXED = -1
MOST = 100_000  # triangles of a hand, and of an object; more are simplified
_LEAST = 200  # of one link
_MARK = 0.55  # share of the mark's colour in that of a link inside the object


@dataclass(frozen=True, slots=True)
class Part:
    """A solid of a page, with what moves it.

    triangles (m, 3, 3) : corners [m], in axes of what moves it when nothing has moved.
    layer : "hand", "inside" (a link inside the object), "tips" (the shape that finds a contact), "environment",
        "object".
    joint : number of the joint that moves it; -1: none.
    before : how many triangles it had before it was simplified.
    """

    triangles: Array
    colour: Colour
    layer: str
    joint: int = FIXED
    before: int = 0


def parts_of(shown: Content) -> list[Part]:
    """Everything that a picture shows, simplified where it has very many triangles."""
    table = environment_bodies(shown.grasp)
    hand = shown.solids[: len(shown.solids) - len(table)]
    state = getattr(shown.grasp, "state", None)
    found = [_part(b, "hand") for b in hand] if state is None else list(_links(state, hand, shown.tips))
    found = _fewer(found) + [_part(b, "environment") for b in table]
    return found + _fewer([_part(shown.glass, "object")] if shown.glass is not None else [])


def notes_of(shown: Content, parts: Sequence[Part]) -> list[str]:
    """What a reader should know of how things are drawn."""
    notes = list[str]()
    if not hasattr(shown.grasp, "state"):
        notes.append("The grasp has no hand: rods stand for its fingers.")
    if shown.glass is not None and shown.glass.label != "object":
        notes.append("The object is not known: the hull of the contacts stands for it.")
    for name, layers in (("hand", ("hand", "inside")), ("object", ("object",))):
        drawn = [p for p in parts if p.layer in layers]
        now, before = sum(len(p.triangles) for p in drawn), sum(p.before for p in drawn)
        if now < before:
            notes.append(f"The {name} is simplified: it is drawn with {now} of its {before} triangles.")
    return notes


def _part(body: Body, layer: str) -> Part:
    return Part(body.triangles, body.colour, layer, before=len(body.triangles))


def _links(state: HandState, bodies: Sequence[Body], tips: Sequence[Array]) -> Iterator[Part]:
    """Bodies and fingertips in world axes, taken to those of their joints."""
    hand = state.hand
    model, data = hand.model, hand.model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    joint_of = {f.name: int(f.parentJoint) for f in model.frames if f.type == pin.FrameType.BODY}
    for b in bodies:
        joint, layer = joint_of.get(b.link, 0), "inside" if b.marked else "hand"
        yield Part(_taken(b.triangles, data.oMi[joint]), _marked(b), layer, joint, len(b.triangles))
    ink = rgb(INK)
    for triangles in tips:
        away = np.linalg.norm(state.tip_positions - triangles.mean(axis=(0, 1)), axis=1)
        joint = int(model.frames[hand.tips.frames[int(away.argmin())]].parentJoint)
        yield Part(_taken(triangles, data.oMi[joint]), ink, "tips", joint, len(triangles))


def _taken(triangles: Array, joint: Any) -> Array:
    """World axes to those of a joint."""
    return np.asarray((triangles - joint.translation) @ joint.rotation)


def _marked(body: Body) -> Colour:
    if not body.marked:
        return body.colour
    r, g, b = ((1.0 - _MARK) * np.array(body.colour) + _MARK * np.array(rgb(RED))).tolist()
    return (r, g, b)


def _fewer(parts: list[Part]) -> list[Part]:
    """With at most so many triangles in all, each part's share as it was."""
    share = MOST / max(sum(len(p.triangles) for p in parts), 1)
    if share >= 1.0:
        return parts
    return [replace(p, triangles=simplified(p.triangles, max(_LEAST, int(share * len(p.triangles))))) for p in parts]


# ----------------------------------------------------------------
# Triangles as few bytes: corners on a grid of 65535 along each edge of their box, shared between triangles.
#
# Which corners make triangles is stored once for shapes that differ in size and direction alone, such as two spheres.

_GRID = 65534  # even: what lies in the middle is on the grid, too
_SHORT = 65536  # points that two bytes can number


class Meshes:
    """All shapes of a page, packed into as few bytes as they need."""

    def __init__(self) -> None:
        self._known: dict[bytes, int] = {}
        self._bytes = bytearray()

    def add(self, triangles: Array) -> dict[str, Any]:
        """Store a shape (m, 3, 3) [m], and return how the viewer finds it again:

        low, size : the box that the shape fills [m], axes of the shape.
        points : where its points begin among the bytes, 3 × uint16 each, and how many there are.
        corners : where its triangles begin, three numbers of points each, and how many there are.
        wide : whether these numbers are uint32, not uint16.
        """
        low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        size = high - low
        grid = np.round((triangles - low) * (_GRID / np.where(size > 0.0, size, 1.0))).astype(np.uint16)
        points, corners = _shared(grid.reshape(-1, 3))
        wide = len(points) > _SHORT
        packed = corners.astype("<u4" if wide else "<u2")
        return {
            "low": low,
            "size": size,
            "points": [self._at(points.astype("<u2").tobytes()), len(points)],
            "corners": [self._at(packed.tobytes()), len(corners)],
            "wide": wide,
        }

    def packed(self) -> str:
        """All of them, gzip in base64."""
        return base64.b64encode(gzip.compress(bytes(self._bytes), 9, mtime=0)).decode("ascii")

    def _at(self, data: bytes) -> int:
        """Where these bytes are; numbers of four bytes must begin at a multiple of four."""
        if data not in self._known:
            self._known[data] = len(self._bytes)
            self._bytes += data + bytes(-len(data) % 4)
        return self._known[data]


def _shared(grid: Array) -> tuple[Array, Ints]:
    """Points (k, 3) in the order in which (3m, 3) corners first name them, and their numbers (m, 3)."""
    keys = (grid.astype(np.uint64) << np.array([32, 16, 0], dtype=np.uint64)).sum(axis=1)
    _, first, corner = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    corners = rank[corner].reshape(-1, 3)
    a, b, c = corners.T
    return grid[first[order]], corners[(a != b) & (b != c) & (c != a)]
