"""The depth buffer behind the pictures, in one compiled loop."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.lcp.compiler.when import at_once
from handlcp.lcp.kernels.dense import kernel


@at_once()  # a picture has a million pixels
def fill(colour: Array, depth: Array, triangles: Array, rgb: Array) -> None:
    """Draw triangles (m, 3, 3) with their colours rgb (m, 3) into the buffers colour (h, w, 3) and depth (h, w).

    Corners are in pixels; z grows towards the viewer. A pixel belongs to the nearest triangle over its centre.
    """
    _fill(colour, depth, triangles, rgb)


def touch() -> None:
    """Draw nothing, so that the kernel is compiled."""
    fill(np.ones((1, 1, 3)), np.zeros((1, 1)), np.zeros((1, 3, 3)), np.ones((1, 3)))


@kernel
def _fill(colour: Array, depth: Array, triangles: Array, rgb: Array) -> None:
    h, w = depth.shape
    for k in range(len(triangles)):
        ax, ay, az = triangles[k, 0]
        bx, by, bz = triangles[k, 1]
        cx, cy, cz = triangles[k, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        left, right = max(int(np.floor(min(ax, bx, cx))), 0), min(int(np.ceil(max(ax, bx, cx))) + 1, w)
        low, high = max(int(np.floor(min(ay, by, cy))), 0), min(int(np.ceil(max(ay, by, cy))) + 1, h)
        for i in range(low, high):
            y = i + 0.5
            for j in range(left, right):
                x = j + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                s = 1.0 - u - v
                if u >= -1e-9 and v >= -1e-9 and s >= -1e-9:
                    z = u * az + v * bz + s * cz
                    if z > depth[i, j]:
                        depth[i, j] = z
                        for c in range(3):
                            colour[i, j, c] = rgb[k, c]
