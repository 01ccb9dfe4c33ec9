"""Fewer triangles: corners that share a small cell become one."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array

__all__ = ["simplified"]

_FINEST, _COARSEST = 400, 24  # cells along the longest edge
_COARSER = 0.8


def simplified(triangles: Array, most: int) -> Array:
    """At most so many triangles of (m, 3, 3), if cells of 1/24 of their extent are coarse enough; all where they are
    few.
    """
    cells = float(_FINEST)
    found = triangles
    while len(found) > most and cells > _COARSEST:
        found = _clustered(triangles, cells)
        cells *= _COARSER
    return found


def _clustered(triangles: Array, cells: float) -> Array:
    """Each corner moved to the mean of those in its cell; triangles without an area left out."""
    points = triangles.reshape(-1, 3)
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max()) or 1.0
    keys = np.floor((points - low) * (cells / size)).astype(np.int64)
    _, cell, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    cell = cell.ravel()
    mean = np.stack([np.bincount(cell, points[:, k]) for k in range(3)], axis=1) / count[:, None]
    corners = cell.reshape(-1, 3)
    a, b, c = corners.T
    whole = corners[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(whole, axis=1), axis=0, return_index=True)
    return np.asarray(mean[whole[np.sort(first)]])
