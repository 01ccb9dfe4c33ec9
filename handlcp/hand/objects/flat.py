"""What of a shape touches an object where both are flat: the points that are nearest when it is tilted a little."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.grasp.model.kind import cross_rows
from handlcp.hand.objects.detect import Proximity, nearest
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.solid import size_of
from handlcp.words import first_largest

TILT = 2e-3  # [rad]
SPREAD = 1.5e-3  # [m] farther apart, points are not those of a curved surface
# Along no axis of a link: tilted toward an edge alone, a face touches anywhere on that edge, and not at its corners
_ASIDE = np.array([0.62, 0.34, 0.71])
_WAYS = np.array([(np.cos(a), np.sin(a)) for a in 0.2 + np.arange(8) * np.pi / 4])


def tilted(
    shapes: tuple[Any, ...], p: Array, R: Array, obj: Object, near: Proximity, angle: float = TILT
) -> tuple[Array, Array]:
    """Points (8, 3) of the shapes, where they are, that are nearest when they are tilted by an angle [rad] in eight
    directions about where they are nearest now, and the object's points (8, 3) opposite. The frame is at p (3,) with
    rotation R (3, 3).
    """
    x, n = across_in(R, near.normal), near.normal
    axes = np.stack([x, cross_rows(n, x), n], axis=1)
    away = leaning(max(size_of(shape.geometry) for shape in shapes), angle)
    own, opposite = np.empty((8, 3)), np.empty((8, 3))
    for k, turn in enumerate(axes @ _turns(angle) @ axes.T):
        lifted = near.tip_point - away * n
        there = nearest(shapes, lifted + turn @ (p - near.tip_point), turn @ R, obj)
        own[k] = near.tip_point + (there.tip_point - lifted) @ turn
        opposite[k] = there.position
    return own, opposite


def leaning(size: float, angle: float = TILT) -> float:
    """[m] By how much the gap of a shape of this size [m] changes as it is tilted, at most."""
    return 2.0 * angle * size


@lru_cache(maxsize=8)
def _turns(angle: float) -> Array:
    """(8, 3, 3) rotations by an angle [rad] that raise z in each of eight directions across it."""
    return np.array([pin.exp3(angle * np.array([-b, a, 0.0])) for a, b in _WAYS])


def across_in(R: Array, normal: Array) -> Array:
    """(3,) a unit vector across the normal (3,), which turns with a frame whose rotation is R (3, 3)."""
    x = R @ _ASIDE
    x = x - normal * (normal @ x)
    return np.asarray(x / np.sqrt(x @ x))


def is_wide(along: Array, apart: float = SPREAD) -> bool:
    """Whether points at (m,) along an axis [m] are farther apart than those of a curved surface, which touches at a
    point.
    """
    return bool(np.ptp(along) > apart)


def corners(flat: Array, apart: float = SPREAD) -> list[int]:
    """Numbers of two to four of points (m, 2) that span what all do, the farthest from those before first; none but
    the first two are nearer to each other than `apart` [m]. Of those that are as far but for rounding, the first.

    The points are more than `apart` wide, or one is enough, which `is_wide` says: no other measure decides it here.
    """
    chosen = [first_largest(np.linalg.norm(flat, axis=1))]
    while len(chosen) < 4:
        away = np.linalg.norm(flat[:, None] - flat[chosen], axis=2).min(axis=1)
        if away.max() <= (apart if len(chosen) > 1 else 0.0):
            break
        chosen.append(first_largest(away))
    return chosen
