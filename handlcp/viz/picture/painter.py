"""`paint_bodies`: the image of the solids: shaded triangles in a depth buffer, outlines, the translucent object.

matplotlib draws one polygon after the other, which leaves seams in translucent surfaces and jagged edges where solids
meet. So the solids become an image here, and matplotlib draws everything else over it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from handlcp.check import Array, Bools
from handlcp.viz.picture.body import Body
from handlcp.viz.picture.camera import Camera, ViewLimits, blank_image, fill_triangles
from handlcp.viz.style import RED, hex_to_rgb

LIGHT_DIRECTION = np.array([-0.45, 0.65, 0.62])  # screen axes: from the upper left
LIGHT_DIRECTION /= np.linalg.norm(LIGHT_DIRECTION)
CREASE_COSINE = np.cos(np.radians(28.0))  # edges of the object sharper than this are drawn
OBJECT_OPACITY = 0.40  # opacity of the object
CONTOUR_BRIGHTNESS = 0.55  # brightness of the lines around solids
SAMPLES_PER_PIXEL = 2  # samples per pixel and direction
MARK_OPACITY, STRIPE_OPACITY = 0.22, 0.75  # opacity of the mark on links inside the object, and of its stripes
MARK_COLOUR = np.array(hex_to_rgb(RED))
# Samples of an image, and those beside them in each of four ways
_AHEAD, _BEHIND = np.s_[1:], np.s_[:-1]
_NEIGHBOURS = (
    (_AHEAD, _BEHIND),
    (_BEHIND, _AHEAD),
    (np.s_[:, 1:], np.s_[:, :-1]),
    (np.s_[:, :-1], np.s_[:, 1:]),
)
STRIPE_SPACING = 12 * SAMPLES_PER_PIXEL  # samples from one stripe of hatching to the next


def paint_bodies(
    ax: Any, camera: Camera, solids: Sequence[Body], glass: Body | None, frame: ViewLimits, dpi: float
) -> Callable[[Array], Array]:
    """Draw opaque solids and one translucent body within the frame, as an image of `dpi` dots an inch, which
    the axes end with.

    Returns a function that tells of points (n, 3) how far before them the nearest solid is, and how far before them the
    near side of the translucent body [m], (n, 2); -inf where there is none.
    """
    x0, x1, y0, y1 = frame.box
    pixels = round((x1 - x0) / frame.inch * dpi), round((y1 - y0) / frame.inch * dpi)
    w, h = pixels[0] * SAMPLES_PER_PIXEL, pixels[1] * SAMPLES_PER_PIXEL
    scale = np.array([w / (x1 - x0), h / (y1 - y0), 1.0])

    def page(points: Array) -> Array:
        return np.asarray((points @ camera.axes.T - np.array([x0, y0, 0.0])) * scale)

    colour, depth, near = blank_image(h, w), np.full((h, w), -np.inf), np.full((h, w), -np.inf)
    for body in solids:
        fill_triangles(colour, depth, page(body.triangles), _shade_triangles(camera, body))
    _darken_contours(colour, depth, 0.012 * (y1 - y0))
    solid = depth.copy()
    if glass is not None:
        front = blank_image(h, w)
        fill_triangles(front, near, page(glass.triangles), _shade_triangles(camera, glass))
        seen = near > depth
        colour[seen] = (1 - OBJECT_OPACITY) * colour[seen] + OBJECT_OPACITY * front[seen]
        lines = _line_triangles(page(drawn_edges(camera, glass.triangles)), 0.004 * (y1 - y0))
        fill_triangles(colour, depth, lines, np.tile(0.42 * np.array(glass.colour), (len(lines), 1)))
    if marked := [page(b.triangles) for b in solids if b.is_marked]:
        back = np.full((h, w), -np.inf)
        if glass is not None:
            behind = page(glass.triangles) * (1, 1, -1)
            fill_triangles(np.empty_like(colour), back, behind, np.zeros((len(behind), 3)))
        _mark_bodies(colour, solid, (solid < near) & (solid > -back), np.concatenate(marked))
    if frame.is_cut:
        _fade_edges(colour, frame)
    places = product(range(SAMPLES_PER_PIXEL), repeat=2)
    small = sum(colour[i::SAMPLES_PER_PIXEL, j::SAMPLES_PER_PIXEL] for i, j in places) / SAMPLES_PER_PIXEL**2
    ax.imshow(small, extent=frame.box, origin="lower", interpolation="antialiased", zorder=1, aspect="auto")
    ax.axis("off")
    ax.set_xlim(x0, x1)
    ax.set_ylim(y0, y1)

    def depth_before(points: Array) -> Array:
        x, y, z = page(points).T
        i, j = np.clip(y.astype(int), 0, h - 1), np.clip(x.astype(int), 0, w - 1)
        return np.stack([solid[i, j] - z, near[i, j] - z], axis=1)

    return depth_before


def _mark_bodies(colour: Array, depth: Array, inside: Bools, triangles: Array) -> None:
    """A tint on what is seen of bodies whose triangles (m, 3, 3) are given, among the solids whose depths (h, w) are
    known; stripes where that is inside the object.
    """
    own = np.full(depth.shape, -np.inf)
    fill_triangles(np.empty_like(colour), own, triangles, np.zeros((len(triangles), 3)))
    seen = np.isfinite(own) & (own >= depth)
    row, column = np.indices(depth.shape)
    stripes = seen & inside & ((row + column) % STRIPE_SPACING < STRIPE_SPACING / 3)
    for where, share in ((seen, MARK_OPACITY), (stripes, STRIPE_OPACITY)):
        colour[where] = (1 - share) * colour[where] + share * MARK_COLOUR


def _shade_triangles(camera: Camera, body: Body) -> Array:
    """(m, 3) colour of each triangle, lit from the viewer's side."""
    n = _unit_normals(body.triangles) @ camera.axes.T
    n = n * np.where(n[:, 2:] < 0, -1.0, 1.0)
    shade = 0.58 + 0.36 * np.clip(n @ LIGHT_DIRECTION, 0, None) + 0.12 * n[:, 2]
    return np.asarray(np.clip(shade[:, None] * np.array(body.colour), 0, 1))


def _unit_normals(triangles: Array) -> Array:
    """(m, 3) unit normals; zero for a triangle without area."""
    n = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.linalg.norm(n, axis=1)
    return np.asarray(n / np.where(size > 0, size, 1.0)[:, None])


def _darken_contours(colour: Array, depth: Array, step: float) -> None:
    """Darken where the depth jumps by more than `step`: the outlines of solids."""
    there = np.isfinite(depth)
    d = np.where(there, depth, -1e9)
    lowest = d.copy()
    for here, beside in _NEIGHBOURS:
        np.minimum(lowest[here], d[beside], out=lowest[here])
    line = d - lowest > step
    wide = line.copy()
    for here, beside in _NEIGHBOURS:
        wide[here] |= line[beside]
    colour[wide & there] *= CONTOUR_BRIGHTNESS


def _fade_edges(colour: Array, frame: ViewLimits) -> None:
    """Fade into the page where the hand is cut, up to where labels begin."""
    h, w, _ = colour.shape
    (x0, x1, y0, y1), (a, b, c, d), soft = frame.box, frame.inner, 0.30 * frame.inch
    x, y = np.linspace(x0, x1, w), np.linspace(y0, y1, h)
    across = np.clip(np.minimum(x - a, b - x) / soft, 0, 1)
    along = np.clip(np.minimum(y - c, d - y) / soft, 0, 1)
    share = (along[:, None] * across[None])[..., None]
    colour *= share
    colour += 1.0 - share


def _line_triangles(lines: Array, lift: float) -> Array:
    """(2k, 3, 3) triangles of lines (k, 2, 3) on the page, one pixel and a half wide and nearer by `lift`."""
    side = np.cross([0.0, 0.0, 1.0], lines[:, 1] - lines[:, 0])
    length = np.linalg.norm(side, axis=1)
    lines, side = lines[length > 0], side[length > 0] / length[length > 0][:, None]
    a, b, across = lines[:, 0] + (0, 0, lift), lines[:, 1] + (0, 0, lift), side * 0.75 * SAMPLES_PER_PIXEL
    corners = [a - across, b - across, b + across, a - across, b + across, a + across]
    return np.asarray(np.stack(corners, axis=1).reshape(-1, 3, 3))


def drawn_edges(camera: Camera, triangles: Array) -> Array:
    """The edges (k, 2, 3) of a body [m] that are drawn: its outline, and sharp ones on the near side.

    triangles (m, 3, 3) : of the body [m], world axes.
    """
    n = _unit_normals(triangles)
    t, n = triangles[n.any(axis=1)], n[n.any(axis=1)]
    ends = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    places = np.round(ends.reshape(-1, 3) / (1e-6 * float(np.ptp(t, axis=(0, 1)).max()))).astype(np.int64)
    corners = np.unique(places, axis=0, return_inverse=True)[1].reshape(-1, 2)
    _, edge, count = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True)
    # Both ends of each edge that two triangles share, side by side; end i belongs to triangle i modulo their number
    twice = np.argsort(edge.ravel(), kind="stable")[np.repeat(count == 2, count)].reshape(-1, 2)
    a, b = twice.T % len(t)
    front = n @ camera.axes[2] > 0
    sharp = ((n[a] * n[b]).sum(1) < CREASE_COSINE) & (front[a] | front[b])
    return np.asarray(ends[twice[sharp | (front[a] != front[b]), 0]])
