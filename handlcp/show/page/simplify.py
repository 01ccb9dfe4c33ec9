"""Fewer triangles: corners that share a small cell become one."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array

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
