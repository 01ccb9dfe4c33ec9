"""Triangles as few bytes: corners on a grid of 65536 along each edge of their box, shared between triangles.

What differs in size alone, such as two spheres, is stored once.
"""

from __future__ import annotations

import base64
import gzip
from typing import Any

import numpy as np

from handlcp.check import Array

__all__ = ["Meshes"]

_GRID = 65535


class Meshes:
    """The shapes of a page. count : of all triangles that were added, as they are drawn."""

    def __init__(self) -> None:
        self._known: dict[bytes, int] = {}
        self._table: list[dict[str, int]] = []
        self._bytes = bytearray()
        self.count = 0

    def add(self, triangles: Array) -> dict[str, Any]:
        """A shape (m, 3, 3) [m]: its number, and the box that it fills."""
        low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        size = high - low
        grid = np.round((triangles - low) * (_GRID / np.where(size > 0.0, size, 1.0)))
        points, corner = np.unique(grid.reshape(-1, 3).astype(np.uint16), axis=0, return_inverse=True)
        corners = corner.reshape(-1, 3)
        a, b, c = corners.T
        corners = corners[(a != b) & (b != c) & (c != a)].astype("<u4")
        packed = points.astype("<u2").tobytes() + b"\0\0" * (points.size % 2) + corners.tobytes()
        self.count += len(corners)
        if packed not in self._known:
            self._known[packed] = len(self._table)
            self._table.append({"at": len(self._bytes), "points": len(points), "triangles": len(corners)})
            self._bytes += packed
        return {"mesh": self._known[packed], "low": low, "size": size}

    def to_dict(self) -> dict[str, Any]:
        """For JSON. table : of each shape, where it begins, its numbers of points (3 × uint16) and of triangles (3 ×
        uint32, from the next multiple of four bytes on). packed : all of them, gzip in base64.
        """
        squeezed = gzip.compress(bytes(self._bytes), 9, mtime=0)
        return {"table": self._table, "packed": base64.b64encode(squeezed).decode("ascii")}
