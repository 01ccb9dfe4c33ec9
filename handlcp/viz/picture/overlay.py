"""`Overlay`: what is drawn over the solids: friction cones, arrows, moments, contact points, axes and scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.geometry.table import hull_corners
from handlcp.grasp.model.contact import contact_frame
from handlcp.viz.picture.camera import Camera, ViewLimits
from handlcp.viz.style import INK, shorten_names, spread_labels, text_width

# ----------------------------------------------------------------
# Moments and turns as arcs about their axes, with a head at the end that shows their sense.

_MIN_ARC_COSINE = 0.42  # cosine between the axis and the line of sight from which on an arc looks like one
_MIN_SWEEP, _MAX_SWEEP = 110.0, 290.0  # [degrees] of an arc
_ARC_POINTS = 60


@dataclass(frozen=True, slots=True)
class RotationArc:
    """A moment or a turn as an arc about its axis, in the sense of a right-hand screw.

    centre (3,) : [m], world axes. axis (3,) : a unit vector. radius : [m]. share : of the largest moment that is drawn
    in this way, from 0 to 1, which makes the length of the arc.
    """

    centre: Array
    axis: Array
    radius: float
    share: float = 1.0

    def extent_points(self) -> Array:
        """(k, 3) points around everything that an arc can cover."""
        return np.asarray(self.centre + self.radius * np.vstack([np.eye(3), -np.eye(3)]))

    def screen_points(self, camera: Camera) -> Array:
        """(k, 2) points on the screen, the last one at the head.

        An axis that lies across the line of sight would make the arc a line: it is tilted towards or away from the
        viewer until the arc is open, which keeps its sense.
        """
        sight = camera.axes[2]
        along = float(self.axis @ sight)
        axis = self.axis
        if abs(along) < _MIN_ARC_COSINE:
            across = axis - along * sight
            across /= np.linalg.norm(across)
            cosine = _MIN_ARC_COSINE if along >= 0 else -_MIN_ARC_COSINE
            axis = np.sqrt(1 - cosine**2) * across + cosine * sight
        x, y, _ = contact_frame(axis, camera.axes[0] if abs(axis @ camera.axes[0]) < 0.9 else camera.axes[1]).T
        sweep = np.radians(_MIN_SWEEP + (_MAX_SWEEP - _MIN_SWEEP) * self.share)
        a = np.pi / 2 + np.linspace(-sweep / 2, sweep / 2, _ARC_POINTS)
        points = self.centre + self.radius * (np.cos(a)[:, None] * x + np.sin(a)[:, None] * y)
        return camera.project(points)


# ----------------------------------------------------------------

SCALE_COLOUR = "#777777"
MIN_ARROW_LENGTH = 0.06  # inches on paper: shorter arrows are not drawn


class Overlay:
    """Draws over a camera's picture. inch : metres on the screen that are one inch on paper."""

    def __init__(self, ax: Any, camera: Camera, inch: float) -> None:
        self.ax, self.camera, self.inch = ax, camera, inch

    def draw_arrow(self, start: Array, vector: Array, colour: str, width: float = 1.0, dashed: bool = False) -> bool:
        """A straight arrow in space; its width is that on paper. One that points at the viewer or away is a ring with a
        dot or a cross. Returns whether it is long enough to be seen.
        """
        a, b = self.camera.project(start), self.camera.project(start + vector)
        if np.linalg.norm(b - a) >= MIN_ARROW_LENGTH * self.inch:
            self.draw_flat_arrow(a, b, colour, width, dashed)
            return True
        if np.linalg.norm(vector) < 2 * MIN_ARROW_LENGTH * self.inch:
            return False
        mark = "." if vector @ self.camera.axes[2] > 0 else "x"
        ring = {"markersize": 9.0, "markeredgecolor": colour, "markerfacecolor": "white", "markeredgewidth": 1.4}
        self.ax.plot(*a, "o", zorder=7.5, **ring)
        self.ax.plot(*a, mark, color=colour, markersize=4.5, markeredgewidth=1.4, zorder=7.6)
        return True

    def draw_flat_arrow(self, a: Array, b: Array, colour: str, width: float = 1.0, dashed: bool = False) -> None:
        """An arrow on the screen."""
        from matplotlib.patches import Polygon

        along = b - a
        length = float(np.linalg.norm(along))
        x = along / length
        y = np.array([-x[1], x[0]])
        head = min(0.17 * self.inch * width, 0.6 * length)
        wing = min(0.068 * self.inch * width, 0.45 * head)
        half = min(0.026 * self.inch * width, 0.4 * wing)
        neck = length - head
        outline = [(0, half), (neck, half), (neck, wing), (length, 0), (neck, -wing), (neck, -half), (0, -half)]
        points = np.array([a + u * x + v * y for u, v in outline])
        style: dict[str, Any] = {"facecolor": colour, "edgecolor": "white", "linewidth": 0.9}
        if dashed:
            style = {"facecolor": "white", "edgecolor": colour, "linewidth": 1.4, "linestyle": (0, (2.2, 1.2))}
        self.ax.add_patch(Polygon(points, closed=True, joinstyle="round", zorder=6, **style))

    def draw_cone(self, apex: Array, edge: Array, colour: str) -> None:
        """A friction cone from its apex (3,) to its rim `edge` (k, 3); k = 2 in a planar scene: a wedge."""
        from matplotlib.patches import Polygon

        s, p = self.camera.project(edge), self.camera.project(apex)
        body = _convex_outline(np.vstack([s, p]))
        self.ax.add_patch(Polygon(body, closed=True, facecolor=colour, alpha=0.22, edgecolor="none", zorder=3))
        self.ax.add_patch(Polygon(body, closed=True, fill=False, edgecolor=colour, alpha=0.75, linewidth=0.8, zorder=3))
        if len(edge) > 2:
            self.ax.plot(*s.T, color=colour, alpha=0.75, linewidth=0.8, zorder=3)

    def draw_arc(self, turn: RotationArc, colour: str, width: float = 1.0, dashed: bool = False) -> None:
        """An arc about an axis, with its head at the end."""
        from matplotlib import patheffects
        from matplotlib.patches import Polygon

        points = turn.screen_points(self.camera)
        head = min(0.15 * self.inch * width, 0.5 * turn.radius)
        left = np.linalg.norm(points - points[-1], axis=1)
        last = int(np.argmax(left < 0.8 * head))  # the line ends within the head
        casing = [patheffects.withStroke(linewidth=2.2 * width + 1.6, foreground="white")]
        dash: Any = (0, (1.6, 0.9)) if dashed else "-"
        line = {"linewidth": 2.2 * width, "linestyle": dash, "solid_capstyle": "butt", "path_effects": casing}
        self.ax.plot(*points[: last + 1].T, color=colour, zorder=6, **line)
        tip, way = points[-1], points[-1] - points[last]
        x = way / max(float(np.linalg.norm(way)), 1e-300)
        y = np.array([-x[1], x[0]])
        corners = np.array([tip, tip - head * x + 0.42 * head * y, tip - head * x - 0.42 * head * y])
        style = {"facecolor": colour, "edgecolor": "white", "linewidth": 0.7, "joinstyle": "round"}
        self.ax.add_patch(Polygon(corners, closed=True, zorder=6.1, **style))

    def draw_contact_point(self, point: Array, colour: str, hollow: bool = False) -> None:
        """Draw the point of a contact (3,) [m]. hollow : whether a surface hides it."""
        p = self.camera.project(point)
        face, edge, width = ("white", colour, 1.6) if hollow else (colour, "white", 0.9)
        style = {"markersize": 5.5, "markerfacecolor": face, "markeredgecolor": edge, "markeredgewidth": width}
        self.ax.plot(*p, "o", zorder=7, **style)

    def draw_shape(self, triangles: Array) -> None:
        """A convex body as glass, with its outline."""
        from matplotlib.patches import Polygon

        body = _convex_outline(self.camera.project(triangles).reshape(-1, 2))
        style: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.9, "linestyle": (0, (3, 1.5)), "zorder": 2.5}
        self.ax.add_patch(Polygon(body, closed=True, facecolor=(1.0, 1.0, 1.0, 0.30), **style))

    def draw_edges(self, lines: Array, colour: str) -> None:
        """Dashed lines (k, 2, 3) in space."""
        from matplotlib.collections import LineCollection

        style: dict[str, Any] = {"colors": colour, "linewidths": 1.0, "linestyles": [(0, (4, 2))], "zorder": 2.8}
        self.ax.add_collection(LineCollection(list(self.camera.project(lines)), **style))

    def draw_triad(self, corner: Array) -> None:
        """The world's axes as the camera sees them, from a screen point."""
        size = 0.34 * self.inch
        for axis, name in zip(np.eye(3), "xyz", strict=True):
            tip = self.camera.project(axis) * size
            length = float(np.linalg.norm(tip))
            if length < 0.12 * size:
                continue
            style = {"arrowstyle": "-|>", "color": SCALE_COLOUR, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}
            self.ax.annotate("", corner + tip, corner, arrowprops=style, zorder=8)
            x, y = corner + tip * (1 + 0.3 * size / max(length, 0.3 * size))
            self._write_scale_text(x, y, name, "center")

    def draw_scale_bar(self, corner: Array, length: float, text: str) -> None:
        x, y = corner
        tick = 0.04 * self.inch
        for xs, ys in (([x, x + length], [y, y]), *(([e, e], [y - tick, y + tick]) for e in (x, x + length))):
            self.ax.plot(xs, ys, color=SCALE_COLOUR, linewidth=1.2, zorder=8)
        self._write_scale_text(x + length / 2, y + 1.6 * tick, text, "bottom")

    def draw_force_scale(self, corner: Array, length: float, text: str) -> None:
        """A force, to the scale of the arrows."""
        self.draw_flat_arrow(corner, corner + np.array([length, 0.0]), SCALE_COLOUR)
        self._write_scale_text(corner[0] + length / 2, corner[1] + 0.064 * self.inch, text, "bottom")

    def _write_scale_text(self, x: float, y: float, text: str, va: str) -> None:
        self.ax.text(x, y, text, ha="center", va=va, color="#555555", fontsize=9.5, zorder=8)


def friction_cone_rim(apex: Array, axes: Array, height: float, mu: float, planar: bool) -> Array:
    """(k, 3) rim of a friction cone of `height` along the normal z of axes (3, 3); planar: both ends of a wedge."""
    x, y, n = axes.T
    if planar:
        return np.array([apex + height * (n + s * mu * x) for s in (1.0, -1.0)])
    a = np.linspace(0, 2 * np.pi, 73)
    return np.asarray(apex + height * (n + mu * (np.cos(a)[:, None] * x + np.sin(a)[:, None] * y)))


def nice_number(value: float) -> float:
    """The largest of 1, 2, 5 × 10^k that does not exceed a positive value."""
    base = 10.0 ** np.floor(np.log10(value))
    return float(base * max(m for m in (1.0, 2.0, 5.0) if m * base <= value * (1 + 1e-9)))


def _convex_outline(points: Array) -> Array:
    """Convex hull of screen points, in order; of points on a line, its ends."""
    return np.asarray(points[hull_corners(points, range(len(points)), 1e-9 * float(np.ptp(points, axis=0).max()))])


# ----------------------------------------------------------------
# Labels of contacts in a column on each side of the picture, with lines to their contacts that do not cross.


LABEL_SPACING = 0.46  # inches from one label to the next
NAME_SIZE, DETAIL_SIZE = 10.5, 9.5  # points
MAX_NAME_LETTERS = 24  # of a name
COLUMN_TOP_GAP = 0.05  # inches from the picture's upper edge to the columns
LEFT_COLUMN_BOTTOM, RIGHT_COLUMN_BOTTOM = 1.05, 0.62  # inches from its lower edge, where axes and scales are
COLUMN_GAP = 0.10  # inches from the picture to a column
LEVEL_LENGTH, TEXT_GAP = 0.12, 0.06  # inches: the level part of a line, from there to the text


@dataclass(frozen=True, slots=True)
class ContactLabel:
    """The label of one contact, or of several that share it.

    points (k, 2) : screen points that the label belongs to [m]; its line leads to the nearest one.
    name : written in `colour`. detail : written below it.
    """

    points: Array
    name: str
    detail: str
    colour: str


def label_capacity(inches: float) -> int:
    """How many labels there is room for in a picture of this height."""
    return sum(_count_rows(inches - COLUMN_TOP_GAP - below) for below in (LEFT_COLUMN_BOTTOM, RIGHT_COLUMN_BOTTOM))


def widest_label(figure: Any, names: Sequence[str], details: Sequence[str]) -> float:
    """Width of the widest line in inches."""
    widths = [text_width(figure, name, fontsize=NAME_SIZE, weight="bold") for name in names]
    widths += [text_width(figure, detail, fontsize=DETAIL_SIZE) for detail in details]
    return max(widths, default=0.0) / float(figure.dpi)


def place_labels(ax: Any, labels: Sequence[ContactLabel], frame: ViewLimits) -> None:
    """Each label in the nearer column where that has room, as close to its contact's height as its neighbours allow;
    and a line from there to its contact.
    """
    from matplotlib import patheffects

    casing = [patheffects.withStroke(linewidth=2.6, foreground="white", alpha=0.85)]
    line_style: dict[str, Any] = {"path_effects": casing, "linewidth": 0.9, "zorder": 5, "solid_capstyle": "round"}
    _, _, y0, y1 = frame.box
    line, high = LABEL_SPACING * frame.inch, y1 - COLUMN_TOP_GAP * frame.inch
    lows = [y0 + below * frame.inch for below in (LEFT_COLUMN_BOTTOM, RIGHT_COLUMN_BOTTOM)]
    rooms = [max(1, _count_rows((high - low) / frame.inch)) for low in lows]
    centres = [float(m.points[:, 0].mean()) for m in labels]
    middle = sum(centres) / max(len(centres), 1)
    ordered = [labels[i] for i in np.argsort(centres, kind="stable")]
    first = sum(c <= middle for c in centres)
    first = min(max(first, len(ordered) - rooms[1]), rooms[0])
    sides = (ordered[:first], frame.inner[0], -1.0), (ordered[first:], frame.inner[1], 1.0)
    short = dict(zip([m.name for m in labels], shorten_names([m.name for m in labels], MAX_NAME_LETTERS), strict=True))
    for (column, x, way), low in zip(sides, lows, strict=True):
        start = x + way * COLUMN_GAP * frame.inch
        ends = [m.points[int(np.argmin(abs(m.points[:, 0] - start)))] for m in column]
        # The column is filled from the top, `spread_labels` counts upwards: heights change sign
        order = np.argsort([-float(p[1]) for p in ends], kind="stable")
        depths = spread_labels([-float(ends[i][1]) - line / 2 for i in order], [line] * len(column), -high, -low)
        heights = [-depth - line / 2 for depth in depths]
        bend = start - way * LEVEL_LENGTH * frame.inch
        for i, y in zip(_uncross_lines([int(k) for k in order], heights, ends, bend), heights, strict=True):
            label, end, colour = column[i], ends[i], column[i].colour
            ax.plot([start, bend, end[0]], [y, y, end[1]], color=colour, **line_style)
            beside = {"x": start + way * TEXT_GAP * frame.inch, "ha": "right" if way < 0 else "left", "zorder": 9}
            name_style = {"va": "bottom", "color": colour, "fontsize": NAME_SIZE, "weight": "bold"}
            ax.text(y=y + 0.01 * frame.inch, s=short[label.name], **name_style, **beside)
            ax.text(y=y - 0.02 * frame.inch, s=label.detail, va="top", color=INK, fontsize=DETAIL_SIZE, **beside)


def _count_rows(inches: float) -> int:
    return int(inches / LABEL_SPACING)


def _uncross_lines(order: list[int], heights: Sequence[float], ends: Sequence[Array], x: float) -> list[int]:
    """Which label stands at which height, so that no two lines from (x, height) to their ends cross.

    Two labels whose lines cross change places, which shortens the lines: so it comes to an end.
    """
    order, changed = list(order), True
    while changed:
        changed = False
        for i, j in combinations(range(len(order)), 2):
            lines = [(np.array([x, heights[k]]), ends[order[k]]) for k in (i, j)]
            if _do_lines_cross(*lines[0], *lines[1]):
                order[i], order[j], changed = order[j], order[i], True
    return order


def _do_lines_cross(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Whether the lines from a to b and from c to d cross."""

    def side(p: Array, q: Array, r: Array) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
