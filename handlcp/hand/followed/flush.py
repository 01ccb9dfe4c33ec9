"""Where shapes press on each other that lie flush, edge on edge or face on face: between their corners.

The nearest point alone jumps from one corner to another as the shapes tilt, and a body that leans on both would be held
by neither. A pad spreads its pressure instead. With the gaps g_k of the corners, and weights λ_k ≥ 0, Σ λ_k = 1,

    gap = min over λ of Σ λ_k g_k + c / 2 (Σ λ_k² - 1)        pressed at Σ λ_k x_k

so that ∂gap/∂g_k = λ_k: the contact's point is where its gap says that it is. One corner carries all of it where the
others are farther by more than c, which is a tilt by a thousandth of a radian; side by side they share, and the gap
is c / 4 less for two of them, a few micrometres.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.hand.objects.detect import Proximity
from handlcp.hand.objects.flat import TILT, corners, is_wide, tilted
from handlcp.hand.objects.object import Object

_WIDTH = 0.5 * TILT  # of the corners' distance: one that weighs something is found, whichever way it lies


class Flush(NamedTuple):
    """Corners (m, 3) of what a fingertip touches, on the object, their gaps (m,) and how these change with the
    fingertip's motion (m, 6), about its place; across (3, 3) : takes off what lies along the line or face. width c.
    """

    corners: Array
    gaps: Array
    rates: Array
    across: Array
    width: float

    def at(self, by: Array) -> tuple[Array, float, Array]:
        """Where it presses (3,), the gap, and how that point moves with the fingertip (3, 6), once this has moved by
        (6,).
        """
        gaps = self.gaps + self.rates @ by
        weights, active = shares(gaps, self.width)
        change = np.zeros_like(self.rates)
        change[active] = (self.rates[active].mean(axis=0) - self.rates[active]) / self.width
        gap = float(weights @ gaps) + 0.5 * self.width * (float(weights @ weights) - 1.0)
        return weights @ self.corners, gap, self.corners.T @ change


def shares(gaps: Array, width: float) -> tuple[Array, Bools]:
    """λ (m,), and which are above zero: the projection of -g / c on the simplex."""
    beyond = (gaps - gaps.min()) / width
    order = np.sort(beyond)
    level = (np.cumsum(order) + 1.0) / np.arange(1, len(gaps) + 1)
    weights = np.maximum(float(level[np.flatnonzero(order < level)[-1]]) - beyond, 0.0)
    return weights, weights > 0.0


def flush(tip: tuple[Any, ...], at: Array, own: Array, near: Proximity, obj: Object, apart: float) -> Flush | None:
    """Of a fingertip at (3,) with rotation own (3, 3), so near to the object. None: they touch at a point, as curved
    surfaces do, whose corners would be no farther apart than `apart` [m].
    """
    points, opposite = tilted(tip, at, own, obj, near)
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle)[2]
    flat = (points - middle) @ axes[:2].T
    if not is_wide(flat[:, 0], apart):
        return None
    chosen = corners(flat, apart)
    n, x = near.normal, opposite[chosen]
    gaps = (x - points[chosen]) @ n
    gaps += near.gap - gaps.min()
    arms = x - at
    rates = -np.hstack([np.tile(n, (len(x), 1)), np.cross(arms, n)])
    wide = axes[: 1 + int(is_wide(flat[:, 1], apart))]
    between = np.linalg.norm(points[chosen, None] - points[chosen], axis=2)
    return Flush(x, gaps, rates, np.eye(3) - wide.T @ wide, _WIDTH * float(between[between > 0.0].min()))
