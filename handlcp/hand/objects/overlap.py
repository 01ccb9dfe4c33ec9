"""How deep two convex shapes overlap, or how far they are apart, from their support functions, between bounds that
prove it.

With D all differences a - b of points a of the first shape and b of the second, n · x ≤ h(n) = h_A(n) + h_B(-n) in D:

    depth = min over unit n of h(n)

Any n bounds the depth from above. The hull of some points of D lies within D, and the face of it that is nearest to the
origin bounds the depth from below. Each step adds the furthest points along the normals of the nearest faces, until the
bounds meet (van den Bergen, Game Developers Conference 2001: EPA, here with hulls by qhull).

Apart, the same points of D bound the distance from above by the one of their hull that is nearest to the origin, and
any n from below by -h(n); each step adds the furthest point towards the origin (Gilbert, Johnson & Keerthi 1988: GJK,
here with all points kept and the nearest one by non-negative least squares).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.kind import cross_rows

Pairs = Callable[[Array], tuple[Array, Array]]

_GRID, _FEW = 60, 12  # directions to begin with, and where a depth is only to be proven
_MOST, _AT_ONCE = 60, 6  # steps, and faces looked at in each
_SAME = 1e-9  # normals this near to each other are one
_TILTS = (1e-4, 1e-2)  # [rad] of those around the normal that is known
_RING = np.array([(np.cos(a), np.sin(a)) for a in 2 * np.pi * np.arange(3) / 3])


class Overlap(NamedTuple):
    """least, most [m]: bounds on the depth. normal (3,) : from the first shape into the second, the direction of
    `most`. first, second (3,) [m]: the points of each that are deepest in the other.
    """

    least: float
    most: float
    normal: Array
    first: Array
    second: Array


def overlap(furthest: Pairs, near: Array, close: float, enough: float = np.inf) -> Overlap | None:
    """None where a plane parts the shapes. After too many steps the bounds may be further apart than `close` [m].

    furthest : from directions (k, 3), unit, the furthest points (k, 3) of the first shape along them, and of the second
    against them. near (3,) : a unit normal to begin with, beside those of a grid. enough [m] : a depth which, proven to
    be the least, ends the search; the points are then only those that are furthest along the normal.
    """
    from scipy.spatial import ConvexHull  # a tenth of a second that few contacts should pay

    n = np.concatenate([_around(near), evenly(_GRID if np.isinf(enough) else _FEW)])
    first, second = furthest(n)
    h = np.einsum("ij,ij->i", n, first - second)
    for step in range(_MOST):
        if not h.min() >= 0.0:  # or a position is no number
            return None
        hull = ConvexHull(first - second)
        inside = -hull.equations[:, 3]
        order = np.argsort(inside, kind="stable")
        n = hull.equations[order[:_AT_ONCE], :3]
        a, b = furthest(n)
        h, least = np.einsum("ij,ij->i", n, a - b), float(inside[order[0]])
        if least >= enough:
            return Overlap(least, float(h[0]), n[0], a[0], b[0])
        if h[0] - least <= close or step == _MOST - 1:
            # Where several faces lie in the nearest plane, the origin's foot lies in one of them
            same = (inside <= least + close) & (hull.equations[:, :3] @ n[0] > 1.0 - _SAME)
            faces = hull.simplices[same]
            points = _deepest(first[faces], second[faces], least * n[0])
            break
        first, second = np.concatenate([first, a]), np.concatenate([second, b])
    return Overlap(least, float(h[0]), n[0], *points)


def apart(furthest: Pairs, near: Array, close: float) -> Overlap | None:
    """The distance as an overlap below zero, bounds no further apart than `close` [m]; None where they do not meet, as
    of shapes that touch. furthest, near : as in `overlap`.
    """
    from scipy.optimize import nnls

    first, second = furthest(np.concatenate([_around(near), evenly(_GRID)]))
    for _ in range(_MOST):
        D = (second - first).T
        if not np.isfinite(D).all():
            return None
        size = max(float(np.sqrt((D**2).sum(axis=0)).min()), close)
        share, _ = nnls(np.vstack([D / size, np.ones(D.shape[1])]), np.array([0.0, 0.0, 0.0, 1.0]))
        share /= share.sum()
        on, beside = share @ first, share @ second
        far = float(np.sqrt((beside - on) @ (beside - on)))
        if not far > close:
            return None
        n = (beside - on) / far
        a, b = furthest(n[None])
        least = float(n @ (b - a)[0])
        if far - least <= close:
            return Overlap(-far, -least, n, on, beside)
        first, second = np.concatenate([first, a]), np.concatenate([second, b])
    return None


def _deepest(first: Array, second: Array, at: Array) -> tuple[Array, Array]:
    """The points of both shapes whose difference is the point `at` (3,) of one of the faces: first and second (k, 3, 3)
    are the corners of the faces, in rows. Of the face that holds it best.
    """
    corners = np.concatenate([(first - second).transpose(0, 2, 1), np.ones((len(first), 1, 3))], axis=1)
    shares = np.linalg.pinv(corners) @ np.append(at, 1.0)
    k = int(np.argmax(shares.min(axis=1)))
    share = np.clip(shares[k], 0.0, 1.0)
    share /= share.sum()
    return share @ first[k], share @ second[k]


def evenly(k: int, first: float = 0.0) -> Array:
    """(k, 3) unit vectors in all directions, evenly: a spiral from pole to pole, `first` of a step further on."""
    i = np.arange(k)
    z, turn = 1.0 - (2.0 * i + 1.0) / k, np.pi * (3.0 - np.sqrt(5.0)) * (i + first)
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


def outermost(points: Array, ways: Array) -> Array:
    """Those of points (m, 3) that are furthest in directions (k, 3), each once."""
    return np.asarray(points[np.unique((points @ ways.T).argmax(axis=0))])


def _around(n: Array) -> Array:
    """(1 + 3 k, 3) a direction and some close to it, which bound the depth from below where it is right."""
    x = np.eye(3)[int(np.argmin(abs(n)))]
    x = x - n * (n @ x)
    x /= np.sqrt(x @ x)
    ring = _RING @ np.stack([x, cross_rows(n, x)])
    every = np.concatenate([n[None], *[n + tilt * ring for tilt in _TILTS]])
    return np.asarray(every / np.sqrt((every * every).sum(axis=1, keepdims=True)))
