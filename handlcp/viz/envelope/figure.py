"""`draw_envelope`: polar diagrams of an envelope, coloured by what gives out first; and the words that all pictures of
one have.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Ints
from handlcp.studies.envelope import Envelope
from handlcp.studies.envelope.result import (
    describe_compliance,
    describe_geometry,
    envelope_headline,
    format_direction,
    format_factor,
)
from handlcp.viz.envelope.surface import (
    NO_CAUSE_COLOUR,
    EnvelopeSurface,
    border_lines,
    bound_lines,
    cut_by_plane,
    make_surface,
)
from handlcp.viz.output_file import Figure
from handlcp.viz.picture.body import Body
from handlcp.viz.picture.camera import Camera, ViewLimits
from handlcp.viz.picture.content import PictureContent
from handlcp.viz.picture.figure import PICTURE_DPI, PICTURE_WIDTH, draw_bodies
from handlcp.viz.picture.overlay import Overlay, nice_number
from handlcp.viz.picture.painter import paint_bodies
from handlcp.viz.style import (
    GREY,
    INK,
    LEFT_MARGIN,
    SMALL_SIZE,
    TEXT_SIZE,
    capitalise,
    draw_sentences,
    draw_title,
    figure_below,
    hex_to_rgb,
    text_width,
)

# ----------------------------------------------------------------
# What the pictures of an envelope say in words: the headline, and the colours with their causes.

LEGEND_ROW, LEGEND_COLUMN = 0.215, 0.5  # inches of a line; a column's share of the width
LEGEND_TITLE = "What gives out first: share of the directions, and how much is held there"


def draw_envelope_heading(figure: Any, env: Envelope, title: str) -> float:
    """Title, weakest direction, what compliance gives away; returns where that ends, in inches below the top."""
    y = draw_title(figure, title)
    for k, text in enumerate(envelope_sentences(env)):
        y = draw_sentences(figure, y, text, GREY if k else INK, 0.964)
    return y


def envelope_sentences(env: Envelope) -> list[str]:
    """The weakest direction, what compliance gives away, what stays where it is."""
    told = envelope_headline(env), describe_compliance(env), describe_geometry(env)
    return [capitalise(text) for text in told if text]


class CauseLegend:
    """The colours of an envelope with their causes, written in two columns.

    bound : how the limit without compliance is drawn, "line" or "dashed".
    lines : (kind, colour, text) of each; kind: "patch", or how the bound is drawn.
    height : inches that the legend takes, with its heading.
    """

    def __init__(self, env: Envelope, s: EnvelopeSurface, bound: str = "dashed") -> None:
        self.lines = list[tuple[str, str, str]]()
        for key in s.keys:
            least = "" if key.colour == NO_CAUSE_COLOUR else f", {key.least:.3g} {env.unit}".rstrip() + " and more"
            least = ", drawn as far as the bound" if np.isnan(key.least) else least
            self.lines.append(("patch", key.colour, f"{key.says}: {words.format_percent(key.share)}{least}"))
        if s.has_visible_bound:
            self.lines.append((bound, INK, "without compliance: friction and torque limits alone"))
        cut = f"{s.reach:.3g} {env.unit}".rstrip()
        self.note = f"Cut at {cut}: what reaches farther is drawn there." if s.cut else ""
        self.rows = (len(self.lines) + 1) // 2
        self.height = 0.34 + LEGEND_ROW * (self.rows + bool(self.note)) + 0.08

    def draw(self, figure: Any, top: float) -> None:
        """Below `top`, in inches."""
        from matplotlib.lines import Line2D
        from matplotlib.patches import Rectangle

        wide, tall = (float(size) for size in figure.get_size_inches())
        style: dict[str, Any] = {"fontsize": SMALL_SIZE, "va": "center"}
        figure.text(LEFT_MARGIN, 1.0 - (top + 0.1) / tall, LEGEND_TITLE, weight="bold", color=INK, **style)
        for k, (kind, colour, text) in enumerate(self.lines):
            column, row = divmod(k, self.rows)
            x, y = LEFT_MARGIN + LEGEND_COLUMN * column, 1.0 - (top + 0.34 + LEGEND_ROW * row) / tall
            if kind == "patch":
                look: dict[str, Any] = {"facecolor": colour, "edgecolor": "#55555566", "linewidth": 0.5}
                mark: Any = Rectangle((x, y - 0.06 / tall), 0.24 / wide, 0.12 / tall, **look)
            else:
                dash: Any = "-" if kind == "line" else (0, (4, 2))
                mark = Line2D([x, x + 0.24 / wide], [y, y], color=colour, linewidth=1.0, linestyle=dash)
            mark.set_transform(figure.transFigure)
            figure.add_artist(mark)
            says, colon, rest = text.partition(": ")
            room = (LEGEND_COLUMN - 0.24 / wide - 0.03) * figure.bbox.width
            while text_width(figure, says + colon + rest, fontsize=SMALL_SIZE) > room and len(says) > 12:
                says = says.removesuffix(" …")[:-3].rstrip() + " …"
            figure.text(x + 0.32 / wide, y, says + colon + rest, color=INK, **style)
        if self.note:
            figure.text(LEFT_MARGIN, 1.0 - (top + 0.34 + LEGEND_ROW * self.rows) / tall, self.note, color=GREY, **style)


# ----------------------------------------------------------------

POLAR_WIDTH, PANEL_SIDE = 10.0, 3.3  # inches: of the figure, of a panel
SINGLE_PANEL_SIDE = 4.6  # of the panel where it is the only one
RING_COLOUR, GRID_COLOUR = "#D9DCDF", "#C4C8CC"
POLAR_MARGIN = 1.19  # of the panel's half width, in reaches


def draw_polar_envelope(env: Envelope, title: str = "") -> Figure:
    """Draw polar diagrams of an envelope: in the planes xy, yz and xz, or in the plane of its directions.

    Raises InputError for directions that lie neither all around nor in a plane; Unsupported without matplotlib.
    """
    s = make_surface(env)
    planes = [env.plane] if env.plane is not None else [np.eye(3)[list(axes)] for axes in ((0, 1), (1, 2), (0, 2))]
    side = SINGLE_PANEL_SIDE if len(planes) == 1 else PANEL_SIDE
    legend = CauseLegend(env, s)
    rooms = side, 0.15, legend.height
    figure, above, tall = figure_below(POLAR_WIDTH, lambda drawn: draw_envelope_heading(drawn, env, title), *rooms)
    for k, axes in enumerate(planes):
        left = (POLAR_WIDTH - len(planes) * side) / 2 + k * side
        ax = figure.add_axes((left / POLAR_WIDTH, 1.0 - (above + side + 0.1) / tall, side / POLAR_WIDTH, side / tall))
        _draw_plane(ax, env, s, axes)
    legend.draw(figure, above + side + 0.15)
    return figure


def _draw_plane(ax: Any, env: Envelope, s: EnvelopeSurface, axes: Array) -> None:
    """Draw the polar diagram of one plane.

    axes (2, 3) : unit vectors to the right and upwards in the panel, world axes.
    """
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.patches import Circle

    if s.cells.shape[1] == 2:
        lines, cells, limit = s.factor_points[s.cells], np.arange(len(s.cells)), s.bound_points[s.cells]
    else:
        normal = np.cross(*axes)
        lines, cells = cut_by_plane(s.factor_points, s.cells, normal)
        limit = cut_by_plane(s.bound_points, s.cells, normal)[0]
    _draw_rings(ax, env, s, axes)
    inside = Circle((0, 0), s.reach, transform=ax.transData)
    runs = _chain_segments(lines @ axes.T, s.cell_keys[cells])
    colours = [s.keys[k].colour for k, _ in runs]
    wedges = [np.vstack([np.zeros(2), line]) for _, line in runs]
    fill = PolyCollection(wedges, facecolors=colours, edgecolors="none", alpha=0.28, zorder=2)
    rim = LineCollection([line for _, line in runs], colors=colours, linewidths=2.4, capstyle="round", zorder=4)
    whole = [line for _, line in _chain_segments(limit @ axes.T, np.zeros(len(limit), dtype=np.int64))]
    bound = LineCollection(whole, colors=INK, linewidths=1.0, linestyles=[(0, (4, 2.5))], zorder=3)
    for drawn in (fill, rim, *([bound] if s.has_visible_bound else [])):
        ax.add_collection(drawn)
        drawn.set_clip_path(inside)


def _draw_rings(ax: Any, env: Envelope, s: EnvelopeSurface, axes: Array) -> None:
    """Circles of equal load with their numbers, and the axes with their names."""
    from matplotlib.patches import Circle

    ax.axis("off")
    ax.set_aspect("equal")
    room = POLAR_MARGIN * s.reach
    ax.set_xlim(-room, room)
    ax.set_ylim(-room, room)
    step = nice_number(0.51 * s.reach) if s.reach > 0 else 1.0
    if s.reach / step > 4.2:
        step *= 2
    rings = np.arange(step, s.reach * (1 + 1e-9), step)
    for r in rings:
        ax.add_patch(Circle((0, 0), r, fill=False, edgecolor=RING_COLOUR, linewidth=0.8, zorder=1))
    ax.add_patch(Circle((0, 0), s.reach, fill=False, edgecolor=GRID_COLOUR, linewidth=1.0, zorder=1))
    for angle in np.radians(np.arange(0, 360, 30)):
        way = np.array([np.cos(angle), np.sin(angle)])
        style = {"color": GRID_COLOUR if abs(way).max() > 0.99 else RING_COLOUR, "linewidth": 0.7, "zorder": 1}
        ax.plot(*np.outer(way, (0, s.reach)), **style)
    for r in rings:
        at = r * np.array([np.cos(np.radians(75)), np.sin(np.radians(75))])
        text = f"{r:g}" + (f" {env.unit}" if r == rings[-1] and env.unit else "")
        box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
        ax.text(*at, text, fontsize=SMALL_SIZE - 1.5, color=GREY, ha="center", va="center", zorder=5, bbox=box)
    for way in (*np.eye(2), *-np.eye(2)):
        name = format_direction(way @ axes)
        ha = "center" if abs(way[0]) < 0.5 else "left" if way[0] > 0 else "right"
        va = "center" if abs(way[1]) < 0.5 else "bottom" if way[1] > 0 else "top"
        ax.text(*(1.035 * s.reach * way), name, fontsize=TEXT_SIZE, color=INK, ha=ha, va=va, weight="bold")


def _chain_segments(segments: Array, keys: Ints) -> list[tuple[int, Array]]:
    """Segments (s, 2, 2) put end to end around the origin: (key, line (k, 2)) of neighbours with the same key (s,)."""
    if not len(segments):
        return []
    middle = segments.mean(axis=1)
    order = np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))
    ends, own = segments[order], keys[order]
    turn = ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]
    ends[turn < 0.0] = ends[turn < 0.0][:, ::-1]
    starts = [0, *(np.flatnonzero(np.diff(own)) + 1).tolist(), len(own)]
    return [(int(own[a]), np.vstack([ends[a:b, 0], ends[b - 1 : b, 1]])) for a, b in pairwise(starts)]


# ----------------------------------------------------------------
# The picture of an envelope: the hand, and the surface of what it holds, from the same side and the opposite one.


PANEL_HEIGHT, HAND_WIDTH = 3.75, 2.7  # inches: height of the panels, width of the hand's
SURFACE_MARGIN = 1.13  # of a surface's half width, in its reach
WEAKEST_COLOUR = "#C8102E"  # the weakest direction


def draw_envelope(env: Envelope, title: str = "") -> Figure:
    """The figure; polar diagrams of directions in a plane. Raises InputError for directions that lie neither all around
    nor in a plane; Unsupported without matplotlib.
    """
    if env.plane is not None:
        return draw_polar_envelope(env, title)
    s = make_surface(env)
    legend = CauseLegend(env, s, "line")
    rooms = 0.32, PANEL_HEIGHT, 0.12, legend.height
    drawn, above, tall = figure_below(PICTURE_WIDTH, lambda figure: draw_envelope_heading(figure, env, title), *rooms)
    above += 0.32
    shown = PictureContent(env.grasp, env.grasp.solve(throw=False), None)
    camera = shown.camera
    behind = Camera(camera.axes * np.array([[-1.0], [1.0], [-1.0]]))
    side, bottom = (PICTURE_WIDTH - HAND_WIDTH) / 2, 1.0 - (above + PANEL_HEIGHT) / tall
    panels = [
        (0.0, HAND_WIDTH, "The hand, without forces"),
        (HAND_WIDTH, side, "What it holds, seen from the same side"),
        (HAND_WIDTH + side, side, "From the opposite side"),
    ]
    for k, (left, wide, name) in enumerate(panels):
        ax = drawn.add_axes((left / PICTURE_WIDTH, bottom, wide / PICTURE_WIDTH, PANEL_HEIGHT / tall))
        at = (left + 0.18) / PICTURE_WIDTH
        drawn.text(at, 1.0 - (above - 0.08) / tall, name, fontsize=SMALL_SIZE, weight="bold", color=INK, va="center")
        if k:
            _draw_surface(ax, camera if k == 1 else behind, env, s, (wide, PANEL_HEIGHT))
            continue
        points = shown.grasp.scene.positions
        if shown.object_body is None:  # one contact alone has no size
            points = (points[:, None] + 0.5 * shown.size * np.concatenate([np.eye(3), -np.eye(3)])).reshape(-1, 3)
        over, view, _ = draw_bodies(ax, shown, points, (wide, PANEL_HEIGHT), 0.12)
        over.draw_triad(np.array([view.box[0], view.box[2]]) + np.array([0.5, 0.4]) * view.inch)
    legend.draw(drawn, above + PANEL_HEIGHT + 0.12)
    return drawn


def _draw_surface(ax: Any, camera: Camera, env: Envelope, s: EnvelopeSurface, inches: tuple[float, float]) -> None:
    """The surface, the bound's lines around it, axes, the weakest direction."""
    from matplotlib.collections import LineCollection

    inch = 2.0 * SURFACE_MARGIN * s.reach / min(inches[0], inches[1] - 0.35)
    w, h = inches[0] * inch, inches[1] * inch
    low = -h / 2 - 0.12 * inch
    box = (-w / 2, w / 2, low, low + h)
    view = ViewLimits(box, box, inch, False)
    bodies = [Body(s.points[s.cells[s.cell_keys == k]], hex_to_rgb(key.colour)) for k, key in enumerate(s.keys)]
    before = paint_bodies(ax, camera, [b for b in bodies if len(b.triangles)], None, view, PICTURE_DPI)
    over = Overlay(ax, camera, inch)
    if len(lines := border_lines(s)):
        near = before(lines.mean(axis=1))[:, 0] < 0.01 * s.reach
        ax.add_collection(LineCollection(list(camera.project(lines[near])), colors="white", linewidths=0.8, zorder=2.9))
    if s.has_visible_bound and len(lines := bound_lines(s)):
        hidden = before(lines.mean(axis=1))[:, 0] > 0.01 * s.reach
        cut = np.linalg.norm(lines, axis=2).min(axis=1) > 0.999 * s.reach
        style: dict[str, Any] = {"colors": INK, "zorder": 3, "linewidths": 0.6}
        for some, alpha in ((~hidden & ~cut, 0.75), (~hidden & cut, 0.3)):
            ax.add_collection(LineCollection(list(camera.project(lines[some])), alpha=alpha, **style))
    _draw_axes(ax, camera, s, before)
    _draw_weakest(ax, camera, env, s, before)
    bar = nice_number(0.9 * inch)
    text = f"{bar:g} {env.unit}".strip()
    over.draw_scale_bar(np.array([box[0] + 0.25 * inch, box[2] + 0.16 * inch]), bar, text)


def _draw_axes(ax: Any, camera: Camera, s: EnvelopeSurface, before: Any) -> None:
    """Where the axes leave the surface, as far as its reach."""
    from matplotlib import patheffects

    halo = patheffects.withStroke(linewidth=2.2, foreground="white")
    for way in (*np.eye(3), *-np.eye(3)):
        points = np.linspace(0.0, 1.06 * s.reach, 120)[:, None] * way
        seen = before(points)[:, 0] < 0.004 * s.reach
        flat = camera.project(points)
        flat[~seen] = np.nan
        ax.plot(*flat.T, color=GREY, linewidth=1.0, zorder=3.5)
        if seen[-1] and np.linalg.norm(camera.project(way)) > 0.2:
            end = camera.project(1.13 * s.reach * way)
            style = {"weight": "bold", "color": GREY, "ha": "center", "va": "center", "zorder": 8}
            ax.text(*end, format_direction(way), fontsize=SMALL_SIZE, **style).set_path_effects([halo])


def _draw_weakest(ax: Any, camera: Camera, env: Envelope, s: EnvelopeSurface, before: Any) -> None:
    """Its point, with the load beside it, where it is on the near side."""
    from matplotlib import patheffects

    w = env.weakest
    point = s.points[w.number]
    if before(point[None] * 1.02)[0, 0] > 0.03 * s.reach or not 0.0 < w.factor < np.inf:
        return
    at = camera.project(point)
    look = {"markerfacecolor": WEAKEST_COLOUR, "markeredgecolor": "white", "markeredgewidth": 1.0}
    ax.plot(*at, "o", markersize=6.5, zorder=9, **look)
    away = 1.0 if at[0] >= 0 else -1.0
    end = np.array([away * 0.62 * s.reach, at[1] + 0.45 * s.reach * (1.0 if at[1] >= 0 else -1.0)])
    ax.plot([at[0], end[0]], [at[1], end[1]], color=WEAKEST_COLOUR, linewidth=0.9, zorder=8.5)
    style: dict[str, Any] = {"color": WEAKEST_COLOUR, "weight": "bold", "va": "center", "zorder": 9}
    says = f"weakest\n{format_factor(env, w.factor).partition(' (')[0]}"
    text = ax.text(*end, says, fontsize=SMALL_SIZE, ha="left" if away > 0 else "right", **style)
    text.set_path_effects([patheffects.withStroke(linewidth=2.5, foreground="white")])
