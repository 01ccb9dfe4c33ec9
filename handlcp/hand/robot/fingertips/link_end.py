"""Where a link ends: the middle of the round end that its geometry has farthest from its joint.

The link points from the joint's axis to the middle of its geometry. The end is the last fifth of its length from there.
The point lies in the middle of the end's width, and below the outermost surface by half of the end's thickness, as the
centre of a ball that would just fill a round end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp.check import Array, read_only
from handlcp.hand.robot.link_surface import surface_points
from handlcp.hand.robot.source.description import Part

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
