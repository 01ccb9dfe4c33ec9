"""`MeshPack`: bodies of a page: parts, their meshes, simplified where they are heavy."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand import HandState
from handlcp.viz.picture.body import Body, Colour, environment_bodies
from handlcp.viz.picture.content import PictureContent
from handlcp.viz.style import INK, RED, hex_to_rgb

# ----------------------------------------------------------------
# Fewer triangles: corners that share a small cell become one.

_FINEST_CELLS, _COARSEST_CELLS = 400, 16  # cells along the longest edge
_CELL_STEP_FACTOR = 0.97


def simplify_triangles(triangles: Array, most: int) -> Array:
    """At most so many triangles of (m, 3, 3), if cells of 1/16 of their extent are coarse enough; all where they are
    few.
    """
    cells, found = _FINEST_CELLS, triangles
    while len(found) > most and cells >= _COARSEST_CELLS:
        found = _cluster_corners(triangles, cells)
        cells = min(cells - 1, int(_CELL_STEP_FACTOR * cells * np.sqrt(most / max(len(found), 1))))
    return found


def _cluster_corners(triangles: Array, cells: int) -> Array:
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

NO_JOINT = -1
MAX_TRIANGLES = 100_000  # triangles of a hand, and of an object; more are simplified
_MIN_LINK_TRIANGLES = 200  # of one link
_MARK_SHARE = 0.55  # share of the mark's colour in that of a link inside the object


@dataclass(frozen=True, slots=True)
class PagePart:
    """A solid of a page, with what moves it.

    triangles (m, 3, 3) : corners [m], in axes of what moves it when nothing has moved.
    layer : "hand", "inside" (a link inside the object), "tips" (the shape that finds a contact), "environment",
        "object".
    joint : number of the joint that moves it; -1: none.
    original_count : how many triangles it had before it was simplified.
    """

    triangles: Array
    colour: Colour
    layer: str
    joint: int = NO_JOINT
    original_count: int = 0


def make_parts(shown: PictureContent) -> list[PagePart]:
    """Everything that a picture shows, simplified where it has very many triangles."""
    table = environment_bodies(shown.grasp)
    hand = shown.solids[: len(shown.solids) - len(table)]
    state = getattr(shown.grasp, "state", None)
    if state is None:
        found = [_make_part(b, "hand") for b in hand]
    else:
        found = list(_link_parts(state, hand, shown.tip_triangles))
    found = _limit_triangles(found) + [_make_part(b, "environment") for b in table]
    return found + _limit_triangles([_make_part(b, "object") for b in (shown.object_body,) if b is not None])


def drawing_notes(shown: PictureContent, parts: Sequence[PagePart]) -> list[str]:
    """What a reader should know of how things are drawn."""
    notes = list[str]()
    if not hasattr(shown.grasp, "state"):
        notes.append("The grasp has no hand: rods stand for its fingers.")
    if shown.object_body is not None and shown.object_body.label != "object":
        notes.append("The object is not known: the hull of the contacts stands for it.")
    for name, layers in (("hand", ("hand", "inside")), ("object", ("object",))):
        drawn = [p for p in parts if p.layer in layers]
        now, before = sum(len(p.triangles) for p in drawn), sum(p.original_count for p in drawn)
        if now < before:
            notes.append(f"The {name} is simplified: it is drawn with {now} of its {before} triangles.")
    return notes


def _make_part(body: Body, layer: str) -> PagePart:
    return PagePart(body.triangles, body.colour, layer, original_count=len(body.triangles))


def _link_parts(state: HandState, bodies: Sequence[Body], tips: Sequence[Array]) -> Iterator[PagePart]:
    """Bodies and fingertips in world axes, taken to those of their joints."""
    hand = state.hand
    model, data = hand.model, hand.model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    joint_of = {f.name: int(f.parentJoint) for f in model.frames if f.type == pin.FrameType.BODY}
    for b in bodies:
        joint, layer, colour = joint_of.get(b.link, 0), "inside" if b.is_marked else "hand", b.colour
        if b.is_marked:
            mixed = (1.0 - _MARK_SHARE) * np.array(b.colour) + _MARK_SHARE * np.array(hex_to_rgb(RED))
            colour = (float(mixed[0]), float(mixed[1]), float(mixed[2]))
        yield PagePart(_to_joint_axes(b.triangles, data.oMi[joint]), colour, layer, joint, len(b.triangles))
    ink = hex_to_rgb(INK)
    for triangles in tips:
        away = np.linalg.norm(state.tip_positions - triangles.mean(axis=(0, 1)), axis=1)
        joint = int(model.frames[hand.tips.frames[int(away.argmin())]].parentJoint)
        yield PagePart(_to_joint_axes(triangles, data.oMi[joint]), ink, "tips", joint, len(triangles))


def _to_joint_axes(triangles: Array, joint: Any) -> Array:
    """World axes to those of a joint."""
    return np.asarray((triangles - joint.translation) @ joint.rotation)


def _limit_triangles(parts: list[PagePart]) -> list[PagePart]:
    """With at most so many triangles in all, each part's share as it was."""
    share = MAX_TRIANGLES / max(sum(len(p.triangles) for p in parts), 1)
    if share >= 1.0:
        return parts
    return [
        replace(p, triangles=simplify_triangles(p.triangles, max(_MIN_LINK_TRIANGLES, int(share * len(p.triangles)))))
        for p in parts
    ]


# ----------------------------------------------------------------
# Triangles as few bytes: corners on a grid of 65535 along each edge of their box, shared between triangles.
#
# Which corners make triangles is stored once for shapes that differ in size and direction alone, such as two spheres.

_GRID_STEPS = 65534  # even: what lies in the middle is on the grid, too
_MAX_SHORT_INDEX = 65536  # points that two bytes can number


class MeshPack:
    """All shapes of a page, packed into as few bytes as they need."""

    def __init__(self) -> None:
        self._offsets: dict[bytes, int] = {}
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
        grid = np.round((triangles - low) * (_GRID_STEPS / np.where(size > 0.0, size, 1.0))).astype(np.uint16)
        # Points in the order in which corners first name them
        keys = (grid.reshape(-1, 3).astype(np.uint64) << np.array([32, 16, 0], dtype=np.uint64)).sum(axis=1)
        _, first, corner = np.unique(keys, return_index=True, return_inverse=True)
        order = np.argsort(first)
        points, corners = grid.reshape(-1, 3)[first[order]], np.argsort(order)[corner].reshape(-1, 3)
        a, b, c = corners.T
        corners = corners[(a != b) & (b != c) & (c != a)]
        wide = len(points) > _MAX_SHORT_INDEX
        packed = corners.astype("<u4" if wide else "<u2")
        return {
            "low": low,
            "size": size,
            "points": [self._store(points.astype("<u2").tobytes()), len(points)],
            "corners": [self._store(packed.tobytes()), len(corners)],
            "wide": wide,
        }

    def to_base64(self) -> str:
        """All of them, gzip in base64."""
        return base64.b64encode(gzip.compress(bytes(self._bytes), 9, mtime=0)).decode("ascii")

    def _store(self, data: bytes) -> int:
        """Where these bytes are; numbers of four bytes must begin at a multiple of four."""
        if data not in self._offsets:
            self._offsets[data] = len(self._bytes)
            self._bytes += data + bytes(-len(data) % 4)
        return self._offsets[data]
