"""`ContactTracker`: where shapes that lie flush, edge on edge or face on face, press on each other.

The nearest point alone jumps from one corner to another as the shapes tilt, and a body that leans on both would be held
by neither. A pad spreads its pressure instead. With the gaps g_k of the corners, and weights λ_k ≥ 0, Σ λ_k = 1,

    gap = min over λ of Σ λ_k g_k + c / 2 (Σ λ_k² - 1)        pressed at Σ λ_k x_k

so that ∂gap/∂g_k = λ_k: the contact's point is where its gap says that it is. One corner carries all of it where the
others are farther by more than c, which is a tilt by a thousandth of a radian; side by side they share, and the gap
is c / 4 less for two of them, a few micrometres.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.contact.closest_point import TILT_ANGLE, write_corner_contact
from handlcp.geometry.contact_detection import (
    Proximity,
    choose_corners,
    find_tilted_points,
    is_wide,
    quick_proximity,
    shape_proximity,
    tilt_gap_change,
)
from handlcp.geometry.distance import shape_size
from handlcp.geometry.object import Object
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.path.newton.tangent import skew
from handlcp.lcp.kernels.dense import kernel, product

# Of the corners' distance: one that weighs something is found, whichever way it lies
_FLUSH_WIDTH_SHARE = 0.5 * TILT_ANGLE


class FlushContact(NamedTuple):
    """Corners (m, 3) of what a fingertip touches, on the object, their gaps (m,) and how these change with the
    fingertip's motion (m, 6), about its place; across (3, 3) : takes off what lies along the line or face. width c.
    """

    corners: Array
    gaps: Array
    rates: Array
    across: Array
    width: float

    def press_at(self, by: Array) -> tuple[Array, float, Array]:
        """Where it presses (3,), the gap, and how that point moves (3, 6), once the fingertip has moved by (6,)."""
        gaps = self.gaps + self.rates @ by
        # λ, the projection of -g / c on the simplex
        beyond = (gaps - gaps.min()) / self.width
        order = np.sort(beyond)
        level = (np.cumsum(order) + 1.0) / np.arange(1, len(gaps) + 1)
        weights = np.maximum(float(level[np.flatnonzero(order < level)[-1]]) - beyond, 0.0)
        active = weights > 0.0
        change = np.zeros_like(self.rates)
        change[active] = (self.rates[active].mean(axis=0) - self.rates[active]) / self.width
        gap = float(weights @ gaps) + 0.5 * self.width * (float(weights @ weights) - 1.0)
        return weights @ self.corners, gap, self.corners.T @ change


def find_flush_contact(
    tip: tuple[Any, ...], at: Array, own: Array, near: Proximity, obj: Object, apart: float
) -> FlushContact | None:
    """Of a fingertip at (3,) with rotation own (3, 3), so near to the object. None: they touch at a point, as curved
    surfaces do, whose corners would be no farther apart than `apart` [m].
    """
    points, opposite = find_tilted_points(tip, at, own, obj, near)
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle)[2]
    flat = (points - middle) @ axes[:2].T
    if not is_wide(flat[:, 0], apart):
        return None
    chosen = choose_corners(flat, apart)
    n, x = near.normal, opposite[chosen]
    gaps = (x - points[chosen]) @ n
    gaps += near.gap - gaps.min()
    arms = x - at
    rates = -np.hstack([np.tile(n, (len(x), 1)), np.cross(arms, n)])
    wide = axes[: 1 + int(is_wide(flat[:, 1], apart))]
    between = np.linalg.norm(points[chosen, None] - points[chosen], axis=2)
    width = _FLUSH_WIDTH_SHARE * float(between[between > 0.0].min())
    return FlushContact(x, gaps, rates, np.eye(3) - wide.T @ wide, width)


# ----------------------------------------------------------------
# Contacts of shapes that are detected: where they are, and how they turn and shift as a fingertip moves.
#
# How follows from differences between detections a small step to either side. Two things jump between these. Where
# edges or faces lie flush the nearest point jumps from one corner to another: `flush`. Where the contact comes to a
# sharp edge its normal jumps. There it turns along a radius of 3 mm instead, as what bears on an edge has a pad: a
# turn that is sharper than what the fingers can follow has no step that leads on.


# Of the object's size: differences of detected contacts, whose points are good to a millionth or less
_DIFFERENCE_STEP = 2e-3
_MAX_NORMAL_TURN = 300.0  # [1/m] how fast a normal turns at an edge at most
# Of an edge's normals on either side: they differ by this much, or from the one between them by this share more on one
# side than on the other
_EDGE_NORMAL_DIFFERENCE, _EDGE_UNEVENNESS = 0.3, 0.5
# Normals that differ by less are those of a face
_FACE_NORMAL_DIFFERENCE = 1e-3 * _EDGE_NORMAL_DIFFERENCE / _EDGE_UNEVENNESS


ContactArrays: TypeAlias = tuple[Array, Array, Array, Array, Array]


class DetectedContacts(NamedTuple):
    """Fingertips where they were detected, in the object's axes: at (k, 3) with rotations own (k, 3, 3), NaN before;
    the contact's position, normal (k, 3) and gap (k,), and how it turns and shifts (k, 3, 6).
    """

    tip_positions: Array
    tip_rotations: Array
    position: Array
    normal: Array
    gap: Array
    turn: Array
    shift: Array

    @classmethod
    def empty(cls, k: int) -> DetectedContacts:
        """Of k fingertips none."""
        return cls(*[np.full((k, *more), np.nan) for more in ((3,), (3, 3), (3,), (3,), (), (3, 6), (3, 6))])

    def store(self, i: int, at: Array, own: Array, near: Proximity, turn: Array, shift: Array) -> None:
        """The i-th was detected."""
        self.tip_positions[i], self.tip_rotations[i], self.turn[i], self.shift[i] = at, own, turn, shift
        self.position[i], self.normal[i], self.gap[i] = near.position, near.normal, near.gap


@kernel
def _motion_since(
    places: Array, turns: Array, R: Array, t: Array, seen: DetectedContacts, size: float, by: Array, far: Array
) -> None:
    """Write by (k, 6), how far fingertips, the first of places (n, 3) with rotations turns (n, 3, 3), have moved since
    they were seen, in the axes of an object that has moved by x ↦ R x + t; and far (k,) [m] of an object of this size
    [m], NaN where they were not seen.
    """
    turned = np.empty((3, 3))
    for i in range(len(seen.tip_positions)):  # contacts of the environment come after those of the fingertips
        moved2, turned2, trace = 0.0, 0.0, 0.0
        for a in range(3):
            by[i, a] = -seen.tip_positions[i, a]
            for b in range(3):
                by[i, a] += R[b, a] * (places[i, b] - t[b])
            moved2 += by[i, a] ** 2
        now = product(R.T, turns[i])
        for a in range(3):
            for b in range(3):
                turned2 += (now[a, b] - seen.tip_rotations[i, a, b]) ** 2
        far[i] = np.sqrt(moved2) + size * np.sqrt(turned2)
        turned[:] = product(now, seen.tip_rotations[i].T)
        for a in range(3):
            trace += turned[a, a]
            by[i, 3 + a] = 0.5 * (turned[(a + 2) % 3, (a + 1) % 3] - turned[(a + 1) % 3, (a + 2) % 3])
        sine = np.sqrt(by[i, 3] ** 2 + by[i, 4] ** 2 + by[i, 5] ** 2)
        if sine > 0.0:  # of the angle: by is the axis times it
            by[i, 3:] *= np.arctan2(sine, 0.5 * (trace - 1.0)) / sine


@kernel
def _carry_contacts(by: Array, R: Array, t: Array, seen: DetectedContacts, out: ContactArrays) -> None:
    """Write contacts of fingertips that have moved by (k, 6) since they were seen; out : as in `ContactFinder`."""
    positions, normals, gaps, turns, shifts = out
    n, x = np.empty(3), np.empty(3)
    for i in range(len(by)):
        arm, v, w = seen.position[i] - seen.tip_positions[i], by[i, :3], by[i, 3:]
        gaps[i] = seen.gap[i]
        length2 = 0.0
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            gaps[i] -= seen.normal[i, a] * (v[a] + w[b] * arm[c] - w[c] * arm[b])
            n[a], x[a] = seen.normal[i, a], seen.position[i, a]
            for k in range(6):
                n[a] += seen.turn[i, a, k] * by[i, k]
                x[a] += seen.shift[i, a, k] * by[i, k]
            length2 += n[a] ** 2
        n /= np.sqrt(length2)
        for a in range(3):
            positions[i, a], normals[i, a] = t[a], 0.0
            for b in range(3):
                positions[i, a] += R[a, b] * x[b]
                normals[i, a] += R[a, b] * n[b]
        for k in range(0, 6, 3):
            turns[i, :, k : k + 3] = product(product(R, seen.turn[i, :, k : k + 3]), R.T)
            shifts[i, :, k : k + 3] = product(product(R, seen.shift[i, :, k : k + 3]), R.T)


class ContactTracker:
    """Shapes that are detected, in the axes of the object where it was at the start: fingertips are moved back instead
    of the object. A fingertip that has moved by less than the steps of the differences since it was detected takes its
    contact along as they say: where an edge lies along the object, detection finds one of its ends or the other, and
    no step would converge.
    """

    noise = 1e-8

    def __init__(self, obj: Object, shapes: list[Any]) -> None:
        self.obj, self.shapes = obj, shapes
        self.step = _DIFFERENCE_STEP * float(np.cbrt(obj.volume)) if obj.volume > 0.0 else _DIFFERENCE_STEP * 0.05
        self.size = self.step / _DIFFERENCE_STEP
        ways = np.repeat(np.eye(6), 2, axis=0) * self.step
        ways[1::2] *= -1.0
        ways[6:] /= self.size
        # A step each way, what that turns, and how far the two of each axis are from each other
        self._ways, self._turned = ways, np.array([pin.exp3(way[3:]) for way in ways])
        self._steps = 2.0 * abs(ways[::2]).sum(axis=1)
        self._on_corners = [i for i, tip in enumerate(shapes) if tip[0].corner is not None]
        self._flush = dict[int, FlushContact]()  # of fingertips that do not touch at a point
        self._seen = DetectedContacts.empty(len(shapes))
        # How near each shape of a fingertip was at least, and how far from its place the shapes reach
        self._least = [np.full(len(tip), np.nan) for tip in shapes]
        self._reach = [
            max(float(np.linalg.norm(s.translation) + np.sqrt(3.0) * shape_size(s.geometry)) for s in tip)
            for tip in shapes
        ]

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Find the contacts in these places, as `ContactFinder` documents."""
        positions, normals, gaps, turn, shift = out
        by, far = np.empty((len(self.shapes), 6)), np.empty(len(self.shapes))
        _motion_since(places, turns, R, t, self._seen, self.size, by, far)
        for i in np.flatnonzero(~(far <= self.step)).tolist():
            if i not in self._on_corners:
                self._detect(i, R.T @ (places[i] - t), R.T @ turns[i])
                by[i] = 0.0
        _carry_contacts(by, R, t, self._seen, out)
        for i, lies in self._flush.items():
            pressed, gaps[i], along = lies.press_at(by[i])
            own = lies.across @ self._seen.shift[i]
            positions[i] = R @ (pressed + own @ by[i]) + t
            own += along
            shift[i, :, :3], shift[i, :, 3:] = R @ own[:, :3] @ R.T, R @ own[:, 3:] @ R.T
        for i in self._on_corners:
            (Q, q), tip, face = self.obj.frame, self.shapes[i][0], self.shapes[i][0].face
            positions[i] = R @ (Q @ tip.corner + q) + t
            gaps[i] = write_corner_contact(
                positions[i], places[i], turns[i], face.centre, face.spans, face.radius, normals[i], turn[i], shift[i]
            )

    def _detect(self, i: int, at: Array, own: Array) -> None:
        """Detect a fingertip where it is, in the object's axes."""
        tip, each = self._nearby_shapes(i, at, own)
        near = min(each, key=lambda one: one.gap)
        on, normals = self._contacts_beside(tip, at, own, each)
        turn, shift = (normals[::2] - normals[1::2]).T / self._steps, (on[::2] - on[1::2]).T / self._steps
        if _is_edge(normals[0:6:2], near.normal, normals[1:6:2]):
            turn = _limit_edge_turn(turn, near.position - at)
        farthest = float(abs(on[6:] - near.position).max())  # on a curved surface by its radius times the tilt, less
        lies = find_flush_contact(tip, at, own, near, self.obj, 2.0 * self.step) if farthest > self.step else None
        self._flush.pop(i, None)
        if lies is not None:
            self._flush[i] = lies
        self._seen.store(i, at, own, near, turn, shift)

    def _nearby_shapes(self, i: int, at: Array, own: Array) -> tuple[Any, list[Proximity]]:
        """The shapes of a fingertip that are nearest to the object, or may be after a step or a tilt, and how near each
        is. A gap changes by no more than the shape moves, so that not all are measured again.
        """
        tip, least = self.shapes[i], self._least[i]
        moved, turned = at - self._seen.tip_positions[i], own - self._seen.tip_rotations[i]
        least -= np.sqrt((moved * moved).sum()) + self._reach[i] * np.sqrt((turned * turned).sum())
        found, gap = dict[int, Proximity](), np.inf
        for k in np.argsort(least, kind="stable").tolist():
            if gap + 4.0 * self.step + 2.0 * tilt_gap_change(self._reach[i]) < least[k]:
                break
            found[k] = shape_proximity(tip[k], at, own, self.obj)
            least[k] = found[k].gap
            gap = min(gap, found[k].gap)
        some = sorted(found)
        return tuple([tip[k] for k in some]), [found[k] for k in some]

    def _contacts_beside(self, tip: Any, at: Array, own: Array, each: list[Proximity]) -> tuple[Array, Array]:
        """Positions and normals (12, 3) of the contact, with the fingertip moved a step each way. each : where its
        shapes and the object are nearest to each other without that.
        """
        places, turns = at + self._ways[:, :3], self._turned @ own
        if len(tip) == 1 and tip[0].radius is not None:
            known = self.obj.closest_all(places + self._turned @ (own @ tip[0].translation))
            if known is not None:
                return known[1], -known[2]
        moved = [self._ways[:, :3] + cross_rows(self._ways[:, 3:], near.tip_point - at) for near in each]
        gaps = np.array([near.gap - by @ near.normal for near, by in zip(each, moved, strict=True)])
        # Those that may be the nearest after a step, by which gaps change as normals say, give or take a step
        may = [k for k, row in enumerate(gaps) if (row <= gaps.min(axis=0) + 2.0 * self.step).any()]
        ends = list[Proximity]()
        for j in range(len(places)):
            beside = [quick_proximity(tip[k], places[j], turns[j], self.obj, gaps[k, j], self.step) for k in may]
            ends.append(min(beside, key=lambda one: one.gap))
        return np.array([end.position for end in ends]), np.array([end.normal for end in ends])


def _is_edge(some: Array, between: Array, other: Array) -> bool:
    """Whether normals (k, 3) on either side of a contact, any two, are those of an edge, not of a curved surface."""
    sides, middles = some - other, some + other - 2.0 * between
    apart, off = np.sqrt((sides * sides).sum(axis=1)), np.sqrt((middles * middles).sum(axis=1))
    uneven = (off > _EDGE_UNEVENNESS * apart) & (apart > _FACE_NORMAL_DIFFERENCE)
    return bool(((apart > _EDGE_NORMAL_DIFFERENCE) | uneven).any())


def _limit_edge_turn(turn: Array, arm: Array) -> Array:
    """An edge's turn (3, 6) no faster than `_MAX_NORMAL_TURN`; arm (3,) : from the fingertip's place to the contact."""
    fastest = float(np.linalg.norm(turn[:, :3], 2))
    if fastest <= _MAX_NORMAL_TURN:
        return turn
    along = _MAX_NORMAL_TURN / fastest * turn[:, :3]
    own = turn[:, 3:] + turn[:, :3] @ skew(arm)  # the contact moves by v + ω × arm; beside that it turns with a body
    own *= min(1.0, 1.0 / float(np.linalg.norm(own, 2)))
    return np.hstack([along, own - along @ skew(arm)])
