"""Solids on a flat page: shaded triangles in a depth buffer, a translucent object between them, and fine contours.

matplotlib draws one polygon after the other, which leaves seams in what is translucent and teeth where solids meet; so
the solids are an image made here, and matplotlib draws everything else over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.show.bodies import Body
from handlcp.show.camera import Camera, Frame
from handlcp.show.raster import fill

__all__ = ["paint"]

LIGHT = np.array([-0.45, 0.65, 0.62])  # screen axes: from the upper left, before the page
CREASE = np.cos(np.radians(28.0))  # edges of the object sharper than this are drawn
GLASS = 0.40  # opacity of the object
CONTOUR = 0.55  # brightness of the lines around solids
OVER = 2  # samples per pixel and direction


def paint(ax: Any, camera: Camera, solids: Sequence[Body], glass: Body | None, frame: Frame, dpi: float) -> None:
    """Opaque solids and one translucent body within the frame, as an image of dpi dots an inch."""
    x0, x1, y0, y1 = frame.box
    pixels = round((x1 - x0) / frame.inch * dpi), round((y1 - y0) / frame.inch * dpi)
    w, h = pixels[0] * OVER, pixels[1] * OVER
    scale = np.array([w / (x1 - x0), h / (y1 - y0), 1.0])
    origin = np.array([x0, y0, 0.0])

    def page(triangles: Array) -> Array:
        return np.ascontiguousarray((triangles @ camera.axes.T - origin) * scale)

    colour, depth = np.ones((h, w, 3)), np.full((h, w), -np.inf)
    for body in solids:
        keep, shade = _lit(camera, body)
        rgb = np.clip(shade[:, None] * np.array(body.colour), 0, 1)
        fill(colour, depth, page(body.triangles[keep]), rgb)
    _contours(colour, depth, 0.012 * (y1 - y0))
    if glass is not None:
        keep, shade = _lit(camera, glass)
        front, near = np.ones((h, w, 3)), np.full((h, w), -np.inf)
        fill(front, near, page(glass.triangles[keep]), np.clip(shade[:, None] * np.array(glass.colour), 0, 1))
        seen = near > depth
        colour[seen] = (1 - GLASS) * colour[seen] + GLASS * front[seen]
        ink = 0.42 * np.array(glass.colour)
        lines = page(_creases(camera, glass.triangles))
        lift = 0.004 * (y1 - y0)
        for ends in lines:
            side = np.array([ends[0, 1] - ends[1, 1], ends[1, 0] - ends[0, 0]])
            length = float(np.linalg.norm(side))
            if length == 0.0:
                continue
            across = np.append(side / length * 0.75 * OVER, 0.0)
            a, b = ends[0] + (0, 0, lift), ends[1] + (0, 0, lift)
            quad = np.array([[a - across, b - across, b + across], [a - across, b + across, a + across]])
            fill(colour, depth, quad, np.tile(ink, (2, 1)))
    _fade(colour, frame)
    small = colour.reshape(pixels[1], OVER, pixels[0], OVER, 3).mean((1, 3))
    ax.imshow(small, extent=frame.box, origin="lower", interpolation="antialiased", zorder=1, aspect="auto")


def _contours(colour: Array, depth: Array, step: float) -> None:
    """Darken where the depth jumps: the outlines of solids, before each other and before the page."""
    d = np.where(np.isfinite(depth), depth, -1e9)
    line = np.zeros(d.shape, dtype=bool)
    for axis in (0, 1):
        for way in (1, -1):
            line |= d - np.roll(d, way, axis) > step
    for _ in range(OVER - 1):
        grown = line.copy()
        for axis in (0, 1):
            for way in (1, -1):
                grown |= np.roll(line, way, axis) & (d > -1e9)
        line = grown
    colour[line] *= CONTOUR


def _fade(colour: Array, frame: Frame) -> None:
    """Where the hand is cut, it fades into the page."""
    h, w, _ = colour.shape
    (x0, x1, y0, y1), (a, b, c, d), soft = frame.box, frame.inner, 0.30 * frame.inch
    x, y = np.linspace(x0, x1, w), np.linspace(y0, y1, h)
    across = np.clip(np.minimum(x - a, b - x) / soft + 1.0, 0, 1)
    along = np.clip(np.minimum(y - c, d - y) / soft + 1.0, 0, 1)
    share = (along[:, None] * across[None])[..., None]
    colour *= share
    colour += 1.0 - share


def _lit(camera: Camera, body: Body) -> tuple[Array, Array]:
    """(kept triangles, their brightness)."""
    t = body.triangles
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    size = np.linalg.norm(n, axis=1)
    n = (n / np.where(size > 0, size, 1.0)[:, None]) @ camera.axes.T
    keep = size > 0
    if body.outward:
        keep &= n[:, 2] > 0
    else:
        n = n * np.where(n[:, 2:] < 0, -1.0, 1.0)
    n = n[keep]
    light = LIGHT / np.linalg.norm(LIGHT)
    return keep, 0.58 + 0.36 * np.clip(n @ light, 0, None) + 0.12 * n[:, 2]


def _creases(camera: Camera, triangles: Array) -> Array:
    """(k, 2, 3) edges to draw: sharp ones on the near side, and the outline."""
    t = triangles
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    size = np.linalg.norm(n, axis=1)
    t, n = t[size > 0], n[size > 0] / size[size > 0][:, None]
    scale = float(np.ptp(t.reshape(-1, 3), axis=0).max())
    ends = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    owner = np.tile(np.arange(len(t)), 3)
    key = np.round(ends / (1e-6 * scale)).astype(np.int64)
    flip = np.array([tuple(a) > tuple(b) for a, b in key.tolist()])
    key[flip] = key[flip][:, ::-1]
    _, first, inverse, count = np.unique(
        key.reshape(-1, 6), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    order = np.argsort(inverse.ravel(), kind="stable")
    starts = np.concatenate([[0], np.cumsum(count)[:-1]])
    pairs = count == 2
    a, b = owner[order[starts[pairs]]], owner[order[starts[pairs] + 1]]
    front = n @ camera.axes[2] > 0
    sharp = ((n[a] * n[b]).sum(1) < CREASE) & (front[a] | front[b])
    return np.asarray(ends[first[pairs][sharp | (front[a] != front[b])]])
