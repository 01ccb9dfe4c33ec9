"""Triangles as few bytes: corners on a grid of 65535 along each edge of their box, shared between triangles.

Which corners make triangles is stored once for shapes that differ in size and direction alone, such as two spheres.
"""

from __future__ import annotations

import base64
import gzip
from typing import Any

import numpy as np

from handlcp.check import Array, Ints

_GRID = 65534  # even: what lies in the middle is on the grid, too
_SHORT = 65536  # points that two bytes can number


class Meshes:
    """The shapes of a page."""

    def __init__(self) -> None:
        self._known: dict[bytes, int] = {}
        self._bytes = bytearray()

    def add(self, triangles: Array) -> dict[str, Any]:
        """A shape (m, 3, 3) [m]: low, size: the box that it fills; points: where its points begin, 3 × uint16 each, and
        how many there are; corners: where its triangles begin, three numbers of points each, and how many there are;
        wide: whether these are uint32, not uint16.
        """
        low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        size = high - low
        grid = np.round((triangles - low) * (_GRID / np.where(size > 0.0, size, 1.0))).astype(np.uint16)
        points, corners = _shared(grid.reshape(-1, 3))
        wide = len(points) > _SHORT
        packed = corners.astype("<u4" if wide else "<u2")
        return {
            "low": low, "size": size, "points": [self._at(points.astype("<u2").tobytes()), len(points)],
            "corners": [self._at(packed.tobytes()), len(corners)], "wide": wide,
        }  # fmt: skip

    def packed(self) -> str:
        """All of them, gzip in base64."""
        return base64.b64encode(gzip.compress(bytes(self._bytes), 9, mtime=0)).decode("ascii")

    def _at(self, data: bytes) -> int:
        """Where these bytes are; numbers of four bytes must begin at a multiple of four."""
        if data not in self._known:
            self._known[data] = len(self._bytes)
            self._bytes += data + bytes(-len(data) % 4)
        return self._known[data]


def _shared(grid: Array) -> tuple[Array, Ints]:
    """Points (k, 3) in the order in which (3m, 3) corners first name them, and their numbers (m, 3)."""
    keys = (grid.astype(np.uint64) << np.array([32, 16, 0], dtype=np.uint64)).sum(axis=1)
    _, first, corner = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    corners = rank[corner].reshape(-1, 3)
    a, b, c = corners.T
    return grid[first[order]], corners[(a != b) & (b != c) & (c != a)]
