"""How a hand's fingertips find their contacts while the object moves, and how these contacts turn: in compiled code for
balls on primitives, by detection for other shapes, on planes for contacts that were given without an object.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.newton.tangent import skew
from handlcp.hand.followed.contacts import contacts_at
from handlcp.hand.followed.detected import Detected
from handlcp.hand.objects.object import Object, on_surface, put_contact
from handlcp.hand.objects.swept import corner_contact, nearest_station, station_moves
from handlcp.hand.robot.tip_geometry import TipShape
from handlcp.lcp.kernels.dense import kernel, product

# ----------------------------------------------------------------
# Balls on surfaces that are known in closed form, compiled: contacts, and how they turn and shift as balls move.

_NO_CORNER = np.full(3, np.nan)
_TURN = 1e-6  # of the object's size: central differences of normals, good to ten digits


@kernel
def ball_look(
    placements: Array, columns: Array, support: Array, coupling: Array, pads: Array, around: Array, kind: int,
    sizes: Array, own: Array, at: Array, swept: Stations, R: Array, t: Array, give: Array, old: Array, places: Array,
    turns: Array, positions: Array, normals: Array, gaps: Array, turn: Array, shift: Array, frames: Array, P: Array,
    J: Array, turning: Array,
) -> None:  # fmt: skip
    """Write all that an iterate knows of contacts that are swept balls of fingers alone: see `ball_contacts`,
    `contacts_at`.

    placements (k, 4, 4) : of the fingertips, give (k, 3) : of their pads. The object has moved by x ↦ R x + t; own
    (3, 3), at (3,) : its shape's axes and frame before.
    """
    p = np.empty(3)
    for a in range(3):
        p[a] = t[a] + R[a, 0] * at[0] + R[a, 1] * at[1] + R[a, 2] * at[2]
    for i in range(len(swept.radii)):
        for a in range(3):
            places[i, a] = placements[i, a, 3] + give[i, a]
            for b in range(3):
                turns[i, a, b] = placements[i, a, b]
    ball_contacts(kind, sizes, product(R, own), p, places, turns, swept, positions, normals, gaps, turn, shift)
    contacts_at(
        columns, support, coupling, pads, around, turns, positions, old, normals, frames, P, J, turning
    )  # fmt: skip


class Stations(NamedTuple):
    """Swept balls in tip axes (`Swept`): beside (k, 3) their middles, spans (k, 2, 3), radii (k,) [m]. corners (k, 3) :
    of the object, in the axes of its shape, which stand on them; NaN: what is nearest touches.
    """

    beside: Array
    spans: Array
    radii: Array
    corners: Array


def stations(tips: Sequence[TipShape]) -> Stations:
    """Of fingertips that are swept balls."""
    every = [tip.swept for tip in tips]
    beside, spans, radii = (np.array([one[k] for one in every if one is not None], dtype=float) for k in range(3))
    return Stations(beside, spans, radii, np.array([_NO_CORNER if tip.corner is None else tip.corner for tip in tips]))


@kernel
def ball_contacts(
    kind: int, sizes: Array, R: Array, p: Array, places: Array, turns: Array, swept: Stations, positions: Array,
    normals: Array, gaps: Array, turn: Array, shift: Array,
) -> None:  # fmt: skip
    """Write the contacts of k swept balls with a shape of this kind and sizes (3,), whose axes are the columns of R and
    whose frame is at p: positions, normals, gaps, turn, shift as in `Touch`.

    places (n, 3), turns (n, 3, 3) : of the fingertips.
    """
    arm, c, out, step = np.empty(3), np.empty(3), np.empty(3), _TURN * sizes.max()
    H, N, spans, own, at, moves = (
        np.empty((3, 3)), np.empty((3, 3)), np.empty((2, 3)), np.empty((2, 3)), np.zeros(2), np.empty((3, 6)),
    )  # fmt: skip
    for i in range(len(swept.radii)):
        if swept.corners[i, 0] == swept.corners[i, 0]:
            turned(R, swept.corners[i], c)
            positions[i] = p + c
            gaps[i] = corner_contact(
                positions[i], places[i], turns[i], swept.beside[i], swept.spans[i], swept.radii[i], normals[i],
                turn[i], shift[i],
            )  # fmt: skip
            continue
        turned(turns[i], swept.beside[i], arm)
        for a in range(3):
            c[a] = 0.0
            for b in range(3):
                c[a] += R[b, a] * (places[i, b] + arm[b] - p[b])
        line = False
        for k in range(2):
            turned(turns[i], swept.spans[i, k], spans[k])
            for a in range(3):
                line = line or swept.spans[i, k, a] != 0.0
                own[k, a] = R[0, a] * spans[k, 0] + R[1, a] * spans[k, 1] + R[2, a] * spans[k, 2]
        if line:
            c = nearest_station(kind, sizes, c, own, at)
            for a in range(3):
                arm[a] += at[0] * spans[0, a] + at[1] * spans[1, a]
        distance, x, out = on_surface(kind, sizes, c)
        for a in range(3):
            kept = c[a]
            c[a] = kept + step
            _, _, ahead = on_surface(kind, sizes, c)
            c[a] = kept - step
            _, _, back = on_surface(kind, sizes, c)
            c[a] = kept
            for b in range(3):
                H[b, a] = -(ahead[b] - back[b]) / (2.0 * step)
        for a in range(3):
            for b in range(3):
                N[a, b] = 0.0
                for e in range(3):
                    if H[e, 0] != 0.0 or H[e, 1] != 0.0 or H[e, 2] != 0.0:
                        N[a, b] += R[a, e] * (H[e, 0] * R[b, 0] + H[e, 1] * R[b, 1] + H[e, 2] * R[b, 2])
        gaps[i] = distance - swept.radii[i]
        put_contact(R, p, x, out, positions[i], normals[i])
        if line:
            station_moves(N, normals[i], spans, at, arm, sizes.max(), moves)
            carried_along(turn[i], shift[i], N, normals[i], distance, moves)
        else:
            moved_along(turn[i], shift[i], N, normals[i], distance, arm)


@kernel
def turned(R: Array, x: Array, out: Array) -> None:
    """Write R x, (3,)."""
    for a in range(3):
        out[a] = R[a, 0] * x[0] + R[a, 1] * x[1] + R[a, 2] * x[2]


@kernel
def carried_along(turn: Array, shift: Array, N: Array, normal: Array, distance: float, moves: Array) -> None:
    """Write turn, shift (3, 6) as `moved_along`, of a point whose motion is moves (3, 6)."""
    for a in range(3):
        for j in range(6):
            turn[a, j] = shift[a, j] = 0.0
            for b in range(3):
                turn[a, j] += N[a, b] * moves[b, j]
                shift[a, j] += (distance * N[a, b] - normal[a] * normal[b]) * moves[b, j]
            shift[a, j] += moves[a, j]


@kernel
def moved_along(turn: Array, shift: Array, N: Array, normal: Array, distance: float, arm: Array) -> None:
    """Write turn, shift (3, 6) of a contact that follows a point of the fingertip, `arm` (3,) away from its place:
    N (3, 3) turns the normal by the point's motion, and with d the point's distance the contact at x = p + d n moves by
    (1 - n nᵀ + d N).
    """
    for a in range(3):
        for b in range(3):
            turn[a, b] = N[a, b]
            shift[a, b] = distance * N[a, b] - normal[a] * normal[b]
        shift[a, a] += 1.0
    for a in range(3):  # the point moves by v + ω × arm
        for rows in (turn, shift):
            x, y, z = rows[a, 0], rows[a, 1], rows[a, 2]
            rows[a, 3] = arm[1] * z - arm[2] * y
            rows[a, 4] = arm[2] * x - arm[0] * z
            rows[a, 5] = arm[0] * y - arm[1] * x


# ----------------------------------------------------------------


class Find(Protocol):
    """Contacts of the first k of n fingertips. noise : of what is found, as a share of the object's size."""

    noise: float

    def __call__(
        self, places: Array, turns: Array, R: Array, t: Array, out: tuple[Array, Array, Array, Array, Array]
    ) -> None:
        """Fingertips stand at places (n, 3) with rotations turns (n, 3, 3); the object has moved by x ↦ R x + t. Writes
        the first k rows of positions (n, 3), normals (n, 3), gaps (n,), and of turn, shift (n, 3, 6) as `Touch` has
        them.
        """


def finger_contacts(spec: GraspSpec, mechanism: Any) -> Find:
    """For the k fingers of a grasp. mechanism : its `HandMechanism`."""
    obj, hand = mechanism.target, mechanism.posture.hand
    if obj is None:
        return _Given(spec, mechanism)
    shapes = [hand.tip_shapes(i) for i in mechanism.tips]
    if obj.known is not None and all(len(s) == 1 and s[0].swept is not None for s in shapes):
        return Balls(obj, [s[0] for s in shapes])
    return Detected(obj, shapes)


class Balls:
    """Fingertips that are swept balls, on an object whose surface is known in closed form."""

    noise = 0.0

    def __init__(self, obj: Object, tips: list[TipShape]) -> None:
        assert obj.known is not None  # `finger_contacts` saw to it
        self.kind, self.sizes = obj.known[0], np.array(obj.known[1], dtype=float)
        self.own, self.at = np.ascontiguousarray(obj.placement.rotation), obj.placement.translation.copy()
        self.swept = stations(tips)

    def __call__(
        self, places: Array, turns: Array, R: Array, t: Array, out: tuple[Array, Array, Array, Array, Array]
    ) -> None:
        """See `Find`."""
        ball_contacts(self.kind, self.sizes, R @ self.own, R @ self.at + t, places, turns, self.swept, *out)


class _Given:
    """Points of the fingertips, on planes of the object. What a preload puts between point and plane lies half along
    the fingertip's axis, half along the normal: it grows as the fingertip turns, and neither slides nor rolls then.
    """

    noise = 0.0

    def __init__(self, spec: GraspSpec, mechanism: Any) -> None:
        k, tips, first = len(mechanism.tips), list(mechanism.tips), mechanism.posture
        turned = first.tip_rotations[tips]
        self.points = np.einsum("nji,nj->ni", turned, spec.positions[:k] - first.tip_positions[tips])
        self.planes, self.out = spec.positions[:k].copy(), spec.frames[:k, :, 2].copy()
        self.along = np.einsum("nji,nj->ni", turned, self.out)  # of fingertips, in their axes

    def __call__(
        self, places: Array, turns: Array, R: Array, t: Array, out: tuple[Array, Array, Array, Array, Array]
    ) -> None:
        """See `Find`."""
        positions, normals, gaps, turn, shift = out
        k = len(self.points)
        arms, along = (np.einsum("nij,nj->ni", turns[:k], own) for own in (self.points, self.along))
        normals[:k] = self.out @ R.T
        gaps[:k] = (normals[:k] * (self.planes @ R.T + t - places[:k] - arms)).sum(axis=1)
        half = along + normals[:k]
        size = gaps[:k] / (normals[:k] * half).sum(axis=1)
        positions[:k], turn[:k] = places[:k] + arms + size[:, None] * half, 0.0
        for i in range(k):
            shift[i, :, :3] = np.eye(3) - np.outer(half[i] / (normals[i] @ half[i]), normals[i])
            shift[i, :, 3:] = -shift[i, :, :3] @ skew(arms[i] + size[i] * along[i])
