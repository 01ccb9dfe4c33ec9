"""From where the page of an envelope is seen at first: so that the weakest direction is in sight.

The surface has one point along each direction. So no part of it hides a point from a viewer far out along its own
direction. A little from the side one also sees how far out the point is; there parts of the surface may hide it, and
the hand may do so anywhere.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array

_TILTS = (15.0, 30.0, 45.0)  # [degrees] from the direction itself
_AROUND = 12
_STEEPEST = 78.0  # [degrees] above or below: seen from the very top nothing is upright
_CLEAR = 1.03  # of the point's distance: the surface beside it does not count as before it


def facing(point: Array, axes: Array, up: Array, centre: Array, solids: Array) -> Array:
    """(3, 3) axes of a camera, as `Camera` has them, that sees a point (3,) of the surface, from the centre of it.

    axes (3, 3) : of the usual camera, to which this one is as near as may be. up (3,) : stays upright. solids
    (k, 3, 3) : triangles that may hide the point.
    """
    distance = float(np.linalg.norm(point))
    if not distance > 0.0:
        return axes
    way = point / distance
    usual = np.arcsin(np.clip(axes[2] @ up, -1.0, 1.0))

    def unlike(towards: Array) -> float:
        """How far from the usual height above the horizon, and half as much from the direction itself."""
        height = np.arcsin(np.clip(towards @ up, -1.0, 1.0))
        return float(abs(height - usual) + 0.5 * np.arccos(np.clip(towards @ way, -1.0, 1.0)))

    for towards in sorted([t for tilt in np.radians(_TILTS) for t in _tilted(way, tilt)], key=unlike):
        here = _upright(towards, up)
        if here[2] @ way > 0.5 and not _hidden(centre + _CLEAR * point, here[2], solids):
            return here
    return _upright(way, up)


def _tilted(way: Array, tilt: float) -> list[Array]:
    """Unit vectors at this angle from a way, all around it."""
    other = np.eye(3)[int(abs(way).argmin())]
    a = np.cross(way, other) / np.linalg.norm(np.cross(way, other))
    b = np.cross(way, a)
    turns = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    return [np.cos(tilt) * way + np.sin(tilt) * (np.cos(t) * a + np.sin(t) * b) for t in turns]


def _upright(towards: Array, up: Array) -> Array:
    """Axes that look against `towards`, no steeper than may be."""
    flat: Array = towards - (towards @ up) * up
    size = float(np.linalg.norm(flat))
    level = flat / size if size > 1e-9 else np.eye(3)[int(abs(up).argmin())]
    angle = np.clip(np.arcsin(np.clip(towards @ up, -1.0, 1.0)), -np.radians(_STEEPEST), np.radians(_STEEPEST))
    seen = np.cos(angle) * level + np.sin(angle) * up
    right = np.cross(up, seen)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(seen, right), seen])


def _hidden(point: Array, towards: Array, triangles: Array) -> bool:
    """Whether the ray from a point to the viewer meets one of the triangles (k, 3, 3) (Möller and Trumbore)."""
    a = triangles[:, 0]
    one, two = triangles[:, 1] - a, triangles[:, 2] - a
    across = np.cross(towards, two)
    det = (one * across).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        from_a = point - a
        u = (from_a * across).sum(axis=1) / det
        side = np.cross(from_a, one)
        v = side @ towards / det
        far = (two * side).sum(axis=1) / det
        met = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (far > 0.0)
    return bool(met.any())
